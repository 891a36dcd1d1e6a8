#include "engine/cli/soak_on_devices.h"

#include <algorithm>
#include <array>
#include <iostream>
#include <iterator>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "engine/cli/command_output.h"
#include "engine/cli/formatted.h"
#include "engine/cli/program_signals.h"
#include "engine/cli/run_results.h"
#include "engine/report/csv.h"
#include "engine/report/output_files.h"
#include "engine/report/text_file.h"
#include "engine/simulation/calm_chart.h"

namespace palpate {
namespace {

constexpr int kBrokenPromise = 1;
constexpr const char* kCasesName = "calm_chart.csv";
constexpr const char* kZonesName = "stiffness_zones.csv";
constexpr const char* kCaseColumns =
    "case,shape,grip,contact,stiffness_N_per_m,delay_s,rate_Hz,motors,peak_force_N,"
    "states_mechanics,states_delay,stable_N_per_m,calm_N_per_m,zone,outcome,trip,rest_time_s,"
    "amplitude_m,returned_J,given_J,hand_J,largest_speed_m_per_s";
constexpr std::array kZoneRates_Hz = {250.0, 1000.0, 4000.0, 10000.0};
constexpr int kZoneDelays = 51;  // from 0 to ChartRange::kLongestDelay_s
constexpr std::size_t kMostListed = 20;
constexpr std::size_t kOutcomes = std::size(kChartOutcomeNames);

struct ChartRow {
  std::uint64_t number = 0;
  ChartCase chart_case;
  ChartResult result;
};

std::size_t index_of(ChartOutcome outcome) {
  return static_cast<std::size_t>(outcome);
}

std::string_view outcome_name(const ChartResult& result) {
  return kChartOutcomeNames[index_of(result.outcome)];
}

std::string_view trip_name(const ChartResult& result) {
  return kTripReasonNames[static_cast<std::size_t>(result.trip.reason)];
}

std::string cases_csv(const std::vector<ChartRow>& rows) {
  CsvLines csv(kCaseColumns);
  for (const auto& [number, c, r] : rows) {
    csv.add(number).add(name_of(c.shape)).add(name_of(c.grip)).add(name_of(c.contact));
    csv.add(c.stiffness_N_per_m).add(c.delay_s).add(c.rate_Hz).add(c.motors).add(c.peak_force_N);
    csv.add(c.states_mechanics).add(c.states_delay);
    csv.add(r.zones.stable_N_per_m).add(r.zones.calm_N_per_m).add(name_of(r.zone));
    csv.add(outcome_name(r)).add(trip_name(r)).add(r.rest_time_s).add(r.amplitude_m);
    csv.add(r.returned_J).add(r.given_J).add(r.hand_J).add(r.largest_speed_m_per_s);
    csv.end_line();
  }
  return csv.text();
}

// The zones of a device that states nothing but its delay.
Result<std::string> zones_csv() {
  CsvLines csv("rate_Hz,delay_s,passive_N_per_m,stable_N_per_m,calm_N_per_m,damping_Ns_per_m");
  for (const double rate_Hz : kZoneRates_Hz) {
    for (int n = 0; n < kZoneDelays; ++n) {
      ChartCase c;
      c.rate_Hz = rate_Hz;
      c.delay_s = ChartRange::kLongestDelay_s * n / (kZoneDelays - 1);
      const auto zones = zones_of(c);
      if (!zones) return zones.error();
      csv.add(rate_Hz).add(c.delay_s).add(zones->passive_N_per_m).add(zones->stable_N_per_m);
      csv.add(zones->calm_N_per_m).add(zones->damping_Ns_per_m).end_line();
    }
  }
  return csv.text();
}

struct ZoneCounts {
  std::array<std::uint64_t, kOutcomes> outcomes{};
  std::uint64_t cases = 0;
  double longest_rest_s = 0.0;
  double most_returned_J = 0.0;
};

std::array<ZoneCounts, 3> counts_of(const std::vector<ChartRow>& rows) {
  std::array<ZoneCounts, 3> zones;
  for (const auto& [number, c, r] : rows) {
    ZoneCounts& zone = zones[static_cast<std::size_t>(r.zone)];
    ++zone.cases;
    ++zone.outcomes[index_of(r.outcome)];
    zone.longest_rest_s = std::max(zone.longest_rest_s, r.rest_time_s);
    zone.most_returned_J = std::max(zone.most_returned_J, r.returned_J);
  }
  return zones;
}

std::string case_line(const ChartRow& row) {
  const ChartCase& c = row.chart_case;
  const ChartResult& r = row.result;
  return formatted(
      "case %llu: %s, %s tip, %s, %.0f N/m, %.2f ms, %.0f Hz: %s; amplitude %.2f mm, returned "
      "%.1f mJ\n",
      static_cast<unsigned long long>(row.number), std::string(name_of(c.shape)).c_str(),
      std::string(name_of(c.grip)).c_str(), std::string(name_of(c.contact)).c_str(),
      c.stiffness_N_per_m, 1e3 * c.delay_s, c.rate_Hz, std::string(outcome_name(r)).c_str(),
      1e3 * r.amplitude_m, 1e3 * r.returned_J);
}

std::vector<ChartRow> broken(const std::vector<ChartRow>& rows) {
  std::vector<ChartRow> all;
  std::copy_if(rows.begin(), rows.end(), std::back_inserter(all),
               [](const ChartRow& row) { return !row.result.keeps_promises(); });
  return all;
}

std::string chart_text(const ChartRequest& request, const std::vector<ChartRow>& rows) {
  std::string text = formatted("%zu random contacts of a simulated device with motors, seed %llu\n",
                               rows.size(), static_cast<unsigned long long>(request.seed));
  text += formatted("%-26s %8s %8s %8s %8s %8s %10s %12s\n", "zone of the stiffness", "cases",
                    "at rest", "tripped", "swings", "returns", "rest, s", "returned, mJ");
  const auto zones = counts_of(rows);
  for (std::size_t n = 0; n < zones.size(); ++n) {
    const ZoneCounts& zone = zones[n];
    const auto count = [&](ChartOutcome outcome) {
      return static_cast<unsigned long long>(zone.outcomes[index_of(outcome)]);
    };
    text += formatted(
        "%-26s %8llu %8llu %8llu %8llu %8llu %10.2f %12.2f\n",
        name_of(static_cast<StiffnessZone>(n)), static_cast<unsigned long long>(zone.cases),
        count(ChartOutcome::kStable) + count(ChartOutcome::kControlled),
        count(ChartOutcome::kTripped), count(ChartOutcome::kSwings), count(ChartOutcome::kReturns),
        zone.longest_rest_s, 1e3 * zone.most_returned_J);
  }
  const auto bad = broken(rows);
  for (std::size_t n = 0; n < std::min(bad.size(), kMostListed); ++n) text += case_line(bad[n]);
  if (bad.empty()) {
    return text + formatted(
                      "every tip came to rest to %g mm within %g s, or was refused or "
                      "tripped, and got at most %g mJ\n",
                      1e3 * ChartPromise::kRest_m, ChartPromise::kRest_s,
                      1e3 * ChartPromise::kReturned_J);
  }
  return text + formatted(
                    "%zu cases break a promise: at rest to %g mm within %g s, at most %g mJ "
                    "returned\n",
                    bad.size(), 1e3 * ChartPromise::kRest_m, ChartPromise::kRest_s,
                    1e3 * ChartPromise::kReturned_J);
}

nlohmann::ordered_json chart_json(const ChartRequest& request, const std::vector<ChartRow>& rows) {
  nlohmann::ordered_json json = {{"seed", request.seed}, {"cases", rows.size()}};
  const auto zones = counts_of(rows);
  for (std::size_t n = 0; n < zones.size(); ++n) {
    nlohmann::ordered_json zone = {{"cases", zones[n].cases}};
    for (std::size_t k = 0; k < kOutcomes; ++k) {
      zone["outcomes"][std::string(kChartOutcomeNames[k])] = zones[n].outcomes[k];
    }
    zone["longest_rest_s"] = zones[n].longest_rest_s;
    zone["most_returned_J"] = zones[n].most_returned_J;
    json["zones"][name_of(static_cast<StiffnessZone>(n))] = zone;
  }
  nlohmann::ordered_json numbers = nlohmann::ordered_json::array();
  for (const ChartRow& row : broken(rows)) numbers.push_back(row.number);
  json["broken_cases"] = numbers;
  return json;
}

Result<std::vector<ChartRow>> run_cases(const ChartRequest& request) {
  std::vector<ChartRow> rows;
  ProgressBar bar("cases");
  for (std::uint64_t number = 0; number < request.cases && !signal_flag().requested(); ++number) {
    bar.show(static_cast<double>(number) / static_cast<double>(request.cases));
    ChartCase chart_case = ChartCase::random(request.seed, number);
    if (request.rate_Hz) chart_case.rate_Hz = *request.rate_Hz;
    auto result = run_chart_case(chart_case);
    if (!result) return result.error();
    rows.push_back({number, chart_case, *result});
  }
  return rows;
}

}  // namespace

int soak_on_devices(const ChartRequest& request) {
  const SignalPhaseScope in_order(SignalPhase::kInOrder);
  Result<OutputFiles> files = OutputFiles::create(request.out_dir, {kCasesName, kZonesName});
  if (!files) return refuse(files.error());
  const auto rows = run_cases(request);
  if (!rows) return refuse(rows.error());
  const auto zones = zones_csv();
  if (!zones) return refuse(zones.error());
  for (const auto& [name, content] :
       {std::pair{kCasesName, cases_csv(*rows)}, std::pair{kZonesName, *zones}}) {
    const auto written = write_text_file(files->path(name), content);
    if (!written) return refuse(files->in_place(written.error()));
  }
  if (const auto error = move_into_place(*files)) return refuse(*error);
  if (request.json) {
    print(chart_json(request, *rows));
  } else {
    std::cout << chart_text(request, *rows) << "tables in " << request.out_dir << "/\n";
  }
  const int code = finish_output();
  if (code != 0) return code;
  return exit_code_after_signals(broken(*rows).empty() ? 0 : kBrokenPromise);
}

}  // namespace palpate
