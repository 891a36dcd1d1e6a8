#include "engine/cli/run_options.h"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <sstream>

#include "engine/cli/command_help.h"
#include "engine/cli/number_option.h"
#include "engine/cli/setting_texts.h"

namespace palpate {
namespace {

// Longer than any useful tick, and small enough that no sum of work overflows.
constexpr std::uint64_t kMostWorkBudget = 1'000'000'000'000;

}  // namespace

void add_work_budget(CLI::App& app, RunSettings& settings) {
  const auto read = [&settings](const std::string& text) {
    settings.measures_work_budget = text == "auto";
    settings.work_budget.reset();
    if (settings.measures_work_budget) return;
    const auto units = parse_integer("--work-budget", text, {1, kMostWorkBudget});
    if (!units) throw CLI::ValidationError("--work-budget", units.error().problem);
    settings.work_budget = static_cast<std::int64_t>(*units);
  };
  app.add_option_function<std::string>(
         "--work-budget", read,
         "largest work of a tick, in units of at most 23 ns; auto: measured at the start, so that "
         "the proxy and the effects take at most half of a tick of --rate [5000, 20000 or 160000 "
         "for --accuracy fast, balanced or exact]")
      ->type_name("INTEGER|auto")
      ->group(kTouchGroup);
}

void add_place(CLI::App& app, RunOptions& options) {
  app.add_option("--place", options.place,
                 "pose of the scene in the device frame, \"x y z qw qx qy qz\"")
      ->group(kSceneGroup);
  app.add_option(
         "--move", options.moves,
         "NODE=\"vx vy vz wx wy wz\": move the node at constant velocity, m/s and rad/s along and "
         "about the axes of the scene; may be repeated")
      ->expected(1)
      ->take_all()
      ->group(kSceneGroup);
}

void add_device(CLI::App& app, RunOptions& options, const std::string& quantum_help) {
  RunSettings& settings = options.settings;
  add_integer(app, "--sensors", settings.sensors, {2, 3},
              "number of sensed axes, 2 or 3: the first of A1 A2 A3")
      ->group(kDeviceGroup);
  add_integer(app, "--actuators", settings.actuators, {0, 3},
              "number of actuated axes: the first of A1 A2 A3 [" +
                  std::to_string(settings.default_actuators) + ", at most the number of sensors]")
      ->group(kDeviceGroup);
  app.add_option(
         "--actuated-axes", options.actuated_axes,
         "actuated directions in place of --actuators, device frame, such as \"0 0 1; 1 0 0\"")
      ->group(kDeviceGroup);
  add_choice<ForceMode>(
      app, "--force", settings.force,
      {{"none", ForceMode::kNone}, {"actuated", ForceMode::kActuated}, {"full", ForceMode::kFull}},
      "actuated", "the commanded force: none, its part along the actuated axes, or all of it")
      ->group(kDeviceGroup);
  add_real(app, "--max-force", settings.max_force_N, kAboveZero,
           "largest force, N; a longer force is shortened and keeps its direction [the device's "
           "peak force]")
      ->group(kDeviceGroup);
  add_real(app, "--rate", settings.rate_Hz, {1.0 / kLongestTick_s}, "ticks per second, Hz")
      ->group(kDeviceGroup);
  add_real(
      app, "--plane-height", settings.plane_height_m, {},
      "with 2 sensors: height of the sensed plane A1 A2 along A3, m [0; `run`: the middle of the "
      "object, or the nearest height with a contour]")
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
  app.add_option_function<std::string>(
         "--workspace", read,
         "extent of the device's workspace along each axis, m; a longer path is flagged")
      ->type_name("NUMBER")
      ->default_str(usual.str())
      ->group(kDeviceGroup);
}

std::vector<CLI::Option*> add_mechanics(CLI::App& app, DeviceDescription& device) {
  return {add_real(app, "--device-mass", device.mass_kg, kAboveZero,
                   "mass of the device at its tip, kg"),
          add_real(app, "--device-damping", device.damping_Ns_per_m, kZeroOrMore,
                   "viscous damping of the device, N s/m"),
          add_real(app, "--device-friction", device.coulomb_friction_N, kZeroOrMore,
                   "Coulomb friction of the device, N")};
}

void add_touch(CLI::App& app, RunSettings& settings) {
  add_real(app, "--stiffness", settings.stiffness_N_per_m, kZeroOrMore,
           "stiffness of the coupling for surfaces that state none, N/m")
      ->group(kTouchGroup);
  add_real(app, "--damping", settings.damping_Ns_per_m, kZeroOrMore,
           "damping of the coupling for surfaces that state none, N s/m")
      ->group(kTouchGroup);
  add_real(app, "--radius", settings.radius_m, kZeroOrMore, "radius of the proxy, m; 0 is a point")
      ->group(kTouchGroup);
  add_choice<Accuracy>(
      app, "--accuracy", settings.accuracy,
      {{"fast", Accuracy::fast()},
       {"balanced", Accuracy::balanced()},
       {"exact", Accuracy::exact()}},
      "balanced", "accuracy of the proxy: fast (few steps, no certificate), balanced, or exact")
      ->group(kTouchGroup);
  add_work_budget(app, settings);
  add_choice<VelocityMethod>(
      app, "--velocity-estimator", settings.velocity_estimator,
      {{"difference", VelocityMethod::kDifference},
       {"line", VelocityMethod::kLineFit},
       {"adaptive", VelocityMethod::kAdaptive}},
      "difference",
      "velocity for the damper: difference over the window, line fitted to the window, or "
      "adaptive: "
      "the longest window whose positions are on a line within an encoder's step")
      ->group(kTouchGroup);
  add_integer(
      app, "--velocity-window", settings.velocity_window_ticks, {1, VelocityEstimator::kMostTicks},
      "window of the damper's velocity, 1 to 63 ticks: a longer window has less noise and more lag")
      ->group(kTouchGroup);
}

void add_rotation(CLI::App& app, RunSettings& settings) {
  add_choice<Table1Form>(
      app, "--table1", settings.table1,
      {{"corrected", Table1Form::kCorrected}, {"printed", Table1Form::kAsPrinted}}, "corrected",
      "theoretical rotation: Table 1 of the paper, corrected or as printed")
      ->group(kA4Group);
  add_choice<StepRule>(
      app, "--a4-step", settings.a4_step,
      {{"exact", StepRule::kExact}, {"paper", StepRule::kSpeedByDt}}, "exact",
      "elementary rotation: exact solution of the speed profile, or the paper's S dt")
      ->group(kA4Group);
  add_choice<Alignment>(
      app, "--align", settings.align,
      {{"nearest", Alignment::kNearest}, {"forward", Alignment::kForward}}, "nearest",
      "with one motor: turn the normal to the nearer end of its line, or forward to the first "
      "actuated axis, by up to 180 deg")
      ->group(kA4Group);
}

CLI::Option* add_cpu(CLI::App& app, std::optional<std::uint64_t>& cpu) {
  constexpr std::uint64_t kMostCpu = 1023;
  return add_integer(app, "--cpu", cpu, {0, kMostCpu}, "the CPU on which the haptic thread stays");
}

void add_output(CLI::App& app, RunSettings& settings, bool& json) {
  app.add_flag("--json", json, "print the results as JSON")->group(kOutputGroup);
  app.add_flag("--effect-times", settings.effect_times,
               "measure each effect's share of the tick time; measuring lengthens ticks")
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
  auto setup = make_setup(settings);
  if (setup && setup->measured_budget && !options.is_quiet) {
    std::cerr << "palpate: work budget: " << setup->measured_budget->units
              << " units a tick; a unit took " << std::lround(setup->measured_budget->unit_ns)
              << " ns\n";
  }
  return setup;
}

}  // namespace palpate
