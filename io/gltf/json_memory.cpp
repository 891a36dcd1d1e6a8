#include "io/gltf/json_memory.h"

#include <algorithm>
#include <array>

#include "io/gltf/limits.h"

namespace palpate {

JsonExtent extent_of_json(std::string_view text) {
  JsonExtent extent;
  std::array<std::uint64_t, kMaxGltfJsonDepth + 1> values{};  // so far, of what is open
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
  // Measured on files of 15 to 50,000 objects: from these bounds to 30 % less.
  constexpr std::uint64_t kPerValue = 60;
  constexpr std::uint64_t kPerObject = 600;
  const std::uint64_t bytes = text.size() + kPerValue * extent.values + kPerObject * extent.objects;
  // What is all brackets is refused before it is a model. Real texts stay below 32 bytes a byte.
  constexpr std::uint64_t kMostPerByte = 36;
  constexpr std::uint64_t kShort = std::uint64_t{1} << 20;
  const std::uint64_t most = kShort + kMostPerByte * text.size();
  // Twice: tinygltf parses a text of its own.
  return {std::min(bytes, most), std::min(2 * bytes, most)};
}

std::size_t memory_to_destroy(std::string_view text, const JsonExtent& extent) {
  // The list may hold the rest of one array or object, and one of those in it; it grows to double
  // its size while it has the old one.
  constexpr std::size_t kBytesPerValue = 16;
  constexpr std::size_t kGrowing = 3;
  constexpr std::size_t kMostPerByte = 2;  // of the text: only one of brackets would take more
  return std::min<std::size_t>(2 * kGrowing * kBytesPerValue * extent.largest,
                               kMostPerByte * text.size());
}

}  // namespace palpate
