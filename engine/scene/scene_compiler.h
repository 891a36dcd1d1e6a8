#pragma once

// Compiles the description of a scene into a Scene.

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/scene/conforming.h"
#include "engine/scene/node_placement.h"
#include "engine/scene/scene.h"
#include "engine/scene/scene_effects.h"
#include "engine/scene/seams.h"
#include "engine/scene/shared_indices.h"
#include "engine/scene/surface_attributes.h"
#include "geometry/base/box.h"
#include "geometry/base/memory_ledger.h"
#include "geometry/base/result.h"
#include "geometry/mesh/boundary_joins.h"
#include "geometry/mesh/welded_surface.h"
#include "io/scene_description.h"

namespace palpate {

// One compilation: the description is consumed step by step, and the scene grows. Not thread-safe;
// some steps use several cores.
class SceneCompiler {
 public:
  // settings and ledger must outlive this object.
  SceneCompiler(SceneDescription&& description, const SceneSettings& settings,
                MemoryLedger& ledger);

  // As Scene::compile(), but throws if an allocation fails. Only once.
  Result<Scene> run();

 private:
  // A surface that bounds a medium and cannot be touched.
  struct Medium {
    std::string name;
    IndexUse use;
    std::size_t material_set;  // SceneEffects::material_set()
    RigidTransform T_scene_body;
  };

  // The steps, in order (scene_compiler.cpp).
  std::optional<Error> compile();
  std::optional<Error> choose_nodes();
  void take_declarations();
  std::optional<Error> weld_meshes();
  std::optional<Error> place_nodes();
  std::optional<Error> fix_size();
  void take_parts();
  void take_contours();
  std::optional<Error> conform_nodes(SceneEffects& effects);
  std::optional<Error> add_surfaces(SceneEffects& effects);
  std::optional<Error> build_world();
  std::optional<Error> take_attributes();
  std::optional<Error> compile_effects(SceneEffects& effects);

  void measure_bounds();
  template <typename Visit>
  void visit_shapes_and_stretches(const Visit& visit) const;
  EffectSurface effect_surface(std::string_view node, const IndexUse& use, std::size_t material_set,
                               const RigidTransform& T_scene_body) const;

  // Boundaries of meshes (scene_joins.cpp).
  std::optional<Error> join_boundaries(const std::vector<GapLimit>& limits, JoinStatistics& joins);
  std::optional<Error> join_within_rounding();
  std::optional<Error> close_gaps();
  void report_gaps(double gap_m);

  // Nodes that meet (scene_conforming.cpp).
  Result<std::vector<std::uint32_t>> solid_nodes(SceneEffects& effects) const;
  std::uint64_t memory_for_changes() const;
  std::optional<Error> change_nodes(std::vector<ConformingSurface>& surfaces,
                                    std::span<const std::uint32_t> solid);
  void change_node(std::uint32_t n, const ConformingSurface& surface, bool is_shared);
  void warn_of_unchanged(const std::vector<std::uint32_t>& nodes);
  void report_conforming(const Conforming& made, std::size_t divided_edges);
  void note_conforming();

  // Surfaces and their indices (scene_meshes.cpp).
  std::uint64_t corner_bytes(const Seams& seams) const;
  std::optional<Error> take_surfaces(const Seams& seams);
  void build_meshes_and_indices();

  // Bodies (scene_world.cpp).
  std::optional<Error> take_places();
  void keep_touchable_nodes();
  void add_bodies();
  void add_face_materials();
  void widen_sweeps(const Seams& seams);
  Result<Seams> find_node_seams();
  void report_seams(const Seams& seams);
  void add_corners(Seams& seams);

  SceneDescription description_;
  const SceneSettings& settings_;
  MemoryLedger& ledger_;
  Scene scene_;
  SceneStatistics& statistics_ = scene_.statistics_;
  std::vector<WeldedSurface> welded_;      // one per mesh
  std::size_t file_meshes_ = 0;            // the first of welded_, without copies for changed nodes
  std::vector<Box> boxes_;                 // one per mesh, in its frame
  std::vector<NodePlacement> placements_;  // one per node
  Box bounds_scene_ = {Vec3::Zero(), Vec3::Zero()};
  // The vertices of nodes that meet those of other nodes.
  std::map<std::uint32_t, std::vector<std::uint32_t>> met_of_node_;
  bool are_nodes_searched_ = true;                   // for places where they meet
  std::vector<bool> is_changed_;                     // per node
  std::vector<double> moved_m_;                      // per mesh, how far vertices were moved
  std::vector<std::uint32_t> node_of_object_;        // index into the description
  std::vector<std::size_t> material_set_of_object_;  // SceneEffects::material_set()
  std::vector<Medium> media_;
};

}  // namespace palpate
