// Joins the boundaries of meshes: see SceneSettings and scene_compiler.h.

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "engine/scene/memory_budget.h"
#include "engine/scene/scene_compiler.h"
#include "geometry/base/decompositions.h"
#include "geometry/base/parallel.h"
#include "geometry/mesh/boundary_joins.h"

namespace palpate {
namespace {

// A gap is narrower than this part of the largest extent of the scene; what is wider is a shape.
constexpr double kMostGapPerExtent = 0.1;

// Gaps are measured for the first surfaces that have at most this many boundary edges together,
// which takes a second, as long as edges pass few vertices. Where they pass many, the number of
// examined leaves limits the time to a few seconds.
constexpr std::size_t kMostMeasuredEdges = 100000;
constexpr std::size_t kMostMeasuredLeaves = std::size_t{1} << 23;

// The gaps that are tried have lengths from this part of the extent of the scene to
// kMostGapPerExtent; each is twice the one before.
constexpr double kLeastMeasuredPerExtent = 0x1p-26;

// Two nodes measure alike if their metrics differ by at most this part of their norm: several
// roundings of the products that gave the metrics.
constexpr double kSameMetric = 64 * std::numeric_limits<double>::epsilon();

std::size_t divided_edges(const std::vector<EdgeDivision>& divisions) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < divisions.size(); ++i) {
    count += i == 0 || divisions[i - 1].half_edge != divisions[i].half_edge ? 1 : 0;
  }
  return count;
}

void add(const BoundaryJoins& found, JoinStatistics& sum) {
  sum.joined_edges += found.changes.joined_edges;
  sum.joined_vertices += found.changes.merged.size();
  sum.divided_edges += divided_edges(found.changes.divisions);
  sum.ambiguous_edges += found.ambiguous_edges;
}

// Per mesh: how its nodes measure lengths. If they measure differently, no node stretches a length
// more than the result says.
std::vector<GapLimit> gap_limits(std::size_t meshes, const std::vector<NodeDescription>& nodes,
                                 double most_m) {
  std::vector<GapLimit> limits(meshes, GapLimit{Mat3::Identity(), most_m});
  std::vector<bool> has_node(meshes, false), is_alike(meshes, true);
  std::vector<double> stretch(meshes, 0.0);
  const auto metric = [](const Mat3& linear) { return Mat3(linear.transpose() * linear); };
  for (const NodeDescription& node : nodes) {
    GapLimit& limit = limits[node.mesh];
    if (!has_node[node.mesh]) limit.linear = node.linear_scene_mesh;
    has_node[node.mesh] = true;
    const Mat3 own = metric(node.linear_scene_mesh);
    if ((own - metric(limit.linear)).norm() > kSameMetric * own.norm()) {
      is_alike[node.mesh] = false;
    }
    stretch[node.mesh] = std::max(stretch[node.mesh], singular_values(node.linear_scene_mesh)[0]);
  }
  for (std::size_t i = 0; i < meshes; ++i) {
    if (!is_alike[i]) limits[i].linear = stretch[i] * Mat3::Identity();
  }
  return limits;
}

std::string text_of(const JoinStatistics& joins) {
  return std::to_string(joins.joined_edges) + " pairs of edges and " +
         std::to_string(joins.joined_vertices) + " vertices are joined, and " +
         std::to_string(joins.divided_edges) + " edges are divided at vertices that lie on them";
}

std::string warning_of_capped(std::size_t capped_edges) {
  return "boundaries: " + std::to_string(capped_edges) +
         " boundary edges stay open, because very many edges or vertices are near them, and the "
         "search for those that they meet has a limit in proportion to the size of the mesh; "
         "a point may pass there. Weld the vertices of the mesh, or leave out the part where its "
         "triangles "
         "cross each other";
}

