#include "io/gltf/json_memory.h"

#include <algorithm>
#include <array>

#include "io/gltf/limits.h"

namespace palpate {

JsonExtent extent_of_json(std::string_view text) {
  JsonExtent extent;
  std::array<std::uint64_t, kMaxGltfJsonDepth + 1>
      values{};  // so far, of each open array or object
  std::size_t depth = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
      continue;
    }
    if (c == '"') in_string = true;
    if (c == '{') ++extent.objects;
    if ((c == '{' || c == '[') && depth + 1 < values.size()) values[++depth] = 1;
    if (c == ',') ++values[depth];
    if ((c == '}' || c == ']') && depth > 0) {
      extent.values += values[depth];
      extent.largest = std::max(extent.largest, values[depth]);
      --depth;
    }
  }
  return extent;
}

MemoryNeed memory_of_json(std::string_view text, const JsonExtent& extent) {
  // Upper bounds; files of 15 to 50,000 objects needed up to 30 % less.
  constexpr std::uint64_t kPerValue = 60;
  constexpr std::uint64_t kPerObject = 600;
  const std::uint64_t bytes = text.size() + kPerValue * extent.values + kPerObject * extent.objects;
  // A text of only brackets is rejected before the model is built. Real texts need less than 32
  // bytes per byte.
  constexpr std::uint64_t kMostPerByte = 36;
  constexpr std::uint64_t kShort = std::uint64_t{1} << 20;
  const std::uint64_t most = kShort + kMostPerByte * text.size();
  // Twice, because tinygltf parses a text of its own.
  return {std::min(bytes, most), std::min(2 * bytes, most)};
}

std::size_t memory_to_destroy(std::string_view text, const JsonExtent& extent) {
  // The list may contain the rest of one array or object and one nested array or object. While it
  // grows, the old list and one of twice its size exist.
  constexpr std::size_t kBytesPerValue = 16;
  constexpr std::size_t kGrowing = 3;
  constexpr std::size_t kMostPerByte = 2;  // per byte of text; only a text of brackets needs more
  return std::min<std::size_t>(2 * kGrowing * kBytesPerValue * extent.largest,
                               kMostPerByte * text.size());
}

}  // namespace palpate
