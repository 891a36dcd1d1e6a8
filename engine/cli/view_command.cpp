// The subcommand `view`: a page in the browser shows what the haptic thread does.

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "engine/cli/all_commands.h"
#include "engine/cli/command_help.h"
#include "engine/cli/command_output.h"
#include "engine/cli/number_option.h"
#include "engine/cli/prepared_run.h"
#include "engine/cli/program_signals.h"
#include "engine/viewer/page_files.h"
#include "engine/viewer/view_server.h"
#include "engine/viewer/view_session.h"

namespace palpate {
namespace {

constexpr auto kLookEvery = std::chrono::milliseconds(20);
constexpr const char* kViewGroup = "Page";

struct ViewRequest {
  RunRequest run;
  ServerSettings server;
  bool opens_browser = false;
  bool prints_licences = false;
};

std::string address_of(const ViewServer& server) {
  return "http://127.0.0.1:" + std::to_string(server.port()) + "/#" + server.token().text();
}

Error no_page() {
  return {ErrorCode::kUnsupported, "", "view", "the program was built without its page",
          "run ./run.sh view, which installs npm if it is missing and builds the page"};
}

void wait_for_signal() {
  while (!signal_flag().requested()) std::this_thread::sleep_for(kLookEvery);
}

int serve(const ViewRequest& request, const PageFiles& page, ViewSession& session) {
  const auto server = ViewServer::listen(request.server, page, session);
  if (!server) return refuse(server.error());
  (*server)->start();
  if (const auto error = session.start()) return refuse(*error);
  std::cout << address_of(**server) << "\n" << std::flush;
  const SignalPhaseScope in_order(SignalPhase::kInOrder);
  wait_for_signal();
  session.stop();  // zero force, before anything that may wait
  (*server)->stop();
  return exit_code_after_signals(finish_output(session.warnings()));
}

int view(const ViewRequest& request) {
  const auto page = embedded_page();
  if (!page) return refuse(no_page());
  const Result<PreparedRun> prepared = prepare_run(request.run);
  if (!prepared) return refuse(prepared.error());
  ViewSettings settings;
  settings.scene_name = std::filesystem::path(request.run.scene.path).filename().string();
  const auto session = ViewSession::create(prepared->scene, prepared->setup, settings);
  if (!session) return refuse(session.error());
  return serve(request, *page, **session);
}

class ViewCommand final : public Command {
 public:
  CLI::App* add_to(CLI::App& program) override;
  int run(const std::vector<std::string>& /*arguments*/) override {
    if (request_.prints_licences) {
      std::cout << embedded_licences();
      return finish_output();
    }
    return view(request_);
  }

 private:
  ViewRequest request_;
  std::uint64_t port_ = 0;
};

CLI::App* ViewCommand::add_to(CLI::App& program) {
  RunRequest& run = request_.run;
  RunSettings& settings = run.options.settings;
  settings.sensors = 2;
  settings.default_actuators = 1;
  CLI::App& app = *program.add_subcommand(
      "view", "show a scene and the ball in a browser, live; a pointer moves the simulated hand");
  set_help(app, "  timeout --signal=INT 5 ./run.sh view models/star.glb\n");
  add_scene(app, run.scene, true);
  return &app;
}

}  // namespace

std::unique_ptr<Command> make_view_command() {
  return std::make_unique<ViewCommand>();
}

}  // namespace palpate
