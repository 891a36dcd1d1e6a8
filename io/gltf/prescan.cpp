#include "io/gltf/prescan.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <utility>

#include "io/gltf/error.h"
#include "io/gltf/json_spaces.h"
#include "io/gltf/known_formats.h"
#include "io/gltf/limits.h"

namespace palpate {
namespace {

static_assert(std::endian::native == std::endian::little, "glTF data are little-endian");

constexpr std::uint64_t kHeaderBytes = 12;
constexpr std::uint64_t kChunkHeaderBytes = 8;
constexpr std::uint32_t kMagic = 0x46546C67;      // "glTF"
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;  // "JSON"
constexpr std::uint32_t kBinChunk = 0x004E4942;   // "BIN"

// A longer JSON text is judged by its ends before it is read. The errors of the parser say more.
constexpr std::uint64_t kShortText = std::uint64_t{1} << 20;
constexpr std::uint64_t kBlock = std::uint64_t{1} << 16;
constexpr std::string_view kSpaces = " \t\r\n";

// Requires offset + 4 <= bytes.size().
std::uint32_t word_at(std::span<const std::uint8_t> bytes, std::size_t offset) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + offset, sizeof word);
  return word;
}

std::string_view text_of(const GltfSource::Part& part) {
  return {reinterpret_cast<const char*>(part.bytes.data()), part.bytes.size()};
}

// Up to kBlock bytes of a range, `skip` bytes after its begin. They do not count as memory.
Result<GltfSource::Part> block_of(const GltfSource& source, const GltfRange& range,
                                  std::uint64_t skip) {
  auto block =
      source.part({range.begin + skip, std::min<std::uint64_t>(range.length - skip, kBlock)});
  if (block) source.give_back(*block);
  return block;
}

struct Chunk {
  std::uint32_t type = 0;
  GltfRange data;
};

// The chunk at the offset; the offset advances to the next chunk.
Result<Chunk> next_chunk(const GltfSource& source, std::uint64_t& offset, std::size_t index) {
  const std::string element = "GLB chunk " + std::to_string(index);
  const std::uint64_t left = source.size() - offset;
  if (left < kChunkHeaderBytes) {
    return gltf_invalid(
        element, "its header needs 8 bytes, but the file has " + std::to_string(left) + " left");
  }
  const auto header = source.part({offset, kChunkHeaderBytes});
  if (!header) return header.error();
  source.give_back(*header);
  const std::uint64_t length = word_at(header->bytes, 0);
  const std::uint32_t type = word_at(header->bytes, 4);
  offset += kChunkHeaderBytes;
  if (length > source.size() - offset) {
    return gltf_invalid(element,
                        "its length is " + std::to_string(length) + " bytes, but the file has " +
                            std::to_string(source.size() - offset) + " left",
                        "the file may be truncated");
  }
  const Chunk chunk{type, {offset, length}};
  offset += length;
  return chunk;
}

// Skips a UTF-8 byte order mark; an error for other encodings. element: of the text, for messages.
// start: the first bytes of the text.
std::optional<Error> check_encoding(std::string_view start_of_text, GltfContainer& container,
                                    const std::string& element) {
  using namespace std::string_view_literals;
  // Without a mark, the zero bytes beside the first brace identify the encoding.
  constexpr std::pair<std::string_view, const char*> kOthers[] = {
      {"\xFF\xFE\0\0"sv, "UTF-32"}, {"\0\0\xFE\xFF"sv, "UTF-32"}, {"{\0\0\0"sv, "UTF-32"},
      {"\0\0\0{"sv, "UTF-32"},      {"\xFF\xFE"sv, "UTF-16"},     {"\xFE\xFF"sv, "UTF-16"},
      {"{\0"sv, "UTF-16"},          {"\0{"sv, "UTF-16"}};
  for (const auto& [start, name] : kOthers) {
    if (!start_of_text.starts_with(start)) continue;
    return gltf_error(ErrorCode::kNotGltf, element,
                      std::string("is text in ") + name + "; expected UTF-8",
                      "save it in UTF-8, without a byte order mark");
  }
  constexpr std::string_view kMark = "\xEF\xBB\xBF";
  container.byte_order_mark = start_of_text.starts_with(kMark);
  if (!container.byte_order_mark) return std::nullopt;
  container.json.begin += kMark.size();
  container.json.length -= kMark.size();
  return std::nullopt;
}

// The first byte of the text that is no space, from `skip` on; no value if there is none. The
// search reads one block after another.
Result<std::optional<std::uint64_t>> first_mark(const GltfSource& source, const GltfRange& json,
                                                std::uint64_t skip) {
  for (; skip < json.length; skip += kBlock) {
    const auto block = block_of(source, json, skip);
    if (!block) return block.error();
    const std::size_t found = first_json_mark(text_of(*block), 0);
    if (found < block->bytes.size()) return std::optional(skip + found);
  }
  return std::optional<std::uint64_t>();
}

// The last byte of the text that is neither a space nor a zero; a brace if a block of the text has
// none, since spaces may be as long as the file.
Result<char> last_mark(const GltfSource& source, const GltfRange& json) {
  const auto block = block_of(source, json, json.length - std::min(json.length, kBlock));
  if (!block) return block.error();
  const std::string_view text = text_of(*block);
  using namespace std::string_view_literals;
  const std::size_t found = text.find_last_not_of(" \t\r\n\0"sv);
  return found == text.npos ? '}' : text[found];
}

