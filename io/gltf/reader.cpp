#include "io/gltf/reader.h"

#include <chrono>
#include <exception>
#include <filesystem>
#include <new>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "geometry/base/memory_reserve.h"
#include "io/gltf/buffers.h"
#include "io/gltf/error.h"
#include "io/gltf/extensions.h"
#include "io/gltf/file.h"
#include "io/gltf/json_memory.h"
#include "io/gltf/json_scan.h"
#include "io/gltf/json_text.h"
#include "io/gltf/limits.h"
#include "io/gltf/meshopt.h"
#include "io/gltf/model.h"
#include "io/gltf/prescan.h"
#include "io/gltf/scene_reader.h"
#include "io/gltf/source.h"
#include "io/gltf/tinygltf.h"

namespace palpate {
namespace {

using Json = nlohmann::json;

// The files that the asset names are inputs, also those that nothing reads, such as colours and the
// sounds and lamps of extensions: each string named "uri", wherever it is. Iterative; the stack has
// as many levels as the JSON, at most kMaxGltfJsonDepth.
std::optional<Error> add_referenced_inputs(const Json& root, const std::string& folder) {
  struct Level {
    const Json& value;
    Json::const_iterator next;
  };
  std::vector<Level> levels;
  levels.push_back({root, root.begin()});
  while (!levels.empty()) {
    Level& level = levels.back();
    if (level.next == level.value.end()) {
      levels.pop_back();
      continue;
    }
    const Json& child = *level.next;
    const bool is_uri = child.is_string() && level.value.is_object() && level.next.key() == "uri";
    ++level.next;
    if (is_uri) {
      if (auto error = add_referenced_input(folder, child.get_ref<const std::string&>())) {
        return error;
      }
    } else if (child.is_structured()) {
      levels.push_back({child, child.begin()});
    }
  }
  return std::nullopt;
}

// The nodes are counted before the text is parsed, which takes half of their memory.
std::optional<Error> check_node_count(std::size_t nodes, std::uint64_t file_bytes) {
  const std::size_t most = most_gltf_nodes(file_bytes);
  if (nodes <= most) return std::nullopt;
  return gltf_error(ErrorCode::kLimitExceeded, "/nodes",
                    "has " + std::to_string(nodes) + " elements; at most " + std::to_string(most) +
                        " are read from a file of " + std::to_string(file_bytes) + " bytes",
                    "join small meshes, or divide the scene among several files");
}

std::optional<Error> check_count(std::size_t count, std::size_t most, const std::string& element) {
  if (count <= most) return std::nullopt;
  return gltf_error(
      ErrorCode::kLimitExceeded, element,
      "has " + std::to_string(count) + " elements; at most " + std::to_string(most) + " are read",
      "remove those that are not needed");
}

// As read_gltf_bytes(), but may throw, and Error::path is empty.
Result<SceneDescription> read_asset(const GltfSource& source, const std::string& folder,
                                    const ReadOptions& options, MemoryLedger& ledger) {
  const auto container = find_content(source);
  if (!container) return container.error();
  auto text = source.part(container->json);
  if (!text) return text.error();
  const std::string_view json(reinterpret_cast<const char*>(text->bytes.data()),
                              text->bytes.size());
  const auto scan = scan_json(json);
  if (!scan) return scan.error();
  if (auto error = check_node_count(scan->nodes, source.size())) return *error;
  if (auto error = check_count(scan->scenes, kMaxGltfScenes, "/scenes")) return *error;
  if (auto error = check_count(scan->animations, kMaxGltfAnimations, "/animations")) return *error;
  ledger.begin("parsing the JSON");
  const JsonExtent& extent = scan->extent;
  const MemoryNeed json_need = memory_of_json(parsed_bytes(*scan, json.size()), extent);
  if (auto error = ledger.take(json_need)) return *error;
  expect_available(json_need.peak);
  const MemoryReserve reserve(memory_to_destroy(parsed_bytes(*scan, json.size()), extent));
  std::vector<std::string> warnings;
  if (container->byte_order_mark) {
    warnings.push_back("JSON: begins with a byte order mark, which is ignored");
  }
  auto root = parse_gltf_json(json, *scan, warnings);
  if (!root) return root.error();
  if (auto error = check_asset_version(*root)) return *error;
  if (auto error = add_referenced_inputs(*root, folder)) return *error;
  auto extensions = check_extensions(*root);
  if (!extensions) return extensions.error();
  if (scan->long_data.empty()) {
    source.give_back(*text);
    text->storage = {};
  }
  auto sections = read_model(*root, container->json.length, warnings);
  expect_no_shortage();
  if (!sections) return sections.error();
  ledger.begin("reading the file");
  const std::span<std::uint8_t> own_text(text->storage.data(), text->storage.size());
  GltfBuffers buffers(std::move(sections->buffers), source, container->bin_chunk, folder, &ledger,
                      own_text.empty() ? GltfDataUris(json, scan->long_data)
                                       : GltfDataUris(own_text, scan->long_data));
  if (container->misaligned) {
    warnings.push_back("GLB: the length of a chunk is not a multiple of 4, as it must be");
  }
  GltfMeshoptViews compressed_views(*root, buffers);
  const GltfAsset asset{sections->model, *root, buffers, compressed_views,
                        extensions->mesh_quantization};
  ledger.begin("reading the scene");
  auto scene = read_scene(asset, options, std::move(warnings), extensions->warnings);
  if (scene) scene->files_read = buffers.files_read();
  return scene;
}

// Handles the exceptions that are not caused by lack of memory.
Result<SceneDescription> read_counted(const GltfSource& source, const std::string& folder,
                                      const ReadOptions& options, MemoryLedger& ledger) {
  try {
    return read_asset(source, folder, options, ledger);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::length_error&) {
    throw;
  } catch (const std::system_error&) {
    throw;
  } catch (const std::exception& exception) {
    return gltf_invalid({}, std::string("cannot be read: ") + exception.what());
  }
}

Error with_path(Error error, const std::string& path) {
  error.path = path;
  return error;
}

}  // namespace

Result<SceneDescription> read_gltf_bytes(std::span<const std::uint8_t> bytes,
                                         const std::string& folder, const std::string& name,
                                         const ReadOptions& options) {
  MemoryLedger ledger;
  auto scene = or_out_of_memory(
      ledger, [&] { return read_counted(GltfSource(bytes), folder, options, ledger); });
  if (!scene) return with_path(scene.error(), name);
  scene->path = name;
  return scene;
}

Result<SceneDescription> read_gltf(const std::string& path, const ReadOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  MemoryLedger ledger;
  auto scene = or_out_of_memory(ledger, [&]() -> Result<SceneDescription> {
    ledger = MemoryLedger(options.memory);
    ledger.begin("reading the file");
    const auto file = RegularFile::open(path);
    if (!file) return file.error();
    const GltfSource source(*file, ledger);
    if (file->size() > kMaxGltfFileBytes) {
      // What is no glTF is better told than its size.
      if (const auto content = find_content(source);
          !content && content.error().code == ErrorCode::kNotGltf) {
        return content.error();
      }
      return *file->check_size(kMaxGltfFileBytes);
    }
    return read_counted(source, std::filesystem::path(path).parent_path().string(), options,
                        ledger);
  });
  if (!scene) return with_path(scene.error(), path);
  scene->path = path;
  const std::chrono::duration<double, std::milli> elapsed =
      std::chrono::steady_clock::now() - start;
  scene->parse_ms = elapsed.count();
  return scene;
}

}  // namespace palpate