#pragma once

// A driver: what the program must know of a kind of device that has motors.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/devices/guardable_device.h"
#include "engine/simulation/held_tip.h"
#include "geometry/base/result.h"

namespace palpate {

enum class DriverKeyKind : std::uint8_t { kText, kReal, kWhole };

// A key of a driver's settings, as a user writes it.
struct DriverKey {
  std::string_view name;
  std::string_view meaning;  // one line, with the unit
  DriverKeyKind kind = DriverKeyKind::kReal;
  // The range of a number. A whole number outside of it is refused; a driver checks real numbers.
  double least = 0.0;
  double most = 0.0;
  std::optional<double> initial = {};  // the number without the key; no value: none
};

// The settings that a user has given, checked against the keys: numbers are finite.
class DriverValues {
 public:
  void set_text(std::string_view key, std::string_view text) { texts_.emplace_back(key, text); }
  void set_number(std::string_view key, double number) { numbers_.emplace_back(key, number); }
  // No value: the user has not given the key.
  std::optional<std::string> text(std::string_view key) const { return find(texts_, key); }
  std::optional<double> number(std::string_view key) const { return find(numbers_, key); }

 private:
  template <typename Value>
  static std::optional<Value> find(const std::vector<std::pair<std::string, Value>>& values,
                                   std::string_view key) {
    for (const auto& [name, value] : values) {
      if (name == key) return value;
    }
    return std::nullopt;
  }

  std::vector<std::pair<std::string, std::string>> texts_;
  std::vector<std::pair<std::string, double>> numbers_;
};

// A device that a driver simulates, in real time, until the destructor.
class SimulatedHardware {
 public:
  virtual ~SimulatedHardware() = default;
  // What it is and where a driver finds it: "a simulated hAPI board at /dev/pts/3".
  virtual std::string place() const = 0;
  // What it has done so far, in one line.
  virtual std::string summary() const = 0;
};

// What stands behind the board of a simulated device, and how slow the line to it is.
struct SimulatedPlant {
  TipSettings tip;
  double delay_s = 0.0;  // of a message and its answer together, beside the board's own time
};

struct Driver {
  std::string_view name;
  std::string_view what;     // the devices, their sensors and motors, in one line
  std::string_view example;  // of settings: "port=/dev/ttyACM0"
  std::vector<DriverKey> (*keys)();
  // The device with the initial values of all keys.
  DeviceDescription (*describe)();
  // Makes the device; start() opens it. works_without_guard: it commands forces although nothing
  // stops the motors if this process hangs or ends; for tests. The Error's element is the key.
  Result<std::unique_ptr<GuardableDevice>> (*make)(const DriverValues& values,
                                                   bool works_without_guard);
  // Starts the simulated hardware; null: the driver has none.
  Result<std::unique_ptr<SimulatedHardware>> (*simulate)() = nullptr;
  // The same with this plant, whose hand probes the scene (probing_hand.h); null: the driver has
  // none.
  Result<std::unique_ptr<SimulatedHardware>> (*simulate_plant)(const SimulatedPlant& plant) =
      nullptr;
};

}  // namespace palpate
