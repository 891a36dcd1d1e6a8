#include "engine/cli/report.h"

#include <algorithm>
#include <functional>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/accuracy/advice.h"
#include "engine/cli/effects_report.h"
#include "engine/cli/formatted.h"
#include "engine/cli/option_names.h"
#include "engine/cli/tick_times_report.h"
#include "engine/scene/scene_contours.h"
#include "engine/simulation/run_judgement.h"
#include "geometry/base/printable.h"
#include "io/hidden_nodes.h"

namespace palpate {
namespace {

using nlohmann::ordered_json;

// What "step_ns" is a time of: ticks in simulated time, or those of the haptic thread.
constexpr const char* kMachineClock = "computing time of this machine, ticks in simulated time";
constexpr const char* kThreadClock = "haptic thread";

double load_ms(const SceneStatistics& s) {
  return s.parse_ms + s.mesh_ms + s.index_ms;
}

// Memory of the whole scene and of its parts, and bytes of the surfaces per triangle.
std::string memory_text(const SceneStatistics& s) {
  const auto megabytes = [](std::size_t bytes) { return 1e-6 * static_cast<double>(bytes); };
  const MemoryBreakdown& m = s.memory;
  return formatted(
             "  memory %.1f MB, %.0f bytes per triangle: adjacency %.1f, positions %.1f, maps "
             "%.1f, ",
             megabytes(m.total()),
             static_cast<double>(m.total() - m.places) / static_cast<double>(s.cleaning.triangles),
             megabytes(m.adjacency), megabytes(m.positions), megabytes(m.maps)) +
         formatted("index: triangles %.1f, packs %.1f, boxes %.1f; places %.1f, effects %.1f\n",
                   megabytes(m.index_triangles), megabytes(m.index_packs), megabytes(m.index_boxes),
                   megabytes(m.places), megabytes(m.effects));
}

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

std::vector<Line> run_lines(const Scene& scene) {
  using Run = ExplorationRun;
  const auto mean = [](const char* pattern, double RunSummary::*value, double factor) {
    return [=](const Run& r) {
      return has_means(r.summary) ? formatted(pattern, factor * r.summary.*value)
                                  : std::string("-");
    };
  };
  std::vector<Line> lines = {
      {"in contact",
       [](const Run& r) {
         return r.summary.ticks > 0 ? formatted("%.1f %%", 100 * r.summary.contact_share())
                                    : std::string("-");
       }},
      {"mean contact angle", mean("%.1f deg", &RunSummary::mean_contact_angle_deg, 1.0)},
      {"contact within 30 deg", mean("%.1f %%", &RunSummary::share_within_30deg, 100.0)},
      {"mean penetration", mean("%.2f mm", &RunSummary::mean_penetration_m, 1e3)},
      {"largest penetration",
       [](const Run& r) {
         return r.summary.has_contact() ? formatted("%.2f mm", 1e3 * r.summary.max_penetration_m)
                                        : std::string("-");
       }},
      {"losses of contact",
       [](const Run& r) { return std::to_string(r.summary.losses_of_contact); }},
      {"work of missing motors (1)",
       [](const Run& r) { return formatted("%.2f mJ", 1e3 * r.summary.work_lost_J); }},
      {"energy returned (2)",
       [](const Run& r) { return formatted("%.2f mJ", 1e3 * r.summary.port_work_J); }},
      {"device travel A1 x A2 x A3",
       [](const Run& r) {
         const Vec3& e = r.summary.device_extent_m;
         return formatted("%.2f x %.2f x %.2f m%s", e.x(), e.y(), e.z(),
                          r.exceeds_workspace ? " !" : "");
       }},
      {"missed deadlines",
       [](const Run& r) {
         if (!r.missed_deadlines) return std::string("-");
         return formatted("%llu of %llu", static_cast<unsigned long long>(*r.missed_deadlines),
                          static_cast<unsigned long long>(r.summary.ticks)) +
                (r.tick_times ? late_causes_text(*r.tick_times) : std::string());
       }},
      {"tick p50 / p99 / max",
       [](const Run& r) {
         const StepTimes& s = r.summary.step_ns;
         if (s.ticks == 0) return std::string("-");
         return formatted("%.2f / %.2f / %.2f us%s", 1e-3 * static_cast<double>(s.p50_ns),
                          1e-3 * static_cast<double>(s.p99_ns),
                          1e-3 * static_cast<double>(s.max_ns), is_simulated_time(r) ? " (3)" : "");
       }},
      {"faults", [](const Run& r) { return faults_text(r.summary); }},
      {"A4 turned the scene in",
       [](const Run& r) {
         return formatted("%llu ticks", static_cast<unsigned long long>(r.summary.a4_ticks));
       }},
  };
  for (const std::string& effect : scene.effects().effects) {
    lines.push_back({effect + " active in",
                     [effect](const Run& r) { return effect_use_text(r.summary, effect); }});
  }
  return lines;
}

ordered_json vector_json(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

Vec3 centre_of(const Box& box) {
  return 0.5 * box.low + 0.5 * box.high;
}

ordered_json box_json(const Box& box) {
  return {{"min_m", vector_json(box.low)},
          {"max_m", vector_json(box.high)},
          {"centre_m", vector_json(centre_of(box))}};
}

// null if the scene has too many triangles there for the search.
ordered_json contours_json(const Scene& scene) {
  const auto contours = scene_contours(scene);
  if (!contours) return nullptr;
  ordered_json list = ordered_json::array();
  for (std::size_t axis = 0; axis < contours->size(); ++axis) {
    const SceneContour& c = (*contours)[axis];
    list.push_back({{"normal", kContourNormals[axis]},
                    {"offset_m", c.offset_m},
                    {"curves", c.curves},
                    {"longest_m", c.longest_m},
                    {"closed", c.is_closed}});
  }
  return list;
}

ordered_json animations_json(const SceneStatistics& s) {
  ordered_json list = ordered_json::array();
  for (std::size_t i = 0; i < s.animations.size(); ++i) {
    const AnimationDescription& animation = s.animations[i];
    ordered_json json = {{"number", i}, {"name", animation.name}};
    json["length_s"] = animation.length_s ? ordered_json(*animation.length_s) : ordered_json();
    list.push_back(std::move(json));
  }
  return list;
}

// null for the rest pose.
ordered_json pose_json(const SceneStatistics& s) {
  if (!s.pose) return nullptr;
  return {{"number", s.pose->animation},
          {"name", s.animations[s.pose->animation].name},
          {"time_s", s.pose->time_s}};
}

std::string vector_text(const Vec3& v) {
  return formatted("(%.6g, %.6g, %.6g)", v.x(), v.y(), v.z());
}

std::string contours_text(const Scene& scene) {
  const auto contours = scene_contours(scene);
  if (!contours) {
    return "  contours through the centre: not computed, the scene has too many triangles there\n";
  }
  std::string text;
  for (std::size_t axis = 0; axis < contours->size(); ++axis) {
    const SceneContour& c = (*contours)[axis];
    text += "  contour across " + std::string(kContourNormals[axis]) + " through the centre";
    if (c.curves == 0) {
      text += ": none\n";
    } else if (c.curves == 1) {
      text += formatted(": %.6g m, %s\n", c.longest_m, c.is_closed ? "closed" : "open");
    } else {
      text += formatted(": %zu curves, the longest %.6g m, %s\n", c.curves, c.longest_m,
                        c.is_closed ? "closed" : "open");
    }
  }
  return text;
}

// One line; empty for the rest pose.
std::string chosen_pose_text(const Scene& scene, const char* indent) {
  const SceneStatistics& s = scene.statistics();
  return s.pose ? indent + ("pose: " + printable(pose_text(s.animations, s.pose))) + "\n" : "";
}

std::string animations_text(const SceneStatistics& s) {
  std::string text;
  for (std::size_t i = 0; i < s.animations.size(); ++i) {
    const AnimationDescription& animation = s.animations[i];
    text += "  animation #" + std::to_string(i) + " \"" + printable(animation.name) + "\", " +
            (animation.length_s ? seconds_text(*animation.length_s) : "of unknown length") + "\n";
  }
  return text;
}

// The names of the first scenes (null: without a name), and the loaded one (null: all root nodes).
ordered_json scenes_json(const ListedScenes& scenes) {
  ordered_json names = ordered_json::array();
  for (const std::string& name : scenes.names) {
    names.push_back(name.empty() ? ordered_json() : ordered_json(name));
  }
  return {{"count", scenes.count},
          {"names", std::move(names)},
          {"loaded", scenes.loaded ? ordered_json(*scenes.loaded) : ordered_json()}};
}

// One line for each scene of a file with several, and which of them is loaded.
std::string scenes_text(const ListedScenes& scenes) {
  if (scenes.count < 2) return {};
  constexpr std::size_t kMostLines = 20;
  std::string text;
  const auto add = [&](std::size_t i) {
    const bool has_name = i < scenes.names.size() && !scenes.names[i].empty();
    text += "  scene #" + std::to_string(i) +
            (has_name ? " \"" + printable(scenes.names[i]) + "\"" : "") +
            (scenes.loaded == i ? ", loaded\n" : "\n");
  };
  const std::size_t most = std::min(scenes.count, kMostLines);
  for (std::size_t i = 0; i < most; ++i) add(i);
  if (scenes.loaded && *scenes.loaded >= most) add(*scenes.loaded);
  if (scenes.count > most) {
    text += "  " + std::to_string(scenes.count) + " scenes in all; --scene N loads another one\n";
  }
  return text;
}

ordered_json hidden_json(const HiddenNodes& hidden) {
  return {{"count", hidden.count}, {"first_names", hidden.first_names}};
}

// What is wrong with the file, what it hides, and what it declares in a wrong place.
std::vector<std::string> warning_lines(const SceneStatistics& s) {
  std::vector<std::string> lines = s.warnings;
  if (s.hidden_nodes.count > 0) lines.push_back(hidden_nodes_text(s.hidden_nodes));
  lines.insert(lines.end(), s.unapplied_extras.begin(), s.unapplied_extras.end());
  return with_option_names(std::move(lines));
}

ordered_json joins_json(const JoinStatistics& joins) {
  return {{"edges", joins.joined_edges},
          {"vertices", joins.joined_vertices},
          {"divided_edges", joins.divided_edges},
          {"ambiguous_edges", joins.ambiguous_edges}};
}

// Where nodes meet, and where they are near each other and stay apart.
ordered_json node_seams_json(const SceneStatistics& s) {
  ordered_json json = {{"vertices", s.seam_vertices},
                       {"places", s.seam_places},
                       {"nodes", s.seam_nodes},
                       {"changed_nodes", s.changed_nodes},
                       {"divided_edges", s.divided_edges},
                       {"apart_vertices", s.apart_vertices}};
  if (s.apart_vertices > 0) json["apart_m"] = {s.least_apart_m, s.most_apart_m};
  return json;
}

// What is still open, and what would join it.
std::string open_edges_text(const SceneStatistics& s) {
  if (s.cleaning.boundary_edges == 0) return {};
  if (!s.nearest_gap_m) return "  open edges: no two of them are near each other\n";
  const std::string gap = shortest_digits(*s.nearest_gap_m);
  return "  open edges: the nearest two are " + gap + " m apart; --close-gaps " + gap +
         " joins them\n";
}

}  // namespace

ordered_json scene_json(const Scene& scene) {
  const SceneStatistics& s = scene.statistics();
  return {{"nodes", s.nodes},
          {"meshes", s.meshes},
          {"instances", s.instances},
          {"indices", s.indices},
          {"scale", s.scale},
          {"triangles_in", s.cleaning.triangles_in},
          {"triangles", s.cleaning.triangles},
          {"instanced_triangles", s.instanced_triangles},
          {"vertices", s.cleaning.welded_vertices},
          {"dropped",
           {{"degenerate", s.cleaning.dropped_degenerate},
            {"duplicate", s.cleaning.dropped_duplicate}}},
          {"split_vertices", s.cleaning.split_vertices},
          {"boundary_edges", s.cleaning.boundary_edges},
          {"non_manifold_edges", s.cleaning.non_manifold_edges},
          {"joined", joins_json(s.rounding_joins)},
          {"gaps_joined", joins_json(s.gap_joins)},
          {"node_seams", node_seams_json(s)},
          {"nearest_gap_m", s.nearest_gap_m ? ordered_json(*s.nearest_gap_m) : ordered_json()},
          {"extent_m", {s.extent_m.x(), s.extent_m.y(), s.extent_m.z()}},
          {"bounding_box", box_json(s.bounds_scene)},
          {"contours", contours_json(scene)},
          {"scenes", scenes_json(s.scenes)},
          {"hidden_nodes", hidden_json(s.hidden_nodes)},
          {"animations", animations_json(s)},
          {"pose", pose_json(s)},
          {"materials", materials_json(scene)},
          {"scene_parameters", declaration_json(scene.effects().scene)},
          {"regions", regions_json(scene)},
          {"effects", scene.effects().effects},
          {"load_ms", {{"parse", s.parse_ms}, {"mesh", s.mesh_ms}, {"index", s.index_ms}}},
          {"memory_bytes", s.memory.total()},
          {"memory",
           {{"adjacency", s.memory.adjacency},
            {"positions", s.memory.positions},
            {"maps", s.memory.maps},
            {"index_triangles", s.memory.index_triangles},
            {"index_packs", s.memory.index_packs},
            {"index_boxes", s.memory.index_boxes},
            {"places", s.memory.places},
            {"effects", s.memory.effects}}},
          {"notes", with_option_names(s.notes)},
          {"warnings", warning_lines(s)}};
}

ordered_json tree_json(std::span<const TreeNode> tree) {
  ordered_json nodes = ordered_json::array();
  for (const TreeNode& node : tree) {
    ordered_json json = {{"name", node.name}, {"number", node.file_index}};
    json["parent"] = node.parent ? ordered_json(*node.parent) : ordered_json();
    json["mesh"] = node.has_mesh;
    if (node.is_hidden) json["hidden"] = true;
    nodes.push_back(std::move(json));
  }
  return nodes;
}

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

std::string scene_text(const std::string& path, const Scene& scene) {
  const SceneStatistics& s = scene.statistics();
  const CleaningReport& c = s.cleaning;
  std::string text = printable(path) + "\n";
  text += formatted("  nodes %zu, meshes %zu, instances %zu, indices %zu\n", s.nodes, s.meshes,
                    s.instances, s.indices);
  text += formatted(
      "  triangles %zu of %zu (%zu without area and %zu duplicates dropped), %zu placed\n",
      c.triangles, c.triangles_in, c.dropped_degenerate, c.dropped_duplicate,
      s.instanced_triangles);
  text +=
      formatted("  vertices %zu, split for OpenMesh %zu\n", c.welded_vertices, c.split_vertices);
  text += formatted("  edges: %zu on a boundary, %zu non-manifold\n", c.boundary_edges,
                    c.non_manifold_edges);
  text += open_edges_text(s);
  text +=
      formatted("  extent %.6g x %.6g x %.6g m\n", s.extent_m.x(), s.extent_m.y(), s.extent_m.z());
  text += "  bounding box " + vector_text(s.bounds_scene.low) + " to " +
          vector_text(s.bounds_scene.high) + " m, centre " +
          vector_text(centre_of(s.bounds_scene)) + " m\n";
  text += contours_text(scene);
  text += scenes_text(s.scenes);
  text += animations_text(s);
  text += declarations_text(scene);
  text += formatted("  loaded in %.1f ms: parse %.1f, mesh %.1f, index %.1f\n", load_ms(s),
                    s.parse_ms, s.mesh_ms, s.index_ms);
  text += memory_text(s);
  if (s.scale != 1.0) text += formatted("  scale %.6g\n", s.scale);
  for (const std::string& note : s.notes) text += "  " + printable(with_option_names(note)) + "\n";
  for (const std::string& warning : warning_lines(s)) {
    text += "  warning: " + printable(warning) + "\n";
  }
  return text;
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
