#include "io/gltf_schema.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>

#include <nlohmann/json.hpp>

#include "io/gltf_error.h"
#include "io/gltf_json.h"
#include "io/gltf_limits.h"

namespace palpate {
namespace {

using Json = nlohmann::json;
using MaybeError = std::optional<Error>;

enum class Kind {
  kId,       // index into the section named by target
  kIds,      // array of them
  kWhole,    // 0 to maximum
  kNumbers,  // array of exactly maximum finite numbers
  kFlag,
  kText,
  kAccessorType,   // "SCALAR", ...
  kComponentType,  // 5120, ...
  kStride,         // 4 to 252 in steps of 4
};

constexpr std::uint64_t kMaxInt = std::numeric_limits<std::int32_t>::max();

struct Property {
  const char* name;
  Kind kind;
  bool required = false;
  const char* target = "";
  std::uint64_t maximum = kMaxGltfWhole;
};

constexpr Property kSceneProperties[] = {
    {"name", Kind::kText},
    {"nodes", Kind::kIds, false, "nodes"},
};
constexpr Property kNodeProperties[] = {
    {"name", Kind::kText},
    {"children", Kind::kIds, false, "nodes"},
    {"mesh", Kind::kId, false, "meshes"},
    {"skin", Kind::kId, false, "skins"},
    {"matrix", Kind::kNumbers, false, "", 16},
    {"translation", Kind::kNumbers, false, "", 3},
    {"rotation", Kind::kNumbers, false, "", 4},
    {"scale", Kind::kNumbers, false, "", 3},
};
constexpr Property kMeshProperties[] = {
    {"name", Kind::kText},
};
constexpr Property kPrimitiveProperties[] = {
    {"indices", Kind::kId, false, "accessors"},
    {"material", Kind::kId, false, "materials"},
    {"mode", Kind::kWhole, false, "", 6},
};
constexpr Property kAccessorProperties[] = {
    {"bufferView", Kind::kId, false, "bufferViews"},
    {"byteOffset", Kind::kWhole},
    {"componentType", Kind::kComponentType, true},
    {"normalized", Kind::kFlag},
    {"count", Kind::kWhole, true},
    {"type", Kind::kAccessorType, true},
};
// tinygltf keeps these in an int.
constexpr Property kSparseProperties[] = {
    {"count", Kind::kWhole, true, "", kMaxInt},
};
constexpr Property kSparseIndicesProperties[] = {
    {"bufferView", Kind::kId, true, "bufferViews"},
    {"byteOffset", Kind::kWhole, false, "", kMaxInt},
    {"componentType", Kind::kComponentType, true},
};
constexpr Property kSparseValuesProperties[] = {
    {"bufferView", Kind::kId, true, "bufferViews"},
    {"byteOffset", Kind::kWhole, false, "", kMaxInt},
};
constexpr Property kBufferViewProperties[] = {
    {"buffer", Kind::kId, true, "buffers"},
    {"byteOffset", Kind::kWhole},
    {"byteLength", Kind::kWhole, true},
    {"byteStride", Kind::kStride},
};
constexpr Property kBufferProperties[] = {
    {"byteLength", Kind::kWhole, true},
    {"uri", Kind::kText},
};

class Checker {
 public:
  Checker(const Json& root, std::size_t text_bytes)
      : root_(root), most_elements_(most_gltf_elements(text_bytes)) {}

  Result<Json> run() {
    constexpr const char* kSections[] = {"scenes",    "nodes",       "meshes",
                                         "accessors", "bufferViews", "buffers"};
    // All of them before the first id, which would be out of range of a section that is no array.
    for (const char* name : kSections) {
      const auto section = root_.find(name);
      if (section != root_.end() && !section->is_array()) {
        return gltf_expected(std::string("/") + name, *section, "an array");
      }
    }
    Json sections = Json::object();
    if (auto error = check_scene(sections)) return *error;
    for (const char* name : kSections) {
      if (auto error = check_section(name, sections)) return *error;
    }
    return sections;
  }

