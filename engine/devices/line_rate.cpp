#include "engine/devices/line_rate.h"

#include <sstream>

namespace palpate {
namespace {

// More delayed forces than this contradict the delay that a device states (HapiDelay::kRare).
constexpr double kMostDelayed = 1.0 / 20.0;

double reached_Hz(const DeviceDescription& device, const LineRate& line) {
  if (line.at_start_Hz > 0.0) return line.at_start_Hz;
  return line.asked_Hz > 0.0 ? line.asked_Hz : device.rate_Hz;
}

bool is_halved(double rate_Hz, const LineRate& line) {
  return rate_Hz < 0.5 * line.asked_Hz;
}

std::string expected_text() {
  std::ostringstream text;
  text << "; expected at least " << LeastRates::kRefused_Hz
       << " for a device that moves motors, because it holds each force until the next one";
  return text.str();
}

std::string slow_text(const std::string& what, double rate_Hz) {
  std::ostringstream text;
  text << what << " have a rate of " << rate_Hz << " Hz; expected at least "
       << LeastRates::kWarned_Hz << " Hz: the slower they are, the softer a wall must be";
  return text.str();
}

std::string reached_text(double rate_Hz, double asked_Hz) {
  std::ostringstream text;
  text << rate_Hz << " of " << asked_Hz << " messages per second";
  return text.str();
}

}  // namespace

std::optional<Error> check_least_rates(const DeviceDescription& device, const LineRate& line,
                                       double tick_rate_Hz) {
  if (!pushes(device)) return std::nullopt;
  if (tick_rate_Hz < LeastRates::kRefused_Hz) {
    std::ostringstream problem;
    problem << "is " << tick_rate_Hz << " Hz" << expected_text();
    return invalid_argument("rate_Hz", problem.str());
  }
  const double messages_Hz = reached_Hz(device, line);
  if (messages_Hz >= LeastRates::kRefused_Hz) return std::nullopt;
  std::ostringstream problem;
  if (line.asked_Hz >= LeastRates::kRefused_Hz) {
    problem << "reaches only " << reached_text(messages_Hz, line.asked_Hz);
  } else {
    problem << "is asked for " << messages_Hz << " messages per second";
  }
  problem << expected_text();
  return invalid_argument(device.name, problem.str(),
                          line.asked_Hz >= LeastRates::kRefused_Hz
                              ? "connect the device to a faster port, without a hub"
                              : "state a higher rate in the settings of the device");
}

std::vector<std::string> slow_rate_warnings(const DeviceDescription& device, const LineRate& line,
                                            double tick_rate_Hz) {
  std::vector<std::string> warnings;
  if (!pushes(device)) return warnings;
  if (tick_rate_Hz < LeastRates::kWarned_Hz) {
    warnings.push_back(slow_text("the ticks", tick_rate_Hz));
  }
  const double messages_Hz = reached_Hz(device, line);
  if (messages_Hz < LeastRates::kWarned_Hz) {
    warnings.push_back(slow_text("the messages to the device", messages_Hz));
  }
  if (is_halved(messages_Hz, line)) {
    warnings.push_back("the line to the device reaches only " +
                       reached_text(messages_Hz, line.asked_Hz));
  }
  return warnings;
}

std::vector<std::string> line_warnings(const DeviceDescription& device, const LineRate& line) {
  std::vector<std::string> warnings;
  const double least_Hz = line.slowest_Hz;  // a session of less than a second has none
  const bool is_known = least_Hz > 0.0 && least_Hz < reached_Hz(device, line);
  if (is_known && (least_Hz < LeastRates::kWarned_Hz || is_halved(least_Hz, line))) {
    warnings.push_back("the line to the device became slower: in one second it carried only " +
                       reached_text(least_Hz, line.asked_Hz));
  }
  if (line.delayed_share > kMostDelayed) {
    std::ostringstream text;
    text << 100.0 * line.delayed_share << " % of the forces were later than "
         << 1e3 * device.delay.most_s << " ms, the longest delay that was measured at the start "
         << "(up to " << 1e3 * line.delay.most_s
         << " ms): the limits of the stiffness are too high";
    warnings.push_back(text.str());
  }
  return warnings;
}

}  // namespace palpate
