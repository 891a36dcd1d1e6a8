#include "io/gltf/json_memory.h"

#include <algorithm>

namespace palpate {

std::uint64_t parsed_bytes(const JsonScan& scan, std::uint64_t text_bytes) {
  for (const auto* parts : {&scan.long_data, &scan.long_spaces}) {
    for (const JsonTextPart& part : *parts) text_bytes -= part.end - part.begin;
  }
  return text_bytes;
}

MemoryNeed memory_of_json(std::uint64_t text_bytes, const JsonExtent& extent) {
  // Upper bounds; files of 15 to 50,000 objects needed up to 30 % less.
  constexpr std::uint64_t kPerValue = 60;
  constexpr std::uint64_t kPerObject = 600;
  const std::uint64_t bytes = text_bytes + kPerValue * extent.values + kPerObject * extent.objects;
  // A text of only brackets is rejected before the model is built. Real texts need less than 32
  // bytes per byte.
  constexpr std::uint64_t kMostPerByte = 36;
  constexpr std::uint64_t kShort = std::uint64_t{1} << 20;
  const std::uint64_t most = kShort + kMostPerByte * text_bytes;
  // Twice, because tinygltf parses a text of its own.
  return {std::min(bytes, most), std::min(2 * bytes, most)};
}

std::size_t memory_to_destroy(std::uint64_t text_bytes, const JsonExtent& extent) {
  // The list may contain the rest of one array or object and one nested array or object. While it
  // grows, the old list and one of twice its size exist.
  constexpr std::size_t kBytesPerValue = 16;
  constexpr std::size_t kGrowing = 3;
  constexpr std::size_t kMostPerByte = 2;  // per byte of text; only a text of brackets needs more
  return std::min<std::size_t>(2 * kGrowing * kBytesPerValue * extent.largest,
                               kMostPerByte * text_bytes);
}

}  // namespace palpate
