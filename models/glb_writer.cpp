#include "models/glb_writer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "models/scene_content.h"

namespace palpate {
namespace {

using nlohmann::json;

// Constants of the glTF specification.
constexpr std::uint32_t kMagicGlb = 0x46546c67;
constexpr std::uint32_t kChunkJson = 0x4e4f534a;
constexpr std::uint32_t kChunkBin = 0x004e4942;
constexpr int kUnsignedShort = 5123;
constexpr int kUnsignedInt = 5125;
constexpr int kFloat = 5126;
constexpr int kArrayBuffer = 34962;
constexpr int kElementArrayBuffer = 34963;
constexpr int kNoTarget = 0;
constexpr int kTriangles = 4;
constexpr int kLinear = 9729;
constexpr int kLinearMipmapLinear = 9987;
constexpr int kRepeat = 10497;

constexpr const char* kPhysics = "KHR_physics_rigid_bodies";
constexpr const char* kHaptic = "MPEG_haptic_material";

// glTF is little-endian on every machine.
void append_little_endian(std::string& bytes, std::uint32_t value, int byte_count) {
  for (int i = 0; i < byte_count; ++i) bytes += static_cast<char>(value >> 8 * i & 0xffu);
}

void pad_to_four(std::string& bytes, char filler) {
  bytes.append((4 - bytes.size() % 4) % 4, filler);
}

// 0xffff is the primitive restart value of 16-bit indices and must not be used.
bool fits_16_bit(const TriangleMesh& mesh) {
  return mesh.positions_m.size() <= 0xffff;
}

bool is_finite_float(double x) {
  return std::isfinite(static_cast<float>(x));
}

// The reason why a mesh cannot be written; empty if it can.
std::string find_mesh_defect(const MeshContent& content) {
  const TriangleMesh& mesh = content.mesh;
  const std::size_t vertices = mesh.positions_m.size();
  if (mesh.triangles.empty()) return "the mesh has no triangle";
  for (const Vec3& p : mesh.positions_m) {
    if (!std::all_of(p.begin(), p.end(), is_finite_float)) {
      return "a coordinate is not a finite float";
    }
  }
  for (const Triangle& triangle : mesh.triangles) {
    for (const std::uint32_t vertex : triangle) {
      if (vertex >= vertices) {
        return "a triangle uses vertex " + std::to_string(vertex) + ", but the mesh has " +
               std::to_string(vertices) + " vertices";
      }
    }
  }
  const std::vector<Point2>& uv = content.texture_coordinates;
  if (!uv.empty() && uv.size() != vertices) {
    return "the mesh has " + std::to_string(uv.size()) + " texture coordinates for " +
           std::to_string(vertices) + " vertices";
  }
  for (const Point2& p : uv) {
    if (!is_finite_float(p.x()) || !is_finite_float(p.y())) {
      return "a texture coordinate is not a finite float";
    }
  }
  return {};
}

std::optional<Error> invalid(const char* list, std::size_t index, const std::string& problem) {
  return Error{ErrorCode::kInvalidArgument, "",
               std::string("/") + list + "/" + std::to_string(index), problem, ""};
}

bool fits(const Index& index, std::size_t count) {
  return !index || *index < count;
}

// The first mesh, material or node that cannot be written.
std::optional<Error> find_defect(const SceneContent& content) {
  const std::size_t images = content.images.size();
  if (content.meshes.empty()) return invalid("meshes", 0, "is missing: a scene needs a mesh");
  for (std::size_t i = 0; i < content.meshes.size(); ++i) {
    const MeshContent& mesh = content.meshes[i];
    const std::string defect = find_mesh_defect(mesh);
    if (!defect.empty()) return invalid("meshes", i, defect);
    if (!fits(mesh.material, content.materials.size()) ||
        !fits(mesh.haptic_material, content.haptic_materials.size())) {
      return invalid("meshes", i, "refers to a material that does not exist");
    }
  }
  for (std::size_t i = 0; i < content.materials.size(); ++i) {
    const MaterialContent& material = content.materials[i];
    if (!fits(material.base_color_image, images) || !fits(material.normal_image, images)) {
      return invalid("materials", i, "refers to an image that does not exist");
    }
  }
  for (std::size_t i = 0; i < content.haptic_materials.size(); ++i) {
    const HapticMaterialContent& material = content.haptic_materials[i];
    if (!fits(material.friction_image, images) || !fits(material.vibrotactile_image, images)) {
      return invalid("extensions/MPEG_haptic_material/materials", i,
                     "refers to an image that does not exist");
    }
  }
  for (std::size_t i = 0; i < content.nodes.size(); ++i) {
    const NodeContent& node = content.nodes[i];
    if (!fits(node.mesh, content.meshes.size()) ||
        !fits(node.physics_material, content.physics_materials.size())) {
      return invalid("nodes", i, "refers to a mesh or a physics material that does not exist");
    }
    if (!node.translation_m.allFinite())
      return invalid("nodes", i, "has a translation that is not finite");
  }
  return std::nullopt;
}

void append_float(std::string& bytes, double x) {
  append_little_endian(bytes, std::bit_cast<std::uint32_t>(static_cast<float>(x)), 4);
}

std::string position_bytes(const TriangleMesh& mesh) {
  std::string bytes;
  bytes.reserve(12 * mesh.positions_m.size());
  for (const Vec3& p : mesh.positions_m) {
    for (const double x_m : p) append_float(bytes, x_m);
  }
  return bytes;
}

std::string index_bytes(const TriangleMesh& mesh) {
  const int index_size = fits_16_bit(mesh) ? 2 : 4;
  std::string bytes;
  bytes.reserve(3 * static_cast<std::size_t>(index_size) * mesh.triangles.size());
  for (const Triangle& triangle : mesh.triangles) {
    for (const std::uint32_t vertex : triangle) append_little_endian(bytes, vertex, index_size);
  }
  return bytes;
}

std::string texture_coordinate_bytes(const std::vector<Point2>& uv) {
  std::string bytes;
  bytes.reserve(8 * uv.size());
  for (const Point2& p : uv) {
    for (const double x : {p.x(), p.y()}) append_float(bytes, x);
  }
  return bytes;
}

json position_accessor(const TriangleMesh& mesh) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  std::array<float, 3> low{kInfinity, kInfinity, kInfinity};
  std::array<float, 3> high{-kInfinity, -kInfinity, -kInfinity};
  for (const Vec3& p : mesh.positions_m) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto x_m = static_cast<float>(p[static_cast<Eigen::Index>(axis)]);
      low[axis] = std::min(low[axis], x_m);
      high[axis] = std::max(high[axis], x_m);
    }
  }
  return {{"componentType", kFloat},
          {"count", mesh.positions_m.size()},
          {"type", "VEC3"},
          {"min", low},
          {"max", high}};
}

