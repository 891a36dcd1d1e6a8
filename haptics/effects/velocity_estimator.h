#pragma once

// How fast something moves, from where it was in the last ticks.

#include <array>
#include <cstddef>
#include <cstdint>

#include "geometry/base/types.h"

namespace palpate {

// From the last w + 1 samples x_k at times t_k, n the newest of them:
enum class VelocityMethod : std::uint8_t {
  kDifference,  // (x_n - x_{n-w}) / (t_n - t_{n-w})
  kLineFit,     // slope of the straight line that fits them best, by least squares
  // First-order adaptive windowing (Janabi-Sharifi, Hayward and Chen 2000): the difference over the
  // longest window, no longer than w, in which the straight line between its ends is within half an
  // encoder quantum of each sample between them. Slow and steady motion gets a long window, a jerk
  // a short one. One window for all three axes, so that the velocity is that between two samples;
  // half a quantum on each axis. It is the longest such window, though a shorter one may fail. The
  // ends are rounded, too: even steady motion is up to a whole quantum off the line, so that this
  // errs towards short windows. A quantum given twice as large rarely cuts steady motion short.
  kAdaptive
};

// A window of w ticks of length T lags w T / 2 behind: under a steady acceleration a, the first two
// methods are off by a w T / 2. The quantum q of an encoder makes noise, rms, if rounding is as
// good as random: q / (sqrt(6) w T) in a difference, q / (T sqrt(w (w + 1) (w + 2))) in a line fit.
struct VelocitySettings {
  VelocityMethod method = VelocityMethod::kDifference;
  int window_ticks = 1;            // w, 1 to VelocityEstimator::kMostTicks; for 1 all are the same
  double encoder_quantum_m = 0.0;  // kAdaptive only: > 0
};

// Ticks may differ in length. Any frame, as long as it is the same for all samples; metres.
//
// No allocation, lock or exception; a difference takes the same time whatever its window, the
// others a time in proportion to it. One thread owns it.
class VelocityEstimator {
 public:
  static constexpr int kMostTicks = 63;

  // A window out of range is taken as the nearest one within.
  explicit VelocityEstimator(const VelocitySettings& settings);

  // Takes a sample and returns the velocity there. dt_s > 0: since the last sample; of no matter
  // for the first one. While there are fewer samples than the window has, those that are there are
  // its window; of the first one the velocity is zero.
  Vec3 add(const Vec3& position_m, double dt_s) noexcept;

  // The next sample is the first.
  void reset() noexcept { count_ = 0; }

 private:
  // In two doubles: their differences keep all digits of a tick, however long the contact lasts and
  // however much ticks differ.
  struct Time {
    double high_s = 0.0;
    double low_s = 0.0;

    Time plus(double dt_s) const noexcept;
    double seconds_to(const Time& later) const noexcept {
      return (later.high_s - high_s) + (later.low_s - low_s);
    }
  };
  struct Sample {
    Vec3 position_m;
    Time time;
  };
  static constexpr std::size_t kCapacity = 64;  // a power of two
  static_assert(kCapacity == kMostTicks + 1);

  // k = 0: the newest.
  const Sample& back(std::size_t k) const noexcept { return samples_[(newest_ - k) % kCapacity]; }
  // last: the newest, not read back from where it was just stored.
  Vec3 difference(const Sample& last, std::size_t window) const noexcept;
  Vec3 line_fit(const Sample& last, std::size_t window) const noexcept;
  Vec3 adaptive(const Sample& last, std::size_t window) const noexcept;

  VelocityMethod method_;
  std::size_t window_;
  double half_quantum_m_;
  std::size_t count_ = 0;   // of samples that are there
  std::size_t newest_ = 0;  // counts on; its place is the remainder
  std::array<Sample, kCapacity> samples_;
};

}  // namespace palpate
