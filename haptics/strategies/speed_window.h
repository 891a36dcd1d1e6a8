#pragma once

// The mean speed and the mean velocity of a device over a short window of time.

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
    if (count_ == 0 || time_s - entry(count_ - 1).time_s >= window_s_ / kSpacing) {
      entry(count_) = newest_;
      ++count_;
      if (count_ - oldest_ > kEntries) ++oldest_;
    }
    while (oldest_ + 1 < count_ && is_old(entry(oldest_ + 1))) ++oldest_;
    const std::size_t first = count_ > kEntries ? count_ - kEntries : 0;
    while (oldest_ > first && !is_old(entry(oldest_))) --oldest_;
  }

  // The distance between the newest position and the newest one that is at least a window older,
  // divided by the time between them, m/s. No value until positions span a window.
  std::optional<double> speed_m_per_s() const noexcept {
    if (!has_newest_ || count_ == 0 || !is_old(entry(oldest_))) return std::nullopt;
    return way_m().norm() / time_s();
  }

  // The way between the same two positions, divided by the same time, m/s, device frame.
  std::optional<Vec3> velocity_m_per_s() const noexcept {
    if (!has_newest_ || count_ == 0 || !is_old(entry(oldest_))) return std::nullopt;
    return Vec3(way_m() / time_s());
  }

  // False if speed_m_per_s() has no value or is certainly below a limit. Faster than the speed.
  bool may_exceed(double limit_m_per_s) const noexcept {
    if (!has_newest_ || count_ == 0 || !is_old(entry(oldest_))) return false;
    const double half_m = 0.5 * limit_m_per_s * time_s();
    return !(way_m().squaredNorm() < half_m * half_m);
  }

  void clear() noexcept { count_ = oldest_ = 0, has_newest_ = false; }

 private:
  static constexpr std::size_t kSpacing = 32;
  static constexpr std::size_t kEntries = 2 * kSpacing;
  struct Entry {
    double time_s = 0.0;
    Vec3 p_m = Vec3::Zero();
  };
  Entry& entry(std::size_t n) noexcept { return entries_[n % kEntries]; }
  const Entry& entry(std::size_t n) const noexcept { return entries_[n % kEntries]; }
  // The window is a multiple of the tick up to rounding; half a spacing is more than that and less
  // than a tick.
  bool is_old(const Entry& e) const noexcept {
    return newest_.time_s - e.time_s >= window_s_ * (1.0 - 0.5 / kSpacing);
  }
  double time_s() const noexcept { return newest_.time_s - entry(oldest_).time_s; }
  Vec3 way_m() const noexcept { return newest_.p_m - entry(oldest_).p_m; }

  double window_s_ = 0.0;
  std::array<Entry, kEntries> entries_{};
  std::size_t count_ = 0;   // positions that were kept since clear()
  std::size_t oldest_ = 0;  // the newest one that is a window older than newest_, or the first one
  Entry newest_;
  bool has_newest_ = false;
};

}  // namespace palpate
