#include "tests/helpers/compressed_seeds.h"

#include <array>
#include <cstdint>
#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>
#include <meshoptimizer.h>
#include <string>
#include <vector>

#include "tests/helpers/gltf_builder.h"

namespace palpate::test {
namespace {

using Json = nlohmann::json;

// A tetrahedron.
const std::vector<std::array<float, 4>> kPoints = {
    {0, 0, 0, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};  // the fourth pads to 16 bytes
const std::vector<std::uint32_t> kIndices = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};

template <typename T>
void add_attribute(draco::Mesh& mesh, draco::GeometryAttribute::Type type, draco::DataType data,
                   std::int8_t components, const std::vector<std::array<T, 4>>& values) {
  draco::GeometryAttribute attribute;
  attribute.Init(type, nullptr, components, data, false,
                 components * static_cast<std::int64_t>(sizeof(T)), 0);
  const int id = mesh.AddAttribute(attribute, true, mesh.num_points());
  for (std::uint32_t v = 0; v < values.size(); ++v) {
    mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(v), values[v].data());
  }
}

// skinned: with joints (attribute 1) and weights (attribute 2)
std::string draco_stream(int method, bool skinned) {
  draco::Mesh mesh;
  mesh.set_num_points(static_cast<std::uint32_t>(kPoints.size()));
  add_attribute(mesh, draco::GeometryAttribute::POSITION, draco::DT_FLOAT32, 3, kPoints);
  if (skinned) {
    const std::vector<std::array<std::uint8_t, 4>> joints = {
        {0, 0, 0, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}, {1, 0, 0, 0}};
    const std::vector<std::array<float, 4>> weights(4, {0.5f, 0.5f, 0.0f, 0.0f});
    add_attribute(mesh, draco::GeometryAttribute::GENERIC, draco::DT_UINT8, 4, joints);
    add_attribute(mesh, draco::GeometryAttribute::GENERIC, draco::DT_FLOAT32, 4, weights);
  }
  for (std::size_t i = 0; i < kIndices.size(); i += 3) {
    mesh.AddFace({draco::PointIndex(kIndices[i]), draco::PointIndex(kIndices[i + 1]),
                  draco::PointIndex(kIndices[i + 2])});
  }
  draco::Encoder encoder;
  encoder.SetEncodingMethod(method);
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, 8);
  draco::EncoderBuffer buffer;
  if (!encoder.EncodeMeshToBuffer(mesh, &buffer).ok()) return {};
  return {buffer.data(), buffer.size()};
}

GltfBuilder draco_builder(int method, bool skinned) {
  constexpr const char* kDraco = "KHR_draco_mesh_compression";
  GltfBuilder asset;
  asset.json["extensionsUsed"] = {kDraco};
  asset.json["extensionsRequired"] = {kDraco};
  asset.json["accessors"] = {
      {{"componentType", GltfBuilder::kFloat}, {"count", kPoints.size()}, {"type", "VEC3"}},
      {{"componentType", GltfBuilder::kUnsignedShort},
       {"count", kIndices.size()},
       {"type", "SCALAR"}}};
  Json primitive = {{"attributes", {{"POSITION", 0}}}, {"indices", 1}};
  primitive["extensions"][kDraco] = {{"bufferView", asset.add_view(draco_stream(method, skinned))},
                                     {"attributes", {{"POSITION", 0}}}};
  asset.add_node({{"mesh", asset.add_mesh(Json::array({primitive}))}});
  return asset;
}

std::string draco_asset(int method) {
  return draco_builder(method, false).glb_bytes();
}

