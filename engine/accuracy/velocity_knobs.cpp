// The accuracy of the damper's velocity: which estimator, over which window.
//
// A hand presses into a flat sheet along its normal N. The loop reports the force F and the lag x
// of the proxy, so the velocity that its damper used is (F.N - K x.N) / B.

#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "engine/accuracy/error_measures.h"
#include "engine/accuracy/flat_sheet.h"
#include "engine/accuracy/knobs.h"
#include "engine/accuracy/session_pass.h"
#include "engine/devices/light_device.h"
#include "engine/report/human_units.h"
#include "haptics/record_vectors.h"

namespace palpate {
namespace {

constexpr double kPi = std::numbers::pi;

// The same at all levels of all three knobs.
constexpr double kStiffness_N_per_m = 1000.0;
constexpr double kDamping_Ns_per_m = 2.0;
constexpr double kTick_s = 1e-3;
constexpr std::array kWindows_ticks = {1, 2, 4, 8, 16, 32};

// A tick above the sheet, then enough ticks to fill the longest window of any estimator.
constexpr std::size_t kTicksUntilFull = 2 + VelocityEstimator::kMostTicks;

// The hand: its depth below the sheet, and the rate at which the depth grows.
struct Press {
  double depth_m;
  double speed_m_per_s;
  Eigen::Vector2d along_m = Eigen::Vector2d::Zero();  // displacement along the sheet
};
using HandMotion = std::function<Press(double time_s)>;

// The differences between the three knobs. `seconds`: how long the hand presses.
struct Workload {
  HandMotion (*hand)(SeededRandom& random, double seconds);
  double sensed_quantum_m;     // positions are rounded to it; 0: exact positions
  double estimator_quantum_m;  // for the adaptive estimator, > 0
  double (*error)(std::span<const double> errors_m_per_s);
};

double root_mean_square(std::span<const double> values) {
  RootMeanSquare rms;
  for (const double v : values) rms.add(v);
  return rms.value();
}

double size_of_mean(std::span<const double> values) {
  double sum = 0.0;
  for (const double v : values) sum += v;
  return std::abs(sum) / static_cast<double>(values.size());
}

// Slow and steady. The hand also stirs along the sheet, by five quanta of 20 µm a tick, so that the
// rounding of each encoder is practically random from tick to tick, however slowly the hand
// presses. The stirring does not affect the damper.
HandMotion steady_hand(SeededRandom& random, double) {
  constexpr double kStir_m = 5e-3;
  constexpr double kStir_Hz = 3.0;
  const double speed_m_per_s = random.uniform(4e-3, 6e-3);
  const double phase = random.uniform(0.0, 2.0 * kPi);
  return [=](double time_s) {
    const double turn = phase + 2.0 * kPi * kStir_Hz * time_s;
    return Press{1e-3 + speed_m_per_s * time_s, speed_m_per_s,
                 kStir_m * Eigen::Vector2d(std::cos(turn), std::sin(turn))};
  };
}

constexpr double kAcceleration_m_per_s2 = 0.5;

// Moves out and in again, with a speed of zero in the middle.
HandMotion accelerating_hand(SeededRandom& random, double seconds) {
  const double least_m = random.uniform(1e-3, 2e-3);
  return [=](double time_s) {
    const double from_middle_s = time_s - 0.5 * seconds;
    return Press{least_m + 0.5 * kAcceleration_m_per_s2 * from_middle_s * from_middle_s,
                 kAcceleration_m_per_s2 * from_middle_s};
  };
}

// 10 mm to either side, twice a second: 1.1 m/s² rms.
HandMotion swinging_hand(SeededRandom& random, double) {
  constexpr double kSwing_m = 10e-3;
  constexpr double kSwing_rad_per_s = 2.0 * kPi * 2.0;
  const double phase = random.uniform(0.0, 2.0 * kPi);
  return [=](double time_s) {
    const double turn = phase + kSwing_rad_per_s * time_s;
    return Press{kSwing_m + 2e-3 + kSwing_m * std::sin(turn),
                 kSwing_m * kSwing_rad_per_s * std::cos(turn)};
  };
}

// A position as encoders along the axes of the device sense it.
Vec3 sensed(const Vec3& p_m, double quantum_m) {
  if (quantum_m == 0.0) return p_m;
  return (p_m / quantum_m).array().round().matrix() * quantum_m;
}

struct Estimate {
  VelocitySettings velocity;
  Accuracy accuracy;
};

Sample run_hand(const Workload& workload, std::size_t ticks, const Estimate& estimate,
                std::uint64_t seed) {
  SeededRandom random(seed);
  const Vec3 normal = random.unit_vector();
  const FlatSheet sheet(normal, random);
  const HandMotion hand =
      workload.hand(random, static_cast<double>(kTicksUntilFull + ticks) * kTick_s);
  std::vector<Vec3> path_m{sheet.below(-1e-3)};
  std::vector<double> speeds_m_per_s{0.0};
  for (std::size_t n = 1; n < kTicksUntilFull + ticks; ++n) {
    const Press press = hand(static_cast<double>(n) * kTick_s);
    path_m.push_back(sensed(sheet.below(press.depth_m, press.along_m), workload.sensed_quantum_m));
    speeds_m_per_s.push_back(press.speed_m_per_s);
  }
  const PassSetup setup = PassSetup::fully_actuated(
      {kStiffness_N_per_m, kDamping_Ns_per_m, estimate.velocity}, {0.0, estimate.accuracy});
  std::vector<double> errors_m_per_s;
  bool is_clamped = false;
  const PassCost cost = run_path(
      sheet.world(), setup, path_m, kTick_s, kTicksUntilFull, [&](const TickRecord& record) {
        const double force_N = vec3(record.force_device_N).dot(normal);
        const double lag_m = (vec3(record.proxy_scene_m) - vec3(record.goal_scene_m)).dot(normal);
        const double used_m_per_s = (force_N - kStiffness_N_per_m * lag_m) / kDamping_Ns_per_m;
        errors_m_per_s.push_back(used_m_per_s - speeds_m_per_s[record.tick]);
        is_clamped = is_clamped || !(force_N > 0.0);
      });
  Sample sample{0.0, cost.tick_ns, cost.iterations, cost.ticks, failure_of(cost.faults)};
  if (is_clamped) sample.failure = "the force was clamped: the coupling would have pulled";
  if (cost.ticks != ticks) sample.failure = "lost contact";
  if (sample.failure.empty()) sample.error = workload.error(errors_m_per_s);
  return sample;
}

std::string window_label(int window_ticks) {
  return std::to_string(window_ticks) + (window_ticks == 1 ? " tick" : " ticks");
}

// One curve per estimator, with the orders of the difference and of the line fit.
std::vector<Method> methods(const Workload& workload, std::size_t ticks,
                            std::optional<double> difference_order,
                            std::optional<double> line_fit_order) {
  const auto method = [&](const char* name, VelocityMethod how, std::optional<double> order) {
    Method curve{name, {}, order};
    for (const int window : kWindows_ticks) {
      if (window == 1 && how != VelocityMethod::kDifference) continue;  // all methods are the same
      const Estimate estimate{{how, window, workload.estimator_quantum_m}, {}};
      curve.levels.push_back(
          {static_cast<double>(window), window_label(window),
           [=](std::uint64_t seed) { return run_hand(workload, ticks, estimate, seed); }});
    }
    return curve;
  };
  return {method("difference", VelocityMethod::kDifference, difference_order),
          method("line fit", VelocityMethod::kLineFit, line_fit_order),
          method("adaptive", VelocityMethod::kAdaptive, {})};
}

// The common part of the three knobs.
Knob velocity_knob(const Workload& workload, std::size_t ticks) {
  Knob knob;
  knob.level = {"window", "ticks"};
  knob.error = {"velocity error", "m/s"};
  knob.time = {"time of a tick", "ns"};
  knob.run_preset = [=](std::uint64_t seed, const Accuracy& preset) {
    return run_hand(workload, ticks,
                    {{VelocityMethod::kDifference, 1, workload.estimator_quantum_m}, preset}, seed);
  };
  knob.enough = 0.01 / kDamping_Ns_per_m;
  knob.enough_because =
      "the damper turns it into 0.01 N, a hundredth of a light press of 1 N; a hand distinguishes "
      "forces that differ by some 7 %";
  knob.default_because =
      "with a window of one tick the damper dissipates energy in every tick, as a real damper "
      "does, "
      "and lags least; with a longer window it returns part of the energy";
  return knob;
}

// The adaptive estimator needs a quantum; that of a common encoder if the device states none.
double estimator_quantum_m(const DeviceDescription& device) {
  return device.encoder_quantum_m > 0.0 ? device.encoder_quantum_m
                                        : light_device().encoder_quantum_m;
}

std::string sensed_text(const DeviceDescription& device) {
  if (!(device.encoder_quantum_m > 0.0)) return "sensed exactly";
  return "sensed in steps of q = " + human(device.encoder_quantum_m, "m") + " on each axis";
}

Knob noise_knob(const DeviceDescription& device, std::size_t ticks) {
  const Workload workload{steady_hand, device.encoder_quantum_m, estimator_quantum_m(device),
                          root_mean_square};
  Knob knob = velocity_knob(workload, ticks);
  knob.name = "velocity_noise";
  knob.title = "Velocity window: noise";
  knob.workload =
      "a hand presses into a flat sheet in any pose at a steady 4 to 6 mm/s and stirs along the "
      "sheet, " +
      sensed_text(device) + "; K = 1000 N/m, B = 2 N s/m, T = 1 ms";
  knob.reference =
      "the speed of the hand; rms over the ticks. Theory for a difference over w ticks: "
      "q / (√6 w T), for a line fit q / (T √(w (w + 1) (w + 2)))";
  knob.decided_by = "velocity_total";
  // The order of a line fit changes from -0.9 at one tick to -1.5 at many.
  knob.methods = methods(workload, ticks, -1.0, {});
  return knob;
}

Knob lag_knob(const DeviceDescription& device, std::size_t ticks) {
  const Workload workload{accelerating_hand, 0.0, estimator_quantum_m(device), size_of_mean};
  Knob knob = velocity_knob(workload, ticks);
  knob.name = "velocity_lag";
  knob.title = "Velocity window: lag";
  knob.workload =
      "a hand in a flat sheet in any pose, at a steady acceleration of a = 0.5 m/s² into it, "
      "sensed exactly (the adaptive estimator assumes q = " +
      human(estimator_quantum_m(device), "m") + "); K = 1000 N/m, B = 2 N s/m, T = 1 ms";
  knob.reference =
      "the speed of the hand; size of the mean over the ticks. Theory for a difference and a line "
      "fit over w ticks: a w T / 2";
  knob.decided_by = "velocity_total";
  knob.methods = methods(workload, ticks, 1.0, 1.0);
  return knob;
}

Knob total_knob(const DeviceDescription& device, std::size_t ticks) {
  const Workload workload{swinging_hand, device.encoder_quantum_m, estimator_quantum_m(device),
                          root_mean_square};
  Knob knob = velocity_knob(workload, ticks);
  knob.name = "velocity_total";
  knob.title = "Velocity window: noise and lag";
  knob.workload =
      "a hand in a flat sheet in any pose moves in and out by 10 mm to either side at 2 Hz, " +
      sensed_text(device) + "; K = 1000 N/m, B = 2 N s/m, T = 1 ms";
  knob.reference = "the speed of the hand; rms over the ticks";
  knob.methods = methods(workload, ticks, {}, {});
  return knob;
}

}  // namespace

std::vector<Knob> velocity_knobs(const MeasurementEffort& effort, const DeviceDescription& device) {
  // Whole periods of the swinging hand.
  const std::size_t ticks = effort.quick ? 500 : 1000;
  // The error is the same in every tick; more ticks would take the hand deeper than 15 mm.
  constexpr std::size_t kAcceleratingTicks = 400;
  return {noise_knob(device, ticks), lag_knob(device, kAcceleratingTicks),
          total_knob(device, ticks)};
}

}  // namespace palpate
