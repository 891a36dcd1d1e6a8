#pragma once

// `soak --device`: the chart of calm contacts (engine/simulation/calm_chart.h).

#include <cstdint>
#include <optional>
#include <string>

namespace palpate {

inline constexpr std::uint64_t kMostChartCases = 1'000'000;

struct ChartRequest {
  std::uint64_t seed = 1;
  std::uint64_t cases = 200;
  std::optional<double> rate_Hz;  // of every case; no value: that of the case
  std::string out_dir;
  bool json = false;
};

// Runs the cases, prints the table and writes calm_chart.csv and stiffness_zones.csv. Returns the
// exit code: 1 if a case broke a promise.
int soak_on_devices(const ChartRequest& request);

}  // namespace palpate
