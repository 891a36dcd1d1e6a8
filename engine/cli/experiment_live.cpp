#include "engine/cli/experiment_live.h"

#include <algorithm>
#include <iomanip>
#include <iostream>
#include <sstream>
#include <utility>

#include "engine/accuracy/surface_couplings.h"
#include "engine/cli/command_help.h"
#include "engine/cli/command_output.h"
#include "engine/cli/grip_check.h"
#include "engine/cli/number_option.h"
#include "engine/cli/open_device.h"
#include "engine/cli/page_server.h"
#include "engine/cli/private_output.h"
#include "engine/cli/program_signals.h"
#include "engine/cli/run_on_device.h"
#include "engine/cli/run_stiffness.h"
#include "engine/drivers/drivers.h"
#include "engine/live/live_run.h"
#include "engine/live/scripted_run.h"
#include "engine/viewer/page_files.h"
#include "geometry/base/printable.h"
#include "haptics/safety_governor.h"

namespace palpate {
namespace {

constexpr std::uint64_t kMostCpu = 4095;

std::string minutes_text(double seconds) {
  constexpr double kMinute_s = 60.0;
  std::ostringstream text;
  text << std::fixed << std::setprecision(0) << seconds / kMinute_s << " min";
  return text.str();
}

// "32 trials: about 14 min, 68 min if each takes its limit; about 79 MB of recordings"
std::string estimate_text(const ExperimentPlan& plan) {
  constexpr double kMB = 1e6;
  const LiveEstimate e = estimate_live(plan);
  std::ostringstream text;
  text << e.trials << " trials: about " << minutes_text(e.usual_s) << " ("
       << LiveEstimate::kUsualTrial_s << " s a trial), " << minutes_text(e.longest_s)
       << " if each takes its limit; about " << std::fixed << std::setprecision(0)
       << e.usual_bytes / kMB << " MB of recordings";
  return text.str();
}

std::optional<Error> check_input(const ExperimentPlan& plan, const ExperimentLiveRequest& request) {
  if (!plan.live || !request.script.empty()) return std::nullopt;
  const bool is_board = plan.live->input == PlanInput::kBoard;
  if (is_board == !request.device.empty()) return std::nullopt;
  return invalid_argument(
      "--device",
      is_board ? "is missing; expected a device, because the input of the plan is board"
               : "is given, but the input of the plan is mouse; expected no device",
      is_board ? "such as --device hapi:port=/dev/ttyACM0" : "leave it out, or change /live/input");
}

// The board in place of the device that the plan describes. Errors: it does not sense two axes, or
// cannot render a level of the plan.
std::optional<Error> take_board(const DeviceDescription& board, ExperimentPlan& plan) {
  constexpr int kPlane = 2;
  if (board.sensed_axes != kPlane) {
    return invalid_argument("--device", "senses " + std::to_string(board.sensed_axes) +
                                            " axes; expected 2: a trial lies in a plane");
  }
  for (std::size_t i = 0; i < plan.haptic.size(); ++i) {
    const bool is_full = kHapticLevels[plan.haptic[i]].value == Haptic::kFull;
    if (!is_full || board.motor_count == kPlane) continue;
    return Error{ErrorCode::kInvalidContent, plan.path, "/haptic/" + std::to_string(i),
                 "is H, which a device with one motor cannot render; expected NoH or UaH",
                 "leave the level out, or use a device with two motors"};
  }
  set_device(board, plan.device);
  return std::nullopt;
}

// An error if a surface of the plan is stiffer than the board can hold calm. One stiffness holds in
// all conditions.
std::optional<Error> check_stiffness(const ExperimentPlan& plan, const GuardableDevice& board,
                                     const std::vector<ExperimentScene>& scenes) {
  const DeviceDescription& device = board.description();
  const LineRate line = board.line_rate();
  if (auto error = check_least_rates(device, line, plan.device.rate_Hz)) return error;
  if (!pushes(device)) return std::nullopt;
  double period_s = 1.0 / plan.device.rate_Hz;
  if (line.at_start_Hz > 0.0) period_s = std::max(period_s, 1.0 / line.at_start_Hz);
  const double peak_N = SafetyGovernor::clamp_of(device, plan.device.max_force_N);
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const auto worst =
        worst_surface(couplings_of(scenes[i].scene, scenes[i].setup.haptics.coupling),
                      {device, period_s, peak_N});
    if (!worst) return worst.error();
    if (worst->judged.zone() != StiffnessZone::kRefused) continue;
    if (worst->is_of_loop) {
      return Error{ErrorCode::kInvalidContent, plan.path, "/device/stiffness_N_per_m",
                   too_stiff_text(*worst), "state one stiffness for all conditions"};
    }
    return Error{ErrorCode::kInvalidContent, plan.objects[i].path,
                 "material \"" + worst->judged.surface + "\": stiffness", too_stiff_text(*worst),
                 "use a softer material"};
  }
  return std::nullopt;
}

std::string end_text(const LiveRun& run, const std::string& folder) {
  const std::string step(name_of(run.course().step()));
  if (!run.course().has_ended()) {
    return "interrupted at: " + step + "; the same command goes on; rows in " + folder +
           "/trials.csv";
  }
  return "the course ended at: " + step +
         (run.keeps_data() ? "; rows in " + folder + "/trials.csv"
                           : "; nothing of this participant is kept");
}

int run_person(ExperimentPlan plan, const ExperimentLiveRequest& request) {
  const auto page = embedded_live_page();
  if (!page) return refuse(no_page("experiment live"));
  LiveRunSettings settings{*request.participant, request.out_dir, request.is_pilot};
  settings.warn = warn;
  std::unique_ptr<GuardableDevice> device;
  std::optional<OpenDevice> open;
  if (!request.device.empty()) {
    auto made = make_device("--device", request.device, request.no_guard);
    if (!made) return refuse(made.error());
    device = std::move(*made);
    open.emplace(*device);
    if (const auto error = open->start()) return refuse(*error);
    if (const auto error = take_board(device->description(), plan)) return refuse(*error);
    settings.board = device.get();
    settings.has_guard = !request.no_guard;
    settings.without_realtime = request.without_realtime;
    settings.check_scenes = [&](const std::vector<ExperimentScene>& scenes) {
      return check_stiffness(plan, *device, scenes);
    };
  }
  if (plan.live->grip) {
    settings.check_scenes = [&](const std::vector<ExperimentScene>& scenes) {
      return check_grip(plan, scenes);
    };
  }
  const SignalPhaseScope in_order(SignalPhase::kInOrder);
  if (request.cpu) settings.cpu = static_cast<int>(*request.cpu);
  const auto run = LiveRun::open(plan_for_person(plan), settings);
  if (!run) return refuse(run.error());
  ServerSettings serves = request.server;
  serves.roles = 2;
  const auto server = listen_for_pages(serves, *page, (*run)->pages());
  if (!server) return refuse(server.error());
  (*server)->start();
  const auto told = make_output_private();
  std::cout << "participant:  " << page_address(serves, **server, kParticipantPage)
            << "\nexperimenter: " << page_address(serves, **server, kExperimenterPage) << "\n"
            << estimate_text(plan) << std::endl;
  if (told) warn(*told);
  for (const std::string& warning : plan.warnings()) warn(warning);
  for (const std::string& warning : scene_warnings(plan, (*run)->scenes())) warn(warning);
  if ((*run)->is_resumed()) std::cout << "the course goes on where it was\n" << std::flush;
  const auto error = (*run)->run(signal_flag());
  (*server)->stop();
  if (error) return refuse(*error);
  std::cout << end_text(**run, request.out_dir) << "\n";
  return exit_code_after_signals(finish_output());
}

int run_scripted(ExperimentPlan plan, const ExperimentLiveRequest& request) {
  auto person = load_operator(request.script);
  if (!person) return refuse(person.error());
  plan.person = std::move(*person);
  const SignalPhaseScope in_order(SignalPhase::kInOrder);
  const auto done = run_script(plan, {*request.participant, request.out_dir, request.is_pilot},
                               {find_trial_way, run_trial}, {}, signal_flag());
  if (!done) return refuse(done.error());
  std::cout << (*done ? "the course is complete" : "interrupted; the same command goes on")
            << "; rows in " << request.out_dir << "/trials.csv\n";
  return exit_code_after_signals(finish_output());
}

}  // namespace

