#pragma once

// The mean of errors, and the floor below which they cannot be distinguished.

#include <cmath>
#include <limits>

namespace palpate {

// Root mean square of the numbers added.
class RootMeanSquare {
 public:
  void add(double x) {
    sum_ += x * x;
    count_ += 1.0;
  }
  double value() const { return count_ > 0.0 ? std::sqrt(sum_ / count_) : 0.0; }

 private:
  double sum_ = 0.0;
  double count_ = 0.0;
};

// The rounding of a file's coordinates: half a step of single precision at the farthest coordinate.
// Smaller errors are meaningless for a scene from a file.
inline double float_floor_m(double farthest_coordinate_m) {
  return 0.5 * std::numeric_limits<float>::epsilon() * farthest_coordinate_m;
}

}  // namespace palpate
