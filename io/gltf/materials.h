#pragma once

// What the file declares about how triangles feel: glTF materials with extras.palpate, together
// with the haptic materials of haptic_materials.h. Nothing is interpreted here. Thread-safe.

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
// glTF materials are read when the first triangle has them, so those that no triangle has are not
// looked at. Haptic materials are read at once, all of them; their meshes are bound by
// haptic_material_of_mesh.
class GltfMaterials {
 public:
  // An error if a haptic material is not as its convention asks, or an override has a value that
  // nothing can have. root, as check_sections() has left it, and extras must outlive it.
  static Result<GltfMaterials> open(const nlohmann::json& root, PalpateExtras& extras,
                                    std::span<const MaterialOverride> overrides);

  // The index that the material of the file has in the scene, in the order of first use, with the
  // overrides put in. An error if a declaration of it cannot be represented.
  Result<std::uint32_t> index_of(std::uint32_t id);

  // The maps that a run of this material in a mesh of this haptic material calls for, by their
  // indices in the scene; null: none. Remembers that they were called for. Valid until the next
  // index_of().
  struct Maps {
    const TextureReference* texture = nullptr;
    const TextureReference* friction = nullptr;
  };
  Maps call_maps(std::optional<std::uint32_t> material, std::optional<std::uint32_t> haptic);

  // Decodes the images of the maps that were called for.
  std::optional<Error> decode_maps(GltfImages& images);

  // Moves everything, warnings too, into a scene whose meshes have been read with index_of(). If an
  // override is for "default" and no material has this name, the runs without material get one of
  // their own. An error (kInvalidArgument) if an override is for a material that no triangle has.
  std::optional<Error> finish(SceneDescription& scene);

 private:
  struct Override {
    std::string material;
    MaterialParameter parameter;
    bool used = false;
  };

  GltfMaterials(const nlohmann::json& root, PalpateExtras& extras)
      : root_(&root), extras_(&extras) {}
  // Which maps are called for is asked for every primitive, so it is known for each material.
  struct KnownMaterial {
    bool has_map = false;
    bool is_flat = false;
    bool called = false;
  };
  struct KnownHaptic {
    TextureReference* texture = nullptr;  // these two point into haptic_materials_
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
  std::map<std::uint32_t, std::uint32_t> indices_;  // by id in the file
  std::vector<MaterialDescription> materials_;
  std::vector<KnownMaterial> known_materials_;
  std::vector<HapticMaterialDescription> haptic_materials_;
  std::vector<KnownHaptic> known_haptics_;
  bool is_default_flat_ = false;
  std::vector<std::string> warnings_;
};

// Names the variants of KHR_materials_variants, which are not read.
void note_variants(const nlohmann::json& root, std::vector<std::string>& notes);

}  // namespace palpate
