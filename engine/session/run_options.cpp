#include "engine/session/run_options.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <sstream>
#include <utility>
#include <vector>

#include "engine/scene/memory_budget.h"
#include "haptics/check_settings.h"

namespace palpate {
namespace {

Error invalid(std::string option, std::string problem, std::string hint = "") {
  return {ErrorCode::kInvalidArgument, "", std::move(option), std::move(problem), std::move(hint)};
}

// Finite numbers separated by blanks or commas; nothing if anything else is there.
std::optional<std::vector<double>> parse_numbers(const std::string& text) {
  std::string blanks = text;
  for (char& c : blanks) {
    if (c == ',') c = ' ';
  }
  std::istringstream words(blanks);
  std::vector<double> numbers;
  for (std::string word; words >> word;) {
    const char* end = word.data() + word.size();
    const char* begin = word.data() + (word.starts_with('+') ? 1 : 0);  // which from_chars refuses
    double x = 0.0;
    const auto [rest, failed] = std::from_chars(begin, end, x);
    if (failed != std::errc() || rest != end || !std::isfinite(x)) return std::nullopt;
    numbers.push_back(x);
  }
  return numbers;
}

Result<std::vector<Vec3>> parse_axes(const std::string& text) {
  std::vector<Vec3> axes;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, ';');) {
    const auto numbers = parse_numbers(part);
    if (numbers && numbers->empty()) continue;  // after a closing semicolon
    if (!numbers || numbers->size() != 3) {
      return invalid("--actuated-axes", "\"" + part + "\" is not three numbers",
                     "write for example \"0 0 1; 1 0 0\"");
    }
    axes.emplace_back((*numbers)[0], (*numbers)[1], (*numbers)[2]);
  }
  return axes;
}

Result<ScenePose> parse_place(const std::string& text) {
  ScenePose pose;
  if (text.empty()) return pose;
  const auto n = parse_numbers(text);
  if (!n || n->size() != 7) {
    return invalid("--place", "\"" + text + "\" is not seven numbers \"x y z qw qx qy qz\"",
                   "metres and a quaternion, identity is \"0 0 0 1 0 0 0\"");
  }
  const Quat q((*n)[3], (*n)[4], (*n)[5], (*n)[6]);
  const double norm = q.norm();
  // Typed with six digits or more, a unit quaternion has this length; what has not is a mistake.
  constexpr double kTypedUnit = 1e-4;
  if (!(std::abs(norm - 1.0) <= kTypedUnit)) {
    return invalid("--place", "the quaternion has length " + std::to_string(norm) + ", expected 1");
  }
  pose.rotation = norm == 1.0 ? q : Quat(q.normalized());
  pose.translation_m = {(*n)[0], (*n)[1], (*n)[2]};
  return pose;
}

// The name may hold equals signs, the numbers do not.
Result<SteadyMotion> parse_move(const std::string& text) {
  const std::size_t equals = text.rfind('=');
  const auto n =
      equals == std::string::npos ? std::nullopt : parse_numbers(text.substr(equals + 1));
  if (!n || n->size() != 6 || equals == 0) {
    return invalid("--move", "\"" + text + "\" is not NODE=\"vx vy vz wx wy wz\"",
                   "metres and radians a second along the axes of the scene");
  }
  const SteadyMotion motion{
      text.substr(0, equals), {(*n)[0], (*n)[1], (*n)[2]}, {(*n)[3], (*n)[4], (*n)[5]}};
  if (!std::isfinite(motion.velocity_m_per_s.norm()) ||
      !std::isfinite(motion.turn_rad_per_s.norm())) {
    return invalid("--move", "\"" + text + "\" is too fast to be a motion");
  }
  return motion;
}

Result<std::vector<SteadyMotion>> parse_moves(const std::vector<std::string>& texts) {
  std::vector<SteadyMotion> motions;
  for (const std::string& text : texts) {
    const auto motion = parse_move(text);
    if (!motion) return motion.error();
    motions.push_back(*motion);
  }
  return motions;
}

