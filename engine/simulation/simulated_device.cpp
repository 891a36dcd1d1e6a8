#include "engine/simulation/simulated_device.h"

#include <cmath>
#include <numbers>
#include <sstream>

#include "engine/simulation/standard_normal.h"
#include "haptics/record_vectors.h"

namespace palpate {
namespace {

// The bandwidth of the noise of the hand's force.
constexpr double kForceNoise_Hz = 6.0;

}  // namespace

SimulatedDevice::SimulatedDevice(const PlantSettings& settings, HandPlan& plan,
                                 const Vec3& start_device_m, const ScenePose& T_device_scene,
                                 bool planar)
    : settings_(settings),
      plan_(plan),
      planar_(planar),
      random_(settings.seed),
      position_m_(start_device_m) {
  put(T_device_scene, last_.q_after_wxyz, last_.o_after_m);
}

// Semi-implicit Euler of m x'' = -k x - c x' in steps of h has the characteristic polynomial z^2 -
// (2 - c h / m - k h^2 / m) z + 1 - c h / m. Its roots are inside the unit circle if and only if 2
// c h / m + k h^2 / m < 4 (Jury).
std::optional<Error> check_plant(const PlantSettings& settings, double dt_s) {
  const double h_s = dt_s / settings.substeps;
  const double mass_kg = settings.device.mass_kg + settings.hand.mass_kg;
  const auto is_followed = [&](double damping_Ns_per_m) {
    return (2.0 * damping_Ns_per_m + settings.hand.stiffness_N_per_m * h_s) * (h_s / mass_kg) < 4.0;
  };
  const double of_hand = settings.hand.damping_Ns_per_m;
  if (is_followed(settings.device.damping_Ns_per_m + of_hand)) return std::nullopt;
  const char* field = is_followed(of_hand) ? "device.damping_Ns_per_m" : "rate_Hz";
  std::ostringstream text;
  text << "makes the simulated hand unstable: damping " << settings.device.damping_Ns_per_m
       << " N s/m, step " << h_s << " s, mass " << mass_kg << " kg";
  return Error{ErrorCode::kInvalidArgument, "", field, text.str(),
               "reduce the damping, increase the mass or raise `RunSettings::rate_Hz`"};
}

DeviceSample SimulatedDevice::read(double dt_s) noexcept {
  // The first sample is the rest position: the proxy starts there.
  if (samples_++ > 0) move_hand(dt_s);
  const double quantum_m = settings_.device.encoder_quantum_m;
  Vec3 sensed_m = position_m_;
  // If the encoder steps are too small for the count to be finite, the position is not rounded.
  const Vec3 steps = quantum_m > 0.0 ? Vec3(position_m_ / quantum_m) : Vec3(Vec3::Zero());
  if (quantum_m > 0.0 && steps.allFinite()) sensed_m = steps.array().round() * quantum_m;
  DeviceSample sample;
  sample.position_m = {sensed_m.x(), sensed_m.y(), sensed_m.z()};
  sample.sequence = samples_;
  return sample;
}

void SimulatedDevice::move_hand(double dt_s) {
  HandTarget target = plan_.target(time_s_, pose_after(last_), last_);
  if (settings_.intention_noise_m > 0.0) target.position_m += intention_noise(dt_s);
  if (settings_.wander_m > 0.0) {
    target.position_m += settings_.wander_m * wander_.advance(settings_.wander_Hz, dt_s, random_);
  }
  if (settings_.force_noise > 0.0) advance_force_noise(dt_s);
  if (planar_) {
    target.position_m.z() = position_m_.z();
    target.velocity_m_per_s.z() = 0.0;
  }
  for (int i = 0; i < settings_.substeps; ++i) substep(target, dt_s / settings_.substeps);
  time_s_ += dt_s;
}

// First-order low-pass of white noise, scaled to the requested standard deviation at any rate.
Vec3 SimulatedDevice::intention_noise(double dt_s) {
  const double keep = std::exp(-2.0 * std::numbers::pi * settings_.intention_noise_Hz * dt_s);
  for (int k = 0; k < 3; ++k) {
    noise_m_[k] = keep * noise_m_[k] + settings_.intention_noise_m * std::sqrt(1.0 - keep * keep) *
                                           standard_normal(random_);
  }
  return noise_m_;
}

void SimulatedDevice::advance_force_noise(double dt_s) {
  const double keep = std::exp(-2.0 * std::numbers::pi * kForceNoise_Hz * dt_s);
  for (int k = 0; k < 3; ++k) {
    force_noise_[k] =
        keep * force_noise_[k] + std::sqrt(1.0 - keep * keep) * standard_normal(random_);
  }
}

void SimulatedDevice::substep(const HandTarget& target, double dt_s) {
  const double mass = settings_.device.mass_kg + settings_.hand.mass_kg;
  Vec3 hand = settings_.hand.stiffness_N_per_m * (target.position_m - position_m_) +
              settings_.hand.damping_Ns_per_m * (target.velocity_m_per_s - velocity_m_per_s_);
  if (settings_.force_noise > 0.0) hand += settings_.force_noise * hand.norm() * force_noise_;
  Vec3 force = force_N_ + hand - settings_.device.damping_Ns_per_m * velocity_m_per_s_;
  if (planar_) force.z() = 0.0;
  const Vec3 pushed = velocity_m_per_s_ + force * (dt_s / mass);
  // Coulomb friction reduces the speed to zero at most; it never accelerates the device.
  const double speed = pushed.norm();
  const double lost = settings_.device.coulomb_friction_N * dt_s / mass;
  velocity_m_per_s_ = speed > lost ? Vec3(pushed * (1.0 - lost / speed)) : Vec3(Vec3::Zero());
  position_m_ += dt_s * velocity_m_per_s_;
}

void SimulatedDevice::on_tick(const TickRecord& record) noexcept {
  last_ = record;
}

SimulatedDevice device_in_hand(PlantSettings plant, const RunSetup& setup, HandPlan& plan,
                               const Vec3& start_device_m) {
  if (setup.haptics.force == ForceMode::kFull) {
    give_all_motors(plant.device, setup.actuation.sensors());
  }
  return SimulatedDevice(plant, plan, start_device_m, setup.haptics.initial_pose,
                         setup.actuation.is_planar());
}

}  // namespace palpate
