#include "io/gltf/schema.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

#include "geometry/base/memory_reserve.h"
#include "io/gltf/error.h"
#include "io/gltf/json.h"
#include "io/gltf/limits.h"

namespace palpate {
namespace {

using Json = nlohmann::json;
using MaybeError = std::optional<Error>;

enum class Kind {
  kId,       // index into the section named by target
  kIds,      // array of such indices
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
// tinygltf stores these as int.
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

// The path of a value in the JSON. It is converted to text only for messages, so that a million
// valid elements cost no text.
class JsonPath {
 public:
  JsonPath() = default;
  JsonPath operator/(std::string_view name) const { return {this, name, 0}; }
  JsonPath operator/(std::size_t index) const { return {this, {}, index}; }

  // "/nodes/7/mesh"
  std::string text() const {
    if (parent_ == nullptr) return {};
    return parent_->text() + "/" +
           (name_.data() != nullptr ? std::string(name_) : std::to_string(index_));
  }

 private:
  JsonPath(const JsonPath* parent, std::string_view name, std::size_t index)
      : parent_(parent), name_(name), index_(index) {}

  const JsonPath* parent_ = nullptr;  // outlives this
  std::string_view name_;             // null data: an index
  std::size_t index_ = 0;
};

struct Section {
  GltfSection id;
  const char* name;
};
constexpr Section kSections[] = {
    {GltfSection::kScenes, "scenes"},           {GltfSection::kNodes, "nodes"},
    {GltfSection::kMeshes, "meshes"},           {GltfSection::kAccessors, "accessors"},
    {GltfSection::kBufferViews, "bufferViews"}, {GltfSection::kBuffers, "buffers"}};

std::size_t component_count(const std::string& accessor_type) {
  if (accessor_type == "SCALAR") return 1;
  if (accessor_type == "VEC2") return 2;
  if (accessor_type == "VEC3") return 3;
  if (accessor_type == "MAT3") return 9;
  return accessor_type == "MAT4" ? 16 : 4;
}

class Checker {
 public:
  Checker(Json& root, std::size_t text_bytes, std::vector<std::string>& warnings,
          GltfElements& elements)
      : root_(root),
        most_elements_(most_gltf_elements(text_bytes)),
        warnings_(warnings),
        elements_(elements) {}

  MaybeError run() {
    // All sections are checked before the first id, which would be out of range of a section that
    // is not an array.
    for (const Section& section : kSections) {
      const auto list = root_.find(section.name);
      if (list != root_.end() && !list->is_array()) {
        return gltf_expected(std::string("/") + section.name, *list, "an array");
      }
    }
    constexpr Property kScene[] = {{"scene", Kind::kId, false, "scenes"}};
    Json scenes = Json::object();
    if (auto error = take_properties(root_, JsonPath(), kScene, scenes)) return error;
    for (const Section& section : kSections) {
      if (auto error = check_section(section, scenes)) return error;
    }
    return std::nullopt;
  }

 private:
  std::size_t section_size(const char* name) const {
    const auto section = root_.find(name);
    return section == root_.end() || !section->is_array() ? 0 : section->size();
  }

  // scenes: receives the object that is passed on for the scenes.
  MaybeError check_section(const Section& section, Json& scenes) {
    const auto list = root_.find(section.name);
    if (list == root_.end()) return std::nullopt;
    const JsonPath root_path;
    const JsonPath path = root_path / section.name;
    if (section.id == GltfSection::kNodes && list->size() > kMaxGltfNodes) {
      return gltf_error(ErrorCode::kLimitExceeded, path.text(),
                        "has " + std::to_string(list->size()) + " nodes; at most " +
                            std::to_string(kMaxGltfNodes) + " are read");
    }
    if (auto error = count_elements(list->size(), path)) return error;
    elements_.expect(section.id, list->size());
    Json* scene_list = nullptr;
    if (section.id == GltfSection::kScenes) scene_list = &(scenes["scenes"] = Json::array());
    for (std::size_t i = 0; i < list->size(); ++i) {
      const JsonPath element = path / i;
      Json& object = (*list)[i];
      if (!object.is_object()) return gltf_expected(element.text(), object, "an object");
      Json taken = Json::object();
      if (auto error = check_object(section.id, object, element, taken)) return error;
      Json rest;
      if (object.empty()) rest.swap(object);
      if (scene_list != nullptr) {
        scene_list->push_back(std::move(taken));
      } else if (auto error = elements_.add(section.id, std::move(taken), std::move(rest))) {
        return error;
      }
    }
    if (scene_list == nullptr) return std::nullopt;
    return elements_.add(section.id, std::move(scenes), nullptr);
  }

