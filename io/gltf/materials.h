#pragma once

// The haptic properties that the file declares for triangles: glTF materials with extras.palpate,
// and the haptic materials of haptic_materials.h. The values are not interpreted here.

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "geometry/base/result.h"
#include "io/gltf/extras.h"
#include "io/gltf/images.h"
#include "io/scene_description.h"

namespace palpate {

// The glTF materials and the haptic materials of one asset while its meshes are read. Not
// thread-safe; one per call of read_gltf().
//
// A glTF material is read when the first triangle with it is read, so unused materials are not
// read. All haptic materials are read in open(); haptic_material_of_mesh() binds them to meshes.
class GltfMaterials {
 public:
  // An error if a haptic material violates the extension's specification, or an override has a
  // value that no parameter can have. root: the JSON after check_sections(). root and extras must
  // outlive this object.
  static Result<GltfMaterials> open(const nlohmann::json& root, PalpateExtras& extras,
                                    std::span<const MaterialOverride> overrides);

  // The index in the scene of a material of the file; indices are in the order of first use. The
  // overrides are applied to the material. An error if one of its declarations cannot be
  // represented.
  Result<std::uint32_t> index_of(std::uint32_t id);

  // Whether a triangle with this material of the file has been read.
  bool is_used(std::uint32_t id) const { return indices_.contains(id); }

  // The maps that triangles with this material need in a mesh with this haptic material; a map that
  // is not needed is null. material and haptic: indices in the scene. Marks the maps for
  // decode_maps(). The pointers are valid until the next index_of().
  struct Maps {
    const TextureReference* texture = nullptr;
    const TextureReference* friction = nullptr;
  };
  Maps call_maps(std::optional<std::uint32_t> material, std::optional<std::uint32_t> haptic);

  // Decodes the images of the maps that call_maps() has returned.
  std::optional<Error> decode_maps(GltfImages& images);

  // Moves all materials and warnings into a scene whose meshes have been read with index_of(). If
  // an override names "default" and no material has this name, a default material is added for the
  // triangles without a material. An error (kInvalidArgument) if an override names a material that
  // no triangle has.
  std::optional<Error> finish(SceneDescription& scene);

 private:
  struct Override {
    std::string material;
    MaterialParameter parameter;
    bool used = false;
  };

  GltfMaterials(const nlohmann::json& root, PalpateExtras& extras)
      : root_(&root), extras_(&extras) {}
  // The answers of call_maps() for each material. They are stored, because every primitive queries
  // them.
  struct KnownMaterial {
    bool has_map = false;
    bool is_flat = false;
    bool called = false;
  };
  struct KnownHaptic {
    TextureReference* texture = nullptr;  // both point into haptic_materials_
    TextureReference* friction = nullptr;
    bool texture_called = false;
    bool friction_called = false;
  };

  void find_haptic_maps();
  bool is_default_flat() const;
  void apply_overrides(MaterialDescription& material);
  void add_default(SceneDescription& scene);

  const nlohmann::json* root_;
  PalpateExtras* extras_;
  std::vector<Override> overrides_;
  std::map<std::uint32_t, std::uint32_t> indices_;  // id in the file to index in materials_
  std::vector<MaterialDescription> materials_;
  std::vector<KnownMaterial> known_materials_;
  std::vector<HapticMaterialDescription> haptic_materials_;
  std::vector<KnownHaptic> known_haptics_;
  bool is_default_flat_ = false;
  std::vector<std::string> warnings_;
};

// Adds a note with the names of the variants of KHR_materials_variants, which are not read.
// Thread-safe.
void note_variants(const nlohmann::json& root, std::vector<std::string>& notes);

}  // namespace palpate
