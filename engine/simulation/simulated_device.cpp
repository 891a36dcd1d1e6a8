#include "engine/simulation/simulated_device.h"

#include <cmath>
#include <numbers>

namespace palpate {
namespace {

// Box-Muller on the engine's bits, so that every standard library draws the same numbers.
double standard_normal(std::mt19937_64& random) {
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
  return radius * std::cos(2.0 * std::numbers::pi * uniform());
}

}  // namespace

SimulatedDevice::SimulatedDevice(const PlantSettings& settings, HandPlan& plan,
                                 const Vec3& start_device_m, const ScenePose& T_device_scene,
                                 bool planar)
    : settings_(settings),
      plan_(plan),
      planar_(planar),
      random_(settings.seed),
      position_m_(start_device_m),
      T_device_scene_(T_device_scene) {}

Vec3 SimulatedDevice::read_position_m(double dt_s) noexcept {
  // The first sample is the rest position: the proxy starts there.
  if (started_) {
    HandTarget target = plan_.target(time_s_, T_device_scene_, last_);
    target.position_m += intention_noise(dt_s);
    if (planar_) {
      target.position_m.z() = position_m_.z();
      target.velocity_m_per_s.z() = 0.0;
    }
    for (int i = 0; i < settings_.substeps; ++i) substep(target, dt_s / settings_.substeps);
    time_s_ += dt_s;
  }
  started_ = true;
  if (settings_.encoder_quantum_m == 0.0) return position_m_;
  return (position_m_ / settings_.encoder_quantum_m).array().round() * settings_.encoder_quantum_m;
}

// First-order low-pass of white noise, scaled to the standard deviation asked for at any rate.
Vec3 SimulatedDevice::intention_noise(double dt_s) {
  const double keep = std::exp(-2.0 * std::numbers::pi * settings_.intention_noise_Hz * dt_s);
  for (int k = 0; k < 3; ++k) {
    noise_m_[k] = keep * noise_m_[k] + settings_.intention_noise_m * std::sqrt(1.0 - keep * keep) *
                                           standard_normal(random_);
  }
  return noise_m_;
}

void SimulatedDevice::substep(const HandTarget& target, double dt_s) {
  const double mass = settings_.device_mass_kg + settings_.hand_mass_kg;
  const Vec3 hand = settings_.hand_stiffness_N_per_m * (target.position_m - position_m_) +
                    settings_.hand_damping_Ns_per_m * (target.velocity_m_per_s - velocity_m_per_s_);
  Vec3 force = force_N_ + hand - settings_.viscous_friction_Ns_per_m * velocity_m_per_s_;
  if (planar_) force.z() = 0.0;
  const Vec3 pushed = velocity_m_per_s_ + force * (dt_s / mass);
  // Coulomb friction takes speed away and stops at zero: it never drives.
  const double speed = pushed.norm();
  const double lost = settings_.coulomb_friction_N * dt_s / mass;
  velocity_m_per_s_ = speed > lost ? Vec3(pushed * (1.0 - lost / speed)) : Vec3(Vec3::Zero());
  position_m_ += dt_s * velocity_m_per_s_;
}

void SimulatedDevice::on_tick(const TickRecord& record, const ScenePose& T_device_scene,
                              std::int64_t /*step_ns*/) noexcept {
  last_ = record;
  T_device_scene_ = T_device_scene;
}

}  // namespace palpate