 private:
  MaybeError check_scene(Json& sections) {
    constexpr Property kScene[] = {{"scene", Kind::kId, false, "scenes"}};
    return copy_properties(root_, "", kScene, sections);
  }

  std::size_t section_size(const std::string& name) const {
    const auto section = root_.find(name);
    return section == root_.end() || !section->is_array() ? 0 : section->size();
  }

  MaybeError check_section(const std::string& name, Json& sections) {
    const auto section = root_.find(name);
    if (section == root_.end()) return std::nullopt;
    if (name == "nodes" && section->size() > kMaxGltfNodes) {
      return gltf_error(ErrorCode::kLimitExceeded, "/nodes",
                        "has " + std::to_string(section->size()) + " nodes; at most " +
                            std::to_string(kMaxGltfNodes) + " are read");
    }
    if (auto error = count_elements(section->size(), "/" + name)) return error;
    Json& copies = sections[name] = Json::array();
    for (std::size_t i = 0; i < section->size(); ++i) {
      const std::string element = gltf_element(name, i);
      const Json& object = (*section)[i];
      if (!object.is_object()) return gltf_expected(element, object, "an object");
      Json copy = Json::object();
      if (auto error = check_object(name, object, element, copy)) return error;
      copies.push_back(std::move(copy));
    }
    return std::nullopt;
  }

  // Each element costs much more memory than its text, which may be no longer than "{},".
  MaybeError count_elements(std::size_t count, const std::string& element) {
    if (count > elements_left_) {
      return gltf_error(ErrorCode::kLimitExceeded, element,
                        "brings the elements of the asset to more than " +
                            std::to_string(most_elements_) +
                            ", the most that are read of so short a text");
    }
    elements_left_ -= count;
    return std::nullopt;
  }

  MaybeError check_object(const std::string& section, const Json& object,
                          const std::string& element, Json& copy) {
    if (section == "scenes") return copy_properties(object, element, kSceneProperties, copy);
    if (section == "nodes") return check_node(object, element, copy);
    if (section == "meshes") return check_mesh(object, element, copy);
    if (section == "accessors") return check_accessor(object, element, copy);
    if (section == "buffers") return copy_properties(object, element, kBufferProperties, copy);
    return copy_properties(object, element, kBufferViewProperties, copy);
  }

  MaybeError check_node(const Json& node, const std::string& element, Json& copy) {
    for (const char* name : {"translation", "rotation", "scale"}) {
      if (node.contains("matrix") && node.contains(name)) {
        return gltf_invalid(
            element, std::string("has both matrix and ") + name + "; expected one or the other");
      }
    }
    return copy_properties(node, element, kNodeProperties, copy);
  }

  MaybeError check_mesh(const Json& mesh, const std::string& element, Json& copy) {
    if (auto error = copy_properties(mesh, element, kMeshProperties, copy)) return error;
    const auto primitives = mesh.find("primitives");
    if (primitives == mesh.end()) {
      return gltf_invalid(element + "/primitives", "is missing; expected an array");
    }
    if (!primitives->is_array()) {
      return gltf_expected(element + "/primitives", *primitives, "an array");
    }
    if (auto error = count_elements(primitives->size(), element + "/primitives")) return error;
    Json& copies = copy["primitives"] = Json::array();
    for (std::size_t i = 0; i < primitives->size(); ++i) {
      const std::string path = element + "/primitives/" + std::to_string(i);
      Json primitive = Json::object();
      if (auto error = check_primitive((*primitives)[i], path, primitive)) return error;
      copies.push_back(std::move(primitive));
    }
    return std::nullopt;
  }

