#include "engine/cli/run_options.h"

#include <algorithm>
#include <sstream>

#include "engine/cli/command_help.h"
#include "engine/cli/number_option.h"
#include "engine/cli/setting_texts.h"

namespace palpate {
namespace {

// More than any tick that anybody waits for, and no sum of work overflows.
constexpr std::uint64_t kMostWorkBudget = 1'000'000'000'000;

}  // namespace

void add_place(CLI::App& app, RunOptions& options) {
  app.add_option("--place", options.place,
                 "pose of the scene in the device frame, \"x y z qw qx qy qz\"")
      ->group(kSceneGroup);
  app.add_option(
         "--move", options.moves,
         "NODE=\"vx vy vz wx wy wz\": the node moves steadily, m/s and rad/s along and about "
         "the axes of the scene; may be repeated")
      ->expected(1)
      ->take_all()
      ->group(kSceneGroup);
}

void add_device(CLI::App& app, RunOptions& options, const std::string& quantum_help) {
  RunSettings& settings = options.settings;
  add_integer(app, "--sensors", settings.sensors, {2, 3},
              "sensed axes, 2 or 3: the first N of A1 A2 A3")
      ->group(kDeviceGroup);
  add_integer(app, "--actuators", settings.actuators, {0, 3},
              "actuated axes: the first M [" + std::to_string(settings.default_actuators) +
                  ", but no more than sensors]")
      ->group(kDeviceGroup);
  app.add_option("--actuated-axes", options.actuated_axes,
                 "directions that push instead, device frame, as \"0 0 1; 1 0 0\"")
      ->group(kDeviceGroup);
  add_choice<ForceMode>(
      app, "--force", settings.force,
      {{"none", ForceMode::kNone}, {"actuated", ForceMode::kActuated}, {"full", ForceMode::kFull}},
      "actuated", "what the actuators are told")
      ->group(kDeviceGroup);
  add_real(app, "--rate", settings.rate_Hz, {1.0 / kLongestTick_s}, "ticks a second, Hz")
      ->group(kDeviceGroup);
  add_real(
      app, "--plane-height", settings.plane_height_m, {},
      "with 2 sensors: where on A3 the plane A1 A2 lies, m; by default 0, and in `run` through "
      "the middle of the object, or the nearest height with a contour")
      ->group(kDeviceGroup);
  add_real(app, "--encoder-quantum", settings.encoder_quantum_m, kAboveZero, quantum_help)
      ->group(kDeviceGroup);
}

void add_workspace(CLI::App& app, DeviceDescription& device) {
  const auto read = [&device](const std::string& text) {
    const auto extent_m = parse_real("--workspace", text, kAboveZero);
    if (!extent_m) throw CLI::ValidationError("--workspace", extent_m.error().problem);
    set_workspace_extent(device, *extent_m);
  };
  std::ostringstream usual;
  usual << workspace_extent_m(device);
  app.add_option_function<std::string>("--workspace", read,
                                       "extent of the device along an axis, m; more is flagged")
      ->type_name("NUMBER")
      ->default_str(usual.str())
      ->group(kDeviceGroup);
}

std::vector<CLI::Option*> add_mechanics(CLI::App& app, DeviceDescription& device) {
  return {
      add_real(app, "--device-mass", device.mass_kg, kAboveZero, "of the device at its tip, kg"),
      add_real(app, "--device-damping", device.damping_Ns_per_m, kZeroOrMore,
               "viscous, of the device, N s/m"),
      add_real(app, "--device-friction", device.coulomb_friction_N, kZeroOrMore,
               "Coulomb, of the device, N")};
}

void add_touch(CLI::App& app, RunSettings& settings) {
  add_real(app, "--stiffness", settings.stiffness_N_per_m, kZeroOrMore,
           "coupling spring of surfaces without their own, N/m")
      ->group(kTouchGroup);
  add_real(app, "--damping", settings.damping_Ns_per_m, kZeroOrMore,
           "coupling damper of surfaces without their own, N s/m")
      ->group(kTouchGroup);
  add_real(app, "--radius", settings.radius_m, kZeroOrMore, "radius of the proxy, m; 0 is a point")
      ->group(kTouchGroup);
  add_choice<Accuracy>(app, "--accuracy", settings.accuracy,
                       {{"fast", Accuracy::fast()},
                        {"balanced", Accuracy::balanced()},
                        {"exact", Accuracy::exact()}},
                       "balanced",
                       "of the proxy: fast (few steps, uncertified), balanced, or exact")
      ->group(kTouchGroup);
  add_integer(app, "--work-budget", settings.work_budget, {1, kMostWorkBudget},
              "what a tick may do at most, in units of 10 to 20 ns; by default as --accuracy "
              "says (5000, 20000 or 160000)")
      ->group(kTouchGroup);
  add_choice<VelocityMethod>(
      app, "--velocity-estimator", settings.velocity_estimator,
      {{"difference", VelocityMethod::kDifference},
       {"line", VelocityMethod::kLineFit},
       {"adaptive", VelocityMethod::kAdaptive}},
      "difference",
      "of the damper: difference over the window, straight line fitted to it, or "
      "adaptive: the longest window that is straight to an encoder's step")
      ->group(kTouchGroup);
  add_integer(app, "--velocity-window", settings.velocity_window_ticks,
              {1, VelocityEstimator::kMostTicks},
              "window of the damper's velocity, 1 to 63 ticks: longer is less noisy, and later")
      ->group(kTouchGroup);
}

void add_rotation(CLI::App& app, RunSettings& settings) {
  add_choice<Table1Form>(
      app, "--table1", settings.table1,
      {{"corrected", Table1Form::kCorrected}, {"printed", Table1Form::kAsPrinted}}, "corrected",
      "theoretical rotation: Table 1 corrected or printed")
      ->group(kA4Group);
  add_choice<StepRule>(app, "--a4-step", settings.a4_step,
                       {{"exact", StepRule::kExact}, {"paper", StepRule::kSpeedByDt}}, "exact",
                       "elementary rotation: exact solution of the profile, or the paper's S dt")
      ->group(kA4Group);
}

void add_output(CLI::App& app, RunSettings& settings, bool& json) {
  app.add_flag("--json", json, "print the results as JSON")->group(kOutputGroup);
  app.add_flag("--effect-times", settings.effect_times,
               "measure each effect's share of the time of a tick, which takes some itself")
      ->group(kOutputGroup);
}

Result<RunSetup> make_setup(const RunOptions& options) {
  RunSettings settings = options.settings;
  auto axes = parse_axes(options.actuated_axes);
  if (!axes) return axes.error();
  settings.actuated_axes = std::move(*axes);
  auto place = parse_place(options.place);
  if (!place) return place.error();
  settings.place = *place;
  auto moves = parse_moves(options.moves);
  if (!moves) return moves.error();
  settings.moves = std::move(*moves);
  return make_setup(settings);
}

}  // namespace palpate