json index_accessor(const TriangleMesh& mesh) {
  return {{"componentType", fits_16_bit(mesh) ? kUnsignedShort : kUnsignedInt},
          {"count", 3 * mesh.triangles.size()},
          {"type", "SCALAR"}};
}

json texture_coordinate_accessor(const std::vector<Point2>& uv) {
  return {{"componentType", kFloat}, {"count", uv.size()}, {"type", "VEC2"}};
}

// The binary chunk, and the JSON that describes its layout.
class Binary {
 public:
  // Adds a view, aligned to four bytes as floats and indices require. Returns the index of the
  // view. target: kNoTarget for an image.
  std::size_t add_view(const std::string& bytes, int target) {
    pad_to_four(bytes_, '\0');
    json view = {{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", bytes.size()}};
    if (target != kNoTarget) view["target"] = target;
    views_.push_back(std::move(view));
    bytes_ += bytes;
    return views_.size() - 1;
  }

  // Returns the index of the accessor.
  std::size_t add_accessor(json accessor, const std::string& bytes, int target) {
    accessor["bufferView"] = add_view(bytes, target);
    accessors_.push_back(std::move(accessor));
    return accessors_.size() - 1;
  }

  void describe_in(json& root) const {
    root["accessors"] = accessors_;
    root["bufferViews"] = views_;
    root["buffers"] = json::array({{{"byteLength", bytes_.size()}}});
  }

  std::string take_bytes() { return std::move(bytes_); }

 private:
  std::string bytes_;
  json views_ = json::array();
  json accessors_ = json::array();
};

json describe_mesh(const MeshContent& content, Binary& binary) {
  const TriangleMesh& mesh = content.mesh;
  json primitive = {{"mode", kTriangles}};
  primitive["attributes"]["POSITION"] =
      binary.add_accessor(position_accessor(mesh), position_bytes(mesh), kArrayBuffer);
  primitive["indices"] =
      binary.add_accessor(index_accessor(mesh), index_bytes(mesh), kElementArrayBuffer);
  const std::vector<Point2>& uv = content.texture_coordinates;
  if (!uv.empty()) {
    primitive["attributes"]["TEXCOORD_0"] = binary.add_accessor(
        texture_coordinate_accessor(uv), texture_coordinate_bytes(uv), kArrayBuffer);
  }
  if (content.material) primitive["material"] = *content.material;
  json described = {{"name", content.name}, {"primitives", json::array({primitive})}};
  if (content.haptic_material) {
    described["extensions"][kHaptic]["hapticMaterialIndex"] = *content.haptic_material;
  }
  return described;
}

json describe_material(const MaterialContent& content) {
  json material = {{"name", content.name}};
  if (!content.palpate.is_null()) material["extras"]["palpate"] = content.palpate;
  if (content.normal_image) material["normalTexture"]["index"] = *content.normal_image;
  if (!content.base_color && !content.base_color_image) return material;
  json& look = material["pbrMetallicRoughness"];
  look["metallicFactor"] = 0.0;
  if (content.base_color_image) look["baseColorTexture"]["index"] = *content.base_color_image;
  if (content.base_color) {
    look["baseColorFactor"] = *content.base_color;
    if (content.base_color->back() < 1.0) material["alphaMode"] = "BLEND";
  }
  return material;
}

json describe_node(const NodeContent& content, std::size_t index) {
  json node = {{"name", content.name}};
  if (content.mesh) node["mesh"] = *content.mesh;
  const Vec3& p = content.translation_m;
  if (!p.isZero(0.0)) node["translation"] = {p.x(), p.y(), p.z()};
  if (!content.extras.is_null()) node["extras"] = content.extras;
  if (content.physics_material) {
    json& collider = node["extensions"][kPhysics]["collider"];
    collider["geometry"] = {{"node", index}, {"convexHull", false}};
    collider["physicsMaterial"] = *content.physics_material;
  }
  return node;
}

json describe_haptic_material(const HapticMaterialContent& content) {
  json material = {{"name", content.name}};
  for (const auto& [property, image] :
       {std::pair("friction", content.friction_image),
        std::pair("vibrotactileTexture", content.vibrotactile_image)}) {
    if (!image) continue;
    const json map = {{"texture", {{"index", *image}}}, {"type", "High_Resolution"}};
    material[property] = json::array({map});
  }
  return material;
}

// Texture i is image i.
void describe_images(const std::vector<std::string>& images, Binary& binary, json& root) {
  for (std::size_t i = 0; i < images.size(); ++i) {
    root["images"].push_back(
        {{"bufferView", binary.add_view(images[i], kNoTarget)}, {"mimeType", "image/png"}});
    root["textures"].push_back({{"source", i}, {"sampler", 0}});
  }
  if (images.empty()) return;
  root["samplers"] = json::array({{{"magFilter", kLinear},
                                   {"minFilter", kLinearMipmapLinear},
                                   {"wrapS", kRepeat},
                                   {"wrapT", kRepeat}}});
}

void describe_extensions(const SceneContent& content, json& root) {
  if (!content.physics_materials.empty()) {
    root["extensions"][kPhysics]["physicsMaterials"] = content.physics_materials;
    root["extensionsUsed"].push_back(kPhysics);
  }
  for (const HapticMaterialContent& material : content.haptic_materials) {
    root["extensions"][kHaptic]["materials"].push_back(describe_haptic_material(material));
  }
  if (!content.haptic_materials.empty()) root["extensionsUsed"].push_back(kHaptic);
}

// glTF forbids empty lists, so empty lists are omitted.
json describe(const SceneContent& content, Binary& binary) {
  json root;
  root["asset"] = {{"version", "2.0"}, {"generator", "Palpate generate_models"}};
  root["scene"] = 0;
  json scene = json::object();
  for (const MeshContent& mesh : content.meshes) {
    root["meshes"].push_back(describe_mesh(mesh, binary));
  }
  for (const MaterialContent& material : content.materials) {
    root["materials"].push_back(describe_material(material));
  }
  for (std::size_t i = 0; i < content.nodes.size(); ++i) {
    root["nodes"].push_back(describe_node(content.nodes[i], i));
    scene["nodes"].push_back(i);
  }
  if (!content.extras.is_null()) scene["extras"] = content.extras;
  root["scenes"] = json::array({scene});
  describe_images(content.images, binary, root);
  describe_extensions(content, root);
  binary.describe_in(root);
  return root;
}

Result<std::string> container_of(std::string text, std::string bin) {
  pad_to_four(bin, '\0');
  pad_to_four(text, ' ');
  const std::size_t size = 12 + 8 + text.size() + 8 + bin.size();
  if (size > 0xffffffffu) {
    return Error{
        ErrorCode::kLimitExceeded, "", "",
        "a GLB file has at most 4 GiB, but this file needs " + std::to_string(size) + " bytes", ""};
  }
  std::string glb;
  glb.reserve(size);
  for (const std::uint32_t word : {kMagicGlb, 2u, static_cast<std::uint32_t>(size),
                                   static_cast<std::uint32_t>(text.size()), kChunkJson}) {
    append_little_endian(glb, word, 4);
  }
  glb += text;
  append_little_endian(glb, static_cast<std::uint32_t>(bin.size()), 4);
  append_little_endian(glb, kChunkBin, 4);
  glb += bin;
  return glb;
}

}  // namespace

Result<std::string> encode_scene(const SceneContent& content) {
  if (auto error = find_defect(content)) return *error;
  Binary binary;
  const json root = describe(content, binary);
  return container_of(root.dump(-1, ' ', false, json::error_handler_t::replace),
                      binary.take_bytes());
}

Result<std::string> encode_glb(GlbContent content, const json& node_extras) {
  SceneContent scene;
  scene.meshes.push_back({.name = content.name, .mesh = std::move(content.mesh), .material = 0});
  scene.materials.push_back({.name = content.material});
  scene.nodes.push_back({.name = content.name, .mesh = 0, .extras = node_extras});
  Result<std::string> bytes = encode_scene(scene);
  if (bytes) return bytes;
  Error error = bytes.error();
  error.path = content.name;
  return error;
}

Result<std::size_t> write_file(const std::string& path, const std::string& bytes) {
  const Error unwritable{ErrorCode::kFileUnwritable, path, "", "cannot be written",
                         "check that the folder exists and that the disk is not full"};
  std::FILE* file = std::fopen(path.c_str(), "wb");
  if (file == nullptr) return unwritable;
  const std::size_t written = std::fwrite(bytes.data(), 1, bytes.size(), file);
  const bool closed = std::fclose(file) == 0;  // writes the rest of the buffer
  if (written != bytes.size() || !closed) return unwritable;
  return written;
}

}  // namespace palpate
