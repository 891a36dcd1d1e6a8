#include "tests/helpers/gltf_builder.h"

#include <fstream>
#include <stdlib.h>
#include <system_error>
#include <utility>

namespace palpate::test {
namespace {

std::string word(std::size_t value) {
  return bytes_of(std::vector<std::uint32_t>{static_cast<std::uint32_t>(value)});
}

std::string padded(std::string bytes, char padding) {
  while (bytes.size() % 4 != 0) bytes += padding;
  return bytes;
}

template <typename T>
std::string narrowed_bytes(const std::vector<std::uint32_t>& values) {
  return bytes_of(std::vector<T>(values.begin(), values.end()));
}

}  // namespace

TemporaryFolder::TemporaryFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "palpate_test_XXXXXX").string();
  folder_ = ::mkdtemp(name.data());
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

std::string TemporaryFolder::write(const std::string& name, const std::string& content) const {
  std::filesystem::create_directories((folder_ / name).parent_path());
  std::ofstream(folder_ / name, std::ios::binary) << content;
  return path(name);
}

std::string base64_encoded(const std::string& bytes) {
  const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      bits = bits << 8 | (i + k < bytes.size() ? static_cast<std::uint8_t>(bytes[i + k]) : 0u);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      text += i + k > bytes.size() ? '=' : digits[bits >> (18 - 6 * k) & 63u];
    }
  }
  return text;
}

std::string glb_of(const std::vector<std::pair<std::string, std::string>>& chunks) {
  std::string body;
  for (const auto& [type, data] : chunks) body += word(data.size()) + type + data;
  return "glTF" + word(2) + word(12 + body.size()) + body;
}

GltfBuilder::GltfBuilder() {
  json["asset"]["version"] = "2.0";
}

std::size_t GltfBuilder::add_view(const std::string& bytes, std::size_t stride_bytes) {
  bin = padded(std::move(bin), '\0');
  nlohmann::json view = {{"buffer", 0}, {"byteOffset", bin.size()}, {"byteLength", bytes.size()}};
  if (stride_bytes != 0) view["byteStride"] = stride_bytes;
  bin += bytes;
  json["bufferViews"].push_back(std::move(view));
  return json["bufferViews"].size() - 1;
}

std::size_t GltfBuilder::add_accessor(std::size_t view, int component_type, std::size_t count,
                                      const std::string& type) {
  json["accessors"].push_back(
      {{"bufferView", view}, {"componentType", component_type}, {"count", count}, {"type", type}});
  return json["accessors"].size() - 1;
}

std::size_t GltfBuilder::add_positions(const std::vector<Eigen::Vector3f>& positions) {
  return add_accessor(add_view(bytes_of(positions)), kFloat, positions.size(), "VEC3");
}

std::size_t GltfBuilder::add_indices(const std::vector<std::uint32_t>& indices,
                                     int component_type) {
  const std::string bytes = component_type == kUnsignedByte ? narrowed_bytes<std::uint8_t>(indices)
                            : component_type == kUnsignedShort
                                ? narrowed_bytes<std::uint16_t>(indices)
                                : bytes_of(indices);
  return add_accessor(add_view(bytes), component_type, indices.size(), "SCALAR");
}

std::size_t GltfBuilder::add_mesh(nlohmann::json primitives) {
  json["meshes"].push_back({{"primitives", std::move(primitives)}});
  return json["meshes"].size() - 1;
}

std::size_t GltfBuilder::add_node(nlohmann::json node) {
  const std::size_t id = add_child(std::move(node));
  json["scenes"][0]["nodes"].push_back(id);
  return id;
}

std::size_t GltfBuilder::add_child(nlohmann::json node) {
  json["nodes"].push_back(std::move(node));
  return json["nodes"].size() - 1;
}

GltfBuilder GltfBuilder::one_triangle() {
  GltfBuilder builder;
  const auto positions = builder.add_positions({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  const auto indices = builder.add_indices({0, 1, 2});
  const nlohmann::json primitive = {{"attributes", {{"POSITION", positions}}},
                                    {"indices", indices}};
  builder.add_node({{"mesh", builder.add_mesh(nlohmann::json::array({primitive}))}});
  return builder;
}

std::string GltfBuilder::glb_bytes() const {
  nlohmann::json root = json;
  if (!root.contains("buffers")) root["buffers"] = {{{"byteLength", bin.size()}}};
  return glb_of({{"JSON", padded(root.dump(), ' ')}, {std::string("BIN\0", 4), padded(bin, '\0')}});
}

std::string GltfBuilder::data_uri_text(const std::string& media_type) const {
  nlohmann::json root = json;
  root["buffers"] = {{{"byteLength", bin.size()},
                      {"uri", "data:" + media_type + ";base64," + base64_encoded(bin)}}};
  return root.dump();
}

std::string GltfBuilder::write_gltf(const TemporaryFolder& folder) const {
  nlohmann::json root = json;
  if (!root.contains("buffers")) {
    folder.write("asset.bin", bin);
    root["buffers"] = {{{"byteLength", bin.size()}, {"uri", "asset.bin"}}};
  }
  return write_text(folder, root.dump());
}

std::string GltfBuilder::write_glb(const TemporaryFolder& folder) const {
  return folder.write("asset.glb", glb_bytes());
}

std::string GltfBuilder::write_data_uri(const TemporaryFolder& folder,
                                        const std::string& media_type) const {
  return write_text(folder, data_uri_text(media_type));
}

std::string GltfBuilder::write_text(const TemporaryFolder& folder, const std::string& text) {
  return folder.write("asset.gltf", text);
}

}  // namespace palpate::test