// The name may hold dots, the key does not; neither does the value hold equals signs.
Result<std::vector<MaterialOverride>> parse_overrides(const std::vector<std::string>& texts) {
  std::vector<MaterialOverride> overrides;
  for (const std::string& text : texts) {
    const std::size_t equals = text.rfind('=');
    const std::size_t dot = equals == std::string::npos || equals == 0
                                ? std::string::npos
                                : text.rfind('.', equals - 1);
    const bool is_whole =
        dot != std::string::npos && dot > 0 && dot + 1 < equals && equals + 1 < text.size();
    if (!is_whole) {
      return invalid("--material", "\"" + text + "\" is not NAME.key=value",
                     "for example wood.stiffness=800");
    }
    overrides.push_back(
        {text.substr(0, dot), text.substr(dot + 1, equals - dot - 1), text.substr(equals + 1)});
  }
  return overrides;
}

Result<ActuationModel> make_actuation(const RunOptions& options) {
  if (options.actuated_axes.empty()) {
    return ActuationModel::from_counts(
        options.sensors,
        options.actuators.value_or(std::min(options.default_actuators, options.sensors)));
  }
  auto axes = parse_axes(options.actuated_axes);
  if (!axes) return axes.error();
  if (options.actuators && static_cast<std::size_t>(*options.actuators) != axes->size()) {
    return invalid("--actuators",
                   std::to_string(*options.actuators) + " actuators, but --actuated-axes gives " +
                       std::to_string(axes->size()) + " directions",
                   "leave --actuators out");
  }
  return ActuationModel::from_axes(options.sensors, *axes);
}

std::optional<Error> check_number(const char* name, double value, bool zero_allowed) {
  if (std::isfinite(value) && (value > 0.0 || (zero_allowed && value == 0.0))) return std::nullopt;
  std::ostringstream text;
  text << value << " given, expected a finite number " << (zero_allowed ? ">= 0" : "> 0");
  return invalid(name, text.str());
}

std::optional<Error> check_numbers(const RunOptions& o) {
  if (auto e = check_number("--rate", o.rate_Hz, false)) return e;
  if (!is_time_step(1.0 / o.rate_Hz)) {
    std::ostringstream text;
    text << o.rate_Hz << " Hz given, expected at least " << 1.0 / kLongestTick_s;
    return invalid("--rate", text.str(), "1000 Hz is usual");
  }
  if (auto e = check_number("--stiffness", o.stiffness_N_per_m, true)) return e;
  if (auto e = check_number("--damping", o.damping_Ns_per_m, true)) return e;
  if (auto e = check_number("--radius", o.radius_m, true)) return e;
  if (!std::isfinite(o.plane_height_m.value_or(0.0)))
    return invalid("--plane-height", "not a finite number");
  return std::nullopt;
}

Result<VelocitySettings> make_velocity(const RunOptions& options) {
  VelocitySettings velocity;
  velocity.method = options.velocity_estimator == "line"       ? VelocityMethod::kLineFit
                    : options.velocity_estimator == "adaptive" ? VelocityMethod::kAdaptive
                                                               : VelocityMethod::kDifference;
  velocity.window_ticks = options.velocity_window_ticks;
  if (velocity.window_ticks < 1 || velocity.window_ticks > VelocityEstimator::kMostTicks) {
    return invalid("--velocity-window", std::to_string(velocity.window_ticks) +
                                            " ticks given, expected 1 to " +
                                            std::to_string(VelocityEstimator::kMostTicks));
  }
  if (options.encoder_quantum_m) {
    velocity.encoder_quantum_m = *options.encoder_quantum_m;
    if (auto e = check_number("--encoder-quantum", velocity.encoder_quantum_m, false)) return *e;
  } else if (velocity.method == VelocityMethod::kAdaptive) {
    return invalid("--velocity-estimator",
                   "adaptive given without --encoder-quantum, by which it chooses its window",
                   "give the step of the device's encoders, such as --encoder-quantum 2e-5");
  }
  return velocity;
}

// What the options say of sensors, motors, encoders and rate, a description says, too.
DeviceDescription device_of(const RunOptions& options, const ActuationModel& actuation) {
  DeviceDescription device = options.device;
  device.sensed_axes = actuation.sensors();
  device.motor_count = actuation.actuators();
  for (int i = 0; i < actuation.actuators(); ++i) {
    const Vec3& axis = actuation.actuated_axis(i);
    device.motors[static_cast<std::size_t>(i)].direction_device = {axis.x(), axis.y(), axis.z()};
  }
  if (options.encoder_quantum_m) device.encoder_quantum_m = *options.encoder_quantum_m;
  device.rate_Hz = options.rate_Hz;
  return device;
}

}  // namespace

