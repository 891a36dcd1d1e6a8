#pragma once

// The measures of a trial that only comparisons of strategies need.

#include <array>
#include <cstdint>
#include <optional>

#include "engine/trials/trial_row.h"
#include "geometry/base/types.h"
#include "haptics/a4/scene_pose.h"
#include "palpate/record.h"

namespace palpate {

// Accumulates the measures from kWallWork to kTurningEnergy, tick by tick. The device holds the
// force of a tick until the next one; so a work is the force of a tick times the displacement that
// follows it, as in RunSummary. Forces and displacements are in the device frame. Does not
// allocate.
//
// - Wall work: sum of max(0, f_t . dx) over contact, where f_t is the part of the commanded force
//   that is perpendicular to the contact normal.
// - Contact work: sum of f . dx over one contact, an interval of ticks in contact. The measure is
//   the largest over all contacts, the unfinished last one included.
// - Empty turns: a turn is a tick in free motion in which the scene turns, with all such ticks up
//   to the next contact. A turn is empty if kTouchWait_s pass after its last turning tick without a
//   contact. A turn that the stop of the clock cuts off does not count.
// - Drift: the distance of the scene's origin from its place in the first tick of the trial. If the
//   scene has turned, the distance has no meaning, and there is no value.
// - Governor share: ticks in which a rule of the safety governor acted on the force.
// - Turning energy: what A4's turns add to the energy of the part of the spring that the motors
//   have, K/2 e^2 cos^2(a), sum over turns by which it grows; a is the contact angle, e the depth
//   of the spring as the motors have it (a4_passive.h). The sum has the turns after which the
//   proxy is still on the same wall. K is the full force over the lag, which is the stiffness in
//   a contact without effects and damper. Ticks in which the governor acted do not count.
class StrategyMeasures {
 public:
  static constexpr double kTouchWait_s = 0.1;

  explicit StrategyMeasures(double dt_s);

  // The first tick of the trial: the scene is in its place.
  void begin(const TickRecord& record) noexcept;
  // A tick between the start and the stop of the clock.
  void add(const TickRecord& record) noexcept;
  // Sets the measures from kWallWork to kTurningEnergy. Call it after at least one add().
  void put(std::array<std::optional<double>, kMeasureCount>& measures) const;

 private:
  void add_work(const TickRecord& record) noexcept;
  void add_turn(const TickRecord& record) noexcept;
  void add_drift(const TickRecord& record) noexcept;
  void add_turning_energy(const TickRecord& record) noexcept;

  std::uint64_t touch_wait_ticks_;
  ScenePose home_;
  std::uint64_t ticks_ = 0;
  std::uint64_t governed_ = 0;

  bool was_in_contact_ = false;  // the fields below are of the last tick
  Vec3 last_device_m_ = Vec3::Zero();
  Vec3 last_force_N_ = Vec3::Zero();
  Vec3 last_tangential_N_ = Vec3::Zero();
  double wall_work_J_ = 0.0;
  double contact_work_J_ = 0.0;  // of the present contact
  std::optional<double> largest_contact_work_J_;

  std::optional<std::uint64_t> since_turn_;  // ticks after the last turning one; no value: no turn
  std::uint64_t empty_turns_ = 0;

  bool has_turned_ = false;
  double drift_sum_m_ = 0.0;
  double worst_drift_m_ = 0.0;

  TickRecord last_;  // for the turning energy
  double turning_energy_J_ = 0.0;
};

}  // namespace palpate
