#include "io/gltf/prescan.h"

#include <bit>
#include <cstring>
#include <string>
#include <utility>

#include "io/gltf/error.h"
#include "io/gltf/limits.h"

namespace palpate {
namespace {

static_assert(std::endian::native == std::endian::little, "glTF data are little-endian");

constexpr std::size_t kHeaderBytes = 12;
constexpr std::size_t kChunkHeaderBytes = 8;
constexpr std::uint32_t kMagic = 0x46546C67;      // "glTF"
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;  // "JSON"
constexpr std::uint32_t kBinChunk = 0x004E4942;   // "BIN"

// Requires offset + 4 <= bytes.size().
std::uint32_t word_at(std::span<const std::uint8_t> bytes, std::size_t offset) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + offset, sizeof word);
  return word;
}

struct Chunk {
  std::uint32_t type = 0;
  std::span<const std::uint8_t> data;
};

// The chunk at the offset; the offset advances to the next chunk.
Result<Chunk> next_chunk(std::span<const std::uint8_t> glb, std::size_t& offset,
                         std::size_t index) {
  const std::string element = "GLB chunk " + std::to_string(index);
  if (glb.size() - offset < kChunkHeaderBytes) {
    return gltf_invalid(element, "its header needs 8 bytes, but the file has " +
                                     std::to_string(glb.size() - offset) + " left");
  }
  const std::size_t length = word_at(glb, offset);
  const std::uint32_t type = word_at(glb, offset + 4);
  offset += kChunkHeaderBytes;
  if (length > glb.size() - offset) {
    return gltf_invalid(element,
                        "its length is " + std::to_string(length) + " bytes, but the file has " +
                            std::to_string(glb.size() - offset) + " left",
                        "the file may be truncated");
  }
  const Chunk chunk{type, glb.subspan(offset, length)};
  offset += length;
  return chunk;
}

// Skips a UTF-8 byte order mark; an error for other encodings. element: of the text, for messages.
std::optional<Error> check_encoding(GltfContainer& container, const std::string& element) {
  using namespace std::string_view_literals;
  // Without a mark, the zero bytes beside the first brace identify the encoding.
  constexpr std::pair<std::string_view, const char*> kOthers[] = {
      {"\xFF\xFE\0\0"sv, "UTF-32"}, {"\0\0\xFE\xFF"sv, "UTF-32"}, {"{\0\0\0"sv, "UTF-32"},
      {"\0\0\0{"sv, "UTF-32"},      {"\xFF\xFE"sv, "UTF-16"},     {"\xFE\xFF"sv, "UTF-16"},
      {"{\0"sv, "UTF-16"},          {"\0{"sv, "UTF-16"}};
  for (const auto& [start, name] : kOthers) {
    if (!container.json.starts_with(start)) continue;
    return gltf_error(ErrorCode::kNotGltf, element,
                      std::string("is text in ") + name + "; expected UTF-8",
                      "save it in UTF-8, without a byte order mark");
  }
  constexpr std::string_view kMark = "\xEF\xBB\xBF";
  container.byte_order_mark = container.json.starts_with(kMark);
  if (container.byte_order_mark) container.json.remove_prefix(kMark.size());
  return std::nullopt;
}

Result<GltfContainer> split_glb(std::span<const std::uint8_t> file) {
  if (file.size() < kHeaderBytes) {
    return gltf_invalid("GLB header",
                        "needs 12 bytes; the file has " + std::to_string(file.size()));
  }
  if (const std::uint32_t version = word_at(file, 4); version != 2) {
    return gltf_error(ErrorCode::kUnsupported, "GLB header",
                      "its version is " + std::to_string(version) + "; expected 2",
                      "convert the asset to glTF 2.0");
  }
  if (const std::size_t length = word_at(file, 8); length != file.size()) {
    return gltf_invalid("GLB header",
                        "its length is " + std::to_string(length) + " bytes, but the file has " +
                            std::to_string(file.size()),
                        "the file may be truncated");
  }
  std::size_t offset = kHeaderBytes;
  const auto json = next_chunk(file, offset, 0);
  if (!json) return json.error();
  if (json->type != kJsonChunk) {
    return gltf_invalid("GLB chunk 0", "is not of type JSON, as the first chunk must be");
  }
  GltfContainer container;
  container.json = {reinterpret_cast<const char*>(json->data.data()), json->data.size()};
  if (auto error = check_encoding(container, "JSON")) return *error;
  container.misaligned = json->data.size() % 4 != 0;
  for (std::size_t index = 1; offset < file.size(); ++index) {
    const auto chunk = next_chunk(file, offset, index);
    if (!chunk) return chunk.error();
    if (chunk->type == kJsonChunk || (chunk->type == kBinChunk && index != 1)) {
      return gltf_invalid("GLB chunk " + std::to_string(index),
                          "repeats the type JSON or BIN, or BIN is not the second chunk");
    }
    if (chunk->type == kBinChunk) container.bin_chunk = chunk->data;
    container.misaligned |= chunk->data.size() % 4 != 0;
  }
  return container;
}

}  // namespace

Result<GltfContainer> split_container(std::span<const std::uint8_t> bytes) {
  if (bytes.size() >= 4 && word_at(bytes, 0) == kMagic) return split_glb(bytes);
  GltfContainer container;
  container.json = {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  if (auto error = check_encoding(container, {})) return *error;
  const std::size_t first = container.json.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos || container.json[first] != '{') {
    return gltf_error(ErrorCode::kNotGltf, {},
                      bytes.empty()
                          ? "is empty; expected a glTF 2.0 file, .gltf or .glb"
                          : "begins neither like a GLB container (\"glTF\") nor like a "
                            "JSON object (\"{\"); expected a glTF 2.0 file, .gltf or .glb");
  }
  return container;
}

std::optional<Error> check_json_size(std::string_view json) {
  if (json.size() > kMaxGltfJsonBytes) {
    return gltf_error(ErrorCode::kLimitExceeded, "JSON",
                      "has " + std::to_string(json.size()) + " bytes; at most " +
                          std::to_string(kMaxGltfJsonBytes) + " are read",
                      "store the buffers as a GLB or as .bin files");
  }
  std::size_t depth = 0;
  std::size_t values = 1;
  bool in_string = false;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
      continue;
    }
    if (c == '"') in_string = true;
    if (c == ',' || c == '[' || c == '{') ++values;
    if (c == '[' || c == '{') ++depth;
    if ((c == ']' || c == '}') && depth > 0) --depth;
    if (depth > kMaxGltfJsonDepth) {
      return gltf_error(ErrorCode::kLimitExceeded, "JSON byte " + std::to_string(i),
                        "nests deeper than " + std::to_string(kMaxGltfJsonDepth) + " levels");
    }
    if (values > kMaxGltfJsonValues) {
      return gltf_error(ErrorCode::kLimitExceeded, "JSON byte " + std::to_string(i),
                        "has more than " + std::to_string(kMaxGltfJsonValues) + " values");
    }
  }
  return std::nullopt;
}

}  // namespace palpate
