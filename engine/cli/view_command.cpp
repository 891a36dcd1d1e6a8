// The subcommand `view`: a page in the browser shows what the haptic thread does.

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "engine/cli/all_commands.h"
#include "engine/cli/command_help.h"
#include "engine/cli/command_output.h"
#include "engine/cli/effects_report.h"
#include "engine/cli/number_option.h"
#include "engine/cli/open_browser.h"
#include "engine/cli/open_device.h"
#include "engine/cli/page_server.h"
#include "engine/cli/page_stiffness.h"
#include "engine/cli/prepared_run.h"
#include "engine/cli/private_output.h"
#include "engine/cli/program_signals.h"
#include "engine/cli/run_on_device.h"
#include "engine/cli/run_recording.h"
#include "engine/cli/run_results.h"
#include "engine/cli/run_stiffness.h"
#include "engine/cli/start_inside_report.h"
#include "engine/cli/strategy_option.h"
#include "engine/cli/tick_times_report.h"
#include "engine/drivers/drivers.h"
#include "engine/trials/trial.h"
#include "engine/viewer/http_rules.h"
#include "engine/viewer/page_files.h"
#include "engine/viewer/view_server.h"
#include "engine/viewer/view_session.h"
#include "geometry/base/printable.h"

namespace palpate {
namespace {

constexpr auto kLookEvery = std::chrono::milliseconds(20);
constexpr const char* kPageGroup = "Page";

// A length on the screen over that of the device: far apart from what any screen or eye resolves.
constexpr NumberRange kDisplayScales{0.01, 100.0};
constexpr NumberRange kDisplayRates_Hz{1.0, 240.0};

enum class PageDisplay : std::uint8_t { kFull, kPaper };

struct ViewRequest {
  RunRequest run;
  PageDisplay display = PageDisplay::kFull;
  double display_rate_Hz = PaperDisplay{}.rate_Hz;
  double display_scale = PaperDisplay{}.scale;
  ServerSettings server;
  std::vector<std::string> origins;  // as given; server.allowed.origins once they are checked
  bool opens_browser = false;
  bool prints_licences = false;
};

std::optional<Error> check_hosts(const std::vector<std::string>& hosts) {
  for (const std::string& text : hosts) {
    const auto host = parse_host(text);
    if (host && !host->port) continue;
    return invalid_argument("--allow-host", "is \"" + text +
                                                "\"; expected a host's name or address without a "
                                                "port, such as desk.example or [2001:db8::1]");
  }
  return std::nullopt;
}

std::optional<Error> take_origins(ViewRequest& request) {
  for (const std::string& text : request.origins) {
    const auto origin = parse_origin(text);
    if (!origin) {
      return invalid_argument(
          "--allow-origin", "is \"" + text +
                                "\"; expected the scheme, host and port of a page, without a "
                                "path, such as https://desk.example or https://desk.example:8443");
    }
    request.server.allowed.origins.push_back(*origin);
  }
  return std::nullopt;
}

// The address on this machine is the first line.
void print_addresses(const ViewRequest& request, const ViewServer& server) {
  const auto told = make_output_private();
  std::cout << page_address(request.server, server) << std::endl;
  for (const WebOrigin& origin : request.server.allowed.origins) {
    std::cout << "through a proxy: " << origin.text() << "/#" << server.token().text()
              << " (with the proxy's path before #)" << std::endl;
  }
  if (told) warn(*told);
}

void print_ticks(const HapticThread& thread) {
  std::cout << "ticks: " << thread.ticks() << ", late: " << thread.missed_deadlines()
            << late_causes_text(thread.times()) << "\n";
}

// Serves until a signal. The force is zero before anything that may wait for a client.
// warnings: about the scene.
std::optional<Error> serve(const ViewRequest& request, const PageFiles& page,
                           const std::vector<std::string>& warnings, ViewSession& session) {
  const auto server = listen_for_pages(request.server, page, session);
  if (!server) return server.error();
  if (const auto problem = ViewServer::files_problem()) warn(*problem);
  if (!is_loopback(request.server.address)) {
    warn(
        "--listen: others on the network can reach this server; its address and token are not "
        "encrypted");
    if (request.server.allowed.hosts.empty() && request.server.allowed.origins.empty()) {
      warn(
          "--listen: a browser is refused unless it reaches the server as localhost; name the host "
          "of other addresses with --allow-host");
    }
  }
  (*server)->start();
  if (auto error = session.start()) return error;
  print_addresses(request, **server);
  for (const std::string& warning : warnings) warn(warning);
  for (const std::string& warning : session.warnings()) warn(warning);
  std::unique_ptr<OpenedBrowser> browser;
  if (request.opens_browser) {
    auto opened = OpenedBrowser::open(page_address(request.server, **server));
    if (opened) {
      browser = std::move(*opened);
    } else {
      warn(opened.error().to_string());
    }
  }
  while (!signal_flag().requested()) std::this_thread::sleep_for(kLookEvery);
  session.stop();
  (*server)->stop();
  print_ticks(session.thread());
  return std::nullopt;
}

ViewSettings view_settings_of(const ViewRequest& request, const IsGiven& is_given) {
  ViewSettings settings;
  const RunRequest& run = request.run;
  settings.scene_name = std::filesystem::path(run.scene.path).filename().string();
  if (run.device.cpu) settings.cpu = static_cast<int>(*run.device.cpu);
  settings.has_guard = !run.device.no_guard;
  settings.without_realtime = run.device.without_realtime;
  settings.stays_inside = run.device.stays_inside;
  settings.takes_motors = !is_given("--actuators") && !is_given("--actuated-axes");
  return settings;
}

std::optional<Error> check_display(const ViewRequest& request, const IsGiven& is_given) {
  if (request.display == PageDisplay::kPaper) return std::nullopt;
  for (const char* const option : {"--display-rate", "--display-scale"}) {
    if (!is_given(option)) continue;
    return invalid_argument(option, "is given without --display paper",
                            "add --display paper, or leave it out");
  }
  return std::nullopt;
}

// The paper's display is seen from above, so that it cannot show the depth of a third sensor.
std::optional<Error> check_display_sensors(const ViewRequest& request, const RunSetup& setup) {
  if (request.display != PageDisplay::kPaper || setup.actuation.is_planar()) return std::nullopt;
  return invalid_argument("--display", "is paper with 3 sensors; expected 2",
                          "use --sensors 2, or --display full");
}

// Without a way, such as in a scene without a wall that is long enough, there are no spheres; the
// warning says why.
PaperDisplay paper_display_of(const ViewRequest& request, const PreparedRun& prepared) {
  PaperDisplay paper{request.display_rate_Hz, request.display_scale};
  const TrialSettings trial;
  const auto way = find_trial_way(prepared.scene, prepared.setup, trial);
  if (way) {
    paper.spheres = DisplayedSpheres{way->green_m, way->red_m, trial.sphere_radius_m};
  } else {
    warn("--display: no start and end spheres are shown: " + way.error().to_string());
  }
  return paper;
}

// device: null for the simulated hand.
int view(ViewRequest request, GuardableDevice* device, const IsGiven& is_given) {
  const auto page = embedded_page();
  if (!page) return refuse(no_page());
  if (device != nullptr) describe_device(device->description(), is_given, request.run);
  auto prepared = prepare_run(request.run);
  if (!prepared) return refuse(with_path(prepared.error(), request.run.scene.path));
  prepared->setup.haptics.a4.enabled = request.run.a4 == A4Runs::kOn;
  if (const auto error = check_display_sensors(request, prepared->setup)) return refuse(*error);
  if (device != nullptr) {
    const auto error = check_motors(request.run.options.settings.strategy, prepared->setup.device);
    if (error) return refuse(*error);
  }
  if (const auto error = check_setup(prepared->scene, prepared->setup)) return refuse(*error);
  std::optional<OpenDevice> open;
  std::unique_ptr<WallJudge> judge;
  if (device != nullptr) {
    open.emplace(*device);
    if (const auto error = open->start()) return refuse(*error);
    const auto stiffness = choose_stiffness(request.run, *device, *prepared);
    if (!stiffness) return refuse(stiffness.error());
    if (*stiffness) {
      tell_stiffness(**stiffness);
      judge = make_wall_judge(device->description(), *prepared, **stiffness);
    }
    tell_energy_budgets(prepared->setup.governor.budgets);
  }
  const SignalPhaseScope in_order(SignalPhase::kInOrder);
  auto recorder =
      make_recorder(request.run.record, request.run.scene, prepared->scene, prepared->setup, false,
                    request.run.device.allow_unstable.value_or(""));
  if (!recorder) return refuse(recorder.error());
  ViewSettings settings = view_settings_of(request, is_given);
  settings.judge = judge.get();
  if (request.display == PageDisplay::kPaper) {
    settings.paper = paper_display_of(request, *prepared);
  }
  if (Recorder* const r = recorder->get()) {
    settings.recording = {r, [r] { return r->failure(); },
                          [r, &scene = prepared->scene](const StartInside::Status& status) {
                            record_start_inside(r, scene, status);
                          }};
  }
  const auto session = ViewSession::create(prepared->scene, prepared->setup, settings, device);
  if (!session) return refuse(with_path(session.error(), request.run.scene.path));
  const auto refusal = serve(request, *page, load_warning_lines(prepared->scene), **session);
  std::vector<RecordingResult> recordings;
  if (auto recording = finish_recording(std::move(*recorder), "interrupted")) {
    recordings.push_back(std::move(*recording));
  }
  if (refusal) return refuse(*refusal);
  for (const RecordingResult& recording : recordings) std::cout << recording_text(recording);
  return exit_code_after_signals(finish_output(recording_warnings(recordings)));
}

int view_with_device(const ViewRequest& request, const IsGiven& is_given) {
  const RunRequest& run = request.run;
  const auto device = make_device("--device", run.device.text, run.device.no_guard);
  if (!device) return refuse(device.error());
  const int sensors = run.options.settings.sensors;
  const int sensed_axes = (*device)->description().sensed_axes;
  if (is_given("--sensors") && sensors != sensed_axes) {
    return refuse(invalid_argument("--sensors", "is " + std::to_string(sensors) + "; expected " +
                                                    std::to_string(sensed_axes) +
                                                    ", the sensors of the device"));
  }
  return view(request, device->get(), is_given);
}

class ViewCommand final : public Command {
 public:
  CLI::App* add_to(CLI::App& program) override;
  int run(const std::vector<std::string>& arguments) override;

