#include "io/gltf/json_scan.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <optional>
#include <string>
#include <utility>

#include "io/gltf/error.h"
#include "io/gltf/limits.h"

namespace palpate {
namespace {

// A shorter run of spaces costs the JSON library less than a part of the list.
constexpr std::size_t kLongRun = 256;

// Less data of data URIs than this stay in the text that is parsed, so that messages of the parser
// have the right column.
constexpr std::size_t kFewData = std::size_t{1} << 20;

constexpr std::string_view kDataUri = "data:";

// A byte that stands for itself in a JSON string.
bool is_plain(char c) {
  return (c >= ' ') & (c <= '~') & (c != '"') & (c != '\\');
}

// The memory of each value in the JSON library, as it is with the containers and the allocator of
// the GNU C++ library.
constexpr std::uint64_t kArrayItemBytes = 32;  // 16, and as many that the array keeps free
constexpr std::uint64_t kMemberBytes = 96;     // a node of a tree, with the key and the value
constexpr std::uint64_t kArrayBytes = 32;
constexpr std::uint64_t kObjectBytes = 64;
constexpr std::uint64_t kStringBytes = 48;
constexpr std::size_t kLongString = 15;         // a longer one has its text elsewhere
constexpr std::uint64_t kAllocationBytes = 16;  // beside that text

// An element of the lists of glTF, such as a node, a mesh or a material, may take this much in
// addition to kMaxGltfJsonMemory: as much as a node of a dozen keys.
constexpr std::uint64_t kElementBytes = 1200;

bool is_section(std::string_view key_in_quotes) {
  constexpr std::string_view kSections[] = {
      "\"accessors\"", "\"animations\"", "\"bufferViews\"", "\"buffers\"", "\"cameras\"",
      "\"images\"",    "\"materials\"",  "\"meshes\"",      "\"nodes\"",   "\"samplers\"",
      "\"scenes\"",    "\"skins\"",      "\"textures\""};
  return std::find(std::begin(kSections), std::end(kSections), key_in_quotes) !=
         std::end(kSections);
}

class JsonScanner {
 public:
  explicit JsonScanner(std::string_view text) : text_(text) {}

  Result<JsonScan> scan() {
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == '"') {
        if (auto error = skip_string()) return *error;
      } else if (is_json_space(c)) {
        skip_spaces();
      } else {
        if (c == ',' || c == '[' || c == '{') {
          if (auto error = count_value(c)) return *error;
        }
        if (c == ']' || c == '}') close();
        ++at_;
      }
    }
    while (depth_ > 0) close();  // of a text that is cut off
    if (auto error = check_memory()) return *error;
    std::size_t data_bytes = 0;
    for (const JsonTextPart& part : scan_.long_data) data_bytes += part.end - part.begin;
    if (data_bytes < kFewData) scan_.long_data.clear();
    return std::move(scan_);
  }

 private:
  struct Level {
    std::uint64_t values;  // so far
    bool is_object;
    std::uint64_t bytes_before;  // JsonExtent::bytes at its begin
  };

  // The error for the place that is examined.
  Error beyond_limit(const std::string& problem, const std::string& hint = {}) const {
    return gltf_error(ErrorCode::kLimitExceeded, "JSON byte " + std::to_string(at_), problem, hint);
  }

  void skip_spaces() {
    const std::size_t end = first_json_mark(text_, at_ + 1);
    if (end - at_ >= kLongRun) scan_.long_spaces.push_back({at_, end - 1});
    at_ = end;
  }

  // If a string that is a data URI with long data begins here, notes the data and returns
  // the closing quote; otherwise returns the first byte of the string.
  std::size_t skip_data() {
    constexpr std::size_t kLongestType = 128;  // media type and parameters
    const std::size_t begin = at_ + 1;
    if (!text_.substr(begin).starts_with(kDataUri)) return begin;
    const std::size_t comma = text_.substr(begin, kLongestType).find_first_of(",\"\\");
    if (comma == text_.npos || text_[begin + comma] != ',') return begin;
    const std::size_t data = begin + comma + 1;
    const std::size_t end = first_json_byte(text_, data, [](char c) { return !is_plain(c); });
    if (end >= text_.size() || text_[end] != '"') return begin;
    // Short data stay in the string, unless they could be mistaken for GltfDataUris::mark().
    if (end - data < kLongRun && text_[data] != '*') return begin;
    scan_.long_data.push_back({data, end});
    return end;
  }

