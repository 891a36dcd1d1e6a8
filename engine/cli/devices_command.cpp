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
#include "engine/simulation/calm_chart.h"

namespace palpate {
namespace {

class DevicesCommand final : public Command {
 public:
  CLI::App* add_to(CLI::App& program) override {
    CLI::App& app = *program.add_subcommand("devices", "list the drivers, or simulate a board");
    set_help(app,
             "  ./run.sh devices --simulate hapi --seconds 1\n"
             "  ./run.sh devices --simulate hapi --plant 0.1,0.5,light,0.001 --seconds 1\n");
    app.add_option("--simulate", simulated_,
                   "simulate the board of this driver (" + driver_names() +
                       ") behind a pseudo-terminal, whose port is printed, until Ctrl-C")
        ->type_name("DRIVER");
    app.add_option(
           "--plant", plant_,
           "mass, kg, damping, N s/m, grip (bare, light or firm), and delay of the line, s, "
           "of the simulated device; its hand probes the scene, and the end of the "
           "simulation states what became of the tip")
        ->type_name("MASS,DAMPING,GRIP,DELAY");
    add_real(app, "--seconds", seconds_, kAboveZero, "end the simulation after this time");
    return &app;
  }
  int run(const std::vector<std::string>& arguments) override;

 private:
  int simulate();

  std::string simulated_;
  std::string plant_;
  std::optional<double> seconds_;
};

constexpr NumberRange kPlantMass_kg{1e-3, 100.0};
constexpr NumberRange kPlantDamping_Ns_per_m{1e-3, 1000.0};
constexpr NumberRange kPlantDelay_s{0.0, 0.1};

Result<SimulatedPlant> parse_plant(const std::string& text) {
  const std::string option = "--plant";
  std::vector<std::string> parts(1);
  for (const char letter : text) {
    if (letter == ',') {
      parts.emplace_back();
    } else {
      parts.back() += letter;
    }
  }
  if (parts.size() != 4) {
    return invalid_argument(option, "is \"" + text +
                                        "\"; expected MASS,DAMPING,GRIP,DELAY, for example "
                                        "0.1,0.5,light,0.001");
  }
  const auto mass_kg = parse_real(option, parts[0], kPlantMass_kg);
  if (!mass_kg) return mass_kg.error();
  const auto damping_Ns_per_m = parse_real(option, parts[1], kPlantDamping_Ns_per_m);
  if (!damping_Ns_per_m) return damping_Ns_per_m.error();
  const auto delay_s = parse_real(option, parts[3], kPlantDelay_s);
  if (!delay_s) return delay_s.error();
  for (const ChartGrip grip : {ChartGrip::kBare, ChartGrip::kLight, ChartGrip::kFirm}) {
    if (parts[2] != name_of(grip)) continue;
    return SimulatedPlant{{*mass_kg, *damping_Ns_per_m, hand_of(grip)}, *delay_s};
  }
  return invalid_argument(option,
                          "has the grip \"" + parts[2] + "\"; expected bare, light or firm");
}

int DevicesCommand::run(const std::vector<std::string>&) {
  if (simulated_.empty() && seconds_) {
    return refuse(invalid_argument("--seconds", "is given alone; expected --simulate beside it"));
  }
  if (simulated_.empty() && !plant_.empty()) {
    return refuse(invalid_argument("--plant", "is given alone; expected --simulate beside it"));
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
  std::optional<SimulatedPlant> plant;
  if (!plant_.empty()) {
    const auto parsed = parse_plant(plant_);
    if (!parsed) return refuse(parsed.error());
    if (driver->simulate_plant == nullptr) {
      return refuse(invalid_argument("--plant", "is given, but the driver \"" + simulated_ +
                                                    "\" simulates no plant; leave it out"));
    }
    plant = *parsed;
  }
  const SignalPhaseScope in_order(SignalPhase::kInOrder);
  const auto hardware = plant ? driver->simulate_plant(*plant) : driver->simulate();
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
