#pragma once

// Where keys of Palpate belong in a file, in words for the lines of gltf/unapplied_extras.h.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "io/gltf/accessor.h"
#include "io/key_names.h"

namespace palpate {

// The key that makes the group of a node a region.
inline constexpr std::string_view kMediumKey = "medium";

enum class ExtrasElementKind { kMaterial, kScene, kNode, kMesh, kOther };

// The element of the file that extras belong to. A primitive is a kMesh with a number.
struct ExtrasElement {
  ExtrasElementKind kind = ExtrasElementKind::kOther;
  std::size_t index = 0;
  std::optional<std::size_t> primitive = {};
};

// The owners of keys (io/key_names.h) that an element is: one, or none.
unsigned owner_of(ExtrasElementKind kind);

class ExtrasPlaces {
 public:
  // scene: the loaded scene. allowance: the work that is left to compare names with keys. The
  // arguments must outlive this object.
  ExtrasPlaces(const GltfAsset& asset, std::optional<std::size_t> scene, const KeyNames& names,
               KeyNames::Allowance& allowance)
      : asset_(asset), scene_(scene), names_(names), allowance_(allowance) {}

  // "stiffness belongs in /materials/3/extras/palpate (material "wood")", for a key that was
  // written at the element. has_medium: the key medium lies beside it.
  std::string belongs(const KeyMatch& match, const ExtrasElement& element, bool has_medium) const;
  // Where the keys of a group belong. is_group: false for a value that is no group.
  std::string belongs(const nlohmann::json& group, const ExtrasElement& element, bool is_group);

 private:
  std::vector<std::size_t> materials_of(const ExtrasElement& element) const;
  std::string material_place(std::size_t id) const;
  std::string place_of(unsigned owners, const ExtrasElement& element, bool has_medium) const;

  const GltfAsset& asset_;
  std::optional<std::size_t> scene_;
  const KeyNames& names_;
  KeyNames::Allowance& allowance_;
};

}  // namespace palpate
