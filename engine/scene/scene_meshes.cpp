// Welds, links and indexes the meshes of a scene: see scene_compiler.h.

#include <algorithm>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>

#include "engine/scene/memory_budget.h"
#include "engine/scene/scene_compiler.h"
#include "geometry/base/parallel.h"

namespace palpate {
namespace {

bool has_uv(const MeshDescription& mesh) {
  return !mesh.texture_uv.empty() || !mesh.friction_uv.empty();
}

std::string mesh_named(const MeshDescription& mesh) {
  return "mesh \"" + mesh.name + "\"";
}

std::string node_named(const std::string& name) {
  return "node \"" + name + "\"";
}

// Calls work(i) for all meshes or indices; uses several cores if there are enough triangles.
template <typename Work>
void run_meshes(std::size_t count, std::size_t triangles, const Work& work) {
  constexpr std::size_t kWorthAThread = 10000;  // triangles: a millisecond of work
  const std::size_t least = 1 + count * kWorthAThread / std::max<std::size_t>(triangles, 1);
  run_ranges(count, least, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) work(i);
  });
}

void add(CleaningReport& sum, const CleaningReport& report) {
  sum.triangles_in += report.triangles_in;
  sum.triangles += report.triangles;
  sum.dropped_degenerate += report.dropped_degenerate;
  sum.dropped_duplicate += report.dropped_duplicate;
  sum.welded_vertices += report.welded_vertices;
  sum.split_vertices += report.split_vertices;
  sum.boundary_edges += report.boundary_edges;
  sum.non_manifold_edges += report.non_manifold_edges;
  sum.joined_edges += report.joined_edges;
  sum.joined_vertices += report.joined_vertices;
  sum.divided_edges += report.divided_edges;
  sum.added_triangles += report.added_triangles;
}

}  // namespace

std::optional<Error> SceneCompiler::weld_meshes() {
  std::vector<MeshDescription>& descriptions = description_.meshes;
  const bool joins_within_rounding = settings_.joins_within_rounding;
  std::size_t triangles = 0;
  std::vector<MemoryNeed> needs;
  std::size_t largest = 0;
  for (const MeshDescription& mesh : descriptions) {
    triangles += mesh.triangles.size();
    needs.push_back(WeldedSurface::memory_need(mesh.positions.size(), mesh.triangles.size()));
    if (has_uv(mesh)) needs.back() = needs.back() + mesh.triangles.size() * sizeof(Triangle);
    if (needs.back().peak > needs[largest].peak) largest = needs.size() - 1;
  }
  ledger_.begin("welding meshes", descriptions.empty() ? "" : mesh_named(descriptions[largest]));
  if (auto error = ledger_.take(sum_of(std::move(needs), core_count()))) return error;
  welded_.resize(descriptions.size());
  file_meshes_ = welded_.size();
  run_meshes(descriptions.size(), triangles, [&](std::size_t i) {
    MeshDescription& mesh = descriptions[i];
    auto given = has_uv(mesh) ? mesh.triangles : std::move(mesh.triangles);
    welded_[i] = joins_within_rounding ? WeldedSurface::with_unused_positions(
                                             std::move(mesh.positions), std::move(given))
                                       : WeldedSurface(std::move(mesh.positions), std::move(given));
    mesh.positions = std::vector<Vec3>();
  });
  return joins_within_rounding ? join_within_rounding() : std::nullopt;
}

// Compiles the parts of the meshes, whose faces must not change any more.
void SceneCompiler::take_parts() {
  std::vector<MeshDescription>& descriptions = description_.meshes;
  for (std::size_t i = 0; i < descriptions.size(); ++i) {
    scene_.parts_.emplace_back(welded_[i], std::move(descriptions[i]));
    descriptions[i] = {};  // frees the data that is now compiled
  }
}

