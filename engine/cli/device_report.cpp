#include "engine/cli/device_report.h"

#include <sstream>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/cli/setting_texts.h"

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
    case TripReason::kUnstable:
      text << ": the loop has given " << 1e3 * trip.value << " mJ too much; expected at most "
           << 1e3 * trip.limit << " mJ";
      break;
    case TripReason::kNone:
    case TripReason::kBadForce:
    case TripReason::kDevice:
      break;
  }
  return text.str();
}

// A number that is unknown is null.
nlohmann::ordered_json known(double number) {
  return number > 0.0 ? nlohmann::ordered_json(number) : nlohmann::ordered_json();
}

nlohmann::ordered_json line_json(const LineRate& line) {
  return {{"asked_Hz", known(line.asked_Hz)},
          {"at_start_Hz", known(line.at_start_Hz)},
          {"in_session_Hz", known(line.in_session_Hz)},
          {"slowest_Hz", known(line.slowest_Hz)},
          {"median_delay_s", known(line.delay.least_s)},
          {"longest_delay_s", known(line.delay.most_s)},
          {"delayed_share", line.delayed_share}};
}

// Empty for a device that does not measure its line.
std::string line_text(const LineRate& line) {
  if (line.in_session_Hz <= 0.0) return {};
  std::ostringstream text;
  text << "messages per second: " << line.in_session_Hz << " of " << line.asked_Hz;
  if (line.slowest_Hz > 0.0) text << ", at least " << line.slowest_Hz << " in each second";
  if (line.delay.is_known()) {
    text << "; delay from a sample to its force " << 1e3 * line.delay.least_s << " ms (longest "
         << 1e3 * line.delay.most_s << " ms)";
  }
  text << "\n";
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
  nlohmann::ordered_json json = {{"name", facts.device.name},
                                 {"option", facts.option},
                                 {"conversation", facts.summary},
                                 {"line", line_json(run.line)},
                                 {"guard", facts.has_guard},
                                 {"without_realtime", facts.without_realtime},
                                 {"fifo", run.has_fifo},
                                 {"given_J", run.governor.given_J},
                                 {"given_late_J", run.governor.given_late_J},
                                 {"encoder_J", run.governor.encoder_J},
                                 {"given_by_design_J", run.governor.given_by_design_J}};
  for (std::size_t n = 0; n < kEnergySourceCount; ++n) {
    json["given_by_source_J"][std::string(kEnergySourceNames[n])] =
        run.governor.given_by_source_J[n];
    json["energy_budgets"][std::string(kEnergySourceNames[n])] = {
        {"tank_J", facts.budgets.of[n].tank_J}, {"power_W", facts.budgets.of[n].power_W}};
  }
  json["problem"] =
      run.health.is_good ? nlohmann::ordered_json() : nlohmann::ordered_json(run.health.problem);
  return json;
}

std::string device_text(const DeviceFacts& facts, const DeviceRun& run) {
  std::ostringstream text;
  text << facts.device.name << ": " << facts.summary << "\n" << line_text(run.line);
  text << "energy that the motors gave " << 1e3 * run.governor.given_J << " mJ ("
       << 1e3 * run.governor.given_late_J << " mJ if each force acts as late as it may";
  if (run.governor.encoder_J > 0.0) {
    text << "; each up to " << 1e3 * run.governor.encoder_J
         << " mJ more or less by the steps of the encoders";
  }
  text << "), of this by design " << 1e3 * run.governor.given_by_design_J << " mJ\n";
  const std::string budgets = energy_budgets_text(facts.budgets);
  if (!budgets.empty()) text << "energy budgets: " << budgets << "\n";
  if (!facts.has_guard) text << "no process guarded the motors (--no-guard)\n";
  if (facts.without_realtime) {
    text << "--without-realtime: SCHED_FIFO was " << (run.has_fifo ? "granted" : "refused") << "\n";
  }
  return text.str();
}

std::vector<std::string> device_warnings(const DeviceFacts& facts, const DeviceRun& run) {
  std::vector<std::string> warnings = run.warnings;
  for (std::string& warning : line_warnings(facts.device, run.line)) {
    warnings.push_back(std::move(warning));
  }
  if (!run.health.is_good) warnings.push_back(run.health.problem);
  return warnings;
}

}  // namespace palpate
