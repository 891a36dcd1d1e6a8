// The subcommand `devices`: lists the drivers, and simulates the device of one.

#include <chrono>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "engine/cli/all_commands.h"
#include "engine/cli/command_help.h"
#include "engine/cli/command_output.h"
#include "engine/cli/number_option.h"
#include "engine/cli/program_signals.h"
#include "engine/drivers/drivers.h"

namespace palpate {
namespace {

class DevicesCommand final : public Command {
 public:
  CLI::App* add_to(CLI::App& program) override {
    CLI::App& app = *program.add_subcommand("devices", "list the drivers, or simulate a board");
    set_help(app, "  ./run.sh devices --simulate hapi --seconds 1\n");
    app.add_option("--simulate", simulated_,
                   "simulate the board of this driver (" + driver_names() +
                       ") behind a pseudo-terminal, whose port is printed, until Ctrl-C")
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
  std::cout << drivers_text();
  return finish_output();
}

int DevicesCommand::simulate() {
  const Driver* const driver = find_driver(simulated_);
  if (driver == nullptr || driver->simulate == nullptr) {
    return refuse(
        invalid_argument("--simulate", "is \"" + simulated_ + "\"; expected " + driver_names()));
  }
  const SignalPhaseScope in_order(SignalPhase::kInOrder);
  const auto hardware = driver->simulate();
  if (!hardware) return refuse(hardware.error());
  std::cout << (*hardware)->place() << "\n" << std::flush;
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  const auto is_over = [&] {
    return seconds_ && std::chrono::duration<double>(Clock::now() - start).count() >= *seconds_;
  };
  while (!signal_flag().requested() && !is_over()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  std::cout << (*hardware)->summary() << "\n";
  return exit_code_after_signals(finish_output());
}

}  // namespace

std::unique_ptr<Command> make_devices_command() {
  return std::make_unique<DevicesCommand>();
}

}  // namespace palpate
