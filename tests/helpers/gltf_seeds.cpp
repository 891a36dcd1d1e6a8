#include "tests/helpers/gltf_seeds.h"

#include <utility>

#include <nlohmann/json.hpp>

#include "tests/helpers/gltf_builder.h"
#include "tests/helpers/png_writer.h"

namespace palpate::test {
namespace {

using Json = nlohmann::json;

const std::vector<Eigen::Vector3f> kTetrahedron = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
const std::vector<std::uint32_t> kFaces = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};

Json primitive_of(std::size_t positions, std::size_t indices, int mode = 4) {
  return {{"attributes", {{"POSITION", positions}}}, {"indices", indices}, {"mode", mode}};
}

// Accessors 0 (positions) and 1 (indices), mesh 0, node 0.
GltfBuilder tetrahedron(const std::vector<std::uint32_t>& indices = kFaces,
                        int component_type = GltfBuilder::kUnsignedShort, int mode = 4) {
  GltfBuilder asset;
  const auto positions = asset.add_positions(kTetrahedron);
  const auto index_accessor = asset.add_indices(indices, component_type);
  asset.add_node(
      {{"mesh", asset.add_mesh(Json::array({primitive_of(positions, index_accessor, mode)}))}});
  return asset;
}

std::size_t add_coordinates(GltfBuilder& asset, const std::vector<float>& uv) {
  return asset.add_accessor(asset.add_view(bytes_of(uv)), GltfBuilder::kFloat, uv.size() / 2,
                            "VEC2");
}

GltfBuilder unindexed() {
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["meshes"][0]["primitives"][0].erase("indices");
  return asset;
}

GltfBuilder interleaved() {
  GltfBuilder asset;
  std::vector<float> rows;
  for (const Eigen::Vector3f& p : kTetrahedron) {
    rows.insert(rows.end(), {p.x(), p.y(), p.z(), 0.0f, 0.0f, 1.0f, 0.5f, 0.5f});
  }
  const auto view = asset.add_view(bytes_of(rows), 32);
  const auto positions = asset.add_accessor(view, GltfBuilder::kFloat, 4, "VEC3");
  const auto normals = asset.add_accessor(view, GltfBuilder::kFloat, 4, "VEC3");
  asset.json["accessors"][normals]["byteOffset"] = 12;
  const auto coordinates = asset.add_accessor(view, GltfBuilder::kFloat, 4, "VEC2");
  asset.json["accessors"][coordinates]["byteOffset"] = 24;
  Json primitive = primitive_of(positions, asset.add_indices(kFaces, GltfBuilder::kUnsignedInt));
  primitive["attributes"]["NORMAL"] = normals;
  primitive["attributes"]["TEXCOORD_0"] = coordinates;
  asset.add_node({{"mesh", asset.add_mesh(Json::array({primitive}))}});
  return asset;
}

GltfBuilder sparse(bool with_base) {
  GltfBuilder asset = tetrahedron();
  const auto where = asset.add_view(bytes_of(std::vector<std::uint16_t>{1, 2, 3}));
  const auto values = asset.add_view(bytes_of(std::vector<float>{2, 0, 0, 0, 2, 0, 0, 0, 2}));
  Json& accessor = asset.json["accessors"][0];
  accessor["sparse"] = {
      {"count", 3},
      {"indices", {{"bufferView", where}, {"componentType", GltfBuilder::kUnsignedShort}}},
      {"values", {{"bufferView", values}}}};
  if (!with_base) accessor.erase("bufferView");
  return asset;
}

GltfBuilder quantized() {
  GltfBuilder asset;
  const auto view =
      asset.add_view(bytes_of(std::vector<std::int16_t>{0, 0, 0, 0, 32767, 0, 0, 0, 0, 32767, 0, 0,
                                                        -32768, 0, 9, 0}),
                     8);
  const auto positions = asset.add_accessor(view, GltfBuilder::kShort, 4, "VEC3");
  asset.json["accessors"][positions]["normalized"] = true;
  asset.json["extensionsUsed"] = {"KHR_mesh_quantization"};
  asset.json["extensionsRequired"] = {"KHR_mesh_quantization"};
  const auto indices = asset.add_indices(kFaces, GltfBuilder::kUnsignedByte);
  asset.add_node({{"mesh", asset.add_mesh(Json::array({primitive_of(positions, indices)}))}});
  return asset;
}

// A tree of nodes with every form of transform, two scenes, and a mesh that many nodes share.
GltfBuilder many_nodes() {
  GltfBuilder asset = tetrahedron();
  asset.json["nodes"][0]["name"] = "root \u00e9";
  asset.json["nodes"][0]["children"] = {1, 2, 3};
  asset.add_child({{"mesh", 0}, {"translation", {1, 2, 3}}, {"rotation", {0, 0, 1, 0}}});
  asset.add_child({{"mesh", 0}, {"scale", {1, -2, 0.5}}, {"children", {4}}});
  asset.add_child({{"mesh", 0}, {"matrix", {0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 7, 8, 9, 1}}});
  asset.add_child({{"mesh", 0}, {"scale", {0, 0, 0}}});
  asset.json["scenes"].push_back({{"name", "other"}, {"nodes", {5}}});
  asset.add_child({{"mesh", 0}, {"rotation", {0.5, 0.5, 0.5, 0.5}}});
  asset.json["scene"] = 0;
  return asset;
}

GltfBuilder skinned() {
  GltfBuilder asset = tetrahedron();
  const auto joints = asset.add_accessor(asset.add_view(bytes_of(std::vector<std::uint8_t>{
                                             0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0})),
                                         GltfBuilder::kUnsignedByte, 4, "VEC4");
  const auto weights =
      asset.add_accessor(asset.add_view(bytes_of(std::vector<float>{
                             0.5f, 0.5f, 0, 0, 1, 0, 0, 0, 0.25f, 0.75f, 0, 0, 1, 0, 0, 0})),
                         GltfBuilder::kFloat, 4, "VEC4");
  std::vector<float> matrices;
  for (int i = 0; i < 2; ++i) {
    matrices.insert(matrices.end(), {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1, 0, 1});
  }
  const auto inverse_binds =
      asset.add_accessor(asset.add_view(bytes_of(matrices)), GltfBuilder::kFloat, 2, "MAT4");
  Json& attributes = asset.json["meshes"][0]["primitives"][0]["attributes"];
  attributes["JOINTS_0"] = joints;
  attributes["WEIGHTS_0"] = weights;
  asset.add_node({{"children", {2}}, {"translation", {0, 1, 0}}});
  asset.add_child({{"rotation", {0, 0, 0.6, 0.8}}});
  asset.json["skins"] = {
      {{"joints", {1, 2}}, {"inverseBindMatrices", inverse_binds}, {"skeleton", 1}}};
  asset.json["nodes"][0]["skin"] = 0;
  return asset;
}

GltfBuilder morphed() {
  GltfBuilder asset = tetrahedron();
  const auto moved = asset.add_positions({{0, 0, 0}, {1, 0, 0}, {0, 0, 0}, {0, 0, 1}});
  Json& mesh = asset.json["meshes"][0];
  mesh["primitives"][0]["targets"] = {{{"POSITION", moved}}, {{"POSITION", moved}}};
  mesh["weights"] = {0.25, 0.5};
  asset.json["nodes"][0]["weights"] = {0.5, 0};
  return asset;
}

// Animation channels with every path and every interpolation.
GltfBuilder animated() {
  GltfBuilder asset = morphed();
  const auto floats = [&](const std::vector<float>& values, std::size_t count,
                          const std::string& type) {
    return asset.add_accessor(asset.add_view(bytes_of(values)), GltfBuilder::kFloat, count, type);
  };
  const auto times = floats({0, 1}, 2, "SCALAR");
  asset.json["accessors"][times]["min"] = {0};
  asset.json["accessors"][times]["max"] = {1};
  const auto moves = floats({0, 0, 0, 1, 2, 3}, 2, "VEC3");
  const auto turns = floats({0, 0, 0, 1, 0, 0, 1, 0}, 2, "VEC4");
  const auto cubic = floats({0, 0, 0, 1, 1, 1, 0, 0, 0, 0, 0, 0, 2, 2, 2, 0, 0, 0}, 6, "VEC3");
  const auto weights = floats({0, 1, 1, 0}, 4, "SCALAR");
  const auto sampler = [&](std::size_t output, const char* interpolation) {
    return Json{{"input", times}, {"output", output}, {"interpolation", interpolation}};
  };
  const auto channel = [](int sampler_id, const char* path) {
    return Json{{"sampler", sampler_id}, {"target", {{"node", 0}, {"path", path}}}};
  };
  asset.json["animations"] = {{{"name", "all"},
                               {"samplers",
                                {sampler(moves, "LINEAR"), sampler(turns, "LINEAR"),
                                 sampler(cubic, "CUBICSPLINE"), sampler(weights, "STEP")}},
                               {"channels",
                                {channel(0, "translation"), channel(1, "rotation"),
                                 channel(2, "scale"), channel(3, "weights")}}}};
  return asset;
}

GltfBuilder instanced() {
  GltfBuilder asset = tetrahedron();
  const auto places = asset.add_positions({{0, 0, 0}, {5, 0, 0}, {0, 5, 0}});
  const auto turns = asset.add_accessor(
      asset.add_view(bytes_of(std::vector<float>{0, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0})),
      GltfBuilder::kFloat, 3, "VEC4");
  const auto scales = asset.add_positions({{1, 1, 1}, {2, 2, 2}, {1, -1, 0.5f}});
  asset.json["extensionsUsed"] = {"EXT_mesh_gpu_instancing"};
  asset.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"TRANSLATION", places}, {"ROTATION", turns}, {"SCALE", scales}};
  return asset;
}

