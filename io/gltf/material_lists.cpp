#include "io/gltf/material_lists.h"

#include <algorithm>
#include <cstddef>
#include <iterator>

#include <nlohmann/json.hpp>

#include "io/gltf/error.h"
#include "io/gltf/json.h"
#include "io/gltf/limits.h"

namespace palpate {

using Json = nlohmann::json;

Result<const Json*> extension_list(const Json& root, const char* extension, const char* name) {
  const Json* none = nullptr;
  const auto object = find_extension(root, "", extension);
  if (!object) return object.error();
  if (!*object) return none;
  const auto list = (*object)->find(name);
  if (list == (*object)->end()) return none;
  const std::string element = std::string("/extensions/") + extension + "/" + name;
  if (!list->is_array()) return gltf_expected(element, *list, "an array");
  if (list->size() > kMaxGltfHapticMaterials) {
    return gltf_error(ErrorCode::kLimitExceeded, element,
                      "has " + std::to_string(list->size()) + " elements; at most " +
                          std::to_string(kMaxGltfHapticMaterials) + " are read");
  }
  return &*list;
}

void warn_about_others(const Json& object, const std::string& element,
                       std::span<const char* const> known, std::vector<std::string>& warnings) {
  constexpr const char* kOfEvery[] = {"name", "extensions", "extras"};
  std::size_t count = 0;
  std::string first;
  for (const auto& [name, value] : object.items()) {
    const auto is_name = [&text = name](const char* k) { return text == k; };
    if (std::any_of(known.begin(), known.end(), is_name)) continue;
    if (std::any_of(std::begin(kOfEvery), std::end(kOfEvery), is_name)) continue;
    if (++count == 1) first = in_quotes(name);
  }
  if (count == 0) return;
  const std::string more = count > 1 ? " and " + std::to_string(count - 1) + " more" : "";
  warnings.push_back(element + ": has " + first + more + ", which is not used");
}

}  // namespace palpate