  MaybeError check_primitive(const Json& primitive, const std::string& element, Json& copy) {
    if (!primitive.is_object()) return gltf_expected(element, primitive, "an object");
    if (auto error = copy_properties(primitive, element, kPrimitiveProperties, copy)) return error;
    const auto attributes = primitive.find("attributes");
    if (attributes == primitive.end()) {
      return gltf_invalid(element + "/attributes", "is missing; expected an object");
    }
    if (auto error = copy_attributes(*attributes, element + "/attributes", copy["attributes"])) {
      return error;
    }
    const auto targets = primitive.find("targets");
    if (targets == primitive.end()) return std::nullopt;
    if (!targets->is_array()) return gltf_expected(element + "/targets", *targets, "an array");
    if (auto error = count_elements(targets->size(), element + "/targets")) return error;
    Json& copies = copy["targets"] = Json::array();
    for (std::size_t i = 0; i < targets->size(); ++i) {
      const std::string path = element + "/targets/" + std::to_string(i);
      if (auto error = copy_attributes((*targets)[i], path, copies.emplace_back())) return error;
    }
    return std::nullopt;
  }

  MaybeError copy_attributes(const Json& attributes, const std::string& element, Json& copy) {
    if (!attributes.is_object()) return gltf_expected(element, attributes, "an object");
    copy = Json::object();
    for (const auto& [name, value] : attributes.items()) {
      const Property property{name.c_str(), Kind::kId, true, "accessors"};
      if (auto error =
              copy_value(value, element + "/" + gltf_shortened(name), property, copy[name]))
        return error;
    }
    return std::nullopt;
  }

  MaybeError check_accessor(const Json& accessor, const std::string& element, Json& copy) {
    if (auto error = copy_properties(accessor, element, kAccessorProperties, copy)) return error;
    const auto sparse = accessor.find("sparse");
    if (sparse == accessor.end()) return std::nullopt;
    const std::string path = element + "/sparse";
    if (!sparse->is_object()) return gltf_expected(path, *sparse, "an object");
    Json& sparse_copy = copy["sparse"] = Json::object();
    if (auto error = copy_properties(*sparse, path, kSparseProperties, sparse_copy)) return error;
    if (auto error = copy_part(*sparse, path, "indices", kSparseIndicesProperties, sparse_copy)) {
      return error;
    }
    return copy_part(*sparse, path, "values", kSparseValuesProperties, sparse_copy);
  }

  // A required object inside another.
  MaybeError copy_part(const Json& parent, const std::string& parent_element, const char* name,
                       std::span<const Property> properties, Json& parent_copy) {
    const std::string element = parent_element + "/" + name;
    const auto part = parent.find(name);
    if (part == parent.end()) return gltf_invalid(element, "is missing; expected an object");
    if (!part->is_object()) return gltf_expected(element, *part, "an object");
    Json& copy = parent_copy[name] = Json::object();
    return copy_properties(*part, element, properties, copy);
  }

  MaybeError copy_properties(const Json& object, const std::string& element,
                             std::span<const Property> properties, Json& copy) {
    for (const Property& property : properties) {
      const std::string path = element + "/" + property.name;
      const auto found = object.find(property.name);
      if (found == object.end()) {
        if (property.required) return gltf_invalid(path, "is missing");
        continue;
      }
      if (auto error = copy_value(*found, path, property, copy[property.name])) return error;
    }
    return std::nullopt;
  }

  MaybeError copy_value(const Json& value, const std::string& element, const Property& property,
                        Json& copy) {
    switch (property.kind) {
      case Kind::kId:
        return copy_id(value, element, property, copy);
      case Kind::kIds:
        return copy_ids(value, element, property, copy);
      case Kind::kWhole:
        return copy_whole(value, element, property.maximum, copy);
      case Kind::kNumbers:
        return copy_numbers(value, element, property.maximum, copy);
      case Kind::kFlag:
        if (!value.is_boolean()) return gltf_expected(element, value, "true or false");
        copy = value;
        return std::nullopt;
      case Kind::kText:
        if (!value.is_string()) return gltf_expected(element, value, "a string");
        copy = value;
        return std::nullopt;
      case Kind::kAccessorType:
        return copy_accessor_type(value, element, copy);
      case Kind::kComponentType:
        return copy_component_type(value, element, copy);
      case Kind::kStride:
        return copy_stride(value, element, copy);
    }
    return std::nullopt;
  }

