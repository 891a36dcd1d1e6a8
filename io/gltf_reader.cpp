#include "io/gltf_reader.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <filesystem>
#include <map>
#include <new>
#include <optional>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "io/gltf_accessor.h"
#include "io/gltf_buffers.h"
#include "io/gltf_error.h"
#include "io/gltf_extensions.h"
#include "io/gltf_file.h"
#include "io/gltf_limits.h"
#include "io/gltf_materials.h"
#include "io/gltf_nodes.h"
#include "io/gltf_prescan.h"
#include "io/gltf_primitives.h"
#include "io/gltf_schema.h"
#include "io/tinygltf.h"

namespace palpate {
namespace {

using Json = nlohmann::json;

Result<Json> parse_json(std::string_view text) {
  if (auto error = check_json_size(text)) return *error;
  if (text.starts_with("\xEF\xBB\xBF")) {  // which the parser would pass over
    return gltf_invalid("JSON", "begins with a byte order mark; expected none");
  }
  // The parser takes a zero byte for the end.
  const std::size_t end = text.find('\0');
  if (text.find_first_not_of('\0', std::min(end, text.size())) != text.npos) {
    return gltf_invalid("JSON", "byte " + std::to_string(end) + " is zero; expected text");
  }
  try {
    return Json::parse(text);
  } catch (const Json::exception& exception) {
    return gltf_invalid("JSON", std::string(exception.what()).substr(0, 200));
  }
}

// Moves the declarations out of the JSON: their data URIs may be long, and tinygltf is not to load
// any.
std::vector<GltfBufferDeclaration> take_buffers(Json& sections) {
  std::vector<GltfBufferDeclaration> declarations;
  const auto buffers = sections.find("buffers");
  if (buffers == sections.end()) return declarations;
  for (Json& buffer : *buffers) {
    GltfBufferDeclaration declaration;
    declaration.byte_length = buffer["byteLength"].get<std::uint64_t>();
    const auto uri = buffer.find("uri");
    if (uri != buffer.end()) declaration.uri = std::move(uri->get_ref<std::string&>());
    declarations.push_back(std::move(declaration));
  }
  sections.erase(buffers);
  return declarations;
}

// tinygltf refuses the whole file when an index accessor has no buffer view, which sparse ones need
// not have. Such accessors get an empty view of their own here, and lose it in
// remove_stand_in_view.
void add_stand_in_view(Json& sections) {
  Json& views = sections["bufferViews"];
  if (views.is_null()) views = Json::array();
  const std::size_t stand_in = views.size();
  if (sections.contains("accessors")) {
    for (Json& accessor : sections["accessors"]) {
      if (!accessor.contains("bufferView")) accessor["bufferView"] = stand_in;
    }
  }
  Json view;
  view["buffer"] = 0;
  view["byteLength"] = 0;
  views.push_back(std::move(view));
}

void remove_stand_in_view(tinygltf::Model& model) {
  const int stand_in = static_cast<int>(model.bufferViews.size()) - 1;
  for (tinygltf::Accessor& accessor : model.accessors) {
    if (accessor.bufferView == stand_in) accessor.bufferView = -1;
  }
  model.bufferViews.pop_back();
}

// How many elements each section has, and each mesh primitives.
std::vector<std::size_t> element_counts(const Json& sections) {
  std::vector<std::size_t> counts;
  for (const char* name : {"nodes", "scenes", "accessors", "bufferViews", "meshes"}) {
    counts.push_back(sections.contains(name) ? sections[name].size() : 0);
  }
  if (!sections.contains("meshes")) return counts;
  for (const Json& mesh : sections["meshes"]) counts.push_back(mesh["primitives"].size());
  return counts;
}

std::vector<std::size_t> element_counts(const tinygltf::Model& model) {
  std::vector<std::size_t> counts = {model.nodes.size(), model.scenes.size(),
                                     model.accessors.size(), model.bufferViews.size(),
                                     model.meshes.size()};
  for (const tinygltf::Mesh& mesh : model.meshes) counts.push_back(mesh.primitives.size());
  return counts;
}

// Takes the sections, which are not needed beside tinygltf's own copy.
Result<tinygltf::Model> load_model(Json sections) {
  sections["asset"]["version"] = "2.0";
  add_stand_in_view(sections);
  const std::vector<std::size_t> expected_counts = element_counts(sections);
  const std::string text = sections.dump(-1, ' ', false, Json::error_handler_t::replace);
  sections = nullptr;
  tinygltf::Model model;
  std::string error;
  std::string warning;
  tinygltf::TinyGLTF loader;
  const bool loaded = loader.LoadASCIIFromString(&model, &error, &warning, text.data(),
                                                 static_cast<unsigned int>(text.size()), "");
  // tinygltf drops without a word what it cannot parse; after the checks nothing should be.
  if (!loaded || element_counts(model) != expected_counts) {
    return gltf_invalid("JSON", "tinygltf cannot read it: " + error.substr(0, 200));
  }
  remove_stand_in_view(model);
  return model;
}

// Makes the description of the scene from a model whose JSON has been checked.
class SceneReader {
 public:
  SceneReader(const GltfAsset& asset, std::vector<std::string> warnings) : asset_(asset) {
    scene_.warnings = std::move(warnings);
  }

