// Changes the meshes of nodes so that their surfaces conform where they meet: see conforming.h.

#include <algorithm>
#include <sstream>
#include <string>
#include <tuple>
#include <utility>

#include "engine/scene/scene_bounds.h"
#include "engine/scene/scene_compiler.h"

namespace palpate {
namespace {

// Copies for changed nodes may use this part of the memory that the other surfaces leave.
constexpr std::uint64_t kOneInMemory = 2;

// A divided edge bends the faces beside it, by up to the distance that was closed. The next round
// finds what lies on these faces.
constexpr int kMostRounds = 4;

Box box_around(std::span<const Vec3> positions) {
  Box box = Box::empty();
  for (const Vec3& p : positions) box = box.united({p, p});
  return box;
}

// The memory that the surface and the index of a mesh need.
std::uint64_t bytes_of_surface(const WeldedSurface& mesh, std::uint64_t added_faces) {
  return SurfaceMesh::memory_need(mesh).kept +
         SurfaceIndex::memory_need(mesh.face_count() + added_faces).kept;
}

std::uint64_t bytes_of_copy(const WeldedSurface& mesh) {
  constexpr std::uint64_t kPerFace = sizeof(Triangle) + 3 * sizeof(std::uint32_t);
  return mesh.positions().size() * sizeof(Vec3) + mesh.face_count() * kPerFace +
         mesh.sources().memory_bytes();
}

bool is_before(const Vec3& p, const Vec3& q) {
  return std::tie(p[0], p[1], p[2]) < std::tie(q[0], q[1], q[2]);
}

// The numbers of vertices after a change that may have dropped some. positions: those vertices.
std::vector<std::uint32_t> numbers_of(std::span<const Vec3> positions,
                                      const WeldedSurface& changed) {
  const std::span<const Vec3> all = changed.positions();
  std::vector<std::uint32_t> by_position(all.size());
  for (std::uint32_t v = 0; v < all.size(); ++v) by_position[v] = v;
  std::sort(by_position.begin(), by_position.end(),
            [&](std::uint32_t v, std::uint32_t w) { return is_before(all[v], all[w]); });
  std::vector<std::uint32_t> numbers;
  for (const Vec3& p : positions) {
    const auto found = std::lower_bound(
        by_position.begin(), by_position.end(), p,
        [&](std::uint32_t v, const Vec3& sought) { return is_before(all[v], sought); });
    if (found != by_position.end() && all[*found] == p) numbers.push_back(*found);
  }
  std::sort(numbers.begin(), numbers.end());
  return numbers;
}

// The positions of the vertices that meet others, after the change, mesh frame.
std::vector<Vec3> met_positions(const WeldedSurface& mesh, const ConformingSurface& surface) {
  std::vector<Vec3> positions;
  auto moved = surface.changes.moved.begin();
  for (const std::uint32_t v : surface.met) {
    while (moved != surface.changes.moved.end() && moved->vertex < v) ++moved;
    const auto count = static_cast<std::uint32_t>(mesh.positions().size());
    if (v >= count) {
      positions.push_back(surface.changes.added_m[v - count]);
    } else if (moved != surface.changes.moved.end() && moved->vertex == v) {
      positions.push_back(moved->position_m);
    } else {
      positions.push_back(mesh.positions()[v]);
    }
  }
  return positions;
}

// How far the changes move vertices, and added vertices off the edges that they divide, mesh frame.
double most_moved_m(const WeldedSurface& mesh, const SurfaceChanges& changes) {
  const std::span<const Vec3> positions = mesh.positions();
  double most_m = 0.0;
  for (const MovedVertex& moved : changes.moved) {
    most_m = std::max(most_m, (moved.position_m - positions[moved.vertex]).norm());
  }
  for (const EdgeDivision& division : changes.divisions) {
    if (division.vertex < positions.size()) continue;
    const Triangle& face = mesh.faces()[division.half_edge / 3];
    const Vec3& from = positions[face[division.half_edge % 3]];
    const Vec3& to = positions[face[next_half_edge(division.half_edge) % 3]];
    const Vec3 on_edge = from + division.along * (to - from);
    most_m =
        std::max(most_m, (changes.added_m[division.vertex - positions.size()] - on_edge).norm());
  }
  return most_m;
}

}  // namespace

// The nodes whose surfaces can be touched; the others bound media.
Result<std::vector<std::uint32_t>> SceneCompiler::solid_nodes(SceneEffects& effects) const {
  const std::vector<NodeDescription>& nodes = description_.nodes;
  std::vector<std::uint32_t> solid;
  for (std::uint32_t i = 0; i < nodes.size(); ++i) {
    const auto set = effects.material_set(nodes[i].name, nodes[i].mesh, nodes[i].physics_material);
    if (!set) return set.error();
    if (effects.is_solid(*set)) solid.push_back(i);
  }
  return solid;
}

std::optional<Error> SceneCompiler::conform_nodes(SceneEffects& effects) {
  const std::vector<NodeDescription>& nodes = description_.nodes;
  if (!settings_.joins_within_rounding || nodes.size() < 2) return std::nullopt;
  const auto solid = solid_nodes(effects);
  if (!solid) return solid.error();
  ledger_.begin("joining nodes that meet", std::to_string(solid->size()) + " nodes");
  if (auto error = ledger_.check(solid->size() * sizeof(void*))) return error;
  std::vector<const NodeDescription*> described;
  described.reserve(solid->size());
  for (const std::uint32_t i : *solid) described.push_back(&nodes[i]);
  const Vec3 middle_m = 0.5 * (bounds_scene_.low + bounds_scene_.high);
  is_changed_.assign(nodes.size(), false);
  moved_m_.assign(welded_.size(), 0.0);
  std::size_t divided_edges = 0;
  const std::size_t warnings = statistics_.warnings.size();
  for (int round = 0; round < kMostRounds; ++round) {
    Result<Conforming> made =
        conform(welded_, boxes_, moved_m_, described,
                {middle_m, statistics_.extent_m.maxCoeff(), settings_.close_gaps_m}, ledger_);
    if (!made) return made.error();
    if (!made->is_complete && round > 0) break;  // what the rounds before joined stays joined
    const bool changes =
        std::any_of(made->surfaces.begin(), made->surfaces.end(),
                    [](const ConformingSurface& surface) { return !surface.changes.empty(); });
    statistics_.warnings.resize(warnings);  // each round finds again what it has to leave
    if (auto error = change_nodes(made->surfaces, *solid)) return error;
    divided_edges += made->divided_edges;
    report_conforming(*made, divided_edges);
    if (!changes) break;
  }
  effects.set_meshes(scene_.parts_);
  statistics_.changed_nodes =
      static_cast<std::size_t>(std::count(is_changed_.begin(), is_changed_.end(), true));
  is_changed_ = {};
  moved_m_ = {};
  note_conforming();
  if (statistics_.changed_nodes > 0) {
    bounds_scene_ = bounds_in_scene(welded_, boxes_, nodes);
  }
  return std::nullopt;
}

// The memory that copies for changed nodes may use.
std::uint64_t SceneCompiler::memory_for_changes() const {
  std::uint64_t others = 0;
  for (const WeldedSurface& mesh : welded_) others += bytes_of_surface(mesh, 0);
  return (ledger_.left() - std::min(others, ledger_.left())) / kOneInMemory;
}

// Gives each changed node a mesh of its own. A node whose mesh no other node uses keeps it.
std::optional<Error> SceneCompiler::change_nodes(std::vector<ConformingSurface>& surfaces,
                                                 std::span<const std::uint32_t> solid) {
  met_of_node_.clear();
  std::vector<std::uint32_t> users(welded_.size(), 0);
  for (const NodeDescription& node : description_.nodes) ++users[node.mesh];
  const std::uint64_t most = memory_for_changes();
  std::uint64_t used = 0;
  std::vector<std::uint32_t> left_as_they_are;
  for (ConformingSurface& surface : surfaces) {
    const std::uint32_t n = solid[surface.surface];
    const NodeDescription& node = description_.nodes[n];
    if (surface.changes.empty()) {
      met_of_node_[n] = std::move(surface.met);
      continue;
    }
    const WeldedSurface& mesh = welded_[node.mesh];
    const bool is_shared = users[node.mesh] > 1;
    const std::uint64_t divisions = surface.changes.divisions.size();
    const MemoryNeed change = mesh.memory_need_of_change(divisions);
    std::uint64_t kept = change.kept;
    if (is_shared) {
      kept += bytes_of_copy(mesh) + scene_.parts_[node.mesh].memory_bytes() + sizeof(Box);
    }
    const std::uint64_t later = is_shared ? bytes_of_surface(mesh, divisions) : 0;
    if (used + change.peak + kept + later > most) {
      left_as_they_are.push_back(n);
      continue;
    }
    used += kept + later;
    if (auto error = ledger_.take({kept, kept + change.peak})) return error;
    if (is_shared) --users[node.mesh];
    change_node(n, surface, is_shared);
    surface = {};  // frees the changes
  }
  warn_of_unchanged(left_as_they_are);
  return std::nullopt;
}

// Changes the mesh of one node, or, if other nodes share the mesh, a copy of it.
void SceneCompiler::change_node(std::uint32_t n, const ConformingSurface& surface, bool is_shared) {
  NodeDescription& node = description_.nodes[n];
  const std::vector<Vec3> met = met_positions(welded_[node.mesh], surface);
  const std::vector<std::uint32_t> first_triangles =
      scene_.parts_[node.mesh].first_triangles(welded_[node.mesh]);
  if (is_shared) {
    WeldedSurface copy = welded_[node.mesh].copy();
    welded_.push_back(std::move(copy));
    MeshParts parts = scene_.parts_[node.mesh];
    scene_.parts_.push_back(std::move(parts));
    boxes_.push_back(boxes_[node.mesh]);
    moved_m_.push_back(moved_m_[node.mesh]);
    node.mesh = static_cast<std::uint32_t>(welded_.size() - 1);
  }
  WeldedSurface& own = welded_[node.mesh];
  moved_m_[node.mesh] += most_moved_m(own, surface.changes);
  own.change(surface.changes);
  scene_.parts_[node.mesh].follow(own, first_triangles);
  boxes_[node.mesh] = box_around(own.positions());
  met_of_node_[n] = numbers_of(met, own);
  is_changed_[n] = true;
}

void SceneCompiler::warn_of_unchanged(const std::vector<std::uint32_t>& nodes) {
  if (nodes.empty()) return;
  statistics_.warnings.push_back(
      description_.nodes[nodes.front()].name +
      (nodes.size() > 1 ? " and " + std::to_string(nodes.size() - 1) + " more nodes" : "") +
      ": not joined with the nodes that they meet, because a copy of the mesh would exceed half "
      "of the memory left; a point may pass between the nodes. Raise "
      "`SceneSettings::max_memory_bytes`");
}

void SceneCompiler::report_conforming(const Conforming& made, std::size_t divided_edges) {
  statistics_.divided_edges = divided_edges;
  statistics_.apart_vertices = made.apart;
  statistics_.least_apart_m = made.least_apart_m;
  statistics_.most_apart_m = made.most_apart_m;
  are_nodes_searched_ = made.is_complete;
}

// Notes on what was joined, and on what stays open.
void SceneCompiler::note_conforming() {
  const SceneStatistics& s = statistics_;
  std::ostringstream text;
  if (s.changed_nodes > 0) {
    text << "seams: " << s.changed_nodes << " nodes meet others only within ";
    if (settings_.close_gaps_m > 0.0) text << settings_.close_gaps_m << " m or ";
    text
        << "the rounding of the file's numbers; their surfaces were moved together by as much, and "
        << s.divided_edges << " edges were divided; each of these nodes has an index of its own";
    statistics_.notes.push_back(text.str());
  }
  if (s.apart_vertices > 0) {
    text.str({});
    text << "seams: " << s.apart_vertices << " vertices are " << s.least_apart_m << " to "
         << s.most_apart_m
         << " m from vertices or edges of other nodes, farther than rounding explains, and "
         << "stay open; `SceneSettings::close_gaps_m` joins them";
    statistics_.notes.push_back(text.str());
  }
  if (!are_nodes_searched_) {
    statistics_.warnings.push_back(
        "seams: nodes overlap so much, or memory is so short, that the places where they meet were "
        "not searched; a point may pass between nodes that meet only within the rounding of the "
        "file. Load a part of the scene with `SceneSettings::node`");
  }
}

}  // namespace palpate