  // Each element costs much more memory than its text, which may be as short as "{},".
  MaybeError count_elements(std::size_t count, const JsonPath& path) {
    if (count > elements_left_) {
      return gltf_error(ErrorCode::kLimitExceeded, path.text(),
                        "raises the number of elements of the asset to more than " +
                            std::to_string(most_elements_) +
                            ", the limit for a text of this length");
    }
    elements_left_ -= count;
    return std::nullopt;
  }

  MaybeError check_object(GltfSection section, Json& object, const JsonPath& path, Json& taken) {
    expect_no_shortage();
    switch (section) {
      case GltfSection::kScenes:
        return take_properties(object, path, kSceneProperties, taken);
      case GltfSection::kNodes:
        return check_node(object, path, taken);
      case GltfSection::kMeshes:
        return check_mesh(object, path, taken);
      case GltfSection::kAccessors:
        return check_accessor(object, path, taken);
      case GltfSection::kBufferViews:
        // The view keeps its properties, which are compared with those of its compressed data.
        return take_properties(object, path, kBufferViewProperties, taken, Source::kKept);
      case GltfSection::kBuffers:
        return take_properties(object, path, kBufferProperties, taken);
    }
    return std::nullopt;
  }

  MaybeError check_node(Json& node, const JsonPath& path, Json& taken) {
    if (node.contains("matrix")) {
      for (const char* name : {"translation", "rotation", "scale"}) {
        if (!node.contains(name)) continue;
        return gltf_invalid(path.text(), std::string("has both matrix and ") + name +
                                             "; expected one or the other");
      }
    }
    return take_properties(node, path, kNodeProperties, taken);
  }

  MaybeError check_mesh(Json& mesh, const JsonPath& path, Json& taken) {
    if (auto error = take_properties(mesh, path, kMeshProperties, taken)) return error;
    const JsonPath list_path = path / "primitives";
    const auto primitives = mesh.find("primitives");
    if (primitives == mesh.end()) {
      return gltf_invalid(list_path.text(), "is missing; expected an array");
    }
    if (!primitives->is_array()) return gltf_expected(list_path.text(), *primitives, "an array");
    if (auto error = count_elements(primitives->size(), list_path)) return error;
    Json& list = taken["primitives"] = Json::array();
    for (std::size_t i = 0; i < primitives->size(); ++i) {
      Json primitive = Json::object();
      if (auto error = check_primitive((*primitives)[i], list_path / i, primitive)) return error;
      list.push_back(std::move(primitive));
    }
    return std::nullopt;
  }

  MaybeError check_primitive(Json& primitive, const JsonPath& path, Json& taken) {
    if (!primitive.is_object()) return gltf_expected(path.text(), primitive, "an object");
    if (auto error = take_properties(primitive, path, kPrimitiveProperties, taken)) return error;
    const auto attributes = primitive.find("attributes");
    if (attributes == primitive.end()) {
      return gltf_invalid((path / "attributes").text(), "is missing; expected an object");
    }
    if (auto error = take_attributes(*attributes, path / "attributes", taken["attributes"])) {
      return error;
    }
    primitive.erase(attributes);
    const auto targets = primitive.find("targets");
    if (targets == primitive.end()) return std::nullopt;
    const JsonPath list_path = path / "targets";
    if (!targets->is_array()) return gltf_expected(list_path.text(), *targets, "an array");
    if (auto error = count_elements(targets->size(), list_path)) return error;
    Json& list = taken["targets"] = Json::array();
    for (std::size_t i = 0; i < targets->size(); ++i) {
      if (auto error = take_attributes((*targets)[i], list_path / i, list.emplace_back())) {
        return error;
      }
    }
    primitive.erase(targets);
    return std::nullopt;
  }