  std::optional<Error> skip_string() {
    const std::size_t begin = skip_data();
    std::size_t end = begin;
    for (; end < text_.size(); ++end) {
      end = first_json_byte(text_, end, [](char c) { return (c == '"') | (c == '\\'); });
      if (end >= text_.size() || text_[end] == '"') break;
      ++end;  // what follows the backslash
    }
    end = std::min(end + 1, text_.size());
    if (end - at_ > kMaxGltfStringBytes && !text_.substr(at_ + 1).starts_with(kDataUri)) {
      return beyond_limit("begins a string of more than " + std::to_string(kMaxGltfStringBytes) +
                              " bytes, which is no data URI",
                          "remove it from the asset");
    }
    string_bytes_ += end - begin;
    if (string_bytes_ > kMaxGltfStringBytesInAll) {
      return beyond_limit("brings the strings together to more than " +
                              std::to_string(kMaxGltfStringBytesInAll) +
                              " bytes; the data of data URIs without a backslash do not count",
                          "shorten names and extras");
    }
    const std::string_view string = text_.substr(at_, end - at_);
    // A key has no memory of its own beside that of its member, unless it is long.
    const std::size_t colon = first_json_mark(text_, end);
    const bool is_key = colon < text_.size() && text_[colon] == ':';
    if (!is_key) scan_.extent.bytes += kStringBytes;
    if (is_key && depth_ == 1) {
      is_in_section_ = is_section(string);
      counted_list_ = string == "\"nodes\""        ? &scan_.nodes
                      : string == "\"scenes\""     ? &scan_.scenes
                      : string == "\"animations\"" ? &scan_.animations
                                                   : nullptr;
    }
    if (end - at_ > kLongString + 2) {
      scan_.extent.bytes += kAllocationBytes;
    }
    at_ = end;
    return std::nullopt;
  }

  // At a comma or an opening bracket.
  std::optional<Error> count_value(char c) {
    if (++counted_ > kMaxGltfJsonValues) {
      return beyond_limit("has more than " + std::to_string(kMaxGltfJsonValues) + " values");
    }
    if (c == ',') {
      ++levels_[depth_].values;
      return std::nullopt;
    }
    if (depth_ == kMaxGltfJsonDepth) {
      return beyond_limit("nests deeper than " + std::to_string(kMaxGltfJsonDepth) + " levels");
    }
    const bool is_object = c == '{';
    scan_.extent.objects += is_object ? 1 : 0;
    const std::uint64_t bytes_before = scan_.extent.bytes;
    scan_.extent.bytes += is_object ? kObjectBytes : kArrayBytes;
    levels_[++depth_] = {1, is_object, bytes_before};
    return std::nullopt;
  }

  void close() {
    if (depth_ == 0) return;
    JsonExtent& extent = scan_.extent;
    const Level& level = levels_[depth_--];
    extent.values += level.values;
    extent.largest = std::max(extent.largest, level.values);
    extent.bytes += level.values * (level.is_object ? kMemberBytes : kArrayItemBytes);
    if (depth_ != 2 || !is_in_section_) return;
    bytes_of_elements_ += std::min(extent.bytes - level.bytes_before, kElementBytes);
    if (counted_list_ != nullptr && level.is_object) ++*counted_list_;
  }

  std::optional<Error> check_memory() const {
    const std::uint64_t bytes = scan_.extent.bytes - bytes_of_elements_;
    if (bytes <= kMaxGltfJsonMemory) return std::nullopt;
    return gltf_error(ErrorCode::kLimitExceeded, "JSON",
                      "needs about " + std::to_string(bytes >> 20) +
                          " MiB of memory for values beside the usual "
                          "ones of glTF, such as extras; at most " +
                          std::to_string(kMaxGltfJsonMemory >> 20) + " MiB are used",
                      "remove large extras from the asset, or store them in a file beside it");
  }

  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t counted_ = 1;
  std::size_t depth_ = 0;
  std::size_t string_bytes_ = 0;
  bool is_in_section_ = false;           // whether the last key of the root is a section
  std::uint64_t bytes_of_elements_ = 0;  // the part of JsonExtent::bytes that sections may have
  std::array<Level, kMaxGltfJsonDepth + 1> levels_{};  // the open arrays and objects
  JsonScan scan_;
  std::size_t* counted_list_ = nullptr;  // the count for the last key of the root
};

}  // namespace

Result<JsonScan> scan_json(std::string_view text) {
  if (text.size() > kMaxGltfJsonBytes) {
    return gltf_error(ErrorCode::kLimitExceeded, "JSON",
                      "has " + std::to_string(text.size()) + " bytes; at most " +
                          std::to_string(kMaxGltfJsonBytes) + " are read",
                      "store the buffers as a GLB or as .bin files");
  }
  return JsonScanner(text).scan();
}

}  // namespace palpate
