#include "haptics/strategies/a4_passive.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "haptics/effects/rendered_force.h"
#include "haptics/proxy/plane_projection.h"
#include "haptics/strategies/strategy_step.h"

namespace palpate {
namespace {

constexpr double kJoulePerMillijoule = 1e-3;

// A proxy rests at up to two stand-offs in front of its planes, and in another place of this gap in
// each tick.
constexpr double kStandOffsOfGap = 2.0;

double stiffness_N_per_m(const StrategyTick& tick) {
  return (tick.response ? tick.response->coupling : tick.settings.coupling).stiffness_N_per_m;
}

// The spring of a lag, solver axes, that this tick's contact has.
MotorSpring spring_of(const Vec3& lag_m, const StrategyTick& tick) {
  const double K = stiffness_N_per_m(tick);
  if (K == 0.0) return {};
  const Vec3 phi = tick.response
                       ? Vec3(rendered_force_N(*tick.response, tick.proxy, lag_m, Vec3::Zero()) / K)
                       : lag_m;
  return {K, phi.norm(), tick.actuation.actuated_part(tick.R_device_scene * phi).norm()};
}

// The lag that friction leaves, as in GodObject::move_with_friction. lag_m: of the old place of the
// proxy, solver axes.
Vec3 held_lag_m(const Vec3& lag_m, const ProxyState& proxy) {
  const Vec3 pressed_m = proxy.pressed_part(lag_m);
  if (pressed_m.dot(proxy.normal) < 0.0) return Vec3::Zero();  // the contact ends
  const Vec3 aside_m = lag_m - pressed_m;
  const double depth_m = pressed_m.norm();
  const bool slides = proxy.friction == FrictionState::kSlides;
  const double most_m =
      depth_m * (slides ? proxy.cone.dynamic_friction : proxy.cone.static_friction);
  if (aside_m.norm() <= most_m) return lag_m;
  return pressed_m + depth_m * proxy.cone.dynamic_friction * aside_m.normalized();
}

// The lag of a proxy that its contacts let go towards the device point. lag_m: before it goes,
// solver axes.
Vec3 settled_lag_m(const Vec3& lag_m, const StrategyTick& tick) {
  if (tick.proxy.is_held) return held_lag_m(lag_m, tick.proxy);
  std::array<ContactPlane, 3> planes;
  const std::size_t count = std::min(planes.size(), tick.contact.contacts().size());
  for (std::size_t i = 0; i < count; ++i) planes[i] = {tick.contact.plane_normal(i), 0.0};
  return lag_m +
         project_onto_planes(std::span(planes).first(count), -lag_m, Feasibility::kAtStartPrecise)
             .displacement_m;
}

class A4PassiveStep final : public StrategyStep {
 public:
  explicit A4PassiveStep(double budget_J) : budget_(budget_J) {}

  std::optional<StrategyForce> force(const Vec3& force_N,
                                     const StrategyTick& tick) noexcept override {
    const Vec3 full_N = tick.R_device_scene * force_N;
    if (!tick.record.contact) return StrategyForce{full_N, tick.actuation.actuated_part(full_N)};
    const Vec3 lag_m = tick.proxy.proxy - tick.goal_solver_m;
    const MotorSpring spring = spring_of(lag_m, tick);
    lag_device_m_ = tick.R_device_scene * lag_m;
    budget_.touch(spring, tick.record.time_s, has_turned_ ? fall_step_m(tick) : 0.0);
    has_turned_ = false;
    device_m_ = Vec3(tick.record.device_m);
    if (budget_.start_m() == 0.0) {
      return StrategyForce{full_N, tick.actuation.actuated_part(full_N)};
    }
    const double withheld = budget_.start_m() / spring.stretch_m;
    const Vec3 given_N = full_N - withheld * (tick.R_device_scene * tick.coupling_force_N);
    return StrategyForce{full_N, tick.actuation.actuated_part(given_N)};
  }

