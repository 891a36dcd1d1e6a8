#include "haptics/strategies/a4_anticipate.h"

#include "haptics/strategies/speed_window.h"
#include "haptics/strategies/strategy_step.h"

namespace palpate {
namespace {

// A direction lies across the sensed plane if its part in the plane is shorter than this: it would
// have lost half of its digits.
constexpr double kLeastInPlane = 1e-8;

// In free motion, the rotation before a touch.
class A4AnticipateStep final : public StrategyStep {
 public:
  A4AnticipateStep(const ActuationModel& actuation, const HapticSettings& settings)
      : anticipation_(actuation, settings.a4, settings.anticipation) {
    window_.set_window(A4Anticipation::kWindow_s);
  }

  AxisAngle turn_about_device_point(const StrategyTick& tick) noexcept override {
    if (!tick.follows_good_tick) window_.clear();
    window_.add(tick.record.time_s, Vec3(tick.record.device_m));
    if (tick.record.contact) {
      anticipation_.end();
      return {};
    }
    const Accuracy& accuracy = tick.settings.god_object.accuracy;
    return anticipation_.update({tick.world, tick.actuation, tick.goal_solver_m,
                                 tick.R_device_scene, window_.velocity_m_per_s(), tick.radius_m,
                                 tick.dt_s, accuracy.work_budget - tick.proxy.work,
                                 accuracy.counting});
  }

 private:
  SpeedWindow window_;  // of the device's positions
  A4Anticipation anticipation_;
};

}  // namespace

std::unique_ptr<StrategyStep> make_a4_anticipate_step(const ActuationModel& actuation,
                                                      const HapticSettings& settings) {
  return std::make_unique<A4AnticipateStep>(actuation, settings);
}

struct A4Anticipation::Approach {
  Vec3 normal_device;       // n
  double clearance_m;       // h
  double approach_m_per_s;  // u
};

std::optional<A4Anticipation::Approach> A4Anticipation::find_approach(
    const FreeMotion& motion) noexcept {
  WorkMeter work(motion.work_left, motion.counting);
  const auto place = nearest_.update(motion.world, motion.goal_solver_m,
                                     settings_.range_m + motion.radius_m, work);
  if (!place) return std::nullopt;
  Vec3 n = motion.R_device_scene * place->direction;
  if (motion.actuation.is_planar()) {
    n.z() = 0.0;
    const double in_plane = n.norm();
    if (in_plane < kLeastInPlane) return std::nullopt;
    n /= in_plane;
  }
  return Approach{n, place->distance_m - motion.radius_m, -n.dot(*motion.velocity_device_m_per_s)};
}

AxisAngle A4Anticipation::update(const FreeMotion& motion) noexcept {
  const std::optional<Vec3>& v = motion.velocity_device_m_per_s;
  // u is at most |v|: no search is needed to know that a slow hand begins no turn.
  if (!v || (!turns_ && v->norm() <= settings_.least_approach_m_per_s)) {
    end();
    return {};
  }
  const auto approach = find_approach(motion);
  if (!approach) {
    if (!nearest_.is_cut_short()) end();
    return {};
  }
  const double u = approach->approach_m_per_s;
  if (!turns_) theoretical_.reset();
  theoretical_.set_actuation(motion.actuation);
  const AxisAngle theoretical = theoretical_.update(approach->normal_device);
  if (turns_) {
    turns_ = u > 0.0;
  } else {
    turns_ = u > settings_.least_approach_m_per_s &&
             approach->clearance_m <= u * alignment_time_s(a4_.profile, theoretical.angle_rad);
  }
  if (!turns_ || theoretical.angle_rad == 0.0) return {};
  return {theoretical.axis_device,
          elementary_rotation_rad(a4_.profile, a4_.step, theoretical.angle_rad, motion.dt_s)};
}

void A4Anticipation::end() noexcept {
  turns_ = false;
  nearest_.forget();
}

}  // namespace palpate
