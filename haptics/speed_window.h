#pragma once

// The mean speed of a device over a short window of time.

#include <array>
#include <cstddef>
#include <optional>

#include "geometry/base/types.h"

namespace palpate {

// Keeps the positions of the last window. A window has at most kEntries positions: at higher rates,
// positions that follow the one before within 1/kSpacing of the window are not kept, which
// lengthens the window by at most that share.
//
// One thread owns an object. No function allocates or throws.
class SpeedWindow {
 public:
  // Forgets all positions if the window has another length than before. window_s: > 0.
  void set_window(double window_s) noexcept {
    if (window_s != window_s_) clear();
    window_s_ = window_s;
  }

  // p_device_m: finite, sampled at time_s, which never decreases.
  void add(double time_s, const Vec3& p_device_m) noexcept {
    newest_ = {time_s, p_device_m};
    has_newest_ = true;
    if (count_ > 0 && time_s - entry(0).time_s < window_s_ / kSpacing) return;
    last_ = (last_ + 1) % kEntries;
    entries_[last_] = newest_;
    if (count_ < kEntries) ++count_;
  }

  // The distance between the newest position and the newest one that is at least a window older,
  // divided by the time between them, m/s. No value until positions span a window.
  std::optional<double> speed_m_per_s() const noexcept {
    for (std::size_t back = 0; has_newest_ && back < count_; ++back) {
      const double time_s = newest_.time_s - entry(back).time_s;
      // The window is a multiple of the tick up to rounding; half a spacing is more than that and
      // less than a tick.
      if (time_s < window_s_ * (1.0 - 0.5 / kSpacing)) continue;
      return (newest_.p_m - entry(back).p_m).norm() / time_s;
    }
    return std::nullopt;
  }

  void clear() noexcept { count_ = 0, has_newest_ = false; }

 private:
  static constexpr std::size_t kSpacing = 32;
  static constexpr std::size_t kEntries = 2 * kSpacing;
  struct Entry {
    double time_s = 0.0;
    Vec3 p_m = Vec3::Zero();
  };
  // back: 0 for the last kept position, 1 for the one before.
  const Entry& entry(std::size_t back) const noexcept {
    return entries_[(last_ + kEntries - back) % kEntries];
  }

  double window_s_ = 0.0;
  std::array<Entry, kEntries> entries_{};
  std::size_t last_ = 0;
  std::size_t count_ = 0;
  Entry newest_;
  bool has_newest_ = false;
};

}  // namespace palpate