Result<RunSetup> make_setup(const RunOptions& options) {
  if (auto error = check_numbers(options)) return *error;
  const auto actuation = make_actuation(options);
  if (!actuation) return actuation.error();
  const auto pose = parse_place(options.place);
  if (!pose) return pose.error();
  const auto accuracy = accuracy_preset(options.accuracy);
  if (!accuracy) {
    return invalid("--accuracy", "\"" + options.accuracy + "\" is none of fast, balanced, exact");
  }
  if (options.work_budget && *options.work_budget < 1) {
    return invalid("--work-budget",
                   std::to_string(*options.work_budget) + " given, expected at least 1 unit");
  }
  const auto velocity = make_velocity(options);
  if (!velocity) return velocity.error();
  auto moves = parse_moves(options.moves);
  if (!moves) return moves.error();
  RunSetup setup{
      *actuation, {}, 1.0 / options.rate_Hz, std::move(*moves), device_of(options, *actuation)};
  setup.haptics.god_object.radius_m = options.radius_m;
  setup.haptics.god_object.accuracy = *accuracy;
  if (options.work_budget) setup.haptics.god_object.accuracy.work_budget = *options.work_budget;
  setup.haptics.coupling = {options.stiffness_N_per_m, options.damping_Ns_per_m, *velocity};
  setup.haptics.force = options.force == "none"   ? ForceMode::kNone
                        : options.force == "full" ? ForceMode::kFull
                                                  : ForceMode::kActuated;
  setup.haptics.a4.enabled = options.a4 == "on";
  setup.haptics.a4.table1 =
      options.table1 == "printed" ? Table1Form::kAsPrinted : Table1Form::kCorrected;
  setup.haptics.a4.step = options.a4_step == "paper" ? StepRule::kSpeedByDt : StepRule::kExact;
  setup.haptics.plane_height_m = options.plane_height_m.value_or(0.0);
  setup.haptics.initial_pose = *pose;
  setup.haptics.measures_effects = options.effect_times;
  return setup;
}

std::optional<Error> check_setup(const Scene& scene, const RunSetup& setup) {
  const double extent_m = workspace_extent_m(setup.device);
  if (!(extent_m > 0.0)) {
    return invalid("--workspace", std::to_string(extent_m) + " m given, expected > 0");
  }
  auto error = check_settings(scene.world(), setup.haptics);
  if (!error) {
    if (is_time_step(setup.dt_s)) return std::nullopt;
    std::ostringstream text;
    text << setup.dt_s << " s a tick, expected above 0 to " << kLongestTick_s;
    return invalid("--rate", text.str());
  }
  constexpr std::pair<const char*, const char*> kOptions[] = {
      {"god_object.radius_m", "--radius"},
      {"coupling.stiffness_N_per_m", "--stiffness"},
      {"coupling.damping_Ns_per_m", "--damping"},
      {"plane_height_m", "--plane-height"},
      {"initial_pose", "--place"}};
  for (const auto& [field, option] : kOptions) {
    if (error->element == field) error->element = option;
  }
  return error;
}

Result<Scene> load_scene(const SceneOptions& options, double proxy_radius_m) {
  SceneSettings settings;
  settings.proxy_radius_m = proxy_radius_m;
  settings.node = options.node;
  settings.pose = options.pose;
  if (options.scale && options.fit_size_m) {
    return invalid("--fit", "given together with --scale; expected one of them");
  }
  if (options.fits_workspace) {
    return invalid("--fit", "auto given without a workspace to fit to",
                   "give the largest extent in metres, such as --fit 0.2");
  }
  if (options.scale) {
    if (auto error = check_number("--scale", *options.scale, false)) return *error;
    settings.scale = *options.scale;
  }
  if (options.fit_size_m) {
    if (auto error = check_number("--fit", *options.fit_size_m, false)) return *error;
    settings.fit_size_m = *options.fit_size_m;
  }
  if (!options.max_memory.empty()) {
    const auto bytes = parse_bytes(options.max_memory);
    if (!bytes) return bytes.error();
    settings.max_memory_bytes = *bytes;
  }
  auto overrides = parse_overrides(options.materials);
  if (!overrides) return overrides.error();
  settings.overrides = std::move(*overrides);
  return Scene::load(options.path, settings);
}

Result<Scene> load_scene(const SceneOptions& options, const RunOptions& run) {
  auto scene = load_scene(options, run.radius_m);
  if (!scene) return scene;
  if (auto error = check_tick_rate(scene->effects(), run.rate_Hz)) {
    error->path = options.path;
    return *error;
  }
  return scene;
}

}  // namespace palpate
