#pragma once

// Estimates a velocity from the positions of the last ticks.

#include <array>
#include <cstddef>
#include <cstdint>

#include "geometry/base/types.h"

namespace palpate {

// The estimation methods. They use the last w + 1 samples x_k at times t_k; n is the number of the
// newest sample.
enum class VelocityMethod : std::uint8_t {
  kDifference,  // (x_n - x_{n-w}) / (t_n - t_{n-w})
  kLineFit,     // slope of the least-squares line through the samples
  // First-order adaptive windowing (Janabi-Sharifi, Hayward and Chen 2000): the difference over the
  // longest window, of at most w ticks, in which the straight line between the end samples is
  // within half an encoder quantum of each sample between them. The window is long for slow, steady
  // motion and short for a sudden motion. All three axes share one window, so that the velocity
  // belongs to one pair of samples; the limit of half a quantum applies to each axis. The longest
  // window that satisfies the condition is used, even if a shorter one violates it. Because the end
  // samples are rounded, too, even a steady motion can be a whole quantum off the line. The method
  // therefore prefers short windows. If encoder_quantum_m is set to twice the quantum, the window
  // of a steady motion is rarely too short.
  kAdaptive
};

// The estimate over a window of w ticks of length T lags w T / 2 behind: under a constant
// acceleration a, the first two methods have the error a w T / 2. If the rounding error of an
// encoder quantum q is random, the noise (rms) is q / (sqrt(6) w T) in a difference and
// q / (T sqrt(w (w + 1) (w + 2))) in a line fit.
struct VelocitySettings {
  VelocityMethod method = VelocityMethod::kDifference;
  int window_ticks = 1;            // w, 1 to VelocityEstimator::kMostTicks; 1: all methods agree
  double encoder_quantum_m = 0.0;  // kAdaptive only: > 0
};

// Estimates the velocity of a point. Ticks may differ in length. Positions are in metres, in any
// frame that is the same for all samples.
//
// Thread-safety: one thread owns an estimator. No allocation, lock or exception. The computing time
// of kDifference does not depend on the window; that of the other methods is proportional to it.
class VelocityEstimator {
 public:
  static constexpr int kMostTicks = 63;

  // A window out of range is clamped to the range.
  explicit VelocityEstimator(const VelocitySettings& settings);

  // Adds a sample and returns the velocity at this sample. dt_s: time since the last sample, > 0;
  // ignored for the first sample, whose velocity is zero. While there are fewer samples than the
  // window needs, the window is shortened to the samples that exist.
  Vec3 add(const Vec3& position_m, double dt_s) noexcept;

  // Forgets all samples: the next one is the first.
  void reset() noexcept { count_ = 0; }

 private:
  // A time as the sum of two doubles: differences keep all digits of a tick, however long the
  // contact lasts and however much the ticks differ.
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

  // The sample k places before the newest one; k = 0 is the newest.
  const Sample& back(std::size_t k) const noexcept { return samples_[(newest_ - k) % kCapacity]; }
  // last: the newest sample, passed to avoid a read right after the store.
  Vec3 difference(const Sample& last, std::size_t window) const noexcept;
  Vec3 line_fit(const Sample& last, std::size_t window) const noexcept;
  Vec3 adaptive(const Sample& last, std::size_t window) const noexcept;

  VelocityMethod method_;
  std::size_t window_;
  double half_quantum_m_;
  std::size_t count_ = 0;   // samples that a window may include
  std::size_t newest_ = 0;  // a running number; its index is the remainder by kCapacity
  std::array<Sample, kCapacity> samples_;
};

}  // namespace palpate
