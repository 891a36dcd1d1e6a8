#include "io/gltf/draco.h"

#include <draco/mesh/mesh.h>
#include <limits>
#include <utility>

#include <nlohmann/json.hpp>

#include "io/gltf/draco_decoder.h"
#include "io/gltf/draco_integers.h"
#include "io/gltf/error.h"
#include "io/gltf/json.h"
#include "io/gltf/limits.h"
#include "io/gltf/tinygltf.h"

namespace palpate {
namespace {

using Json = nlohmann::json;

constexpr const char* kDraco = "KHR_draco_mesh_compression";

std::size_t component_count(const tinygltf::Accessor& accessor) {
  return static_cast<std::size_t>(
      tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor.type)));
}

std::size_t component_bytes(const tinygltf::Accessor& accessor) {
  return static_cast<std::size_t>(
      tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(accessor.componentType)));
}

draco::DataType data_type_of(int component_type) {
  switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return draco::DT_INT8;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return draco::DT_UINT8;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return draco::DT_INT16;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return draco::DT_UINT16;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return draco::DT_UINT32;
    default:
      return draco::DT_FLOAT32;
  }
}

}  // namespace

std::size_t DracoPrimitive::vertex_count() const {
  return mesh_->num_points();
}

std::vector<std::uint32_t> DracoPrimitive::indices() const {
  std::vector<std::uint32_t> indices;
  indices.reserve(3 * static_cast<std::size_t>(mesh_->num_faces()));
  for (draco::FaceIndex face(0); face < mesh_->num_faces(); ++face) {
    for (const auto& point : mesh_->face(face)) indices.push_back(point.value());
  }
  return indices;
}

Result<DracoAttribute> DracoPrimitive::attribute(const std::string& semantic) const {
  const Source& source = attributes_.at(semantic);
  const std::string element = element_ + "/attributes/" + shortened(semantic);
  const tinygltf::Accessor& accessor = asset_.model.accessors[source.accessor];
  const draco::PointAttribute* stored = mesh_->GetAttributeByUniqueId(source.unique_id);
  if (stored == nullptr) {
    return gltf_invalid(element, "is " + std::to_string(source.unique_id) +
                                     ", but its stream has no attribute of this id");
  }
  DracoAttribute attribute{component_count(accessor), {}};
  const draco::DataType declared_type = data_type_of(accessor.componentType);
  const auto from = draco_integer_type(stored->data_type());
  const auto to = draco_integer_type(declared_type);
  const bool same_type = stored->data_type() == declared_type;
  if ((!same_type && (!from || !to)) ||
      static_cast<std::size_t>(stored->num_components()) != attribute.components) {
    return gltf_invalid(element, "its stream contains values of another type than " +
                                     gltf_element("accessors", source.accessor) + " declares");
  }
  attribute.values.reserve(attribute.components * vertex_count());
  std::vector<std::uint8_t> converted;
  for (draco::PointIndex point(0); point < mesh_->num_points(); ++point) {
    const draco::AttributeValueIndex index = stored->mapped_index(point);
    if (index.value() >= stored->size()) {
      return gltf_invalid(
          element, "vertex " + std::to_string(point.value()) + " has no value in its stream");
    }
    const std::uint8_t* value = stored->GetAddress(index);
    if (!same_type) {
      if (!convert_draco_integers(value, *from, attribute.components, *to, converted)) {
        return gltf_invalid(element, "its stream contains integers of another type than " +
                                         gltf_element("accessors", source.accessor) +
                                         " declares, and those of vertex " +
                                         std::to_string(point.value()) + " do not fit into that");
      }
      value = converted.data();
    }
    append_components(accessor, value, attribute.values);
  }
  return attribute;
}

Result<std::vector<Vec3>> DracoPrimitive::positions() const {
  const std::size_t accessor = attributes_.at("POSITION").accessor;
  if (auto error = check_position_type(asset_, accessor)) return *error;
  const auto attribute = this->attribute("POSITION");
  if (!attribute) return attribute.error();
  std::vector<Vec3> positions;
  positions.reserve(vertex_count());
  for (std::size_t i = 0; i < vertex_count(); ++i) {
    positions.emplace_back(attribute->values[3 * i], attribute->values[3 * i + 1],
                           attribute->values[3 * i + 2]);
    if (!positions.back().allFinite()) {
      return gltf_invalid(element_, "position " + std::to_string(i) + " is not finite");
    }
  }
  return positions;
}

