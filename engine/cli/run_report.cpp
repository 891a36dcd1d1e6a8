#include "engine/cli/run_report.h"

#include <algorithm>
#include <functional>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/cli/effects_report.h"
#include "engine/cli/formatted.h"
#include "engine/cli/option_names.h"
#include "engine/cli/scene_report.h"
#include "engine/cli/tick_times_report.h"
#include "engine/simulation/run_judgement.h"
#include "geometry/base/printable.h"

namespace palpate {
namespace {

using nlohmann::ordered_json;

// What "step_ns" is a time of: ticks in simulated time, or those of the haptic thread.
constexpr const char* kMachineClock = "computing time of this machine, ticks in simulated time";
constexpr const char* kThreadClock = "haptic thread";

}  // namespace

std::string faults_text(const RunSummary& s) {
  std::string text;
  const auto add = [&](std::uint64_t ticks, std::string_view name) {
    if (ticks == 0) return;
    if (!text.empty()) text += ", ";
    text += std::to_string(ticks) + " " + std::string(name);
  };
  for (std::size_t i = 0; i < s.faults.size(); ++i) add(s.faults[i], kFaultNames[i]);
  for (std::size_t i = 0; i < s.governor_rules.size(); ++i) {
    add(s.governor_rules[i], "governor_" + std::string(kGovernorRuleNames[i]));
  }
  return text.empty() ? "none" : text;
}

namespace {

// A line of a table: its name, and a function that formats a run's value.
struct Line {
  std::string name;
  std::function<std::string(const ExplorationRun&)> value;
};

std::string interruption_text(const ExplorationRun& run) {
  if (!run.interrupted) return "no";
  return formatted("after %.2f s", run.records.empty() ? 0.0 : run.records.back().time_s);
}

// A number that does not exist is null.
template <typename Number>
ordered_json number_or_null(bool exists, Number number) {
  return exists ? ordered_json(number) : ordered_json();
}

ordered_json step_times_json(const StepTimes& s) {
  const bool exist = s.ticks > 0;
  return {{"p50", number_or_null(exist, s.p50_ns)},
          {"p99", number_or_null(exist, s.p99_ns)},
          {"p999", number_or_null(exist, s.p999_ns)},
          {"max", number_or_null(exist, s.max_ns)}};
}

// Ticks in simulated time have no deadlines, and their times are those of the computation.
bool is_simulated_time(const ExplorationRun& run) {
  return !run.tick_times.has_value();
}

// A person with a device has no path to follow.
bool has_way(const ExplorationRun& run) {
  return !run.contour_scene_m.empty() || !run.places_scene_m.empty();
}

Line way_line(const ExplorationRun& first) {
  return {first.contour_scene_m.empty() ? "places reached" : "contour completed",
          [](const ExplorationRun& r) { return formatted("%.1f %%", 100 * r.way_share); }};
}

std::string missed_text(const ExplorationRun& run) {
  if (!run.missed_deadlines) return "-";
  return formatted("%llu of %llu", static_cast<unsigned long long>(*run.missed_deadlines),
                   static_cast<unsigned long long>(run.summary.ticks)) +
         (run.tick_times ? late_causes_text(*run.tick_times) : std::string());
}

std::string step_times_text(const ExplorationRun& run) {
  const StepTimes& s = run.summary.step_ns;
  if (s.ticks == 0) return "-";
  return formatted("%.2f / %.2f / %.2f us%s", 1e-3 * static_cast<double>(s.p50_ns),
                   1e-3 * static_cast<double>(s.p99_ns), 1e-3 * static_cast<double>(s.max_ns),
                   is_simulated_time(run) ? " (3)" : "");
}

std::string device_travel_text(const ExplorationRun& run) {
  const Vec3& e = run.summary.device_extent_m;
  return formatted("%.2f x %.2f x %.2f m%s", e.x(), e.y(), e.z(),
                   run.exceeds_workspace ? " !" : "");
}

// The lines about the contact between the hand and the scene.
std::vector<Line> contact_lines() {
  using Run = ExplorationRun;
  const auto mean = [](const char* pattern, double RunSummary::*value, double factor) {
    return [=](const Run& r) {
      return has_means(r.summary) ? formatted(pattern, factor * r.summary.*value)
                                  : std::string("-");
    };
  };
  return {{"in contact",
           [](const Run& r) {
             return r.summary.ticks > 0 ? formatted("%.1f %%", 100 * r.summary.contact_share())
                                        : std::string("-");
           }},
          {"mean contact angle", mean("%.1f deg", &RunSummary::mean_contact_angle_deg, 1.0)},
          {"contact within 30 deg", mean("%.1f %%", &RunSummary::share_within_30deg, 100.0)},
          {"mean penetration", mean("%.2f mm", &RunSummary::mean_penetration_m, 1e3)},
          {"largest penetration",
           [](const Run& r) {
             return r.summary.has_contact()
                        ? formatted("%.2f mm", 1e3 * r.summary.max_penetration_m)
                        : std::string("-");
           }},
          {"losses of contact",
           [](const Run& r) { return std::to_string(r.summary.losses_of_contact); }},
          {"work of missing motors (1)",
           [](const Run& r) { return formatted("%.2f mJ", 1e3 * r.summary.work_lost_J); }},
          {"energy returned (2)",
           [](const Run& r) { return formatted("%.2f mJ", 1e3 * r.summary.port_work_J); }}};
}

std::vector<Line> run_lines(const Scene& scene) {
  std::vector<Line> lines = contact_lines();
  lines.insert(lines.end(),
               {{"device travel A1 x A2 x A3", device_travel_text},
                {"missed deadlines", missed_text},
                {"tick p50 / p99 / max", step_times_text},
                {"faults", [](const ExplorationRun& r) { return faults_text(r.summary); }},
                {"A4 turned the scene in", [](const ExplorationRun& r) {
                   return formatted("%llu ticks",
                                    static_cast<unsigned long long>(r.summary.a4_ticks));
                 }}});
  for (const std::string& effect : scene.effects().effects) {
    lines.push_back({effect + " active in", [effect](const ExplorationRun& r) {
                       return effect_use_text(r.summary, effect);
                     }});
  }
  return lines;
}

// One line; empty for the rest pose.
std::string chosen_pose_text(const Scene& scene, const char* indent) {
  const SceneStatistics& s = scene.statistics();
  return s.pose ? indent + ("pose: " + printable(pose_text(s.animations, s.pose))) + "\n" : "";
}

}  // namespace

ordered_json governor_json(const RunSummary& s) {
  ordered_json rules = ordered_json::object();
  for (std::size_t i = 0; i < s.governor_rules.size(); ++i) {
    rules[std::string(kGovernorRuleNames[i])] = s.governor_rules[i];
  }
  ordered_json json = {{"rules", rules}, {"trips", s.trips}, {"last_trip", nullptr}};
  if (s.trips > 0) {
    const GovernorTrip& trip = s.last_trip;
    json["last_trip"] = {{"reason", kTripReasonNames[static_cast<std::size_t>(trip.reason)]},
                         {"tick", trip.tick},
                         {"time_s", trip.time_s},
                         {"value", trip.value},
                         {"limit", trip.limit},
                         {"device_m", trip.device_m},
                         {"wanted_N", trip.wanted_N}};
  }
  return json;
}

ordered_json summary_json(const RunSummary& s, const Scene& scene) {
  ordered_json faults = ordered_json::object();
  for (std::size_t i = 0; i < s.faults.size(); ++i) {
    faults[std::string(kFaultNames[i])] = s.faults[i];
  }
  return {{"ticks", s.ticks},
          {"contact_ticks", s.contact_ticks},
          {"mean_penetration_m", number_or_null(s.has_contact(), s.mean_penetration_m)},
          {"max_penetration_m", number_or_null(s.has_contact(), s.max_penetration_m)},
          {"mean_contact_angle_deg", number_or_null(s.has_contact(), s.mean_contact_angle_deg)},
          {"share_within_30deg", number_or_null(s.has_contact(), s.share_within_30deg)},
          {"losses_of_contact", s.losses_of_contact},
          {"work_lost_J", s.work_lost_J},
          {"port_work_J", s.port_work_J},
          {"faults", faults},
          {"governor", governor_json(s)},
          {"effects", effects_use_json(s, scene)},
          {"not_understood", not_understood_lines(scene)},
          {"step_ns", step_times_json(s.step_ns)},
          {"step_ns_clock", kMachineClock},
          {"load_ms", load_ms(scene.statistics())},
          {"triangles", scene.statistics().cleaning.triangles}};
}

ordered_json run_json(const ExplorationRun& run, const Scene& scene) {
  ordered_json json = {{"a4", run.a4}};
  json.update(summary_json(run.summary, scene));
  const Vec3& extent = run.summary.device_extent_m;
  json["device_extent_m"] = {extent.x(), extent.y(), extent.z()};
  if (has_way(run)) {
    json["exceeds_workspace"] = run.exceeds_workspace;
    json["way_share"] = run.way_share;
    json["near_m"] = run.near_m;
    if (!run.contour_scene_m.empty()) json["contour_closed"] = !run.is_open_contour;
  }
  json["longest_gap_ticks"] =
      number_or_null(run.summary.has_contact(), run.summary.longest_gap_ticks);
  json["contact_share"] = number_or_null(run.summary.ticks > 0, run.summary.contact_share());
  if (!is_simulated_time(run)) json["step_ns_clock"] = kThreadClock;
  if (!has_means(run.summary)) {
    for (const char* mean :
         {"mean_penetration_m", "mean_contact_angle_deg", "share_within_30deg"}) {
      json[mean] = nullptr;
    }
  }
  if (has_way(run)) {
    json["comparable"] = is_comparable(run);
    json["reasons"] = nlohmann::ordered_json::array();
    for (const std::string& reason : reasons(run)) {
      json["reasons"].push_back(with_option_names(reason));
    }
  }
  json["interrupted"] = run.interrupted;
  json["missed_deadlines"] =
      run.missed_deadlines ? ordered_json(*run.missed_deadlines) : ordered_json();
  json["tick_times"] = run.tick_times ? tick_times_json(*run.tick_times) : ordered_json();
  return json;
}

ordered_json work_budget_json(const RunSetup& setup) {
  return {{"units", setup.haptics.god_object.accuracy.work_budget},
          {"unit_ns",
           setup.measured_budget ? ordered_json(setup.measured_budget->unit_ns) : ordered_json()}};
}

std::string summary_text(const RunSummary& s, const Scene& scene) {
  std::string text = chosen_pose_text(scene, "  ");
  text += formatted("  ticks %llu, in contact %llu, losses of contact %llu\n",
                    static_cast<unsigned long long>(s.ticks),
                    static_cast<unsigned long long>(s.contact_ticks),
                    static_cast<unsigned long long>(s.losses_of_contact));
  if (s.has_contact()) {
    text += formatted("  penetration mean %.4g mm, max %.4g mm\n", 1e3 * s.mean_penetration_m,
                      1e3 * s.max_penetration_m);
    text += formatted("  contact angle mean %.2f deg, within 30 deg %.1f %%\n",
                      s.mean_contact_angle_deg, 100 * s.share_within_30deg);
  } else {
    text += "  penetration mean -, max -\n  contact angle mean -, within 30 deg -\n";
  }
  text += formatted("  work of missing motors %.4g mJ, energy returned by the device %.4g mJ\n",
                    1e3 * s.work_lost_J, 1e3 * s.port_work_J);
  if (s.step_ns.ticks > 0) {
    text += formatted(
        "  tick p50 %lld ns, p99 %lld ns, max %lld ns: computing times of this machine, the ticks "
        "are in simulated time\n",
        static_cast<long long>(s.step_ns.p50_ns), static_cast<long long>(s.step_ns.p99_ns),
        static_cast<long long>(s.step_ns.max_ns));
  } else {
    text += "  tick p50 -, p99 -, max -\n";
  }
  text += "  faults: " + faults_text(s) + "\n";
  for (const std::string& effect : scene.effects().effects) {
    text += "  " + effect + " active in " + effect_use_text(s, effect) + "\n";
  }
  text += formatted("  A4 turned the scene in %llu ticks\n",
                    static_cast<unsigned long long>(s.a4_ticks));
  return text;
}

std::string runs_text(const std::vector<ExplorationRun>& runs, const Scene& scene) {
  constexpr int kNameWidth = 29;
  constexpr int kValueWidth = 24;
  std::string text = formatted("%-*s", kNameWidth, "");
  for (const ExplorationRun& run : runs) {
    text += formatted("  %*s", kValueWidth, run.a4 ? "with A4" : "without A4");
  }
  text += "\n";
  std::vector<Line> lines = run_lines(scene);
  if (has_way(runs.front())) lines.insert(lines.begin() + 1, way_line(runs.front()));
  if (std::any_of(runs.begin(), runs.end(), [](const auto& run) { return run.interrupted; })) {
    lines.insert(lines.begin(), {"interrupted", interruption_text});
  }
  for (const Line& line : lines) {
    text += formatted("%-*s", kNameWidth, line.name.c_str());
    for (const ExplorationRun& run : runs) {
      text += formatted("  %*s", kValueWidth, line.value(run).c_str());
    }
    text += "\n";
  }
  text +=
      "(1) work on the hand of motors on all sensed axes, minus the work of the actual motors\n"
      "(2) energy that the device returned to the hand; negative: the hand put energy in\n";
  if (is_simulated_time(runs.front())) {
    text +=
        "(3) computing times of this machine; the run is in simulated time, in which no tick is "
        "late\n";
  }
  text += chosen_pose_text(scene, "");
  if (runs.front().is_open_contour) {
    text +=
        "! the contour is open: it ends at the boundary of the surface, and the hand followed no "
        "other curve; palpate info says how far apart open edges are\n";
  }
  bool exceeds = false;
  for (const ExplorationRun& run : runs) exceeds = exceeds || run.exceeds_workspace;
  if (exceeds) {
    text += "! exceeds the device's workspace: A4 turns a closed contour into one long stroke\n";
  }
  return text;
}

}  // namespace palpate