GltfBuilder with_materials() {
  GltfBuilder asset = tetrahedron();
  asset.json["meshes"][0]["primitives"][0]["material"] = 0;
  asset.json["materials"] = {{{"name", "rubber"},
                              {"doubleSided", true},
                              {"extras",
                               {{"palpate",
                                 {{"stiffness", 800.0},
                                  {"damping", 1.5},
                                  {"staticFriction", 0.5},
                                  {"dynamicFriction", 0.4},
                                  {"viscosity", 0.0}}}}}}};
  asset.json["extensionsUsed"] = {"KHR_physics_rigid_bodies", "MPEG_haptic_material"};
  asset.json["extensions"]["KHR_physics_rigid_bodies"]["physicsMaterials"] = {
      {{"staticFriction", 0.8},
       {"dynamicFriction", 0.7},
       {"restitution", 0.1},
       {"frictionCombine", "average"}}};
  asset.json["extensions"]["MPEG_haptic_material"]["materials"] = {
      {{"name", "wood"},
       {"stiffness", {{{"type", "High_Resolution"}, {"texture", {{"index", 0}, {"texCoord", 0}}}}}},
       {"friction", {{{"type", "High_Resolution"}, {"texture", {{"index", 0}}}}}}}};
  asset.json["meshes"][0]["extensions"]["MPEG_haptic_material"]["hapticMaterialIndex"] = 0;
  asset.json["nodes"][0]["extensions"]["KHR_physics_rigid_bodies"]["collider"] = {
      {"geometry", {{"node", 0}}}, {"physicsMaterial", 0}};
  asset.json["textures"] = {{{"source", 0}, {"sampler", 0}}};
  asset.json["samplers"] = {{{"wrapS", 10497}}};
  const std::string grain = png_of({2, 2, 16, 0}, {0, 20000, 40000, 65535});
  asset.json["images"] = {{{"bufferView", asset.add_view(grain)}, {"mimeType", "image/png"}}};
  asset.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] =
      add_coordinates(asset, {0, 0, 1, 0, 0, 1, 1, 1});
  return asset;
}

