#include "engine/cli/device_report.h"

#include <sstream>

#include <nlohmann/json.hpp>

namespace palpate {
namespace {

// The value that caused the trip, and its limit.
std::string trip_values_text(const GovernorTrip& trip) {
  std::ostringstream text;
  switch (trip.reason) {
    case TripReason::kBadSamples:
      text << ": " << trip.value << " bad samples; expected fewer than " << trip.limit;
      break;
    case TripReason::kSpeed:
      text << ": " << trip.value << " m/s; expected at most " << trip.limit << " m/s";
      break;
    case TripReason::kStale:
      text << ": no new sample for " << trip.value << " s; expected at most " << trip.limit << " s";
      break;
    case TripReason::kNone:
    case TripReason::kBadForce:
    case TripReason::kDevice:
      break;
  }
  return text.str();
}

}  // namespace

std::string trip_text(const GovernorTrip& trip) {
  std::ostringstream text;
  text << kTripReasonNames[static_cast<std::size_t>(trip.reason)] << " at " << trip.time_s
       << " s, tick " << trip.tick << trip_values_text(trip);
  return text.str();
}

nlohmann::ordered_json device_json(const DeviceFacts& facts, const DeviceRun& run) {
  nlohmann::ordered_json json = {{"name", facts.name},
                                 {"option", facts.option},
                                 {"conversation", facts.summary},
                                 {"guard", facts.has_guard},
                                 {"without_realtime", facts.without_realtime},
                                 {"fifo", run.has_fifo},
                                 {"given_J", run.governor.given_J},
                                 {"given_by_design_J", run.governor.given_by_design_J}};
  json["problem"] =
      run.health.is_good ? nlohmann::ordered_json() : nlohmann::ordered_json(run.health.problem);
  return json;
}

std::string device_text(const DeviceFacts& facts, const DeviceRun& run) {
  std::ostringstream text;
  text << facts.name << ": " << facts.summary << "\n";
  text << "energy that the motors gave " << 1e3 * run.governor.given_J << " mJ, of this by design "
       << 1e3 * run.governor.given_by_design_J << " mJ\n";
  if (!facts.has_guard) text << "no process guarded the motors (--no-guard)\n";
  if (facts.without_realtime) {
    text << "--without-realtime: SCHED_FIFO was " << (run.has_fifo ? "granted" : "refused") << "\n";
  }
  return text.str();
}

std::vector<std::string> device_warnings(const DeviceRun& run) {
  std::vector<std::string> warnings = run.warnings;
  if (!run.health.is_good) warnings.push_back(run.health.problem);
  return warnings;
}

}  // namespace palpate