  // Turns nothing. The pose is that after A4's turn.
  AxisAngle turn_about_device_point(const StrategyTick& tick) noexcept override {
    const TickRecord& record = tick.record;
    if (!record.contact) {
      budget_.end_contact();
    } else if (record.rotation_rad != 0.0) {
      const Vec3 lag_m = settled_lag_m(tick.R_device_scene.transpose() * lag_device_m_, tick);
      budget_.turn(spring_of(lag_m, tick));
      expected_lag_device_m_ = tick.R_device_scene * lag_m;
      has_turned_ = true;
    }
    return {};
  }

 private:
  // The most by which this tick's step of the hand changes the lag on the planes of a contact, if
  // the lag has changed by more: the turn let the proxy fall. Otherwise 0. A projection on a convex
  // set shortens every step. Friction that slides adds at most a step along the wall and mu steps
  // of the length of the tangential lag.
  double fall_step_m(const StrategyTick& tick) const {
    if (!tick.world.moving().empty()) return 0.0;
    const ProxyState& proxy = tick.proxy;
    const double step_m = (Vec3(tick.record.device_m) - device_m_).norm();
    const double gap_m =
        kStandOffsOfGap * SolverScale::of(tick.world.size_m(), tick.radius_m).stand_off_m;
    const double most_m =
        gap_m + (proxy.is_held ? (2.0 + proxy.cone.static_friction) * step_m : step_m);
    return (lag_device_m_ - expected_lag_device_m_).norm() > most_m ? most_m : 0.0;
  }

  TurnBudget budget_;
  Vec3 device_m_ = Vec3::Zero();      // of the last tick in contact
  Vec3 lag_device_m_ = Vec3::Zero();  // of the same tick
  bool has_turned_ = false;           // after it
  Vec3 expected_lag_device_m_ = Vec3::Zero();
};

}  // namespace

double MotorSpring::energy_J(double start_m) const noexcept {
  if (stretch_m <= start_m) return 0.0;
  const double motor_depth_m = (stretch_m - start_m) * (motor_stretch_m / stretch_m);
  return 0.5 * stiffness_N_per_m * motor_depth_m * motor_depth_m;
}

double MotorSpring::start_m(double start_m, double most_J) const noexcept {
  if (energy_J(start_m) <= most_J) return start_m;
  const double motor_depth_m = std::sqrt(2.0 * most_J / stiffness_N_per_m);
  return std::max(start_m, stretch_m - motor_depth_m * (stretch_m / motor_stretch_m));
}

void TurnBudget::touch(const MotorSpring& spring, double time_s, double fall_step_m) noexcept {
  if (fall_step_m > 0.0 && in_contact_) fall(spring, fall_step_m);
  if (!in_contact_) begin_contact(time_s);
  last_contact_s_ = time_s;
  start_m_ = std::min(start_m_, spring.stretch_m);
  energy_J_ = spring.energy_J(start_m_);
}

// The most that the spring can have had after the fall, before the hand's step.
void TurnBudget::fall(const MotorSpring& spring, double step_m) noexcept {
  const MotorSpring most{spring.stiffness_N_per_m, spring.stretch_m + step_m,
                         spring.motor_stretch_m + step_m};
  if (most.energy_J(start_m_) > energy_J_) turn(most);
}

void TurnBudget::begin_contact(double time_s) noexcept {
  const bool inherits = had_contact_ && time_s - last_contact_s_ <= kRest_s;
  left_J_ = inherits ? std::min(left_J_, budget_J_) : budget_J_;
  in_contact_ = true;
  had_contact_ = true;
}

void TurnBudget::turn(const MotorSpring& turned) noexcept {
  const double most_J = energy_J_ + left_J_;
  const double turned_J = turned.energy_J(start_m_);
  start_m_ = turned.start_m(start_m_, most_J);
  energy_J_ = std::min(turned_J, most_J);
  left_J_ = most_J - energy_J_;
}

void TurnBudget::end_contact() noexcept {
  in_contact_ = false;
  start_m_ = 0.0;
}

std::unique_ptr<StrategyStep> make_a4_passive_step(const ActuationModel&,
                                                   const HapticSettings& settings) {
  return std::make_unique<A4PassiveStep>(kJoulePerMillijoule * settings.strategy->parameter);
}

}  // namespace palpate