  Result<SceneDescription> run() {
    auto walk = walk_nodes(asset_.model, scene_.warnings);
    if (!walk) return walk.error();
    scene_.tree = std::move(walk->tree);
    for (const PlacedNode& placed : walk->mesh_nodes) {
      if (auto error = add_node(placed)) return *error;
    }
    if (scene_.meshes.empty()) {
      return gltf_error(ErrorCode::kEmptyScene, {}, "the scene has no triangle",
                        scene_.warnings.empty() ? "" : scene_.warnings.front());
    }
    if (auto error = check_placed()) return *error;
    if (auto error = read_materials(asset_.json, scene_)) return *error;
    shorten_warnings();
    return std::move(scene_);
  }

 private:
  std::optional<Error> add_node(const PlacedNode& placed) {
    const tinygltf::Node& node = asset_.model.nodes[placed.node];
    const std::string element = gltf_element("nodes", placed.node);
    NodeDescription description;
    description.name = scene_.tree[placed.tree_node].name;
    description.tree_node = placed.tree_node;
    description.linear_scene_mesh = placed.T_scene_node.linear;
    description.translation_m = placed.T_scene_node.translation_m;
    if (description.linear_scene_mesh.isZero(0.0)) {
      warn(element, description.name, "is scaled to nothing and is left out");
      return std::nullopt;
    }
    if (is_singular(description.linear_scene_mesh)) {
      warn(element, description.name,
           "is left out: its transform, with those of its ancestors, flattens the mesh");
      return std::nullopt;
    }
    const auto mesh = mesh_index(static_cast<std::size_t>(node.mesh));
    if (!mesh) return mesh.error();
    if (!*mesh) return std::nullopt;
    if (node.skin >= 0) {
      warn(element, description.name, "is skinned; its mesh is read unskinned, where the node is");
    }
    description.mesh = **mesh;
    scene_.nodes.push_back(std::move(description));
    return std::nullopt;
  }

  // Reads the mesh when it is first asked for; nothing if it has no triangle.
  Result<std::optional<std::uint32_t>> mesh_index(std::size_t mesh_id) {
    if (const auto known = meshes_.find(mesh_id); known != meshes_.end()) return known->second;
    auto mesh = read_mesh(asset_, mesh_id, budget_, scene_.warnings);
    if (!mesh) return mesh.error();
    std::optional<std::uint32_t> index;
    if (!mesh->triangles.empty()) {
      index = static_cast<std::uint32_t>(scene_.meshes.size());
      scene_.meshes.push_back(std::move(*mesh));
    }
    meshes_.emplace(mesh_id, index);
    return index;
  }

