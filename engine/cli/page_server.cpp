#include "engine/cli/page_server.h"

#include <algorithm>
#include <sys/resource.h>

#include "engine/cli/number_option.h"

namespace palpate {
namespace {

// Each connection is an open file. What the system allows a process at first is often less than a
// crowd of strangers holds.
void allow_many_files() {
  constexpr rlim_t kEnough = 4096;
  rlimit files{};
  if (::getrlimit(RLIMIT_NOFILE, &files) != 0 || files.rlim_cur >= kEnough) return;
  files.rlim_cur = std::min(kEnough, files.rlim_max);
  ::setrlimit(RLIMIT_NOFILE, &files);  // the server lives with fewer
}

}  // namespace

CLI::Option* add_port(CLI::App& app, ServerSettings& settings) {
  constexpr std::uint64_t kMostPort = 65535;
  return add_integer(app, "--port", settings.port, {0, kMostPort},
                     "the server's port; 0: any free one");
}

std::string page_address(const ServerSettings& settings, const ViewServer& server, PageRole role) {
  std::string host = settings.address;
  if (host == "0.0.0.0" || host == "::") host = "localhost";
  if (host.find(':') != std::string::npos) host = "[" + host + "]";
  return "http://" + host + ":" + std::to_string(server.port()) + "/#" + server.token(role).text();
}

Error no_page(const std::string& command) {
  return {ErrorCode::kUnsupported, "", command, "is not complete: the program has no page",
          "run ./run.sh view, which installs npm if it is missing and builds the page"};
}

Result<std::unique_ptr<ViewServer>> listen_for_pages(const ServerSettings& settings,
                                                     const PageFiles& page, ViewModel& model) {
  allow_many_files();
  auto server = ViewServer::listen(settings, page, model);
  if (server) return server;
  Error error = server.error();
  error.element = "--" + error.element;
  return error;
}

}  // namespace palpate