int run_live(const ExperimentLiveRequest& request) {
  const auto plan = load_plan(request.plan);
  if (!plan) return refuse(plan.error());
  if (const auto error = check_input(*plan, request)) return refuse(*error);
  if (const auto error = check_live(*plan, *request.participant)) return refuse(*error);
  return request.script.empty() ? run_person(*plan, request) : run_scripted(*plan, request);
}

void add_live(CLI::App& experiment, ExperimentLiveRequest& request) {
  CLI::App& app = *experiment.add_subcommand("live", "let a person take part, on a page");
  set_help(
      app,
      "  ./run.sh experiment plan paper-live-mouse --out plan.json    # then edit its texts\n"
      "  ./run.sh experiment live plan.json --participant 1 --out people\n",
      "The first printed address is the participant's page, the second one the experimenter's. "
      "Each holds a\nsecret. What is finished is kept in DIR at once; the same command goes on "
      "where it was.\n\nTo take part in an experiment needs consent; whether it needs the approval "
      "of an ethics committee is\nthe experimenter's duty to find out.\n");
  app.add_option("PLAN", request.plan,
                 "plan with `live`, a JSON file; `paper-live` and `paper-live-mouse` ship")
      ->required();
  add_integer(app, "--participant", request.participant, {0, kMostParticipants},
              "number of the participant, 1 for the first")
      ->required();
  app.add_option("--out", request.out_dir, "folder of the experiment")->capture_default_str();
  app.add_option("--device", request.device,
                 "device that the participant holds, such as hapi:port=/dev/ttyACM0; `palpate "
                 "devices` lists drivers and their keys")
      ->type_name("DRIVER:KEY=VALUE,...");
  app.add_flag("--without-realtime", request.without_realtime,
               "run a device that keeps its last force also where the system refuses SCHED_FIFO");
  app.add_flag("--no-guard", request.no_guard,
               "for tests: start no process that stops the motors when the program hangs or ends");
  app.add_option("--script", request.script,
                 "a simulated person takes part, in simulated time and without a page: its name or "
                 "file, such as people2005");
  app.add_flag("--pilot", request.is_pilot, "mark the rows; `experiment analyse` leaves them out");
  add_integer(app, "--cpu", request.cpu, {0, kMostCpu}, "CPU on which the haptic thread stays");
  add_port(app, request.server);
}

}  // namespace palpate
