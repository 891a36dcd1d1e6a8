#include "io/gltf/json_spaces.h"

#include <algorithm>
#include <string>

#include "io/gltf/error.h"
#include "io/gltf/limits.h"

namespace palpate {
namespace {

// A shorter run costs the library less than a part of the list.
constexpr std::size_t kLongRun = 256;

bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

// The end of the string that begins at a quotation mark, after its closing mark.
std::size_t end_of_string(std::string_view text, std::size_t begin) {
  for (std::size_t i = begin + 1; i < text.size(); ++i) {
    if (text[i] == '\\')
      ++i;
    else if (text[i] == '"')
      return i + 1;
  }
  return text.size();
}

}  // namespace

Result<std::vector<JsonTextPart>> long_spaces(std::string_view text) {
  std::vector<JsonTextPart> runs;
  for (std::size_t i = 0; i < text.size();) {
    if (text[i] == '"') {
      const std::size_t end = end_of_string(text, i);
      if (end - i > kMaxGltfStringBytes && !text.substr(i + 1).starts_with("data:")) {
        return gltf_error(ErrorCode::kLimitExceeded, "JSON byte " + std::to_string(i),
                          "begins a string of more than " + std::to_string(kMaxGltfStringBytes) +
                              " bytes, which is no data URI",
                          "remove it from the asset");
      }
      i = end;
    } else if (is_space(text[i])) {
      std::size_t end = i + 1;
      while (end < text.size() && is_space(text[end])) ++end;
      if (end - i >= kLongRun) runs.push_back({i, end - 1});
      i = end;
    } else {
      ++i;
    }
  }
  return runs;
}

}  // namespace palpate
