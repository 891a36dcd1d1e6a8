#include "engine/trials/trial_order.h"

#include <numeric>
#include <utility>

#include "engine/trials/key_hash.h"
#include "geometry/base/random.h"

namespace palpate {
namespace {

KeyHash key(const char* purpose, std::uint64_t seed, int participant) {
  return KeyHash().add(purpose).add(seed).add(static_cast<std::uint64_t>(participant));
}

}  // namespace

std::uint64_t order_seed(std::uint64_t seed, int participant, int block) {
  return key("order", seed, participant).add(static_cast<std::uint64_t>(block)).value();
}

std::uint64_t objects_seed(std::uint64_t seed, int participant, int block,
                           const std::string& level) {
  return key("objects", seed, participant)
      .add(static_cast<std::uint64_t>(block))
      .add(level)
      .value();
}

std::uint64_t noise_seed(std::uint64_t seed, int participant, int block, const std::string& haptic,
                         const std::string& rotation, const std::string& object) {
  return key("noise", seed, participant)
      .add(static_cast<std::uint64_t>(block))
      .add(haptic)
      .add(rotation)
      .add(object)
      .value();
}

std::uint64_t draw_seed(std::uint64_t seed, int participant, const std::string& operator_name,
                        const std::string& draw) {
  return key("draw", seed, participant).add(operator_name).add(draw).value();
}

std::vector<std::size_t> trial_order(std::size_t count, std::uint64_t seed) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  SeededRandom random(seed);
  for (std::size_t left = count; left > 1; --left) {
    std::swap(order[left - 1], order[random.index(left)]);
  }
  return order;
}

std::vector<std::size_t> williams_row(std::size_t count, std::size_t row) {
  std::vector<std::size_t> order(count);
  for (std::size_t place = 0; place < count; ++place) {
    const std::size_t step = (place + 1) / 2;
    order[place] = ((place % 2 == 1 ? step : count - step) + row) % count;
  }
  return order;
}

}  // namespace palpate