  MaybeError take_attributes(Json& attributes, const JsonPath& path, Json& taken) {
    if (!attributes.is_object()) return gltf_expected(path.text(), attributes, "an object");
    taken = Json::object();
    for (auto& [name, value] : attributes.items()) {
      const std::string short_name = shortened(name);
      const Property property{name.c_str(), Kind::kId, true, "accessors"};
      if (auto error = take_value(value, path / short_name, property, taken[name])) return error;
    }
    return std::nullopt;
  }

  MaybeError check_accessor(Json& accessor, const JsonPath& path, Json& taken) {
    if (auto error = take_properties(accessor, path, kAccessorProperties, taken)) return error;
    check_extremes(accessor, path, taken["type"].get_ref<const std::string&>());
    const auto sparse = accessor.find("sparse");
    if (sparse == accessor.end()) return std::nullopt;
    const JsonPath sparse_path = path / "sparse";
    if (!sparse->is_object()) return gltf_expected(sparse_path.text(), *sparse, "an object");
    Json& part = taken["sparse"] = Json::object();
    if (auto error = take_properties(*sparse, sparse_path, kSparseProperties, part)) return error;
    if (auto error = take_part(*sparse, sparse_path, "indices", kSparseIndicesProperties, part)) {
      return error;
    }
    return take_part(*sparse, sparse_path, "values", kSparseValuesProperties, part);
  }

  // Min and max are only hints for other readers; the data are used.
  void check_extremes(const Json& accessor, const JsonPath& path, const std::string& type) {
    const auto low = accessor.find("min");
    const auto high = accessor.find("max");
    const std::size_t count = component_count(type);
    const auto numbers_in = [&](const auto& list, const char* name) {
      if (list == accessor.end()) return false;
      if (list->is_array() && list->size() == count &&
          std::all_of(list->begin(), list->end(), [](const Json& n) { return n.is_number(); })) {
        return true;
      }
      warnings_.push_back((path / name).text() + ": is not a list of " + std::to_string(count) +
                          " numbers, one for each component; it is ignored and the data are used");
      return false;
    };
    const bool has_low = numbers_in(low, "min");
    const bool has_high = numbers_in(high, "max");
    if (!has_low || !has_high) return;
    for (std::size_t i = 0; i < count; ++i) {
      if (!((*low)[i].get<double>() > (*high)[i].get<double>())) continue;
      warnings_.push_back(path.text() + ": its min " + (*low)[i].dump() + " is above its max " +
                          (*high)[i].dump() + " in component " + std::to_string(i) +
                          "; both are ignored and the data are used");
      return;
    }
  }

  // Takes the properties of a required nested object.
  MaybeError take_part(Json& parent, const JsonPath& parent_path, const char* name,
                       std::span<const Property> properties, Json& parent_taken) {
    const JsonPath path = parent_path / name;
    const auto part = parent.find(name);
    if (part == parent.end()) return gltf_invalid(path.text(), "is missing; expected an object");
    if (!part->is_object()) return gltf_expected(path.text(), *part, "an object");
    Json& taken = parent_taken[name] = Json::object();
    return take_properties(*part, path, properties, taken);
  }

  enum class Source { kMoved, kKept };

  MaybeError take_properties(Json& object, const JsonPath& path,
                             std::span<const Property> properties, Json& taken,
                             Source source = Source::kMoved) {
    for (const Property& property : properties) {
      const auto found = object.find(property.name);
      if (found == object.end()) {
        if (property.required) return gltf_invalid((path / property.name).text(), "is missing");
        continue;
      }
      if (auto error = take_value(*found, path / property.name, property, taken[property.name])) {
        return error;
      }
      if (source == Source::kMoved) object.erase(found);
    }
    return std::nullopt;
  }

  MaybeError take_value(Json& value, const JsonPath& path, const Property& property, Json& taken) {
    switch (property.kind) {
      case Kind::kId:
        return take_id(value, path, property, taken);
      case Kind::kIds:
        return take_ids(value, path, property, taken);
      case Kind::kWhole:
        return take_whole(value, path, property.maximum, taken);
      case Kind::kNumbers:
        return take_numbers(value, path, property.maximum, taken);
      case Kind::kFlag:
        if (!value.is_boolean()) return gltf_expected(path.text(), value, "true or false");
        taken = std::move(value);
        return std::nullopt;
      case Kind::kText:
        if (!value.is_string()) return gltf_expected(path.text(), value, "a string");
        taken = std::move(value);
        return std::nullopt;
      case Kind::kAccessorType:
        return take_accessor_type(value, path, taken);
      case Kind::kComponentType:
        return take_component_type(value, path, taken);
      case Kind::kStride:
        return take_stride(value, path, taken);
    }
    return std::nullopt;
  }

