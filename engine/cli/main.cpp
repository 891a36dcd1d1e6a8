// The command line of Palpate: reads arguments, calls a command, turns errors into exit codes.

#include <algorithm>
#include <cstdio>
#include <exception>
#include <fcntl.h>
#include <iostream>
#include <new>
#include <sstream>
#include <string>
#include <string_view>
#include <unistd.h>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "engine/cli/commands.h"
#include "engine/cli/number_option.h"
#include "engine/cli/program_signals.h"
#include "geometry/base/printable.h"

namespace {

constexpr int kOurFault = 1;
constexpr int kBadArguments = 2;
constexpr int kBadInput = 2;

using palpate::add_integer;
using palpate::add_real;

// Headings of the help, in the order in which options are added.
constexpr const char* kSceneGroup = "Scene";
constexpr const char* kDeviceGroup = "Device";
constexpr const char* kTouchGroup = "Touch";
constexpr const char* kHandGroup = "Hand";
constexpr const char* kA4Group = "A4, which turns the scene";
constexpr const char* kOutputGroup = "Output";
constexpr const char* kAccuracyGroup = "Of a SCENE";

std::string footer(const std::string& first_line) {
  return first_line +
         "\nExit codes: 0; 1 for a fault of the program; 2 for bad arguments or bad input, told in "
         "one line;\n3 for a run that is not comparable; 129 after SIGHUP, 130 after Ctrl-C, 143 "
         "after "
         "SIGTERM.";
}

// More than any tick that anybody waits for, and no sum of work overflows.
constexpr std::uint64_t kMostWorkBudget = 1'000'000'000'000;

// A size, or "auto".
CLI::Option* add_fit(CLI::App& app, palpate::SceneOptions& scene) {
  const auto read = [&scene](const std::string& text) {
    scene.fits_workspace = text == "auto";
    if (scene.fits_workspace) return;
    const auto size_m = palpate::parse_real("--fit", text, palpate::kAboveZero);
    if (!size_m) throw CLI::ValidationError("--fit", size_m.error().problem + ", or auto");
    scene.fit_size_m = *size_m;
  };
  return app
      .add_option_function<std::string>(
          "--fit", read,
          "scale so that the largest extent becomes this, m; auto (run): so that the scene fits "
          "the workspace, if it does not")
      ->type_name("NUMBER");
}

void add_scene(CLI::App& app, palpate::SceneOptions& scene, bool is_required = true) {
  app.add_option("SCENE", scene.path, "glTF 2.0 file, .gltf or .glb")->required(is_required);
  app.add_option("--node", scene.node,
                 "only this node and what is below it, by name or \"#number\" (info --list)")
      ->group(kSceneGroup);
  add_real(app, "--scale", scene.scale, palpate::kAboveZero, "times the size that the file has")
      ->group(kSceneGroup);
  add_fit(app, scene)->group(kSceneGroup);
  app.add_option(
         "--pose", scene.pose,
         "NAME@SECONDS: one animation at one time (\"#number@SECONDS\" as info numbers it); "
         "otherwise the file's rest pose")
      ->group(kSceneGroup);
  app.add_option("--material", scene.materials,
                 "NAME.key=value: goes before what the file says of this material; may be repeated")
      ->expected(1)
      ->take_all()
      ->group(kSceneGroup);
  app.add_option("--max-memory", scene.max_memory,
                 "bytes that loading may take, such as 500M or 2GiB [half of what is free]")
      ->group(kSceneGroup);
}

void add_place(CLI::App& app, palpate::RunOptions& options) {
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

void add_device(CLI::App& app, palpate::RunOptions& options) {
  add_integer(app, "--sensors", options.sensors, {2, 3},
              "sensed axes, 2 or 3: the first N of A1 A2 A3")
      ->group(kDeviceGroup);
  add_integer(app, "--actuators", options.actuators, {0, 3},
              "actuated axes: the first M [" + std::to_string(options.default_actuators) +
                  ", but no more than sensors]")
      ->group(kDeviceGroup);
  app.add_option("--actuated-axes", options.actuated_axes,
                 "directions that push instead, device frame, as \"0 0 1; 1 0 0\"")
      ->group(kDeviceGroup);
  app.add_option("--force", options.force, "what the actuators are told")
      ->check(CLI::IsMember({"none", "actuated", "full"}))
      ->capture_default_str()
      ->group(kDeviceGroup);
  add_real(app, "--rate", options.rate_Hz, {1.0 / palpate::kLongestTick_s}, "ticks a second, Hz")
      ->group(kDeviceGroup);
  add_real(
      app, "--plane-height", options.plane_height_m, {},
      "with 2 sensors: where on A3 the plane A1 A2 lies, m; by default 0, and in `run` through "
      "the middle of the object, or the nearest height with a contour")
      ->group(kDeviceGroup);
  add_real(app, "--encoder-quantum", options.encoder_quantum_m, palpate::kAboveZero,
           "step of the device's encoders, m, for the adaptive estimator")
      ->group(kDeviceGroup);
}

void add_workspace(CLI::App& app, palpate::DeviceDescription& device) {
  const auto read = [&device](const std::string& text) {
    const auto extent_m = palpate::parse_real("--workspace", text, palpate::kAboveZero);
    if (!extent_m) throw CLI::ValidationError("--workspace", extent_m.error().problem);
    palpate::set_workspace_extent(device, *extent_m);
  };
  std::ostringstream usual;
  usual << palpate::workspace_extent_m(device);
  app.add_option_function<std::string>("--workspace", read,
                                       "extent of the device along an axis, m; more is flagged")
      ->type_name("NUMBER")
      ->default_str(usual.str())
      ->group(kDeviceGroup);
}

std::vector<CLI::Option*> add_mechanics(CLI::App& app, palpate::DeviceDescription& device) {
  return {add_real(app, "--device-mass", device.mass_kg, palpate::kAboveZero,
                   "of the device at its tip, kg"),
          add_real(app, "--device-damping", device.damping_Ns_per_m, palpate::kZeroOrMore,
                   "viscous, of the device, N s/m"),
          add_real(app, "--device-friction", device.coulomb_friction_N, palpate::kZeroOrMore,
                   "Coulomb, of the device, N")};
}

void add_touch(CLI::App& app, palpate::RunOptions& options) {
  add_real(app, "--stiffness", options.stiffness_N_per_m, palpate::kZeroOrMore,
           "coupling spring of surfaces without their own, N/m")
      ->group(kTouchGroup);
  add_real(app, "--damping", options.damping_Ns_per_m, palpate::kZeroOrMore,
           "coupling damper of surfaces without their own, N s/m")
      ->group(kTouchGroup);
  add_real(app, "--radius", options.radius_m, palpate::kZeroOrMore,
           "radius of the proxy, m; 0 is a point")
      ->group(kTouchGroup);
  app.add_option("--accuracy", options.accuracy,
                 "of the proxy: fast (few steps, uncertified), balanced, or exact")
      ->check(CLI::IsMember({"fast", "balanced", "exact"}))
      ->capture_default_str()
      ->group(kTouchGroup);
  add_integer(app, "--work-budget", options.work_budget, {1, kMostWorkBudget},
              "what a tick may do at most, in units of 10 to 20 ns; by default as --accuracy "
              "says (5000, 20000 or 160000)")
      ->group(kTouchGroup);
  app.add_option("--velocity-estimator", options.velocity_estimator,
                 "of the damper: difference over the window, straight line fitted to it, or "
                 "adaptive: the longest window that is straight to an encoder's step")
      ->check(CLI::IsMember({"difference", "line", "adaptive"}))
      ->capture_default_str()
      ->group(kTouchGroup);
  add_integer(app, "--velocity-window", options.velocity_window_ticks,
              {1, palpate::VelocityEstimator::kMostTicks},
              "window of the damper's velocity, 1 to 63 ticks: longer is less noisy, and later")
      ->group(kTouchGroup);
}

// a4_choices, a4_help: those of the command.
void add_a4(CLI::App& app, palpate::RunOptions& options, std::vector<std::string> a4_choices,
            const char* a4_help) {
  app.add_option("--a4", options.a4, a4_help)
      ->check(CLI::IsMember(std::move(a4_choices)))
      ->capture_default_str()
      ->group(kA4Group);
  app.add_option("--table1", options.table1, "theoretical rotation: Table 1 corrected or printed")
      ->check(CLI::IsMember({"corrected", "printed"}))
      ->capture_default_str()
      ->group(kA4Group);
  app.add_option("--a4-step", options.a4_step,
                 "elementary rotation: exact solution of the profile, or the paper's S dt")
      ->check(CLI::IsMember({"exact", "paper"}))
      ->capture_default_str()
      ->group(kA4Group);
}

void add_output(CLI::App& app, palpate::RunOptions& options, bool& json) {
  app.add_flag("--json", json, "print the results as JSON")->group(kOutputGroup);
  app.add_flag("--effect-times", options.effect_times,
               "measure each effect's share of the time of a tick, which takes some itself")
      ->group(kOutputGroup);
}

void add_run(CLI::App& program, palpate::RunCommand& command) {
  command.options.sensors = 2;
  command.options.default_actuators = 1;
  command.options.a4 = "compare";
  CLI::App& app = *program.add_subcommand(
      "run", "let a simulated hand explore a scene in real time, without and with A4");
  app.footer(footer("For example: palpate run your-scene.glb --fit 0.2 --virtual"));
  add_scene(app, command.scene);
  add_place(app, command.options);
  add_device(app, command.options);
  palpate::ExplorationSettings& hand = command.exploration;
  add_workspace(app, command.options.device);
  for (CLI::Option* option : add_mechanics(app, command.options.device))
    option->group(kDeviceGroup);
  add_real(app, "--seconds", hand.seconds, {2.0, 86400.0}, "length of a run, s, 2 to 86400")
      ->group(kHandGroup);
  add_integer(app, "--seed", hand.seed, {}, "of the hand's noise and walk")->group(kHandGroup);
  app.add_flag("--virtual", hand.virtual_time, "in simulated time, as fast as it goes")
      ->group(kHandGroup);
  add_touch(app, command.options);
  add_a4(app, command.options, {"on", "off", "compare"},
         "rotate the scene: on, off, or both runs compared");
  app.add_option("--out", command.out_dir, "folder for traces and picture")
      ->capture_default_str()
      ->group(kOutputGroup);
  add_output(app, command.options, command.json);
}

void add_replay(CLI::App& program, palpate::ReplayCommand& command) {
  CLI::App& app = *program.add_subcommand(
      "replay", "play a recorded device path through a scene, the same bits every time");
  app.footer(footer("For example: palpate replay scene.glb --trajectory path.txt --out felt.csv"));
  app.add_option(
         "--trajectory", command.trajectory,
         "device positions, one \"[t] x y z\" in metres a line, or a trace of run or replay")
      ->required();
  add_integer(app, "--repeat", command.repeat, {1, 1000},
              "passes, 1 to 1000; each tick's shortest time is kept");
  add_scene(app, command.scene);
  add_place(app, command.options);
  add_device(app, command.options);
  add_touch(app, command.options);
  add_a4(app, command.options, {"on", "off"}, "rotate the scene while in contact");
  app.add_option("--out", command.trace, "CSV file for the trace")->group(kOutputGroup);
  add_output(app, command.options, command.json);
}

void add_accuracy(CLI::App& program, palpate::AccuracyCommand& command) {
  CLI::App& app = *program.add_subcommand(
      "accuracy", "show what accuracy costs in time: a report of every knob, and of a scene");
  app.footer(footer("For example: palpate accuracy your-scene.glb --quick --out report"));
  add_scene(app, command.scene, false);
  app.add_flag("--quick", command.quick, "within a minute: coarser meshes, shorter paths");
  app.add_option("--out", command.out_dir, "folder for report, tables and diagrams")
      ->capture_default_str();
  app.add_option("--knob", command.knobs,
                 "only this knob, by the name of its diagram; may be repeated")
      ->expected(1)
      ->take_all();
  add_integer(app, "--seed", command.seed, {}, "of poses, paths and noise");
  CLI::Option* scene = app.get_option("SCENE");
  for (const char* name : {"--node", "--scale", "--fit", "--pose", "--material", "--max-memory"}) {
    app.get_option(name)->needs(scene)->group(kAccuracyGroup);
  }
  const auto of_scene = [&](const char* name, double& value, const palpate::RealRange& range,
                            const char* what) {
    add_real(app, name, value, range, what)->needs(scene)->group(kAccuracyGroup);
  };
  using palpate::kAboveZero;
  using palpate::kZeroOrMore;
  palpate::RunOptions& run = command.options;
  of_scene("--rate", run.rate_Hz, {1.0 / palpate::kLongestTick_s}, "servo rate, Hz");
  of_scene("--stiffness", run.stiffness_N_per_m, kZeroOrMore,
           "coupling spring of surfaces without their own, N/m");
  of_scene("--damping", run.damping_Ns_per_m, kZeroOrMore,
           "coupling damper of surfaces without their own, N s/m");
  of_scene("--radius", run.radius_m, kZeroOrMore, "radius of the proxy, m; 0 is a point");
  for (CLI::Option* option : add_mechanics(app, command.options.device)) {
    option->needs(scene)->group(kAccuracyGroup);
  }
  of_scene("--encoder-quantum", run.device.encoder_quantum_m, kZeroOrMore,
           "step of the positions that are read, m; 0 for none");
}

// CLI11 takes an empty value for none and keeps the default, `--stiffness "$K"` with K not set, or
// takes the next argument for it, `--out=$OUT --virtual`.
bool has_empty_argument(int argc, char** argv) {
  bool may_be_option = true;
  for (int i = 1; i < argc; ++i) {
    const std::string_view argument = argv[i];
    may_be_option = may_be_option && argument != "--";
    const bool is_option = may_be_option && argument.starts_with("--");
    const bool lacks_value = is_option && argument.find('=') == argument.size() - 1;
    if (!argument.empty() && !lacks_value) continue;
    std::cerr << "palpate: "
              << (lacks_value ? argument.substr(0, argument.size() - 1)
                  : i > 1     ? std::string_view(argv[i - 1])
                              : "palpate")
              << ": nothing given, expected a value (palpate --help tells more)\n";
    return true;
  }
  return false;
}

int run_program(int argc, char** argv) {
  if (has_empty_argument(argc, argv)) return kBadArguments;
  CLI::App program(
      "Palpate: feel any triangle mesh through a point haptic device, with fewer "
      "motors than sensors if need be.");
  program.set_version_flag("--version", "palpate " PALPATE_VERSION);
  program.require_subcommand(1);
  program.footer(footer("palpate COMMAND --help tells what a command takes."));
  palpate::RunCommand run;
  palpate::ReplayCommand replay;
  palpate::InfoCommand info;
  add_run(program, run);
  add_replay(program, replay);
  palpate::AccuracyCommand accuracy;
  add_accuracy(program, accuracy);
  CLI::App& info_app = *program.add_subcommand("info", "tell what a scene is made of");
  add_scene(info_app, info.scene);
  info_app.add_flag("--list", info.list, "the tree of nodes instead");
  info_app.add_flag("--json", info.json, "print as JSON");
  try {
    program.parse(argc, argv);
  } catch (const CLI::Success& help) {
    return program.exit(help);
  } catch (const CLI::ParseError& error) {
    std::string problem = error.what();
    if (program.get_subcommands().empty() && !program.remaining().empty()) {
      problem = program.remaining().front() +
                ": is no subcommand; expected run, replay, info or accuracy";
    }
    std::replace(problem.begin(), problem.end(), '\n', ' ');
    std::cerr << "palpate: " << problem << " (palpate --help tells more)\n";
    return kBadArguments;
  }
  run.arguments.assign(argv + 1, argv + argc);
  if (program.got_subcommand("run")) return palpate::run(run);
  if (program.got_subcommand("accuracy")) return palpate::accuracy(accuracy);
  if (program.got_subcommand("replay")) return palpate::replay(replay);
  return palpate::info(info);
}

// A file that is opened later must not come to be what the program reads or writes as standard
// input, output or error, if it was started without one of these. What is for reading alone refuses
// to be written to, as what is closed does.
void take_standard_descriptors() {
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(descriptor, F_GETFD) >= 0) continue;
    // The lowest that is free: this one.
    [[maybe_unused]] const int taken = ::open("/dev/null", O_RDONLY);
  }
}

}  // namespace

int main(int argc, char** argv) {
  take_standard_descriptors();
  palpate::take_signals();
  const palpate::PrintableStream out(std::cout);
  const palpate::PrintableStream err(std::cerr);
  try {
    return run_program(argc, argv);
  } catch (const std::bad_alloc&) {  // where no step has named it: as results are told
    std::fputs(
        "palpate: there is not enough memory to go on (free some, or raise the "
        "limit of the process, ulimit -v)\n",
        stderr);
    return kBadInput;
  } catch (const std::exception& error) {
    std::cerr << "palpate: " << error.what() << "\n";
    return kOurFault;
  }
}
