// The subcommand `devices`: lists the drivers, and simulates the board of one.

#include <chrono>
#include <iostream>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "engine/cli/all_commands.h"
#include "engine/cli/command_help.h"
#include "engine/cli/command_output.h"
#include "engine/cli/number_option.h"
#include "engine/cli/program_signals.h"
#include "engine/devices/hapi_view.h"
#include "engine/simulation/board_terminal.h"

namespace palpate {
namespace {

constexpr const char* kDrivers =
    "hapi  pantograph on a hAPI board (Haply 2DIY): 2 sensors, 2 motors; not tried on hardware\n"
    "      hapi:port=FILE[,KEY=NUMBER...]\n"
    "      port           the board's serial port, for example /dev/ttyACM0\n"
    "      base, proximal, distal   lengths of the links, m (0.02, 0.05, 0.07)\n"
    "      torque-per-Nm  the board's torque number for 1 N m; without it, no force is commanded\n"
    "      peak-torque    the largest torque of a motor, N m; required beside torque-per-Nm\n"
    "      dev            the number of the device on its board (5)\n"
    "      counts         steps of an encoder per turn (13824)\n"
    "      angle1, angle2 angles of the joints in the rest pose, degrees (180, 0)\n"
    "      rate           messages per second (1000)\n";

std::string delay_words(const DeviceDescription& device) {
  if (device.delay_s == 0.0) return "unknown";
  std::ostringstream text;
  text << 1e3 * device.delay_s << " ms";
  return text.str();
}

constexpr std::size_t kKeptCommands = 1000;

class DevicesCommand final : public Command {
 public:
  CLI::App* add_to(CLI::App& program) override {
    CLI::App& app = *program.add_subcommand("devices", "list the drivers, or simulate a board");
    set_help(app, "  ./run.sh devices --simulate hapi --seconds 1\n");
    app.add_option("--simulate", simulated_,
                   "simulate the board of this driver (hapi) behind a pseudo-terminal, whose port "
                   "is printed, until Ctrl-C")
        ->type_name("DRIVER");
    add_real(app, "--seconds", seconds_, kAboveZero, "end the simulation after this time");
    return &app;
  }
  int run(const std::vector<std::string>& arguments) override;

 private:
  int simulate();

  std::string simulated_;
  std::optional<double> seconds_;
};

int DevicesCommand::run(const std::vector<std::string>&) {
  if (simulated_.empty() && seconds_) {
    return refuse(invalid_argument("--seconds", "is given alone; expected --simulate beside it"));
  }
  if (!simulated_.empty()) return simulate();
  std::cout << kDrivers << "      its delay from a sample to the force: "
            << delay_words(hapi_description(HapiSettings{})) << "\n";
  return finish_output();
}

int DevicesCommand::simulate() {
  if (simulated_ != "hapi") {
    return refuse(invalid_argument("--simulate", "is \"" + simulated_ + "\"; expected hapi"));
  }
  const SignalPhaseScope in_order(SignalPhase::kInOrder);
  BoardSettings settings;
  settings.kept_commands = kKeptCommands;
  const auto board = BoardTerminal::open(settings);
  if (!board) return refuse(board.error());
  std::cout << "a simulated hAPI board at " << (*board)->path() << "\n" << std::flush;
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  const auto is_over = [&] {
    return seconds_ && std::chrono::duration<double>(Clock::now() - start).count() >= *seconds_;
  };
  while (!signal_flag().requested() && !is_over()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  const auto log = (*board)->log();
  std::cout << (*board)->set_ups() << " set-ups, " << (*board)->commands() << " commands";
  if (!log.empty()) {
    std::cout << ", the last torques " << log.back().torques[0] << ", " << log.back().torques[1];
  }
  std::cout << "\n";
  return exit_code_after_signals(finish_output());
}

}  // namespace

std::unique_ptr<Command> make_devices_command() {
  return std::make_unique<DevicesCommand>();
}

}  // namespace palpate