  MaybeError copy_id(const Json& value, const std::string& element, const Property& property,
                     Json& copy) {
    const auto id = whole_number(value);
    const std::size_t count = section_size(property.target);
    if (!id || *id >= count) {
      return gltf_expected(element, value,
                           std::string("an index into /") + property.target + ", which has " +
                               std::to_string(count) + " elements");
    }
    copy = *id;
    return std::nullopt;
  }

  MaybeError copy_ids(const Json& value, const std::string& element, const Property& property,
                      Json& copy) {
    if (!value.is_array()) return gltf_expected(element, value, "an array");
    copy = Json::array();
    const std::size_t count = section_size(property.target);
    for (std::size_t i = 0; i < value.size(); ++i) {
      if (i == count && count > 0) {
        return gltf_invalid(
            element, "has " + std::to_string(value.size()) + " elements; expected each of the " +
                         std::to_string(count) + " in /" + property.target + " once at most");
      }
      Json id;
      if (auto error = copy_id(value[i], element + "/" + std::to_string(i), property, id)) {
        return error;
      }
      copy.push_back(std::move(id));
    }
    return std::nullopt;
  }

  static MaybeError copy_whole(const Json& value, const std::string& element, std::uint64_t maximum,
                               Json& copy) {
    const auto number = whole_number(value);
    if (!number || *number > maximum) {
      return gltf_expected(element, value, "a whole number from 0 to " + std::to_string(maximum));
    }
    copy = *number;
    return std::nullopt;
  }

  static MaybeError copy_numbers(const Json& value, const std::string& element,
                                 std::uint64_t length, Json& copy) {
    if (!value.is_array() || value.size() != length) {
      return gltf_invalid(element,
                          (value.is_array() ? "has " + std::to_string(value.size()) + " elements"
                                            : std::string("is not an array")) +
                              "; expected " + std::to_string(length) + " numbers");
    }
    for (std::size_t i = 0; i < value.size(); ++i) {
      if (!value[i].is_number() || !std::isfinite(value[i].get<double>())) {
        return gltf_expected(element + "/" + std::to_string(i), value[i], "a finite number");
      }
    }
    copy = value;
    return std::nullopt;
  }

  static MaybeError copy_accessor_type(const Json& value, const std::string& element, Json& copy) {
    for (const char* type : {"SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"}) {
      if (value == type) {
        copy = value;
        return std::nullopt;
      }
    }
    return gltf_expected(element, value, "SCALAR, VEC2, VEC3, VEC4, MAT2, MAT3 or MAT4");
  }

  static MaybeError copy_component_type(const Json& value, const std::string& element, Json& copy) {
    const auto type = whole_number(value);
    if (!type || *type < 5120 || *type > 5126 || *type == 5124) {
      return gltf_expected(element, value, "5120, 5121, 5122, 5123, 5125 or 5126");
    }
    copy = *type;
    return std::nullopt;
  }

  static MaybeError copy_stride(const Json& value, const std::string& element, Json& copy) {
    const auto stride = whole_number(value);
    if (!stride || *stride < 4 || *stride > 252 || *stride % 4 != 0) {
      return gltf_expected(element, value, "a multiple of 4 from 4 to 252");
    }
    copy = *stride;
    return std::nullopt;
  }

  const Json& root_;
  std::size_t most_elements_;
  std::size_t elements_left_ = most_elements_;
};

}  // namespace

Result<Json> checked_sections(const Json& root, std::size_t text_bytes) {
  return Checker(root, text_bytes).run();
}

}  // namespace palpate