// Judges a long text by its length, and by what follows its first brace and what ends it.
std::optional<Error> check_ends(const GltfSource& source, const GltfRange& json) {
  if (json.length > kMaxGltfJsonBytes) {
    return gltf_error(ErrorCode::kLimitExceeded, "JSON",
                      "has " + std::to_string(json.length) + " bytes; at most " +
                          std::to_string(kMaxGltfJsonBytes) + " are read",
                      "store the buffers as a GLB or as .bin files");
  }
  if (json.length <= kShortText) return std::nullopt;
  const auto brace = first_mark(source, json, 0);
  if (!brace) return brace.error();
  const auto next = *brace ? first_mark(source, json, **brace + 1) : *brace;
  if (!next) return next.error();
  for (const auto& [at, expected] : {std::pair(*brace, "{"), std::pair(*next, "\"}")}) {
    if (!at) return gltf_invalid("JSON", "has only spaces");
    const auto mark = source.part({json.begin + *at, 1});
    if (!mark) return mark.error();
    source.give_back(*mark);
    if (std::string_view(expected).find(text_of(*mark)) != std::string_view::npos) continue;
    return gltf_invalid("JSON", "byte " + std::to_string(*at) + " is neither a space nor one of " +
                                    expected + ", as it must be in a JSON object");
  }
  const auto last = last_mark(source, json);
  if (!last) return last.error();
  if (*last == '}') return std::nullopt;
  return gltf_invalid("JSON", "does not end with }", "the file may be truncated");
}

std::optional<Error> check_header(const GltfSource& source, std::span<const std::uint8_t> start) {
  if (source.size() < kHeaderBytes) {
    return gltf_invalid("GLB header",
                        "needs 12 bytes; the file has " + std::to_string(source.size()));
  }
  if (const std::uint32_t version = word_at(start, 4); version != 2) {
    return gltf_error(ErrorCode::kUnsupported, "GLB header",
                      "its version is " + std::to_string(version) + "; expected 2",
                      "convert the asset to glTF 2.0");
  }
  if (const std::uint64_t length = word_at(start, 8); length != source.size()) {
    return gltf_invalid("GLB header",
                        "its length is " + std::to_string(length) + " bytes, but the file has " +
                            std::to_string(source.size()),
                        "the file may be truncated");
  }
  return std::nullopt;
}

Result<GltfContainer> find_chunks(const GltfSource& source) {
  std::uint64_t offset = kHeaderBytes;
  const auto json = next_chunk(source, offset, 0);
  if (!json) return json.error();
  if (json->type != kJsonChunk) {
    return gltf_invalid("GLB chunk 0", "is not of type JSON, as the first chunk must be");
  }
  GltfContainer container;
  container.json = json->data;
  const auto start = block_of(source, json->data, 0);
  if (!start) return start.error();
  if (auto error = check_encoding(text_of(*start), container, "JSON")) return *error;
  container.misaligned = json->data.length % 4 != 0;
  for (std::size_t index = 1; offset < source.size(); ++index) {
    if (index == kMaxGltfChunks) {
      return gltf_error(ErrorCode::kLimitExceeded, "GLB",
                        "has more than " + std::to_string(kMaxGltfChunks) + " chunks");
    }
    const auto chunk = next_chunk(source, offset, index);
    if (!chunk) return chunk.error();
    if (chunk->type == kJsonChunk || (chunk->type == kBinChunk && index != 1)) {
      return gltf_invalid("GLB chunk " + std::to_string(index),
                          "repeats the type JSON or BIN, or BIN is not the second chunk");
    }
    if (chunk->type == kBinChunk) container.bin_chunk = chunk->data;
    container.misaligned |= chunk->data.length % 4 != 0;
  }
  if (auto error = check_ends(source, container.json)) return *error;
  return container;
}

Error not_gltf(const GltfSource& source, std::string_view start) {
  if (source.size() == 0) {
    return gltf_error(ErrorCode::kNotGltf, {}, "is empty; expected a glTF 2.0 file, .gltf or .glb");
  }
  std::string problem =
      "begins neither like a GLB container (\"glTF\") nor like a JSON object (\"{\"); expected a "
      "glTF 2.0 file, .gltf or .glb";
  const auto format = known_format(start);
  if (!format) return gltf_error(ErrorCode::kNotGltf, {}, std::move(problem));
  problem += "; it begins like " + std::string(format->name);
  return gltf_error(ErrorCode::kNotGltf, {}, std::move(problem), std::string(format->remedy));
}

}  // namespace

Result<GltfContainer> find_content(const GltfSource& source) {
  const GltfRange whole{0, source.size()};
  const auto block = block_of(source, whole, 0);
  if (!block) return block.error();
  if (block->bytes.size() >= 4 && word_at(block->bytes, 0) == kMagic) {
    if (auto error = check_header(source, block->bytes)) return *error;
    return find_chunks(source);
  }
  const std::string_view start = text_of(*block);
  GltfContainer container;
  container.json = whole;
  if (auto error = check_encoding(start, container, {})) return *error;
  const std::size_t mark = container.byte_order_mark ? whole.length - container.json.length : 0;
  const std::size_t first = start.substr(mark).find_first_not_of(kSpaces);
  if (first == std::string_view::npos ? source.size() <= kBlock : start[mark + first] != '{') {
    return not_gltf(source, start);
  }
  if (first == std::string_view::npos && source.size() <= kMaxGltfJsonBytes) {
    const auto found = first_mark(source, container.json, 0);
    if (!found) return found.error();
    if (!*found) return not_gltf(source, {});
  }
  if (auto error = check_ends(source, container.json)) return *error;
  return container;
}

}  // namespace palpate
