#include "engine/session/run_setup.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <utility>

#include "engine/session/run_setting.h"
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

// Checks the numbers of one type.
template <class Number>
std::optional<Error> check_numbers(RunSettings settings) {
  for (const RunSetting& setting : run_settings()) {
    if (setting.option.empty()) continue;  // check_setup() checks it
    // A driver may leave out the mechanics of its device.
    if (setting.group == SettingGroup::kMechanics) continue;
    std::optional<Number> value;
    if (const auto* at = std::get_if<SettingPlace<Number>>(&setting.value)) {
      value = at->of(settings);
    } else if (const auto* maybe =
                   std::get_if<SettingPlace<std::optional<Number>>>(&setting.value)) {
      value = maybe->of(settings);
    }
    if (!value) continue;
    if (auto error = check_range(setting, *value)) return error;
  }
  return std::nullopt;
}

std::optional<Error> check_rate(double rate_Hz) {
  if (is_time_step(1.0 / rate_Hz)) return std::nullopt;
  std::ostringstream text;
  text << "is " << rate_Hz << " Hz; expected at least " << 1.0 / kLongestTick_s << " Hz";
  return invalid_argument("rate_Hz", text.str(), "use for example 1000 Hz");
}

// A limit may only lower the peak force of the device.
std::optional<Error> check_max_force(const RunSettings& settings) {
  if (!settings.max_force_N) return std::nullopt;
  const double limit_N = *settings.max_force_N;
  const double peak_N = settings.device.peak_force_N;
  if (peak_N <= 0.0 || limit_N <= peak_N) return std::nullopt;
  std::ostringstream text;
  text << "is " << limit_N << " N; expected at most " << peak_N << " N, the peak force of the "
       << "device";
  return invalid_argument("max_force_N", text.str());
}

std::optional<Error> check_energy_budgets(const EnergyBudgets& budgets) {
  for (std::size_t n = 0; n < kEnergySourceCount; ++n) {
    const EnergyBudget& budget = budgets.of[n];
    if (budget.is_in_range()) continue;
    std::ostringstream text;
    text << "has " << 1e3 * budget.tank_J << " mJ and " << budget.power_W << " W for "
         << kEnergySourceNames[n] << "; expected 0 to " << 1e3 * EnergyBudget::kMost_J
         << " mJ and 0 to " << EnergyBudget::kMost_W << " W";
    return invalid_argument("energy_budgets", text.str());
  }
  return std::nullopt;
}

Result<VelocitySettings> make_velocity(const RunSettings& settings) {
  VelocitySettings velocity = settings.haptics.coupling.velocity;
  if (settings.encoder_quantum_m) {
    velocity.encoder_quantum_m = *settings.encoder_quantum_m;
  } else if (velocity.method == VelocityMethod::kAdaptive) {
    return invalid_argument("coupling.velocity.method",
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
    return invalid_argument("a4.align",
                            "is forward, which is for one motor, but the device has " +
                                std::to_string(actuators) + "; expected nearest",
                            "use one motor, or leave the setting out");
  }
  if (table1 == Table1Form::kCorrected) return std::nullopt;
  return invalid_argument(
      "a4.align",
      "is forward together with `HapticSettings::a4.table1` printed, which has a rule "
      "of its own; expected one of them",
      "leave one of the two out");
}

Result<RunSetup> make_setup(const RunSettings& settings) {
  if (auto error = check_numbers<double>(settings)) return *error;
  if (auto error = check_rate(settings.rate_Hz)) return *error;
  if (auto error = check_max_force(settings)) return *error;
  if (auto error = check_energy_budgets(settings.energy_budgets)) return *error;
  const auto actuation = make_actuation(settings);
  if (!actuation) return actuation.error();
  if (auto error = check_align(settings.haptics.a4.align, settings.haptics.a4.table1,
                               actuation->actuators())) {
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
  if (auto error = check_numbers<int>(settings)) return *error;
  const auto velocity = make_velocity(settings);
  if (!velocity) return velocity.error();
  RunSetup setup{*actuation,
                 {},
                 1.0 / settings.rate_Hz,
                 settings.moves,
                 settings.max_force_N,
                 device_of(settings, *actuation)};
  setup.haptics = settings.haptics;
  setup.governor.budgets = settings.energy_budgets;
  if (settings.work_budget) setup.haptics.god_object.accuracy.work_budget = *settings.work_budget;
  if (settings.measures_work_budget) {
    setup.measured_budget = measured_work_budget(setup.dt_s);
    setup.haptics.god_object.accuracy.work_budget = setup.measured_budget->units;
  }
  setup.haptics.coupling.velocity = *velocity;
  if (settings.strategy) set_strategy(*settings.strategy, setup.haptics);
  setup.haptics.plane_height_m = settings.plane_height_m.value_or(0.0);
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
                            "is " + std::to_string(extent_m) + " m; expected more than 0 m",
                            "the description of the device states it, for each axis");
  }
  if (auto error = check_settings(scene.world(), setup.haptics)) return error;
  if (is_time_step(setup.dt_s)) return std::nullopt;
  std::ostringstream text;
  text << "gives ticks of " << setup.dt_s << " s; expected more than 0 s and at most "
       << kLongestTick_s << " s";
  return invalid_argument("rate_Hz", text.str());
}

}  // namespace palpate
