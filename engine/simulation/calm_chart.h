#pragma once

// The chart of calm contacts: random devices, hands and walls, and whether the tip comes to rest.

#include <cstdint>
#include <optional>
#include <string_view>

#include "engine/devices/stiffness_zones.h"
#include "engine/simulation/port_loop.h"
#include "geometry/base/result.h"

namespace palpate {

enum class ChartGrip : std::uint8_t { kBare, kLight, kFirm };
enum class ChartContact : std::uint8_t {
  kThrown,  // the hand throws the tip, and holds it where it has come from, or not at all
  kPressed  // the hand presses the tip into the shape: a grip for ever, a bare tip for kPress_s
};

// The ranges of the chart.
struct ChartRange {
  static constexpr double kLeastStiffness_N_per_m = 100.0, kMostStiffness_N_per_m = 20'000.0;
  static constexpr double kLongestDelay_s = 5e-3;
  static constexpr double kLeastRate_Hz = 250.0, kMostRate_Hz = 10'000.0;
  static constexpr double kSlowest_m_per_s = 0.05, kFastest_m_per_s = 0.3;  // of throws
  // Of presses. A bare tip, which flies away when it is let go, gets half of it: a soft wall then
  // throws it at less than 0.7 m/s.
  static constexpr double kStrongest_N = 3.0;
};

struct ChartCase {
  PortShape shape = PortShape::kWall;
  ChartGrip grip = ChartGrip::kBare;
  ChartContact contact = ChartContact::kThrown;
  double stiffness_N_per_m = 1000.0;
  double delay_s = 0.0;  // the true one
  double rate_Hz = 1000.0;
  double speed_m_per_s = 0.3;  // of a throw
  double push_N = 2.0;         // of a press, at its rest
  double turn_rad = 0.0;       // see PortLoopSettings
  double aim_rad = 0.0;        // of the throw and the push, from the shape's -x axis
  int motors = 2;              // as many as sensors
  double peak_force_N = 10.0;
  bool states_mechanics = false;   // the device states its true mass and damping
  bool states_delay = true;        // an interval that ends at the true delay
  double encoder_quantum_m = 0.0;  // the device's steps, which it states; 0: none
  int ticks_per_sample = 1;        // of the device, which states its own rate

  // Case `number` of a seed. Stiffness and rate are uniform in their logarithms.
  static ChartCase random(std::uint64_t seed, std::uint64_t number);
};

// How a case ended.
enum class ChartOutcome : std::uint8_t {
  kStable,      // at rest in time, as the zone says
  kControlled,  // at rest in time, in the zone of the controller
  kRefused,     // the zone allows no run
  kTripped,     // the governor has cut the force
  kSwings,      // the tip was not at rest in time: a promise is broken
  kReturns      // the motors returned more than they may: a promise is broken
};
inline constexpr std::string_view kChartOutcomeNames[] = {
    "stable", "calm by the controller", "refused", "tripped", "swings", "returns energy"};

// What every case promises.
struct ChartPromise {
  static constexpr double kRest_s = 3.0;       // after the hand's last motion, or the first contact
  static constexpr double kRest_m = 0.1e-3;    // the farthest from the place where the tip ends
  static constexpr double kReturned_J = 5e-3;  // PortAccount::most_returned_J
};

struct ChartResult {
  ChartOutcome outcome = ChartOutcome::kRefused;
  StiffnessZones zones;
  StiffnessZone zone = StiffnessZone::kRefused;
  GovernorTrip trip;
  double rest_time_s = 0.0;            // when the tip last was farther than kRest_m from its end
  double amplitude_m = 0.0;            // half of the way between the extremes after kRest_s
  double returned_J = 0.0;             // PortAccount::most_returned_J since before the contact
  double given_J = 0.0;                // PortAccount::most_given_J since then
  double hand_J = 0.0;                 // the hand's work
  double largest_speed_m_per_s = 0.0;  // after the first contact
  std::uint32_t rules = 0;             // after the start
  bool has_touched = false;

  bool keeps_promises() const {
    return outcome != ChartOutcome::kSwings && outcome != ChartOutcome::kReturns;
  }
};

// The zones of a case, as its device describes itself. Errors: those of stiffness_zones().
Result<StiffnessZones> zones_of(const ChartCase& chart_case);

struct ChartOptions {
  bool runs_refused = false;  // also run cases in the zone kRefused
  // False: the device says that it moves no motors, so that the governor limits only what its
  // motors can push. This is the loop that the controller has to hold.
  bool is_governed = true;
};

// Deterministic. Not for the haptic thread. Errors: those of PortLoop::create() and
// stiffness_zones().
Result<ChartResult> run_chart_case(const ChartCase& chart_case, const ChartOptions& options = {});
// The hand of a grip: HandImpedance of a chart.
HandImpedance hand_of(ChartGrip grip);

std::string_view name_of(PortShape shape);
std::string_view name_of(ChartGrip grip);
std::string_view name_of(ChartContact contact);

}  // namespace palpate
