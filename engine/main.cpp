// The command line of Palpate: reads arguments, calls a command, turns errors into exit codes.

#include <algorithm>
#include <exception>
#include <iostream>
#include <string>

#include <CLI/CLI.hpp>

#include "engine/commands.h"
#include "engine/program_signals.h"

namespace {

constexpr int kOurFault = 1;
constexpr int kBadArguments = 2;

void add_scene(CLI::App& app, palpate::SceneOptions& scene, bool is_required = true) {
  app.add_option("SCENE", scene.path, "glTF 2.0 file, .gltf or .glb")->required(is_required);
  app.add_option("--node", scene.node,
                 "only this node and what is below it, by name or \"#number\" (info --list)");
  app.add_option("--scale", scene.scale, "times the size that the file has");
  app.add_option_function<std::string>(
      "--fit",
      [&scene](const std::string& text) {
        scene.fits_workspace = text == "auto";
        if (scene.fits_workspace) return;
        double size_m = 0.0;
        if (!CLI::detail::lexical_cast(text, size_m)) {
          throw CLI::ValidationError("--fit", text + " is no number, expected metres or auto");
        }
        scene.fit_size_m = size_m;
      },
      "scale so that the largest extent becomes this, m; auto (run): so that the scene fits the "
      "workspace, if it does not");
  app.add_option("--material", scene.materials,
                 "NAME.key=value: goes before what the file says of this material; may be repeated")
      ->expected(1)
      ->take_all();
}

// Options that `run` and `replay` share. Defaults shown are those of `options`.
void add_run_options(CLI::App& app, palpate::RunOptions& options) {
  app.add_option("--sensors", options.sensors, "sensed axes, 2 or 3: the first N of A1 A2 A3")
      ->capture_default_str();
  app.add_option("--actuators", options.actuators,
                 "actuated axes: the first M [" + std::to_string(options.default_actuators) +
                     ", but no more than sensors]");
  app.add_option("--actuated-axes", options.actuated_axes,
                 "directions that push instead, device frame, as \"0 0 1; 1 0 0\"");
  app.add_option("--force", options.force, "what the actuators are told")
      ->check(CLI::IsMember({"none", "actuated", "full"}))
      ->capture_default_str();
  app.add_option("--table1", options.table1, "theoretical rotation: Table 1 corrected or printed")
      ->check(CLI::IsMember({"corrected", "printed"}))
      ->capture_default_str();
  app.add_option("--a4-step", options.a4_step,
                 "elementary rotation: exact solution of the profile, or the paper's S dt")
      ->check(CLI::IsMember({"exact", "paper"}))
      ->capture_default_str();
  app.add_option("--accuracy", options.accuracy,
                 "of the proxy: fast (few steps, uncertified), balanced, or exact")
      ->check(CLI::IsMember({"fast", "balanced", "exact"}))
      ->capture_default_str();
  app.add_option("--work-budget", options.work_budget,
                 "what a tick may do at most, in units of 10 to 20 ns; by default as --accuracy "
                 "says (5000, 20000 or 160000)");
  app.add_option("--rate", options.rate_Hz, "ticks a second, Hz")->capture_default_str();
  app.add_option("--stiffness", options.stiffness_N_per_m,
                 "coupling spring of surfaces without their own, N/m")
      ->capture_default_str();
  app.add_option("--damping", options.damping_Ns_per_m,
                 "coupling damper of surfaces without their own, N s/m")
      ->capture_default_str();
  app.add_option("--velocity-estimator", options.velocity_estimator,
                 "of the damper: difference over the window, straight line fitted to it, or "
                 "adaptive: the longest window that is straight to an encoder's step")
      ->check(CLI::IsMember({"difference", "line", "adaptive"}))
      ->capture_default_str();
  app.add_option("--velocity-window", options.velocity_window_ticks,
                 "window of the damper's velocity, 1 to 63 ticks: longer is less noisy, and later")
      ->capture_default_str();
  app.add_option("--encoder-quantum", options.encoder_quantum_m,
                 "step of the device's encoders, m, for the adaptive estimator");
  app.add_option("--radius", options.radius_m, "radius of the proxy, m; 0 is a point")
      ->capture_default_str();
  app.add_option("--plane-height", options.plane_height_m,
                 "with 2 sensors: where on A3 the plane A1 A2 lies, m; by default 0, and in `run` "
                 "through the middle of the object, or the nearest height with a contour");
  app.add_option("--place", options.place,
                 "pose of the scene in the device frame, \"x y z qw qx qy qz\"");
  app.add_option(
         "--move", options.moves,
         "NODE=\"vx vy vz wx wy wz\": the node moves steadily, m/s and rad/s along and about "
         "the axes of the scene; may be repeated")
      ->expected(1)
      ->take_all();
  app.add_flag("--effect-times", options.effect_times,
               "measure each effect's share of the time of a tick, which takes some itself");
}

void add_run(CLI::App& program, palpate::RunCommand& command) {
  command.options.sensors = 2;
  command.options.default_actuators = 1;
  command.options.a4 = "compare";
  command.options.damping_Ns_per_m = 2.0;
  CLI::App& app = *program.add_subcommand(
      "run", "let a simulated hand explore a scene in real time, without and with A4");
  add_scene(app, command.scene);
  add_run_options(app, command.options);
  app.add_option("--a4", command.options.a4, "rotate the scene: on, off, or both runs compared")
      ->check(CLI::IsMember({"on", "off", "compare"}))
      ->capture_default_str();
  app.add_option("--seconds", command.exploration.seconds, "length of a run, s")
      ->check(CLI::Range(2.0, 86400.0))
      ->capture_default_str();
  app.add_option("--seed", command.exploration.seed, "of the hand's noise and walk")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--workspace", command.exploration.workspace_m,
                 "extent of the device along an axis, m; more is flagged")
      ->capture_default_str();
  app.add_flag("--virtual", command.exploration.virtual_time,
               "in simulated time, as fast as it goes");
  app.add_option("--out", command.out_dir, "folder for traces and picture")->capture_default_str();
  app.add_flag("--json", command.json, "print the results as JSON");
}

