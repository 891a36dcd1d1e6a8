#pragma once

// The mean of errors, and the floor below which errors cannot be distinguished.

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

// The rounding error of a file's coordinates: half of the distance between neighbouring numbers of
// single precision at the farthest coordinate. For a scene from a file, smaller errors are
// meaningless.
inline double float_floor_m(double farthest_coordinate_m) {
  return 0.5 * std::numeric_limits<float>::epsilon() * farthest_coordinate_m;
}

}  // namespace palpate