// Every key of extras.palpate, and a texture in a data URI.
GltfBuilder with_effects() {
  GltfBuilder asset = tetrahedron();
  const std::string grain = png_of({2, 1, 8, 2}, {0, 128, 255, 1, 2, 3});
  Json& primitive = asset.json["meshes"][0]["primitives"][0];
  primitive["material"] = 0;
  primitive["attributes"]["TEXCOORD_1"] = add_coordinates(asset, {0, 0, 1, 0, 0, 1, 1, 1});
  asset.json["images"] = {{{"uri", "data:image/png;base64," + base64_encoded(grain)}}};
  asset.json["samplers"] = {{{"wrapS", 33071}, {"wrapT", 33648}}};
  asset.json["textures"] = {{{"source", 0}, {"sampler", 0}}};
  asset.json["extensionsUsed"] = {"KHR_texture_transform"};
  const Json transform = {{"offset", {0.5, 0}}, {"rotation", 0.5}, {"scale", {2, 3}}};
  asset.json["materials"] = {
      {{"normalTexture",
        {{"index", 0}, {"texCoord", 1}, {"extensions", {{"KHR_texture_transform", transform}}}}},
       {"extras",
        {{"palpate",
          {{"textureHeight", 0.001},
           {"creaseAngle", 30.0},
           {"solid", true},
           {"viscosity", 2.0},
           {"magnetForce", 1.0},
           {"magnetRange", 0.01},
           {"vibrationFrequency", 250.0},
           {"vibrationAmplitude", 0.5},
           {"vibrationWhen", "sliding"},
           {"restitution", 0.5},
           {"impactMass", 0.1},
           {"impactDuration", 0.01}}}}}}};
  asset.json["scenes"][0]["extras"]["palpate"] = {
      {"gravity", {0, -9.81, 0}}, {"toolMass", 0.1}, {"constantForce", {0, 0, 1}}};
  const Json box = {{"medium", "box"}, {"size", {1, 2, 3}}, {"viscosity", 5.0}};
  const Json sphere = {{"medium", "sphere"}, {"radius", 0.5}, {"viscosity", 5.0}};
  asset.add_node({{"translation", {5, 0, 0}}, {"extras", {{"palpate", box}}}});
  asset.add_node({{"translation", {0, 5, 0}}, {"extras", {{"palpate", sphere}}}});
  return asset;
}

