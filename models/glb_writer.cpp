#include "models/glb_writer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>

#include <nlohmann/json.hpp>

namespace palpate {
namespace {

using nlohmann::json;

// Numbers that the glTF specification gives a meaning.
constexpr std::uint32_t kMagicGlb = 0x46546c67;
constexpr std::uint32_t kChunkJson = 0x4e4f534a;
constexpr std::uint32_t kChunkBin = 0x004e4942;
constexpr int kUnsignedShort = 5123;
constexpr int kUnsignedInt = 5125;
constexpr int kFloat = 5126;
constexpr int kArrayBuffer = 34962;
constexpr int kElementArrayBuffer = 34963;
constexpr int kTriangles = 4;

// glTF is little-endian whatever the machine is.
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

// Why the mesh cannot be written; empty if it can.
std::string find_defect(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) return "the mesh has no triangle";
  for (const Vec3& p : mesh.positions_m) {
    for (const double coordinate_m : p) {
      if (!std::isfinite(static_cast<float>(coordinate_m))) {
        return "a coordinate is not a finite float";
      }
    }
  }
  for (const Triangle& triangle : mesh.triangles) {
    for (const std::uint32_t vertex : triangle) {
      if (vertex >= mesh.positions_m.size()) {
        return "vertex " + std::to_string(vertex) + " of " +
               std::to_string(mesh.positions_m.size());
      }
    }
  }
  return {};
}

std::string position_bytes(const TriangleMesh& mesh) {
  std::string bytes;
  bytes.reserve(12 * mesh.positions_m.size());
  for (const Vec3& p : mesh.positions_m) {
    for (const double x_m : p) {
      append_little_endian(bytes, std::bit_cast<std::uint32_t>(static_cast<float>(x_m)), 4);
    }
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
  return {{"bufferView", 0},
          {"componentType", kFloat},
          {"count", mesh.positions_m.size()},
          {"type", "VEC3"},
          {"min", low},
          {"max", high}};
}

json index_accessor(const TriangleMesh& mesh) {
  return {{"bufferView", 1},
          {"componentType", fits_16_bit(mesh) ? kUnsignedShort : kUnsignedInt},
          {"count", 3 * mesh.triangles.size()},
          {"type", "SCALAR"}};
}

json buffer_view(std::size_t offset, std::size_t length, int target) {
  return {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", length}, {"target", target}};
}

json describe(const GlbContent& content, const json& node_extras) {
  json node = {{"name", content.name}, {"mesh", 0}};
  if (!node_extras.is_null()) node["extras"] = node_extras;
  const json primitive = {
      {"attributes", {{"POSITION", 0}}}, {"indices", 1}, {"material", 0}, {"mode", kTriangles}};
  json root;
  root["asset"] = {{"version", "2.0"}, {"generator", "Palpate generate_models"}};
  root["scene"] = 0;
  root["scenes"] = json::array({{{"nodes", json::array({0})}}});
  root["nodes"] = json::array({node});
  root["meshes"] =
      json::array({{{"name", content.name}, {"primitives", json::array({primitive})}}});
  root["materials"] = json::array({{{"name", content.material}}});
  root["accessors"] = json::array({position_accessor(content.mesh), index_accessor(content.mesh)});
  return root;
}

}  // namespace

Result<std::string> encode_glb(const GlbContent& content, const json& node_extras) {
  const std::string defect = find_defect(content.mesh);
  if (!defect.empty()) return Error{ErrorCode::kInvalidArgument, content.name, "mesh", defect, ""};

  // 12 bytes a vertex first: the indices behind them are aligned to their size.
  std::string bin = position_bytes(content.mesh);
  const std::size_t positions_size = bin.size();
  bin += index_bytes(content.mesh);
  json root = describe(content, node_extras);
  root["bufferViews"] =
      json::array({buffer_view(0, positions_size, kArrayBuffer),
                   buffer_view(positions_size, bin.size() - positions_size, kElementArrayBuffer)});
  root["buffers"] = json::array({{{"byteLength", bin.size()}}});
  pad_to_four(bin, '\0');
  std::string text = root.dump(-1, ' ', false, json::error_handler_t::replace);
  pad_to_four(text, ' ');

  const std::size_t size = 12 + 8 + text.size() + 8 + bin.size();
  if (size > 0xffffffffu) {
    return Error{
        ErrorCode::kLimitExceeded, content.name, "",
        "a GLB file holds at most 4 GiB, this one needs " + std::to_string(size) + " bytes", ""};
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

Result<std::size_t> write_file(const std::string& path, const std::string& bytes) {
  const Error unwritable{ErrorCode::kFileUnwritable, path, "", "cannot be written",
                         "check that its folder exists and has room"};
  std::FILE* file = std::fopen(path.c_str(), "wb");
  if (file == nullptr) return unwritable;
  const std::size_t written = std::fwrite(bytes.data(), 1, bytes.size(), file);
  const bool closed = std::fclose(file) == 0;  // what is still buffered is written only here
  if (written != bytes.size() || !closed) return unwritable;
  return written;
}

}  // namespace palpate