  // A large mesh that a great many nodes carry costs whoever reads the scene time for each of them.
  std::optional<Error> check_placed() const {
    std::size_t left = kMaxGltfPlaced;
    for (const NodeDescription& node : scene_.nodes) {
      const MeshDescription& mesh = scene_.meshes[node.mesh];
      const std::size_t count = mesh.positions.size() + mesh.triangles.size();
      if (count > left) {
        return gltf_error(ErrorCode::kLimitExceeded,
                          gltf_element("nodes", scene_.tree[node.tree_node].file_index, "mesh"),
                          "brings the vertices and triangles of all nodes to more than " +
                              std::to_string(kMaxGltfPlaced) + ", the most that are read");
      }
      left -= count;
    }
    return std::nullopt;
  }

  void warn(const std::string& element, const std::string& name, const std::string& text) {
    scene_.warnings.push_back(element + ": " + gltf_quoted(name) + " " + text);
  }

  void shorten_warnings() {
    const std::size_t count = scene_.warnings.size();
    if (count <= kMaxGltfWarnings) return;
    scene_.warnings.resize(kMaxGltfWarnings);
    scene_.warnings.push_back("and " + std::to_string(count - kMaxGltfWarnings) +
                              " further warnings");
  }

  const GltfAsset& asset_;
  SceneDescription scene_;
  GltfBudget budget_{kMaxGltfVertices, kMaxGltfTriangles};
  std::map<std::size_t, std::optional<std::uint32_t>> meshes_;  // by id in the file
};

// As read_gltf_bytes, but it may throw, and Error::path is empty.
Result<SceneDescription> read_asset(std::span<const std::uint8_t> bytes,
                                    const std::string& folder) {
  const auto container = split_container(bytes);
  if (!container) return container.error();
  const auto root = parse_json(container->json);
  if (!root) return root.error();
  if (auto error = check_asset_version(*root)) return *error;
  auto extensions = check_extensions(*root);
  if (!extensions) return extensions.error();
  auto sections = checked_sections(*root);
  if (!sections) return sections.error();
  GltfBuffers buffers(take_buffers(*sections), container->bin_chunk, folder);
  const auto model = load_model(std::move(*sections));
  if (!model) return model.error();
  std::vector<std::string> warnings = std::move(extensions->warnings);
  if (container->misaligned) {
    warnings.push_back("GLB: the length of a chunk is not a multiple of 4, as it must be");
  }
  const GltfAsset asset{*model, *root, buffers, extensions->mesh_quantization};
  return SceneReader(asset, std::move(warnings)).run();
}

Error with_path(Error error, const std::string& path) {
  error.path = path;
  return error;
}

}  // namespace

Result<SceneDescription> read_gltf_bytes(std::span<const std::uint8_t> bytes,
                                         const std::string& folder, const std::string& name) {
  try {
    auto scene = read_asset(bytes, folder);
    if (!scene) return with_path(scene.error(), name);
    scene->path = name;
    return scene;
  } catch (const std::bad_alloc&) {
    return with_path(gltf_error(ErrorCode::kLimitExceeded, {}, "there is not enough memory for it"),
                     name);
  } catch (const std::exception& exception) {
    return with_path(gltf_invalid({}, std::string("cannot be read: ") + exception.what()), name);
  }
}

Result<SceneDescription> read_gltf(const std::string& path) {
  const auto start = std::chrono::steady_clock::now();
  const auto file = read_regular_file(path, kMaxGltfFileBytes);
  if (!file) return with_path(file.error(), path);
  auto scene = read_gltf_bytes(*file, std::filesystem::path(path).parent_path().string(), path);
  if (!scene) return scene;
  const std::chrono::duration<double, std::milli> elapsed =
      std::chrono::steady_clock::now() - start;
  scene->parse_ms = elapsed.count();
  return scene;
}

}  // namespace palpate