void add_replay(CLI::App& program, palpate::ReplayCommand& command) {
  CLI::App& app = *program.add_subcommand(
      "replay", "play a recorded device path through a scene, the same bits every time");
  add_scene(app, command.scene);
  app.add_option("--trajectory", command.trajectory,
                 "device positions, one \"[t] x y z\" in metres a line")
      ->required();
  add_run_options(app, command.options);
  app.add_option("--a4", command.options.a4, "rotate the scene while in contact")
      ->check(CLI::IsMember({"on", "off"}))
      ->capture_default_str();
  app.add_option("--out", command.trace, "CSV file for the trace");
  app.add_option("--repeat", command.repeat, "passes; each tick's shortest time is kept")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_flag("--json", command.json, "print the results as JSON");
}

void add_accuracy(CLI::App& program, palpate::AccuracyCommand& command) {
  CLI::App& app = *program.add_subcommand(
      "accuracy", "show what accuracy costs in time: a report of every knob, and of a scene");
  command.options.damping_Ns_per_m = 0.0;
  add_scene(app, command.scene, false);
  app.add_flag("--quick", command.quick, "within a minute: coarser meshes, shorter paths");
  app.add_option("--out", command.out_dir, "folder for report, tables and diagrams")
      ->capture_default_str();
  app.add_option("--knob", command.knobs,
                 "only this knob, by the name of its diagram; may be repeated")
      ->expected(1)
      ->take_all();
  app.add_option("--seed", command.seed, "of poses, paths and noise")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  CLI::Option* scene = app.get_option("SCENE");
  for (const char* name : {"--node", "--scale", "--fit", "--material"}) {
    app.get_option(name)->needs(scene)->group("With a SCENE");
  }
  const auto of_scene = [&](const char* name, double& value, const char* what) {
    app.add_option(name, value, what)->capture_default_str()->needs(scene)->group("With a SCENE");
  };
  palpate::RunOptions& run = command.options;
  of_scene("--rate", run.rate_Hz, "servo rate, Hz");
  of_scene("--stiffness", run.stiffness_N_per_m,
           "coupling spring of surfaces without their own, N/m");
  of_scene("--damping", run.damping_Ns_per_m,
           "coupling damper of surfaces without their own, N s/m");
  of_scene("--radius", run.radius_m, "radius of the proxy, m; 0 is a point");
  palpate::DeviceMechanics& device = command.device;
  of_scene("--device-mass", device.mass_kg, "of the device at its tip, kg");
  of_scene("--device-damping", device.damping_Ns_per_m, "viscous, of the device, N s/m");
  of_scene("--device-friction", device.coulomb_friction_N, "Coulomb, of the device, N");
  of_scene("--encoder-quantum", device.encoder_quantum_m,
           "step of the positions that are read, m; 0 for none");
}

// CLI11 takes an empty value for none and keeps the default: `--stiffness "$K"` with K not set.
bool has_empty_argument(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    if (*argv[i]) continue;
    std::cerr << "palpate: " << (i > 1 ? argv[i - 1] : "palpate")
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

}  // namespace

int main(int argc, char** argv) {
  palpate::take_signals();
  try {
    return run_program(argc, argv);
  } catch (const std::exception& error) {  // out of memory, say
    std::cerr << "palpate: " << error.what() << "\n";
    return kOurFault;
  }
}
