#pragma once

// Recognises a swing of the contact force that does not die down.

#include <array>
#include <cstddef>
#include <cstdint>

#include "geometry/base/types.h"

namespace palpate {

// Along each axis of the device frame, the watch follows the extremes of the force. A half-swing
// is the way from one extreme to the next. It is a swing if
// - of the last kGrowing half-swings (three periods), each is larger than the one two before it, or
// - the last kSteady half-swings have lost less than kLostShare of the first,
// and if all of them took between kShortest_s and kLongest_s, and each period about as long as the
// others (kSteadyTime). A hand that moves as it likes is not as regular; and a tip of 0.1 kg
// and 0.5 N s/m, which swings freely on a spring, loses more. A swing ends when it is small or
// stops.
//
// One thread owns an object. No function allocates or throws.
class SwingWatch {
 public:
  static constexpr double kShortest_s = 2e-3;  // 250 Hz
  static constexpr double kLongest_s = 0.1;    // 5 Hz
  static constexpr std::size_t kGrowing = 6;
  static constexpr std::size_t kSteady = 7;
  static constexpr double kLostShare = 0.5;
  // The longest period is shorter than this times the shortest.
  static constexpr double kSteadyTime = 1.15;

  // least_N: the smallest half-swing, > 0. Smaller ones are not seen, and a swing ends with them.
  void add(const Vec3& force_N, double least_N, std::int64_t now_ns) noexcept;
  void clear() noexcept { *this = {}; }

  // The angular frequency of the fastest swing, rad/s; 0: none.
  double swing_rad_per_s() const noexcept { return swing_rad_per_s_; }

 private:
  struct Axis {
    double extreme_N = 0.0;       // since the last reversal
    double last_extreme_N = 0.0;  // before it
    int direction = 0;            // of the force, 0: unknown
    std::int64_t reversed_ns = 0;
    std::array<double, kSteady> sizes_N{};  // of the last half-swings, the newest first
    std::size_t count = 0;
    std::array<double, kSteady> halves_s{};  // their durations
    bool swings = false;

    void add(double force_N, double least_N, std::int64_t now_ns) noexcept;
    void reverse(std::int64_t now_ns) noexcept;
    bool is_swing() const noexcept;
    bool is_regular(std::size_t half_swings) const noexcept;
  };

  std::array<Axis, 3> axes_;
  double swing_rad_per_s_ = 0.0;
};

}  // namespace palpate
