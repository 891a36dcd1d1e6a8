#pragma once

// Small glTF assets for tests. Functions add the valid parts; a test changes the JSON itself where
// it needs an invalid part.

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "geometry/base/types.h"

namespace palpate::test {

// A new folder; the destructor removes it with its content.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  std::string path(const std::string& name = {}) const { return (folder_ / name).string(); }
  // Writes a file into the folder and creates subfolders as needed. Returns the file's path.
  std::string write(const std::string& name, const std::string& content) const;

 private:
  std::filesystem::path folder_;
};

template <typename T>
std::string bytes_of(const std::vector<T>& values) {
  std::string bytes(values.size() * sizeof(T), '\0');
  if (!values.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

std::string base64_encoded(const std::string& bytes);

// A GLB of any chunks, valid or not. chunks: the type and the data of each chunk. The lengths in
// the GLB are those of the data.
std::string glb_of(const std::vector<std::pair<std::string, std::string>>& chunks);

class GltfBuilder {
 public:
  static constexpr int kByte = 5120;
  static constexpr int kUnsignedByte = 5121;
  static constexpr int kShort = 5122;
  static constexpr int kUnsignedShort = 5123;
  static constexpr int kUnsignedInt = 5125;
  static constexpr int kFloat = 5126;

  // An empty asset of version 2.0.
  GltfBuilder();

  // The root of the JSON. It has no buffers; the write functions add them.
  nlohmann::json json;
  std::string bin;  // buffer 0

  // Each function returns the id of the element it adds.
  std::size_t add_view(const std::string& bytes, std::size_t stride_bytes = 0);
  std::size_t add_accessor(std::size_t view, int component_type, std::size_t count,
                           const std::string& type);
  std::size_t add_positions(const std::vector<Eigen::Vector3f>& positions);
  std::size_t add_indices(const std::vector<std::uint32_t>& indices,
                          int component_type = kUnsignedShort);
  std::size_t add_mesh(nlohmann::json primitives);
  std::size_t add_node(nlohmann::json node);   // a root of scene 0, which is created if missing
  std::size_t add_child(nlohmann::json node);  // a node without a parent

  // One triangle (0,0,0), (1,0,0), (0,1,0) with 16-bit indices: accessors 0 and 1, views 0 and 1,
  // mesh 0, node 0 in scene 0.
  static GltfBuilder one_triangle();

  // The content of the asset's file. The buffer becomes the BIN chunk or a data URI.
  std::string glb_bytes() const;
  std::string data_uri_text(const std::string& media_type = "application/octet-stream") const;

  // Writes the asset and returns the file's path. The buffer becomes a .bin file beside the asset,
  // the BIN chunk or a data URI.
  std::string write_gltf(const TemporaryFolder& folder) const;
  std::string write_glb(const TemporaryFolder& folder) const;
  std::string write_data_uri(const TemporaryFolder& folder,
                             const std::string& media_type = "application/octet-stream") const;

  // Writes any text as asset.gltf and returns the file's path.
  static std::string write_text(const TemporaryFolder& folder, const std::string& text);
};

}  // namespace palpate::test
