#include "engine/cli/trajectory_report.h"

#include <cmath>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/cli/formatted.h"
#include "geometry/base/printable.h"

namespace palpate {
namespace {

double seconds(std::int64_t time_ns) {
  return static_cast<double>(time_ns) / 1e9;
}

std::string gap_warning(const PlayedPath& path) {
  const PathTimes& times = *path.times;
  const std::size_t longest = path.lines[times.longest_gap];
  std::string text = printable(path.file) + ": line " + std::to_string(longest) + ": ";
  text +=
      formatted("t is %.6g s after the position before it, %.4g times the median of %.6g s",
                seconds(times.longest_gap_ns),
                static_cast<double>(times.longest_gap_ns) / static_cast<double>(times.median_ns),
                seconds(times.median_ns));
  if (times.gaps > 1) {
    text += "; " + std::to_string(times.gaps) + " intervals are " + formatted("%g", kGapMedians) +
            " medians or longer, the first before line " +
            std::to_string(path.lines[times.first_gap]) + ", this one is the longest";
  }
  return text;
}

bool is_usual(double rate_Hz) {
  return rate_Hz >= kLowestUsualRate_Hz && rate_Hz <= kHighestUsualRate_Hz;
}

std::string rate_warning(const PlayedPath& path) {
  const double rate_Hz = path.times->median_rate_Hz();
  std::string text = printable(path.file) +
                     formatted(": the median rate is %.6g Hz; haptic devices run at %g Hz to %g Hz",
                               rate_Hz, kLowestUsualRate_Hz, kHighestUsualRate_Hz);
  struct Unit {
    const char* name;
    double per_second;
  };
  for (const Unit& unit : {Unit{"ms", 1e3}, Unit{"us", 1e6}, Unit{"ns", 1e9}}) {
    if (!is_usual(rate_Hz * unit.per_second)) continue;
    text += std::string(" (if t is in ") + unit.name + ", name its column t_" + unit.name +
            "; if it counts samples, name it \"t [samples]\" and give --rate)";
    break;
  }
  return text;
}

}  // namespace

Result<PlayedPath> read_played_path(const std::string& file, std::optional<double> rate_Hz,
                                    double single_s, std::uint64_t max_memory_bytes) {
  Result<Trajectory> trajectory = read_trajectory(file, rate_Hz);
  if (!trajectory) return trajectory.error();
  PlayedPath path;
  path.file = file;
  path.notes = std::move(trajectory->notes);
  path.comment_warnings = std::move(trajectory->warnings);
  path.positions_m = std::move(trajectory->positions_m);
  path.rate_Hz = 1.0 / single_s;
  if (trajectory->times_ns.empty()) {
    // Rates are printed with a few digits.
    constexpr double kSameRate = 1e-3;
    const double stated_Hz = trajectory->stated_rate_Hz.value_or(path.rate_Hz);
    if (std::abs(stated_Hz - path.rate_Hz) > kSameRate * path.rate_Hz) {
      path.other_rate_Hz = stated_Hz;
      path.other_rate_line = trajectory->stated_rate_line;
    }
    return path;
  }
  path.times = path_times(trajectory->times_ns);
  path.lines = std::move(trajectory->lines);
  if (!rate_Hz) {
    path.ticks_s = tick_lengths_s(trajectory->times_ns, single_s);
    return path;
  }
  Result<RatePath> at_rate = path_at_rate(path.positions_m, trajectory->times_ns, *rate_Hz,
                                          trajectory->has_summed_times, max_memory_bytes);
  if (!at_rate) return at_rate.error();
  path.positions_m = std::move(at_rate->positions_m);
  path.interpolated = at_rate->interpolated;
  path.at_rate_Hz = rate_Hz;
  return path;
}

std::string path_text(const PlayedPath& path) {
  if (!path.times) return "";
  const PathTimes& times = *path.times;
  std::string text = formatted(": %zu position%s in %.9g s", times.rows, times.rows == 1 ? "" : "s",
                               seconds(times.duration_ns));
  if (times.median_ns > 0) text += formatted(", median %.6g Hz", times.median_rate_Hz());
  if (!path.at_rate_Hz) return text + ", each at its time";
  text += formatted(", at %.6g Hz (--rate): ", *path.at_rate_Hz);
  if (path.interpolated == 0 && path.positions_m.size() == times.rows) {
    return text + "no position is interpolated, the times are those of this rate";
  }
  return text + formatted("%zu of %zu positions are interpolated in time", path.interpolated,
                          path.positions_m.size());
}

std::string path_notes_text(const PlayedPath& path) {
  std::string text;
  for (const std::string& note : path.notes) text += "  " + printable(note) + "\n";
  return text;
}

nlohmann::ordered_json path_json(const PlayedPath& path) {
  const std::vector<std::string> warnings = path_warnings(path);
  if (!path.times && path.notes.empty() && warnings.empty()) return nullptr;
  nlohmann::ordered_json json = {{"notes", path.notes}, {"warnings", warnings}};
  if (!path.times) return json;
  const PathTimes& times = *path.times;
  json["rows"] = times.rows;
  json["duration_s"] = seconds(times.duration_ns);
  json["median_rate_Hz"] =
      times.median_ns > 0 ? nlohmann::ordered_json(times.median_rate_Hz()) : nullptr;
  json["gaps"] = times.gaps;
  json["longest_gap_s"] =
      times.gaps > 0 ? nlohmann::ordered_json(seconds(times.longest_gap_ns)) : nullptr;
  json["at_rate_Hz"] = path.at_rate_Hz ? nlohmann::ordered_json(*path.at_rate_Hz) : nullptr;
  json["interpolated"] = path.interpolated;
  return json;
}

std::vector<std::string> path_warnings(const PlayedPath& path) {
  std::vector<std::string> warnings;
  for (const std::string& warning : path.comment_warnings) {
    warnings.push_back(printable(path.file + ": " + warning));
  }
  if (path.other_rate_Hz) {
    warnings.push_back(
        printable(path.file) +
        formatted(": line %zu, a comment, states %.6g Hz; the file has no times, and "
                  "its ticks take the rate of --rate, %.6g Hz",
                  path.other_rate_line, *path.other_rate_Hz, path.rate_Hz));
  }
  if (!path.times || path.times->median_ns == 0) return warnings;
  if (!is_usual(path.times->median_rate_Hz())) warnings.push_back(rate_warning(path));
  if (path.times->gaps > 0) warnings.push_back(gap_warning(path));
  return warnings;
}

}  // namespace palpate