// Reads the extension of one primitive and decodes its stream.
class DracoReader {
 public:
  DracoReader(const GltfAsset& asset, std::size_t mesh, std::size_t primitive)
      : asset_(asset),
        primitive_(asset.model.meshes[mesh].primitives[primitive]),
        json_(asset.json["meshes"][mesh]["primitives"][primitive]),
        primitive_element_(gltf_element("meshes", mesh, "primitives/" + std::to_string(primitive))),
        element_(primitive_element_ + "/extensions/" + kDraco) {}

  Result<std::optional<DracoPrimitive>> run(const DracoLimits& remaining) {
    const auto extension = find_extension(json_, primitive_element_, kDraco);
    if (!extension) return extension.error();
    if (*extension == nullptr) return std::optional<DracoPrimitive>();
    if (primitive_.mode == TINYGLTF_MODE_TRIANGLE_FAN) {
      return gltf_invalid(primitive_element_ + "/mode",
                          "is 6, but only lists and strips of triangles can be compressed");
    }
    DracoPrimitive result(asset_, element_);
    if (auto error = read_attributes(**extension, result)) return *error;
    if (auto error = declare_indices()) return *error;
    if (auto error = check_limits(remaining)) return *error;
    const auto view = required_id(**extension, element_, "bufferView", "/bufferViews",
                                  asset_.model.bufferViews.size());
    if (!view) return view.error();
    const auto bytes = view_bytes(asset_, *view);
    if (!bytes) return bytes.error();
    const tinygltf::BufferView& stored = asset_.model.bufferViews[*view];
    asset_.buffers.note_mesh_data(static_cast<std::size_t>(stored.buffer), stored.byteOffset,
                                  stored.byteLength, true);
    if (auto error = check_expansion(bytes->size())) return *error;
    auto mesh = decode_draco(*bytes, asset_.buffers, declared_, remaining, element_);
    if (!mesh) return mesh.error();
    if (auto error = check_corners(**mesh)) return *error;
    result.mesh_ = std::move(*mesh);
    warn(result);
    return std::optional(std::move(result));
  }

 private:
  void warn(DracoPrimitive& result) const {
    const draco::Mesh& mesh = *result.mesh_;
    if (mesh.num_points() != declared_.vertices ||
        !declared_.agrees_in_triangles(mesh.num_faces())) {
      result.warnings_.push_back(
          primitive_element_ + ": its compressed stream has " + std::to_string(mesh.num_points()) +
          " vertices and " + std::to_string(mesh.num_faces()) +
          " triangles, but its accessors describe " + std::to_string(declared_.vertices) +
          " vertices and " + std::to_string(declared_.indices) +
          " indices; the numbers of the stream are used");
    }
    for (const auto& [semantic, source] : result.attributes_) {
      const tinygltf::Accessor& accessor = asset_.model.accessors[source.accessor];
      const draco::PointAttribute* stored = mesh.GetAttributeByUniqueId(source.unique_id);
      if (!accessor.normalized || stored == nullptr || !draco_integer_type(stored->data_type()) ||
          stored->data_type() == data_type_of(accessor.componentType)) {
        continue;
      }
      result.warnings_.push_back(element_ + "/attributes/" + shortened(semantic) +
                                 ": its stream contains integers of another type than accessor " +
                                 std::to_string(source.accessor) +
                                 " declares, which normalises them; they are divided by the " +
                                 "largest of the accessor's type");
    }
  }

  // The library does not check the indices of a sequential stream.
  std::optional<Error> check_corners(const draco::Mesh& mesh) const {
    for (draco::FaceIndex face(0); face < mesh.num_faces(); ++face) {
      for (const auto& point : mesh.face(face)) {
        if (point.value() < mesh.num_points()) continue;
        return gltf_invalid(element_, "its stream names vertex " + std::to_string(point.value()) +
                                          " in triangle " + std::to_string(face.value()) +
                                          ", but has " + std::to_string(mesh.num_points()));
      }
    }
    return std::nullopt;
  }

