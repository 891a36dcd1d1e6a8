#pragma once

// The strategy `a4-anticipate`: A4, which in free motion may turn the scene before a touch.
//
// The technique is ours. A4 (Lecuyer et al. 2005) begins to turn at the touch; until the normal is
// aligned, the missing motors leave a part of the force out. This strategy begins while the hand
// approaches a surface, so early that the profile of Figure 3 ends with the touch.

#include <optional>

#include "haptics/a4/actuation.h"
#include "haptics/a4/theoretical_rotation.h"
#include "haptics/strategies/haptic_settings.h"
#include "haptics/strategies/nearest_place.h"
#include "haptics/strategies/strategy.h"

namespace palpate {

// What a tick in free motion knows. Its sample is good.
struct FreeMotion {
  const LiveWorld& world;
  const ActuationModel& actuation;
  Vec3 goal_solver_m;                           // x, the device point
  const Mat3& R_device_scene;                   // from solver axes to the device frame
  std::optional<Vec3> velocity_device_m_per_s;  // v, the device's mean velocity over kWindow_s
  double radius_m = 0.0;
  double dt_s = 0.0;
  WorkUnits work_left = 0;  // of the tick's budget
  CountingRule counting = CountingRule::kSecond;
};

// Let q be the surface point nearest to x (NearestPlace), n = (x - q)/|x - q|, with 2 sensors
// projected into the sensed plane and normalised, h the distance less the proxy's radius, and
// u = -v.n. Turning begins when h is at most the range of the settings, u exceeds their least
// approach, and h/u is at most the time that the profile takes to turn n into the actuated span
// (alignment_time_s). It ends with contact, with u <= 0, and beyond the range.
//
// A tick turns by Figure 3 with n for the normal, about the device point. The device point, which
// is the proxy in free motion, keeps its place in the scene. Bodies therefore meet nothing that
// they would not have met, and fields that act in scene coordinates keep their potential.
//
// The hand may not follow the turning picture and miss the surface: such a turn was in vain.
//
// Safe on the haptic thread: no allocation, lock or exception. One thread owns an object.
class A4Anticipation {
 public:
  // The window of the mean velocity. In a tick of 1 ms, an encoder step of 20 um would be a
  // velocity of 20 mm/s; over this window it is 1 mm/s.
  static constexpr double kWindow_s = 0.020;

  A4Anticipation(const ActuationModel& actuation, const A4Settings& a4,
                 const AnticipationSettings& settings)
      : settings_(settings), a4_(a4), theoretical_(actuation, a4.table1, a4.align) {}

  // The rotation of the scene in this tick; its angle is 0 if the tick does not turn. A tick whose
  // search has spent the budget does not turn, and a turn goes on in the next one.
  AxisAngle update(const FreeMotion& motion) noexcept;

  // Ends a turn and forgets q.
  void end() noexcept;

 private:
  struct Approach;
  std::optional<Approach> find_approach(const FreeMotion& motion) noexcept;

  AnticipationSettings settings_;
  A4Settings a4_;
  TheoreticalRotation theoretical_;
  NearestPlace nearest_;
  bool turns_ = false;
};

std::unique_ptr<StrategyStep> make_a4_anticipate_step(const ActuationModel& actuation,
                                                      const HapticSettings& settings);

inline constexpr StrategyType kA4AnticipateStrategy{
    .name = "a4-anticipate", .has_a4 = true, .make_step = make_a4_anticipate_step};

}  // namespace palpate
