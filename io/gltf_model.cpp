// The implementation of tinygltf, compiled once with our switches. Do not link libtinygltf.so as
// well: it was compiled with others. Its functions for single elements are known only here.

#include <fstream>  // its writer needs it, and without TINYGLTF_NO_FS it would include it itself

#define TINYGLTF_IMPLEMENTATION
#include <optional>
#include <utility>

#include <nlohmann/json.hpp>

#include "io/gltf_error.h"
#include "io/gltf_model.h"
#include "io/gltf_schema.h"

namespace palpate {
namespace {

using Json = nlohmann::json;

constexpr bool kKeepText = false;  // of extras and extensions, which are read beside tinygltf

// Reads the elements one after the other. tinygltf drops without a word what it cannot parse; after
// the checks nothing should be.
class ModelReader : public GltfElements {
 public:
  std::optional<Error> add(GltfSection section, Json element) override {
    bool whole = false;
    switch (section) {
      case GltfSection::kScenes:
        whole = read_scenes(element);
        break;
      case GltfSection::kNodes:
        whole =
            tinygltf::ParseNode(&result_.model.nodes.emplace_back(), &problem_, element, kKeepText);
        break;
      case GltfSection::kMeshes:
        whole = read_mesh(element);
        break;
      case GltfSection::kAccessors:
        whole = tinygltf::ParseAccessor(&result_.model.accessors.emplace_back(), &problem_, element,
                                        kKeepText);
        break;
      case GltfSection::kBufferViews:
        whole = tinygltf::ParseBufferView(&result_.model.bufferViews.emplace_back(), &problem_,
                                          element, kKeepText);
        break;
      case GltfSection::kBuffers:
        whole = read_buffer(element);
        break;
    }
    if (whole) return std::nullopt;
    return gltf_invalid("JSON", "tinygltf cannot read it: " + problem_.substr(0, 200));
  }

  void expect(GltfSection section, std::size_t count) override {
    if (section == GltfSection::kNodes) result_.model.nodes.reserve(count);
    if (section == GltfSection::kAccessors) result_.model.accessors.reserve(count);
    if (section == GltfSection::kBufferViews) result_.model.bufferViews.reserve(count);
  }

  GltfModel take() { return std::move(result_); }

 private:
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
    return tinygltf::ParseMesh(&mesh, &result_.model, &problem_, element, kKeepText) &&
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