  MaybeError take_id(const Json& value, const JsonPath& path, const Property& property,
                     Json& taken) {
    const auto id = whole_number(value);
    const std::size_t count = section_size(property.target);
    if (!id || *id >= count) {
      return gltf_expected(path.text(), value,
                           std::string("an index into /") + property.target + ", which has " +
                               std::to_string(count) + " elements");
    }
    taken = *id;
    return std::nullopt;
  }

  MaybeError take_ids(const Json& value, const JsonPath& path, const Property& property,
                      Json& taken) {
    if (!value.is_array()) return gltf_expected(path.text(), value, "an array");
    taken = Json::array();
    const std::size_t count = section_size(property.target);
    for (std::size_t i = 0; i < value.size(); ++i) {
      if (i == count && count > 0) {
        return gltf_invalid(path.text(), "has " + std::to_string(value.size()) +
                                             " elements; expected each of the " +
                                             std::to_string(count) + " in /" + property.target +
                                             " at most once");
      }
      Json id;
      if (auto error = take_id(value[i], path / i, property, id)) return error;
      taken.push_back(std::move(id));
    }
    return std::nullopt;
  }

  static MaybeError take_whole(const Json& value, const JsonPath& path, std::uint64_t maximum,
                               Json& taken) {
    const auto number = whole_number(value);
    if (!number || *number > maximum) {
      return gltf_expected(path.text(), value,
                           "a whole number from 0 to " + std::to_string(maximum));
    }
    taken = *number;
    return std::nullopt;
  }

  static MaybeError take_numbers(Json& value, const JsonPath& path, std::uint64_t length,
                                 Json& taken) {
    if (!value.is_array() || value.size() != length) {
      return gltf_invalid(path.text(),
                          (value.is_array() ? "has " + std::to_string(value.size()) + " elements"
                                            : std::string("is not an array")) +
                              "; expected " + std::to_string(length) + " numbers");
    }
    for (std::size_t i = 0; i < value.size(); ++i) {
      if (!value[i].is_number() || !std::isfinite(value[i].get<double>())) {
        return gltf_expected((path / i).text(), value[i], "a finite number");
      }
    }
    taken = std::move(value);
    return std::nullopt;
  }

  static MaybeError take_accessor_type(const Json& value, const JsonPath& path, Json& taken) {
    for (const char* type : {"SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"}) {
      if (value == type) {
        taken = value;
        return std::nullopt;
      }
    }
    return gltf_expected(path.text(), value, "SCALAR, VEC2, VEC3, VEC4, MAT2, MAT3 or MAT4");
  }

  static MaybeError take_component_type(const Json& value, const JsonPath& path, Json& taken) {
    const auto type = whole_number(value);
    if (!type || *type < 5120 || *type > 5126 || *type == 5124) {
      return gltf_expected(path.text(), value, "5120, 5121, 5122, 5123, 5125 or 5126");
    }
    taken = *type;
    return std::nullopt;
  }

  static MaybeError take_stride(const Json& value, const JsonPath& path, Json& taken) {
    const auto stride = whole_number(value);
    if (!stride || *stride < 4 || *stride > 252 || *stride % 4 != 0) {
      return gltf_expected(path.text(), value, "a multiple of 4 from 4 to 252");
    }
    taken = *stride;
    return std::nullopt;
  }

  Json& root_;
  std::size_t most_elements_;
  std::size_t elements_left_ = most_elements_;
  std::vector<std::string>& warnings_;
  GltfElements& elements_;
};

}  // namespace

MaybeError check_sections(Json& root, std::size_t text_bytes, std::vector<std::string>& warnings,
                          GltfElements& elements) {
  return Checker(root, text_bytes, warnings, elements).run();
}

}  // namespace palpate
