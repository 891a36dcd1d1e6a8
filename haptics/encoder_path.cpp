#include "haptics/encoder_path.h"

#include <algorithm>
#include <cmath>

namespace palpate {

Vec3 EncoderPath::add(const Vec3& sensed_m, double time_s) noexcept {
  if (!(quantum_m_ > 0.0)) return sensed_m;
  if (!is_known_) {
    is_known_ = true;
    for (std::size_t k = 0; k < axes_.size(); ++k) {
      axes_[k] = {};
      axes_[k].sensed_m = sensed_m[static_cast<int>(k)];
    }
    return sensed_m;
  }
  Vec3 place_m;
  for (std::size_t k = 0; k < axes_.size(); ++k) {
    const int axis = static_cast<int>(k);
    place_m[axis] = axes_[k].add(sensed_m[axis], time_s, quantum_m_);
  }
  return place_m;
}

double EncoderPath::Axis::add(double at_m, double time_s, double quantum_m) noexcept {
  since_s += time_s;
  if (at_m != sensed_m) jump(at_m, quantum_m);
  sensed_m = at_m;
  if (!has_edge) return at_m;
  const double half_m = 0.5 * quantum_m;
  const double past_edge_m = std::clamp(0.5 * speed_m_per_s * time_s, -half_m, half_m);
  return std::clamp(edge_m + speed_m_per_s * since_s + past_edge_m, at_m - half_m, at_m + half_m);
}

// A jump of less than a step is that of one of the angles of a linkage: its edge is in the middle.
void EncoderPath::Axis::jump(double at_m, double quantum_m) noexcept {
  const double jump_m = at_m - sensed_m;
  const double to_edge_m = 0.5 * std::clamp(jump_m, -quantum_m, quantum_m);
  const double new_edge_m = at_m - to_edge_m;
  const double way_m = new_edge_m - edge_m;
  const bool is_onward = has_edge && since_s > 0.0 && way_m * jump_m > 0.0;
  speed_m_per_s = is_onward ? way_m / since_s : 0.0;
  edge_m = new_edge_m;
  since_s = 0.0;
  has_edge = true;
}

}  // namespace palpate
