// The command line of Palpate: reads arguments, calls a command, turns errors into exit codes. The
// commands are listed in all_commands.h.

#include <algorithm>
#include <cstdio>
#include <exception>
#include <fcntl.h>
#include <iostream>
#include <memory>
#include <new>
#include <string>
#include <string_view>
#include <unistd.h>
#include <vector>

#include <CLI/CLI.hpp>

#include "engine/cli/all_commands.h"
#include "engine/cli/command_help.h"
#include "engine/cli/program_signals.h"
#include "geometry/base/printable.h"

namespace {

constexpr int kOurFault = 1;
constexpr int kBadArguments = 2;
constexpr int kBadInput = 2;

using Commands = std::vector<std::unique_ptr<palpate::Command>>;

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

// "run, replay or info"
std::string joined(const std::vector<CLI::App*>& apps) {
  std::string names;
  for (std::size_t i = 0; i < apps.size(); ++i) {
    if (i > 0) names += i + 1 < apps.size() ? ", " : " or ";
    names += apps[i]->get_name();
  }
  return names;
}

int refuse_arguments(const CLI::App& program, const std::vector<CLI::App*>& apps,
                     const CLI::ParseError& error) {
  std::string problem = error.what();
  if (program.get_subcommands().empty() && !program.remaining().empty()) {
    problem = program.remaining().front() + ": is no subcommand; expected " + joined(apps);
  }
  std::replace(problem.begin(), problem.end(), '\n', ' ');
  std::cerr << "palpate: " << problem << " (palpate --help tells more)\n";
  return kBadArguments;
}

int run_program(int argc, char** argv) {
  if (has_empty_argument(argc, argv)) return kBadArguments;
  CLI::App program(
      "Palpate: feel any triangle mesh through a point haptic device, with fewer "
      "motors than sensors if need be.");
  program.set_version_flag("--version", "palpate " PALPATE_VERSION);
  program.require_subcommand(1);
  program.footer(palpate::help_footer("palpate COMMAND --help tells what a command takes."));
  const Commands commands = palpate::all_commands();
  std::vector<CLI::App*> apps;
  for (const auto& command : commands) apps.push_back(command->add_to(program));
  try {
    program.parse(argc, argv);
  } catch (const CLI::Success& help) {
    return program.exit(help);
  } catch (const CLI::ParseError& error) {
    return refuse_arguments(program, apps, error);
  }
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  const auto chosen =
      std::find_if(apps.begin(), apps.end(), [](CLI::App* app) { return app->parsed(); });
  return commands[static_cast<std::size_t>(chosen - apps.begin())]->run(arguments);
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