// The nearest gap of one surface; infinite if no gap that is narrow enough can be joined, or if
// leaves_left is 0.
double nearest_gap_m(const WeldedSurface& surface, GapLimit limit, double extent_m,
                     std::size_t& leaves_left) {
  const double most_m = kMostGapPerExtent * extent_m;
  for (limit.most_m = kLeastMeasuredPerExtent * extent_m; limit.most_m < most_m;
       limit.most_m *= 2) {
    const BoundaryJoins found = find_boundary_joins(surface, limit);
    if (found.changes.joined_edges > 0) return found.nearest_m;
    leaves_left -= std::min(leaves_left, found.examined_leaves);
    if (leaves_left == 0) break;
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace

// limits: one per mesh, or none.
std::optional<Error> SceneCompiler::join_boundaries(const std::vector<GapLimit>& limits,
                                                    JoinStatistics& joins) {
  std::vector<std::size_t> open;
  std::vector<MemoryNeed> needs;
  std::size_t edges = 0;
  for (std::size_t i = 0; i < welded_.size(); ++i) {
    if (welded_[i].report().boundary_edges == 0) continue;
    open.push_back(i);
    needs.push_back({0, boundary_joins_memory(welded_[i])});
    edges += welded_[i].report().boundary_edges;
  }
  if (open.empty()) return std::nullopt;
  ledger_.begin("joining boundaries that meet", std::to_string(edges) + " boundary edges");
  if (auto error = ledger_.take(sum_of(std::move(needs), core_count()))) return error;
  std::vector<BoundaryJoins> found(open.size());
  run_each(0, open.size(), [&](std::size_t k) {
    found[k] = find_boundary_joins(welded_[open[k]], limits.empty() ? GapLimit{} : limits[open[k]]);
  });
  needs.clear();
  std::size_t capped_edges = 0;
  for (std::size_t k = 0; k < open.size(); ++k) {
    add(found[k], joins);
    capped_edges += found[k].capped_edges;
    if (found[k].changes.empty()) continue;
    const WeldedSurface& mesh = welded_[open[k]];
    MemoryNeed need = mesh.memory_need_of_change(found[k].changes.divisions.size());
    need.peak += boundary_joins_memory(mesh);
    needs.push_back(need);
  }
  if (capped_edges > 0) statistics_.warnings.push_back(warning_of_capped(capped_edges));
  if (auto error = ledger_.take(sum_of(std::move(needs), core_count()))) return error;
  run_each(0, open.size(), [&](std::size_t k) {
    if (!found[k].changes.empty()) welded_[open[k]].change(found[k].changes);
    found[k] = {};
  });
  return std::nullopt;
}

std::optional<Error> SceneCompiler::join_within_rounding() {
  if (auto error = join_boundaries({}, statistics_.rounding_joins)) return error;
  for (WeldedSurface& mesh : welded_) mesh.drop_unused_positions();
  const JoinStatistics& joins = statistics_.rounding_joins;
  if (joins.joined_vertices + joins.divided_edges > 0) {
    statistics_.notes.push_back("boundaries that meet within the rounding of the file: " +
                                text_of(joins));
  }
  return std::nullopt;
}

std::optional<Error> SceneCompiler::close_gaps() {
  const double extent_m = statistics_.extent_m.maxCoeff();
  const double gap_m = settings_.close_gaps_m;
  if (gap_m != 0.0 && !(gap_m > 0.0 && gap_m < kMostGapPerExtent * extent_m)) {
    std::ostringstream problem;
    problem << "is " << gap_m << " m; expected more than 0 and less than a tenth of the extent of "
            << "the scene, which is " << extent_m << " m";
    return Error{ErrorCode::kInvalidArgument, "", "close_gaps_m", problem.str(),
                 "`palpate info` prints how far apart open edges are"};
  }
  const std::vector<GapLimit> limits = gap_limits(welded_.size(), description_.nodes, gap_m);
  if (gap_m > 0.0) {
    if (auto error = join_boundaries(limits, statistics_.gap_joins)) return error;
    report_gaps(gap_m);
  }
  if (!settings_.measures_gaps) return std::nullopt;
  double nearest_m = std::numeric_limits<double>::infinity();
  std::size_t edges_left = kMostMeasuredEdges;
  std::size_t leaves_left = kMostMeasuredLeaves;
  std::size_t not_measured = 0;
  for (std::size_t i = 0; i < welded_.size(); ++i) {
    const std::size_t edges = welded_[i].report().boundary_edges;
    const bool is_measured = edges <= edges_left && leaves_left > 0;
    if (is_measured) {
      edges_left -= edges;
      nearest_m = std::min(nearest_m, nearest_gap_m(welded_[i], limits[i], extent_m, leaves_left));
    }
    if (!is_measured || leaves_left == 0) not_measured += edges;
  }
  if (std::isfinite(nearest_m)) statistics_.nearest_gap_m = nearest_m;
  if (not_measured > 0) {
    statistics_.notes.push_back(
        "gaps: how far apart open edges are was not measured completely at " +
        std::to_string(not_measured) + " boundary edges, because it would take long");
  }
  return std::nullopt;
}

void SceneCompiler::report_gaps(double gap_m) {
  const JoinStatistics& joins = statistics_.gap_joins;
  std::ostringstream text;
  text << "gaps of up to " << gap_m << " m: " << text_of(joins);
  statistics_.notes.push_back(text.str());
  if (joins.ambiguous_edges == 0) return;
  statistics_.warnings.push_back(
      "gaps: " + std::to_string(joins.ambiguous_edges) +
      " boundary edges stay open, because within the demanded gap each of them meets several "
      "others or a detail of the surface; a smaller gap may join them");
}

}  // namespace palpate
