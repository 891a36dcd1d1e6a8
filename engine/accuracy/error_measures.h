#pragma once

// What errors are summed up to, and which of them say nothing.

#include <cmath>
#include <limits>

namespace palpate {

// Root mean square of what is added.
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

// What a file's coordinates are rounded to: half the step of single precision at the farthest of
// them. Errors below say nothing about a scene that came from a file.
inline double float_floor_m(double farthest_coordinate_m) {
  return 0.5 * std::numeric_limits<float>::epsilon() * farthest_coordinate_m;
}

}  // namespace palpate
