#include "engine/cli/scene_report.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "engine/accuracy/advice.h"
#include "engine/cli/effects_report.h"
#include "engine/cli/formatted.h"
#include "engine/cli/option_names.h"
#include "engine/scene/scene_contours.h"
#include "geometry/base/printable.h"
#include "io/hidden_nodes.h"

namespace palpate {
namespace {

using nlohmann::ordered_json;

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

double load_ms(const SceneStatistics& statistics) {
  return statistics.parse_ms + statistics.mesh_ms + statistics.index_ms;
}

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

}  // namespace palpate