// Contours of nodes: valid, and malformed in several ways, which is a warning.
GltfBuilder with_contours() {
  GltfBuilder asset = tetrahedron();
  const auto extras = [](const Json& contour) { return Json{{"palpate_contour", contour}}; };
  const Json points = {{"start_m", {0.1, 0, 0}}, {"end_m", {0, 0.1, 0}}};
  asset.json["nodes"][0]["extras"] = extras(points);
  asset.json["nodes"][0]["children"] = {1, 2};
  asset.add_child({{"scale", {2, -3, 0.5}}, {"extras", extras(points)}});
  asset.add_child({{"scale", {0, 0, 0}}, {"extras", extras(points)}});
  asset.add_node({{"extras", extras({{"start_m", {1, 2}}, {"end_m", {1, nullptr, 3}}})}});
  asset.add_node({{"extras", extras({{"start_m", {1, 2, 3}}, {"end", {1, 2, 3}}})}});
  asset.add_node({{"extras", extras(7)}});
  return asset;
}

// Points, lines, cameras, lights and a hidden node: the reader ignores them.
GltfBuilder left_out() {
  GltfBuilder asset = tetrahedron();
  for (int mode = 0; mode < 4; ++mode) {
    asset.json["meshes"][0]["primitives"].push_back(primitive_of(0, 1, mode));
  }
  asset.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 1}}}}};
  asset.json["extensionsUsed"] = {"KHR_lights_punctual", "KHR_node_visibility", "VENDOR_secret"};
  asset.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
  asset.add_node({{"camera", 0}});
  asset.add_node({{"mesh", 0}, {"extensions", {{"KHR_node_visibility", {{"visible", false}}}}}});
  return asset;
}

// Geometry that is hard to compile: an open bow-tie, a duplicate sheet and a sliver.
GltfBuilder hard_mesh() {
  GltfBuilder asset;
  const auto positions = asset.add_positions(
      {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {0.5f, 1e-30f, 0}, {0, 0, -0.0f}});
  const auto indices =
      asset.add_indices({0, 1, 2, 0, 3, 4, 2, 1, 0, 0, 1, 5, 0, 1, 6, 1, 1, 2, 6, 1, 2, 0, 2, 3});
  asset.add_node({{"mesh", asset.add_mesh(Json::array({primitive_of(positions, indices)}))}});
  return asset;
}

// JSON after a byte order mark, with a duplicate key and a min above its max.
std::string said_twice() {
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["accessors"][0]["min"] = {1, 1, 1};
  asset.json["accessors"][0]["max"] = {0, 0, 0};
  std::string text = asset.data_uri_text();
  text.insert(text.size() - 1, ",\"scene\":0,\"scene\":0");
  return "\xEF\xBB\xBF" + text;
}

}  // namespace

std::vector<GltfSeed> gltf_seeds() {
  constexpr int kStrip = 5;
  constexpr int kFan = 6;
  constexpr int kShort = GltfBuilder::kUnsignedShort;
  return {
      {"triangle.glb", GltfBuilder::one_triangle().glb_bytes()},
      {"triangle.gltf", GltfBuilder::one_triangle().data_uri_text()},
      {"tetrahedron.glb", tetrahedron().glb_bytes()},
      {"bytes.glb", tetrahedron(kFaces, GltfBuilder::kUnsignedByte).glb_bytes()},
      {"strip.glb", tetrahedron({0, 1, 2, 3, 0}, kShort, kStrip).glb_bytes()},
      {"fan.gltf", tetrahedron({0, 1, 2, 3}, kShort, kFan).data_uri_text("")},
      {"unindexed.glb", unindexed().glb_bytes()},
      {"interleaved.glb", interleaved().glb_bytes()},
      {"sparse.glb", sparse(true).glb_bytes()},
      {"sparse_alone.gltf", sparse(false).data_uri_text()},
      {"quantized.glb", quantized().glb_bytes()},
      {"nodes.glb", many_nodes().glb_bytes()},
      {"nodes.gltf", many_nodes().data_uri_text()},
      {"skin.glb", skinned().glb_bytes()},
      {"morph.glb", morphed().glb_bytes()},
      {"animation.glb", animated().glb_bytes()},
      {"instances.glb", instanced().glb_bytes()},
      {"materials.glb", with_materials().glb_bytes()},
      {"effects.glb", with_effects().glb_bytes()},
      {"contours.glb", with_contours().glb_bytes()},
      {"left_out.glb", left_out().glb_bytes()},
      {"hard_mesh.glb", hard_mesh().glb_bytes()},
      {"said_twice.gltf", said_twice()},
  };
}

}  // namespace palpate::test
