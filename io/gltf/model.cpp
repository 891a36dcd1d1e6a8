// The implementation of tinygltf, compiled once with our switches. Do not link libtinygltf.so as
// well: it was compiled with others. Its functions for single elements are known only here.

#include <fstream>  // its writer needs it, and without TINYGLTF_NO_FS it would include it itself

#define TINYGLTF_IMPLEMENTATION
#include <malloc.h>
#include <optional>
#include <utility>

#include <nlohmann/json.hpp>

#include "io/gltf/error.h"
#include "io/gltf/model.h"
#include "io/gltf/schema.h"

namespace palpate {
namespace {

using Json = nlohmann::json;

constexpr bool kKeepText = false;  // of extras and extensions, which are read beside tinygltf

// Elements that have been read. They go many at a time, and their memory back to the system: were
// each freed at once, the few bytes that the next one needs for good would be taken from its place,
// and keep the page.
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
  static constexpr std::size_t kTogether = std::size_t{1} << 17;  // some 30 MB

  std::vector<Json> elements_;
};

// Newer versions of tinygltf (Debian 13) tell warnings from errors, and ask how strict they are to
// be about Draco streams, which draco.h decodes instead.
template <typename Text>
bool parse_mesh(tinygltf::Mesh& mesh, tinygltf::Model& model, Text& problem, const Json& element) {
  if constexpr (requires { tinygltf::ParseMesh(&mesh, &model, &problem, element, kKeepText); }) {
    return tinygltf::ParseMesh(&mesh, &model, &problem, element, kKeepText);
  } else {
    Text warning;
    return tinygltf::ParseMesh(&mesh, &model, &problem, &warning, element, kKeepText, {});
  }
}

// Reads the elements one after the other. tinygltf drops without a word what it cannot parse; after
// the checks nothing should be.
class ModelReader : public GltfElements {
 public:
  std::optional<Error> add(GltfSection section, Json element, Json rest) override {
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

  // All of them, and which is the default; tinygltf has no function for one.
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

  // Their data URIs may be long, and tinygltf is not to load any.
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