// The memory of the triangles by slot, for the indices of bodies with seams.
std::uint64_t SceneCompiler::corner_bytes(const Seams& seams) const {
  std::vector<bool> has_seams(scene_.shapes_.size(), false);
  for (const SeamBody& body : seams.bodies)
    has_seams[scene_.use_of_object_[body.surface].shape] = true;
  std::uint64_t bytes = 0;
  for (std::size_t i = 0; i < scene_.shapes_.size(); ++i) {
    if (has_seams[i]) bytes += sizeof(Triangle) * welded_[scene_.shapes_[i].mesh].face_count();
  }
  return bytes;
}

// Takes the memory of adjacency, indices and the corners of bodies with seams from the ledger. An
// error names a node with the mesh whose indices need the most memory.
std::optional<Error> SceneCompiler::take_surfaces(const Seams& seams) {
  std::vector<MemoryNeed> needs;
  for (const WeldedSurface& mesh : welded_) needs.push_back(SurfaceMesh::memory_need(mesh));
  std::vector<std::uint64_t> of_mesh(welded_.size(), 0);
  std::vector<std::uint64_t> shapes_of_mesh(welded_.size(), 0);
  for (const IndexShape& shape : scene_.shapes_) {
    needs.push_back(SurfaceIndex::memory_need(welded_[shape.mesh].face_count()) +
                    sizeof(IndexShape));
    of_mesh[shape.mesh] += needs.back().kept;
    ++shapes_of_mesh[shape.mesh];
  }
  MemoryNeed need = sum_of(std::move(needs), core_count() + 1);
  need = need + scene_.world_.stretches->size() * sizeof(Stretch);
  for (const SeamBody& body : seams.bodies) {
    need = need + (sizeof(SolverCorners) + body.joined.size() * sizeof(JoinedVertex));
  }
  if (!seams.bodies.empty()) need = need + corner_bytes(seams);
  const auto largest =
      static_cast<std::size_t>(std::max_element(of_mesh.begin(), of_mesh.end()) - of_mesh.begin());
  const auto shows_it = [&](const SceneObject& object) { return object.mesh == largest; };
  const auto object = std::find_if(scene_.objects_.begin(), scene_.objects_.end(), shows_it);
  const bool is_object = object != scene_.objects_.end();
  std::string element = is_object ? node_named(object->name) : "media";
  if (shapes_of_mesh[largest] > 1) {
    element += ", whose mesh has " + std::to_string(shapes_of_mesh[largest]) + " shapes";
  }
  ledger_.begin("building indices", std::move(element));
  return ledger_.take(need);
}

// Builds adjacency and indices at the same time: both depend only on the welded surfaces.
void SceneCompiler::build_meshes_and_indices() {
  std::size_t triangles = 0;
  for (const WeldedSurface& mesh : welded_) triangles += mesh.face_count();
  scene_.meshes_.resize(welded_.size());
  scene_.indices_.resize(scene_.shapes_.size());
  run_both(
      [&] {
        run_meshes(scene_.shapes_.size(), triangles, [&](std::size_t i) {
          const WeldedSurface& mesh = welded_[scene_.shapes_[i].mesh];
          scene_.indices_[i] = std::make_unique<SurfaceIndex>(
              MappedFaces{mesh.positions(), mesh.faces(), scene_.shapes_[i].map_index_mesh},
              scene_.shapes_[i].sweep_radius);
        });
      },
      [&] {
        run_meshes(welded_.size(), triangles,
                   [&](std::size_t i) { scene_.meshes_[i] = SurfaceMesh(welded_[i]); });
      });
  std::vector<WeldedSurface>().swap(welded_);
  for (std::size_t i = 0; i < scene_.meshes_.size(); ++i) {
    if (i < file_meshes_) add(statistics_.cleaning, scene_.meshes_[i].report());
    statistics_.memory += scene_.meshes_[i].memory();
  }
  for (const auto& index : scene_.indices_) statistics_.memory += index->memory();
}

}  // namespace palpate