  std::optional<Error> read_attributes(const Json& extension, DracoPrimitive& result) {
    const std::string element = element_ + "/attributes";
    const auto attributes = extension.find("attributes");
    if (attributes == extension.end()) return gltf_invalid(element, "is missing");
    if (!attributes->is_object() || attributes->empty()) {
      return gltf_expected(element, *attributes, "an object that is not empty");
    }
    for (const auto& [semantic, value] : attributes->items()) {
      const std::string path = element + "/" + shortened(semantic);
      const auto id = whole_number(value);
      if (!id || *id > std::numeric_limits<std::uint32_t>::max()) {
        return gltf_expected(path, value, "the id of an attribute of the stream");
      }
      const auto accessor = primitive_.attributes.find(semantic);
      if (accessor == primitive_.attributes.end()) {
        return gltf_invalid(path, "is not an attribute of the primitive");
      }
      const auto accessor_id = static_cast<std::size_t>(accessor->second);
      if (auto error = declare_attribute(accessor_id)) return error;
      result.attributes_[semantic] = {static_cast<std::uint32_t>(*id), accessor_id};
    }
    return std::nullopt;
  }

  std::optional<Error> declare_attribute(std::size_t accessor_id) {
    const tinygltf::Accessor& accessor = asset_.model.accessors[accessor_id];
    const std::string count = gltf_element("accessors", accessor_id, "count");
    if (accessor.count == 0) return gltf_invalid(count, "is 0; expected 1 or more");
    if (declared_.vertices != 0 && declared_.vertices != accessor.count) {
      return gltf_invalid(count, "is " + std::to_string(accessor.count) + ", but that of another " +
                                     "attribute of " + primitive_element_ + " is " +
                                     std::to_string(declared_.vertices));
    }
    declared_.vertices = accessor.count;
    declared_.vertex_bytes += component_count(accessor) * component_bytes(accessor);
    return count_declared(accessor_id);
  }

  std::optional<Error> declare_indices() {
    if (primitive_.indices < 0) {
      return gltf_invalid(primitive_element_ + "/indices",
                          "is missing, but the compressed primitive has indices");
    }
    const auto accessor_id = static_cast<std::size_t>(primitive_.indices);
    if (auto error = check_index_type(asset_, accessor_id)) return error;
    declared_.indices = asset_.model.accessors[accessor_id].count;
    declared_.index_bytes = component_bytes(asset_.model.accessors[accessor_id]);
    declared_.strip = primitive_.mode == TINYGLTF_MODE_TRIANGLE_STRIP;
    return count_declared(accessor_id);
  }

  std::optional<Error> count_declared(std::size_t accessor_id) const {
    const tinygltf::Accessor& accessor = asset_.model.accessors[accessor_id];
    if (accessor.sparse.isSparse) {
      return gltf_error(ErrorCode::kUnsupported, gltf_element("accessors", accessor_id, "sparse"),
                        "replaces values of a compressed primitive");
    }
    return asset_.buffers.count_decoded(
        accessor.count * component_count(accessor) * component_bytes(accessor),
        gltf_element("accessors", accessor_id, "count"));
  }

  std::optional<Error> check_limits(const DracoLimits& remaining) const {
    const std::uint64_t triangles = declared_.strip ? declared_.indices : declared_.indices / 3;
    if (declared_.vertices <= remaining.vertices && triangles <= remaining.triangles)
      return std::nullopt;
    return gltf_error(ErrorCode::kLimitExceeded, primitive_element_,
                      "has more vertices or triangles than can still be read, " +
                          std::to_string(remaining.vertices) + " and " +
                          std::to_string(remaining.triangles));
  }

  std::optional<Error> check_expansion(std::size_t stream_bytes) const {
    if (declared_.bytes() / kMaxDracoExpansion <= stream_bytes) return std::nullopt;
    return gltf_error(ErrorCode::kLimitExceeded, element_,
                      "its accessors describe " + std::to_string(declared_.bytes()) +
                          " bytes, its stream has " + std::to_string(stream_bytes) + "; at most " +
                          std::to_string(kMaxDracoExpansion) + " times as many are decoded");
  }

  const GltfAsset& asset_;
  const tinygltf::Primitive& primitive_;
  const Json& json_;
  std::string primitive_element_;
  std::string element_;
  DracoDeclared declared_;
};

Result<std::optional<DracoPrimitive>> read_draco_primitive(const GltfAsset& asset, std::size_t mesh,
                                                           std::size_t primitive,
                                                           std::size_t max_vertices,
                                                           std::size_t max_triangles) {
  return DracoReader(asset, mesh, primitive).run({max_vertices, max_triangles});
}

}  // namespace palpate
