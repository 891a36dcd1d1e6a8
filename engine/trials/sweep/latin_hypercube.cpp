#include "engine/trials/sweep/latin_hypercube.h"

#include <algorithm>
#include <cmath>

#include "engine/trials/key_hash.h"
#include "engine/trials/trial_order.h"
#include "geometry/base/random.h"

namespace palpate {

std::vector<double> hypercube_coordinates(std::uint64_t seed, std::string_view dimension,
                                          std::size_t count) {
  KeyHash key;
  key.add("hypercube").add(seed).add(dimension);
  const std::vector<std::size_t> intervals = trial_order(count, key.value());
  std::vector<double> coordinates;
  for (std::size_t i = 0; i < count; ++i) {
    KeyHash of_point = key;
    SeededRandom random(of_point.add(std::uint64_t{i}).value());
    const auto n = static_cast<double>(count);
    const auto interval = static_cast<double>(intervals[i]);
    // The division may round up to the end of the interval, which is not part of it.
    coordinates.push_back(std::min((interval + random.uniform(0.0, 1.0)) / n,
                                   std::nextafter((interval + 1.0) / n, 0.0)));
  }
  return coordinates;
}

}  // namespace palpate
