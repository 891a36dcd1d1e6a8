#include "engine/drivers/hapi_driver.h"

#include <cmath>
#include <sstream>
#include <utility>

#include "engine/devices/hapi_device.h"
#include "engine/devices/hapi_view.h"
#include "engine/simulation/board_terminal.h"

namespace palpate {
namespace {

using Limits = HapiLimits;

// A key, and how its number is stored.
struct HapiKey {
  DriverKey key;
  void (*store)(HapiSettings&, double);
};

constexpr std::string_view kPort = "port";
constexpr DriverKey kPortKey{kPort, "the board's serial port, for example /dev/ttyACM0; required",
                             DriverKeyKind::kText};

DriverKey length_key(std::string_view name, std::string_view meaning, double initial_m) {
  return {name, meaning, DriverKeyKind::kReal, Limits::kShortest_m, Limits::kLongest_m, initial_m};
}

DriverKey angle_key(std::string_view name, std::string_view meaning, float initial_deg) {
  return {name, meaning, DriverKeyKind::kReal, -360.0, 360.0, initial_deg};
}

std::vector<HapiKey> hapi_keys() {
  const HapiSettings initial;
  return {
      {{"dev", "the number of the device on its board", DriverKeyKind::kWhole, 1.0, 127.0,
        initial.wiring.device},
       [](HapiSettings& s, double x) { s.wiring.device = static_cast<std::uint8_t>(x); }},
      {length_key("base", "length of the base link, m", initial.links.base_m),
       [](HapiSettings& s, double x) { s.links.base_m = x; }},
      {length_key("proximal", "length of a proximal link, m", initial.links.proximal_m),
       [](HapiSettings& s, double x) { s.links.proximal_m = x; }},
      {length_key("distal", "length of a distal link, m", initial.links.distal_m),
       [](HapiSettings& s, double x) { s.links.distal_m = x; }},
      {{"torque-per-Nm",
        "the board's torque number for 1 N m, of either sign; without it, no force is commanded",
        DriverKeyKind::kReal, 1.0 / Limits::kMostPerNm, Limits::kMostPerNm},
       [](HapiSettings& s, double x) { s.torque_per_Nm = x; }},
      {{"peak-torque", "the largest torque of a motor, N m; required beside torque-per-Nm",
        DriverKeyKind::kReal, 0.0, Limits::kMostPeak_Nm},
       [](HapiSettings& s, double x) { s.peak_torque_Nm = x; }},
      {{"counts", "steps of an encoder per turn", DriverKeyKind::kReal, 1.0, Limits::kMostCounts,
        initial.wiring.counts_per_turn},
       [](HapiSettings& s, double x) { s.wiring.counts_per_turn = static_cast<float>(x); }},
      {angle_key("angle1", "angle of the first joint in the rest pose, degrees",
                 initial.wiring.rest_deg[0]),
       [](HapiSettings& s, double x) { s.wiring.rest_deg[0] = static_cast<float>(x); }},
      {angle_key("angle2", "angle of the second joint in the rest pose, degrees",
                 initial.wiring.rest_deg[1]),
       [](HapiSettings& s, double x) { s.wiring.rest_deg[1] = static_cast<float>(x); }},
      {{"rate", "messages per second; at least 250 with torque-per-Nm", DriverKeyKind::kReal,
        Limits::kSlowest_Hz, Limits::kFastest_Hz, initial.rate_Hz},
       [](HapiSettings& s, double x) { s.rate_Hz = x; }},
  };
}

std::vector<DriverKey> keys() {
  std::vector<DriverKey> all{kPortKey};
  for (const HapiKey& hapi : hapi_keys()) all.push_back(hapi.key);
  return all;
}

DeviceDescription describe() {
  return hapi_description(HapiSettings{});
}

Result<std::unique_ptr<GuardableDevice>> make(const DriverValues& values,
                                              bool works_without_guard) {
  auto settings = hapi_settings_of(values);
  if (!settings) return settings.error();
  settings->works_without_guard = works_without_guard;
  return std::unique_ptr<GuardableDevice>(std::make_unique<HapiDevice>(*settings));
}

class SimulatedHapiBoard final : public SimulatedHardware {
 public:
  SimulatedHapiBoard(std::unique_ptr<BoardTerminal> board, bool has_probes)
      : board_(std::move(board)), has_probes_(has_probes) {}
  std::string place() const override { return "a simulated hAPI board at " + board_->path(); }
  std::string summary() const override {
    std::ostringstream text;
    text << board_->set_ups() << " set-ups, " << board_->commands() << " commands";
    const auto log = board_->log();
    if (!log.empty()) {
      text << ", the last torques " << log.back().torques[0] << ", " << log.back().torques[1];
    }
    if (has_probes_) text << "\n" << plant_text();
    return text.str();
  }

 private:
  std::string plant_text() const {
    const PortAccount account = board_->account();
    const ProbeResult probes = board_->probes();
    std::ostringstream text;
    text << "plant: " << probes.judged << " probes, amplitude at their end at most "
         << 1e3 * probes.largest_amplitude_m << " mm; largest speed "
         << account.largest_speed_m_per_s << " m/s; returned over the hand's work at most "
         << 1e3 * account.most_returned_J << " mJ; work of the motors " << 1e3 * account.motors_J
         << " mJ, of the hand " << 1e3 * account.hand_J << " mJ, lost " << 1e3 * account.lost_J
         << " mJ";
    return text.str();
  }

  std::unique_ptr<BoardTerminal> board_;
  bool has_probes_;
};

Result<std::unique_ptr<SimulatedHardware>> simulate_board(BoardSettings settings) {
  settings.kept_commands = 1000;
  auto board = BoardTerminal::open(settings);
  if (!board) return board.error();
  return std::unique_ptr<SimulatedHardware>(
      std::make_unique<SimulatedHapiBoard>(std::move(*board), settings.plant.hand_probes));
}

Result<std::unique_ptr<SimulatedHardware>> simulate() {
  return simulate_board({});
}

Result<std::unique_ptr<SimulatedHardware>> simulate_plant(const SimulatedPlant& plant) {
  BoardSettings settings;
  settings.plant.mass_kg = plant.tip.mass_kg;
  settings.plant.damping_Ns_per_m = plant.tip.damping_Ns_per_m;
  settings.plant.hand = plant.tip.hand;
  settings.plant.hand_probes = true;
  settings.line_ns = std::llround(0.5e9 * plant.delay_s);
  return simulate_board(settings);
}

}  // namespace

Result<HapiSettings> hapi_settings_of(const DriverValues& values) {
  HapiSettings settings;
  settings.port = values.text(kPort).value_or("");
  for (const HapiKey& hapi : hapi_keys()) {
    if (const auto number = values.number(hapi.key.name)) hapi.store(settings, *number);
  }
  if (auto error = check_hapi_settings(settings)) return *error;
  return settings;
}

const Driver kHapiDriver{
    "hapi",
    "pantograph on a hAPI board (Haply 2DIY): 2 sensors, 2 motors; not tried on hardware",
    "port=/dev/ttyACM0",
    keys,
    describe,
    make,
    simulate,
    simulate_plant};

}  // namespace palpate
