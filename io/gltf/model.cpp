// The implementation of tinygltf, compiled once with the macros of tinygltf.h. Do not also link
// libtinygltf.so, which was compiled with other macros. tinygltf's functions for single elements
// are visible only in this file.

#include <fstream>  // for tinygltf's writer, which does not include it with TINYGLTF_NO_FS

#define TINYGLTF_IMPLEMENTATION
#include <malloc.h>
#include <optional>
#include <utility>

#include <nlohmann/json.hpp>

#include "geometry/base/memory_reserve.h"
#include "io/gltf/error.h"
#include "io/gltf/model.h"
#include "io/gltf/schema.h"

namespace palpate {
namespace {

using Json = nlohmann::json;

constexpr bool kKeepText = false;  // of extras and extensions, which are read without tinygltf

// Elements that have been read. They are destroyed in large groups, so that their memory returns to
// the system: if each were freed at once, small permanent allocations of the next element would
// reuse its place and keep the page in use.
class SpentElements {
 public:
  void add(Json element) {
    elements_.push_back(std::move(element));
    if (elements_.size() < kTogether) return;
    elements_.clear();
#ifdef __GLIBC__
    malloc_trim(0);
#endif
  }

 private:
  static constexpr std::size_t kTogether = std::size_t{1} << 17;  // about 30 MB

  std::vector<Json> elements_;
};

// Newer versions of tinygltf (Debian 13) distinguish warnings from errors, and have a strictness
// parameter for Draco streams, which draco.h decodes instead.
template <typename Text>
bool parse_mesh(tinygltf::Mesh& mesh, tinygltf::Model& model, Text& problem, const Json& element) {
  if constexpr (requires { tinygltf::ParseMesh(&mesh, &model, &problem, element, kKeepText); }) {
    return tinygltf::ParseMesh(&mesh, &model, &problem, element, kKeepText);
  } else {
    Text warning;
    return tinygltf::ParseMesh(&mesh, &model, &problem, &warning, element, kKeepText, {});
  }
}

// Reads the elements one by one. tinygltf silently drops elements that it cannot parse; after the
// checks there should be none.
class ModelReader : public GltfElements {
 public:
  std::optional<Error> add(GltfSection section, Json element, Json rest) override {
    expect_no_shortage();
    const bool whole = read(section, element);
    spent_.add(std::move(element));
    spent_.add(std::move(rest));
    if (whole) return std::nullopt;
    return gltf_invalid("JSON", "tinygltf cannot read the element: " + problem_.substr(0, 200));
  }

  void expect(GltfSection section, std::size_t count) override {
    if (section == GltfSection::kNodes) result_.model.nodes.reserve(count);
    if (section == GltfSection::kAccessors) result_.model.accessors.reserve(count);
    if (section == GltfSection::kBufferViews) result_.model.bufferViews.reserve(count);
  }

  GltfModel take() { return std::move(result_); }

 private:
  bool read(GltfSection section, Json& element) {
    tinygltf::Model& model = result_.model;
    switch (section) {
      case GltfSection::kScenes:
        return read_scenes(element);
      case GltfSection::kNodes:
        return tinygltf::ParseNode(&model.nodes.emplace_back(), &problem_, element, kKeepText);
      case GltfSection::kMeshes:
        return read_mesh(element);
      case GltfSection::kAccessors:
        return tinygltf::ParseAccessor(&model.accessors.emplace_back(), &problem_, element,
                                       kKeepText);
      case GltfSection::kBufferViews:
        return tinygltf::ParseBufferView(&model.bufferViews.emplace_back(), &problem_, element,
                                         kKeepText);
      case GltfSection::kBuffers:
        return read_buffer(element);
    }
    return false;
  }

  // Reads all scenes and the index of the default scene; tinygltf has no function for a single
  // scene.
  bool read_scenes(Json& scenes) {
    scenes["asset"]["version"] = "2.0";
    const std::string text = scenes.dump(-1, ' ', false, Json::error_handler_t::replace);
    std::string warning;
    tinygltf::TinyGLTF loader;
    tinygltf::Model read;
    if (!loader.LoadASCIIFromString(&read, &problem_, &warning, text.data(),
                                    static_cast<unsigned int>(text.size()), "")) {
      return false;
    }
    result_.model.scenes = std::move(read.scenes);
    result_.model.defaultScene = read.defaultScene;
    return result_.model.scenes.size() == scenes["scenes"].size();
  }

  bool read_mesh(const Json& element) {
    tinygltf::Mesh& mesh = result_.model.meshes.emplace_back();
    return parse_mesh(mesh, result_.model, problem_, element) &&
           mesh.primitives.size() == element["primitives"].size();
  }

  // Buffers are not passed to tinygltf: data URIs may be long, and tinygltf must not load any.
  bool read_buffer(Json& element) {
    GltfBufferDeclaration& declaration = result_.buffers.emplace_back();
    declaration.byte_length = element["byteLength"].get<std::uint64_t>();
    const auto uri = element.find("uri");
    if (uri != element.end()) declaration.uri = std::move(uri->get_ref<std::string&>());
    return true;
  }

  GltfModel result_;
  SpentElements spent_;
  std::string problem_;
};

}  // namespace

Result<GltfModel> read_model(Json& root, std::size_t text_bytes,
                             std::vector<std::string>& warnings) {
  ModelReader reader;
  if (auto error = check_sections(root, text_bytes, warnings, reader)) return *error;
  return reader.take();
}

}  // namespace palpate
