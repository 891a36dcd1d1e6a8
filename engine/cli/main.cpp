// The program: reads the arguments, calls a command, and turns errors into exit codes.
// all_commands.h lists the commands.

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
#include "engine/cli/command_line.h"
#include "engine/cli/command_output.h"
#include "engine/cli/program_signals.h"
#include "geometry/base/file_roles.h"
#include "geometry/base/printable.h"

namespace {

constexpr int kOurFault = 1;

using Commands = std::vector<std::unique_ptr<palpate::Command>>;

// CLI11 ignores an empty value and keeps the default (`--stiffness "$K"` with K unset), or uses the
// next argument as the value (`--out=$OUT --virtual`).
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
              << ": has an empty value; expected a value (see " << palpate::program_name()
              << " --help)\n";
    return true;
  }
  return false;
}

// "run, replay or info"
std::string joined(const std::vector<const CLI::App*>& apps) {
  std::string names;
  for (std::size_t i = 0; i < apps.size(); ++i) {
    if (i > 0) names += i + 1 < apps.size() ? ", " : " or ";
    names += apps[i]->get_name();
  }
  return names;
}

// The chosen commands: {experiment, run} for `palpate experiment run`.
std::vector<const CLI::App*> chosen_commands(const CLI::App& program) {
  std::vector<const CLI::App*> chosen;
  for (auto inner = program.get_subcommands(); !inner.empty();) {
    chosen.push_back(inner.front());
    inner = inner.front()->get_subcommands();
  }
  return chosen;
}

// CLI11's message, or a clearer one for the commonest mistakes.
std::string problem_of(const CLI::App& program, const std::vector<const CLI::App*>& chosen,
                       const CLI::ParseError& error) {
  const std::string message = error.what();
  const CLI::App& last = chosen.empty() ? program : *chosen.back();
  const std::string name = chosen.empty() ? "palpate" : last.get_name();
  const auto choices = last.get_subcommands([](const CLI::App*) { return true; });
  const std::vector<std::string> extras = program.remaining(/* recurse = */ true);
  if (!choices.empty() && !extras.empty()) {
    return extras.front() +
           (extras.front().starts_with("-") ? ": is not an option of " + name + "; expected "
            : chosen.empty()                ? ": is not a subcommand; expected "
                                            : ": is not a subcommand of " + name + "; expected ") +
           joined(choices);
  }
  if (!choices.empty() && error.get_name() == "RequiredError") {
    return message + "; expected " + joined(choices);
  }
  const bool has_extras = error.get_exit_code() == static_cast<int>(CLI::ExitCodes::ExtrasError);
  if (has_extras && !extras.empty()) {
    return extras.front() +
           (extras.front().starts_with("-") ? ": is not an option of "
                                            : ": is an unexpected argument of ") +
           name;
  }
  const std::size_t repeated = message.find(": At Most 1 required");
  if (repeated != std::string::npos) {
    return message.substr(0, repeated) + ": is given more than once; expected once";
  }
  return message;
}

int refuse_arguments(const CLI::App& program, const CLI::ParseError& error) {
  const auto chosen = chosen_commands(program);
  std::string problem = problem_of(program, chosen, error);
  std::replace(problem.begin(), problem.end(), '\n', ' ');
  std::string command;
  for (const CLI::App* const app : chosen) command += app->get_name() + " ";
  std::cerr << "palpate: " << problem << " (see " << palpate::program_name() << " " << command
            << "--help)\n";
  return palpate::kBadInput;
}

int run_program(int argc, char** argv) {
  if (has_empty_argument(argc, argv)) return palpate::kBadInput;
  CLI::App program(
      "Palpate renders any triangle-mesh scene through a point haptic device, which may have fewer "
      "motors than sensors.");
  program.set_version_flag("--version", "palpate " PALPATE_VERSION);
  program.require_subcommand(1);
  palpate::set_help(program, "  ./run.sh run models/star.glb --virtual\n",
                    "./run.sh COMMAND --help lists the options of a command.\n");
  const Commands commands = palpate::all_commands();
  std::vector<CLI::App*> apps;
  for (const auto& command : commands) apps.push_back(command->add_to(program));
  try {
    program.parse(argc, argv);
  } catch (const CLI::Success& help) {
    return program.exit(help);
  } catch (const CLI::ParseError& error) {
    return refuse_arguments(program, error);
  }
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  const auto chosen =
      std::find_if(apps.begin(), apps.end(), [](CLI::App* app) { return app->parsed(); });
  return commands[static_cast<std::size_t>(chosen - apps.begin())]->run(arguments);
}

// Opens /dev/null for each standard stream that is closed at the start, so that no file opened
// later gets its descriptor. Writing to such a stream fails, as if it were still closed, because
// /dev/null is opened for reading only.
void occupy_standard_descriptors() {
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(descriptor, F_GETFD) >= 0) continue;
    // open() returns the lowest free descriptor: this one.
    [[maybe_unused]] const int opened = ::open("/dev/null", O_RDONLY);
  }
}

}  // namespace

int main(int argc, char** argv) {
  occupy_standard_descriptors();
  palpate::install_signal_handlers();
  palpate::watch_file_roles();
  const palpate::PrintableStream out(std::cout);
  const palpate::PrintableStream err(std::cerr);
  try {
    return run_program(argc, argv);
  } catch (const std::bad_alloc&) {  // outside of the steps that report it themselves
    std::fputs(
        "palpate: the system refused memory (free some, or raise the limit of the process, ulimit "
        "-v)\n",
        stderr);
    return palpate::kBadInput;
  } catch (const std::exception& error) {
    std::cerr << "palpate: " << error.what() << "\n";
    return kOurFault;
  }
}
