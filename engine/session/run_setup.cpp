#include "engine/session/run_setup.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <utility>

#include "haptics/check_settings.h"

namespace palpate {
namespace {

Result<ActuationModel> make_actuation(const RunSettings& settings) {
  const std::vector<Vec3>& axes = settings.actuated_axes;
  if (axes.empty()) {
    return ActuationModel::from_counts(
        settings.sensors,
        settings.actuators.value_or(std::min(settings.default_actuators, settings.sensors)));
  }
  if (settings.actuators && static_cast<std::size_t>(*settings.actuators) != axes.size()) {
    return invalid_argument("actuators",
                            "is " + std::to_string(*settings.actuators) +
                                ", but the number of `RunSettings::actuated_axes` is " +
                                std::to_string(axes.size()),
                            "leave `RunSettings::actuators` out");
  }
  return ActuationModel::from_axes(settings.sensors, axes);
}

std::optional<Error> check_number(const char* name, double value, bool zero_allowed) {
  if (std::isfinite(value) && (value > 0.0 || (zero_allowed && value == 0.0))) return std::nullopt;
  std::ostringstream text;
  text << "is " << value << "; expected a finite number " << (zero_allowed ? ">= 0" : "> 0");
  return invalid_argument(name, text.str());
}

std::optional<Error> check_numbers(const RunSettings& o) {
  if (auto e = check_number("rate_Hz", o.rate_Hz, false)) return e;
  if (!is_time_step(1.0 / o.rate_Hz)) {
    std::ostringstream text;
    text << "is " << o.rate_Hz << " Hz; expected at least " << 1.0 / kLongestTick_s << " Hz";
    return invalid_argument("rate_Hz", text.str(), "use for example 1000 Hz");
  }
  if (auto e = check_number("stiffness_N_per_m", o.stiffness_N_per_m, true)) return e;
  if (auto e = check_number("damping_Ns_per_m", o.damping_Ns_per_m, true)) return e;
  if (auto e = check_number("radius_m", o.radius_m, true)) return e;
  if (!std::isfinite(o.plane_height_m.value_or(0.0))) {
    return invalid_argument(
        "plane_height_m", "is " + std::to_string(*o.plane_height_m) + "; expected a finite number");
  }
  return std::nullopt;
}

// A limit may only lower the peak force of the device.
std::optional<Error> check_max_force(const RunSettings& settings) {
  if (!settings.max_force_N) return std::nullopt;
  const double limit_N = *settings.max_force_N;
  if (auto e = check_number("max_force_N", limit_N, false)) return e;
  const double peak_N = settings.device.peak_force_N;
  if (peak_N <= 0.0 || limit_N <= peak_N) return std::nullopt;
  std::ostringstream text;
  text << "is " << limit_N << " N; expected at most " << peak_N << " N, the peak force of the "
       << "device";
  return invalid_argument("max_force_N", text.str());
}

Result<VelocitySettings> make_velocity(const RunSettings& settings) {
  VelocitySettings velocity;
  velocity.method = settings.velocity_estimator;
  velocity.window_ticks = settings.velocity_window_ticks;
  if (velocity.window_ticks < 1 || velocity.window_ticks > VelocityEstimator::kMostTicks) {
    return invalid_argument("velocity_window_ticks",
                            "is " + std::to_string(velocity.window_ticks) +
                                " ticks; expected 1 to " +
                                std::to_string(VelocityEstimator::kMostTicks));
  }
  if (settings.encoder_quantum_m) {
    velocity.encoder_quantum_m = *settings.encoder_quantum_m;
    if (auto e = check_number("encoder_quantum_m", velocity.encoder_quantum_m, false)) return *e;
  } else if (velocity.method == VelocityMethod::kAdaptive) {
    return invalid_argument("velocity_estimator",
                            "is adaptive, which requires `RunSettings::encoder_quantum_m`",
                            "give the step of the device's encoders, such as "
                            "`RunSettings::encoder_quantum_m` 2e-5");
  }
  return velocity;
}

// The device description, with sensors, motors, encoders and rate replaced by the settings.
DeviceDescription device_of(const RunSettings& settings, const ActuationModel& actuation) {
  DeviceDescription device = settings.device;
  device.sensed_axes = actuation.sensors();
  device.motor_count = actuation.actuators();
  for (int i = 0; i < actuation.actuators(); ++i) {
    const Vec3& axis = actuation.actuated_axis(i);
    device.motors[static_cast<std::size_t>(i)].direction_device = {axis.x(), axis.y(), axis.z()};
  }
  if (settings.encoder_quantum_m) device.encoder_quantum_m = *settings.encoder_quantum_m;
  device.rate_Hz = settings.rate_Hz;
  return device;
}

}  // namespace

std::optional<Error> check_align(Alignment align, Table1Form table1, int actuators) {
  if (align == Alignment::kNearest) return std::nullopt;
  if (actuators != 1) {
    return invalid_argument("align",
                            "is forward, which is for one motor, but the device has " +
                                std::to_string(actuators) + "; expected nearest",
                            "use one motor, or leave the setting out");
  }
  if (table1 == Table1Form::kCorrected) return std::nullopt;
  return invalid_argument(
      "align",
      "is forward together with `RunSettings::table1` printed, which has a rule "
      "of its own; expected one of them",
      "leave one of the two out");
}

Result<RunSetup> make_setup(const RunSettings& settings) {
  if (auto error = check_numbers(settings)) return *error;
  if (auto error = check_max_force(settings)) return *error;
  const auto actuation = make_actuation(settings);
  if (!actuation) return actuation.error();
  if (auto error = check_align(settings.align, settings.table1, actuation->actuators())) {
    return *error;
  }
  if (settings.work_budget && *settings.work_budget < 1) {
    return invalid_argument("work_budget", "is " + std::to_string(*settings.work_budget) +
                                               "; expected at least 1 unit of work");
  }
  if (settings.work_budget && settings.measures_work_budget) {
    return invalid_argument("work_budget",
                            "is " + std::to_string(*settings.work_budget) +
                                " together with `RunSettings::measures_work_budget`; expected one "
                                "of them",
                            "leave one of the two out");
  }
  const auto velocity = make_velocity(settings);
  if (!velocity) return velocity.error();
  RunSetup setup{*actuation,
                 {},
                 1.0 / settings.rate_Hz,
                 settings.moves,
                 settings.max_force_N,
                 device_of(settings, *actuation)};
  setup.haptics.god_object.radius_m = settings.radius_m;
  setup.haptics.god_object.accuracy = settings.accuracy;
  if (settings.work_budget) setup.haptics.god_object.accuracy.work_budget = *settings.work_budget;
  if (settings.measures_work_budget) {
    setup.measured_budget = measured_work_budget(setup.dt_s);
    setup.haptics.god_object.accuracy.work_budget = setup.measured_budget->units;
  }
  setup.haptics.coupling = {settings.stiffness_N_per_m, settings.damping_Ns_per_m, *velocity};
  setup.haptics.force = settings.force;
  setup.haptics.a4.enabled = settings.a4;
  if (settings.strategy) set_strategy(*settings.strategy, setup.haptics);
  setup.haptics.a4.table1 = settings.table1;
  setup.haptics.a4.align = settings.align;
  setup.haptics.a4.step = settings.a4_step;
  setup.haptics.plane_height_m = settings.plane_height_m.value_or(0.0);
  setup.haptics.initial_pose = settings.place;
  setup.haptics.measures_effects = settings.effect_times;
  return setup;
}

void give_all_motors(DeviceDescription& device, int sensors) {
  device.motor_count = sensors;
  for (int i = 0; i < sensors; ++i) {
    const Vec3 axis = Vec3::Unit(i);
    device.motors[static_cast<std::size_t>(i)].direction_device = {axis.x(), axis.y(), axis.z()};
  }
}

std::optional<Error> check_setup(const Scene& scene, const RunSetup& setup) {
  const double extent_m = workspace_extent_m(setup.device);
  if (!(extent_m > 0.0)) {
    return invalid_argument("device.workspace",
                            "is " + std::to_string(extent_m) + " m; expected more than 0 m");
  }
  if (auto error = check_settings(scene.world(), setup.haptics)) return error;
  if (is_time_step(setup.dt_s)) return std::nullopt;
  std::ostringstream text;
  text << "gives ticks of " << setup.dt_s << " s; expected more than 0 s and at most "
       << kLongestTick_s << " s";
  return invalid_argument("rate_Hz", text.str());
}

}  // namespace palpate
