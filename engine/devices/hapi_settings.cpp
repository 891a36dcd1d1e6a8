#include "engine/devices/hapi_settings.h"

#include <cmath>
#include <sstream>

#include "engine/devices/five_bar_workspace.h"
#include "engine/devices/hapi_torques.h"

namespace palpate {
namespace {

// A number of the settings by the name that a user gives it.
struct HapiNumber {
  const char* name;
  double value;
  double least;
  double most;
};

std::optional<Error> number_error(const HapiNumber& number) {
  if (number.value >= number.least && number.value <= number.most) return std::nullopt;
  std::ostringstream problem;
  problem << "is " << number.value << "; expected a number from " << number.least << " to "
          << number.most;
  return invalid_argument(number.name, problem.str());
}

}  // namespace

std::optional<Error> check_hapi_settings(const HapiSettings& settings) {
  using Limits = HapiLimits;
  if (settings.port.empty()) {
    return invalid_argument("port", "is missing; expected port=FILE",
                            "the ports of boards have names like /dev/ttyACM0");
  }
  const HapiWiring& wiring = settings.wiring;
  for (const HapiNumber& number : {
           HapiNumber{"base", settings.links.base_m, Limits::kShortest_m, Limits::kLongest_m},
           HapiNumber{"proximal", settings.links.proximal_m, Limits::kShortest_m,
                      Limits::kLongest_m},
           HapiNumber{"distal", settings.links.distal_m, Limits::kShortest_m, Limits::kLongest_m},
           HapiNumber{"dev", static_cast<double>(wiring.device), 1.0, 127.0},
           HapiNumber{"counts", static_cast<double>(wiring.counts_per_turn), 1.0,
                      Limits::kMostCounts},
           HapiNumber{"angle1", static_cast<double>(wiring.rest_deg[0]), -360.0, 360.0},
           HapiNumber{"angle2", static_cast<double>(wiring.rest_deg[1]), -360.0, 360.0},
           HapiNumber{"rate", settings.rate_Hz, Limits::kSlowest_Hz, Limits::kFastest_Hz},
       }) {
    if (auto error = number_error(number)) return error;
  }
  if (settings.torque_per_Nm) {
    const HapiNumber size{"torque-per-Nm", std::abs(*settings.torque_per_Nm),
                          1.0 / Limits::kMostPerNm, Limits::kMostPerNm};
    if (auto error = number_error(size)) return error;
    if (settings.peak_torque_Nm == 0.0) {
      return invalid_argument("peak-torque", "is missing; expected a number beside torque-per-Nm",
                              "the largest torque of a motor, in N m");
    }
    const HapiNumber peak{"peak-torque", settings.peak_torque_Nm, 0.0, Limits::kMostPeak_Nm};
    if (auto error = number_error(peak)) return error;
  }
  const FiveBar bar(settings.links);
  const auto rest = hapi_pose(bar, wiring.rest_deg);
  if (!rest || !std::isfinite(condition_number(rest->jacobian))) {
    return invalid_argument("angle1, angle2",
                            "are angles at which the links cannot meet or cannot push; expected "
                            "the rest pose of the linkage");
  }
  if (!full_force_workspace(bar)) {
    return invalid_argument("base, proximal, distal",
                            "are links without a workspace; expected links that can push in every "
                            "direction somewhere");
  }
  return std::nullopt;
}

}  // namespace palpate