// The stream has one vertex fewer than its accessors declare, and its joints have fewer bits.
std::string draco_skin_asset(int method) {
  constexpr std::size_t kDeclared = 5;
  GltfBuilder asset = draco_builder(method, true);
  asset.json["accessors"][0]["count"] = kDeclared;
  asset.json["accessors"].push_back(
      {{"componentType", GltfBuilder::kUnsignedShort}, {"count", kDeclared}, {"type", "VEC4"}});
  asset.json["accessors"].push_back(
      {{"componentType", GltfBuilder::kFloat}, {"count", kDeclared}, {"type", "VEC4"}});
  Json& primitive = asset.json["meshes"][0]["primitives"][0];
  primitive["attributes"] = {{"POSITION", 0}, {"JOINTS_0", 2}, {"WEIGHTS_0", 3}};
  primitive["extensions"]["KHR_draco_mesh_compression"]["attributes"] = {
      {"POSITION", 0}, {"JOINTS_0", 1}, {"WEIGHTS_0", 2}};
  asset.add_node({{"translation", {0, 0, 1}}});
  asset.json["skins"] = {{{"joints", {1, 1}}}};
  asset.json["nodes"][0]["skin"] = 0;
  return asset.glb_bytes();
}

// A view that decodes to count elements of stride bytes.
std::size_t add_meshopt_view(GltfBuilder& asset, const std::string& encoded, std::size_t count,
                             std::size_t stride, const char* mode) {
  const std::size_t view = asset.add_view(encoded);
  Json& object = asset.json["bufferViews"][view];
  Json extension = {{"buffer", 0},          {"byteOffset", object.value("byteOffset", 0)},
                    {"byteStride", stride}, {"byteLength", encoded.size()},
                    {"count", count},       {"mode", mode}};
  object["byteLength"] = count * stride;
  if (std::string(mode) == "ATTRIBUTES") object["byteStride"] = stride;
  object["extensions"]["EXT_meshopt_compression"] = extension;
  return view;
}

std::string meshopt_asset(bool sequence) {
  GltfBuilder asset;
  asset.json["extensionsUsed"] = {"EXT_meshopt_compression"};
  asset.json["extensionsRequired"] = {"EXT_meshopt_compression"};
  constexpr std::size_t kStride = sizeof kPoints[0];
  std::string points(meshopt_encodeVertexBufferBound(kPoints.size(), kStride), '\0');
  points.resize(meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char*>(points.data()),
                                           points.size(), kPoints.data(), kPoints.size(), kStride));
  std::string indices;
  const auto encode = [&](auto bound, auto encoder) {
    indices.resize(bound(kIndices.size(), kPoints.size()));
    indices.resize(encoder(reinterpret_cast<unsigned char*>(indices.data()), indices.size(),
                           kIndices.data(), kIndices.size()));
  };
  using Encoder = std::size_t (*)(unsigned char*, std::size_t, const unsigned int*, std::size_t);
  if (sequence) {
    encode(meshopt_encodeIndexSequenceBound, Encoder{meshopt_encodeIndexSequence});
  } else {
    encode(meshopt_encodeIndexBufferBound, Encoder{meshopt_encodeIndexBuffer});
  }
  const std::size_t point_view =
      add_meshopt_view(asset, points, kPoints.size(), kStride, "ATTRIBUTES");
  const std::size_t index_view =
      add_meshopt_view(asset, indices, kIndices.size(), 4, sequence ? "INDICES" : "TRIANGLES");
  asset.add_accessor(point_view, GltfBuilder::kFloat, kPoints.size(), "VEC3");
  asset.add_accessor(index_view, GltfBuilder::kUnsignedInt, kIndices.size(), "SCALAR");
  const Json primitive = {{"attributes", {{"POSITION", 0}}}, {"indices", 1}};
  asset.add_node({{"mesh", asset.add_mesh(Json::array({primitive}))}});
  return asset.glb_bytes();
}

}  // namespace

std::vector<GltfSeed> compressed_gltf_seeds() {
  return {{"draco_edgebreaker.glb", draco_asset(draco::MESH_EDGEBREAKER_ENCODING)},
          {"draco_sequential.glb", draco_asset(draco::MESH_SEQUENTIAL_ENCODING)},
          {"draco_skin.glb", draco_skin_asset(draco::MESH_EDGEBREAKER_ENCODING)},
          {"meshopt_triangles.glb", meshopt_asset(false)},
          {"meshopt_sequence.glb", meshopt_asset(true)}};
}

}  // namespace palpate::test