 private:
  void add_page(CLI::App& app);

  ViewRequest request_;
  CLI::App* app_ = nullptr;
};

CLI::App* ViewCommand::add_to(CLI::App& program) {
  RunRequest& run = request_.run;
  RunSettings& settings = run.options.settings;
  settings.sensors = 2;
  settings.default_actuators = 1;
  run.a4 = A4Runs::kOn;
  CLI::App& app = *program.add_subcommand(
      "view", "show a scene and the ball in a browser, live; a pointer moves the simulated hand");
  app_ = &app;
  set_help(app, "  ./run.sh view models/star.glb\n",
           "The printed address holds a secret: whoever has it can watch and move.\n");
  add_scene(app, run.scene, /* is_required = */ false);
  add_settings(app, run.options, SettingGroup::kScene);
  run.options.states_quantum = true;
  run.options.knows_auto_stiffness = true;
  add_settings(app, run.options, SettingGroup::kDevice);
  add_settings(app, run.options, SettingGroup::kWorkspace);
  add_settings(app, run.options, SettingGroup::kMechanics);
  add_motors(app, run.device);
  add_settings(app, run.options, SettingGroup::kMotors);
  add_settings(app, run.options, SettingGroup::kTouch);
  add_choice<A4Runs>(app, "--a4", run.a4, {{"on", A4Runs::kOn}, {"off", A4Runs::kOff}}, "on",
                     "turn the scene at first: on or off")
      ->group(kA4Group);
  add_settings(app, run.options, SettingGroup::kRotation);
  add_strategy(app, settings.strategy);
  add_record(app, run.record);
  add_page(app);
  return &app;
}

void ViewCommand::add_page(CLI::App& app) {
  ServerSettings& server = request_.server;
  add_port(app, server)->group(kPageGroup);
  app.add_option("--listen", server.address,
                 "IP address at which the server listens; any but a loopback address opens it to "
                 "the network")
      ->capture_default_str()
      ->group(kPageGroup);
  app.add_option("--allow-host", server.allowed.hosts,
                 "a host name under which a browser may reach the server, besides localhost, "
                 "127.0.0.1 and [::1]; may be repeated")
      ->expected(1)
      ->allow_extra_args(false)  // the scene may follow
      ->take_all()
      ->group(kPageGroup);
  app.add_option("--allow-origin", request_.origins,
                 "the origin of a page that a reverse proxy serves, such as https://desk.example; "
                 "may be repeated")
      ->expected(1)
      ->allow_extra_args(false)  // the scene may follow
      ->take_all()
      ->group(kPageGroup);
  add_choice<PageDisplay>(app, "--display", request_.display,
                          {{"full", PageDisplay::kFull}, {"paper", PageDisplay::kPaper}}, "full",
                          "what the page shows: full, or the display of the paper's experiment, "
                          "seen from above, without forces, axes and charts (2 sensors)")
      ->group(kPageGroup);
  add_real(app, "--display-rate", request_.display_rate_Hz, kDisplayRates_Hz,
           "mean pictures per second of --display paper, Hz")
      ->group(kPageGroup);
  add_real(app, "--display-scale", request_.display_scale, kDisplayScales,
           "length on the screen for each length of the device, with --display paper; the screen "
           "is taken to have 96 CSS pixels an inch")
      ->group(kPageGroup);
  app.add_flag("--open", request_.opens_browser, "open the page in a browser (xdg-open)")
      ->group(kPageGroup);
  app.add_flag("--licences", request_.prints_licences,
               "print the licences of what the page is made of, and end")
      ->group(kPageGroup);
}

int ViewCommand::run(const std::vector<std::string>& /*arguments*/) {
  if (request_.prints_licences) {
    if (!embedded_page()) return refuse(no_page());
    std::cout << embedded_licences();
    return finish_output();
  }
  if (request_.run.scene.path.empty()) {
    return refuse(invalid_argument("SCENE", "is required", "see view --help"));
  }
  const IsGiven is_given = [this](const std::string& name) {
    const CLI::Option* const option = app_->get_option_no_throw(name);
    return option != nullptr && option->count() > 0;
  };
  if (const auto error = check_strategy_options(is_given)) return refuse(*error);
  if (const auto error = check_device_options(request_.run, is_given)) return refuse(*error);
  if (const auto error = check_display(request_, is_given)) return refuse(*error);
  if (const auto error = check_hosts(request_.server.allowed.hosts)) return refuse(*error);
  if (const auto error = take_origins(request_)) return refuse(*error);
  take_strategy(request_.run);
  if (const auto error = check_recording_names({request_.run.record})) return refuse(*error);
  return request_.run.device.text.empty() ? view(request_, nullptr, is_given)
                                          : view_with_device(request_, is_given);
}

}  // namespace

std::unique_ptr<Command> make_view_command() {
  return std::make_unique<ViewCommand>();
}

}  // namespace palpate
