#include "io/gltf/json.h"

#include <cmath>

#include <nlohmann/json.hpp>

#include "io/gltf/error.h"

namespace palpate {

using Json = nlohmann::json;

std::optional<std::uint64_t> whole_number(const Json& value) {
  if (value.is_number_unsigned()) {
    const auto whole = value.get<std::uint64_t>();
    return whole <= kMaxGltfWhole ? std::optional(whole) : std::nullopt;
  }
  if (!value.is_number_float()) return std::nullopt;
  const double number = value.get<double>();
  if (!(number >= 0.0) || number > static_cast<double>(kMaxGltfWhole) ||
      std::trunc(number) != number) {
    return std::nullopt;
  }
  return static_cast<std::uint64_t>(number);
}

Error gltf_expected(const std::string& element, const Json& found, const std::string& expected) {
  const std::string text =
      found.is_structured()
          ? (found.is_array() ? "an array" : "an object")
          : found.dump(-1, ' ', false, Json::error_handler_t::replace).substr(0, 60);
  return gltf_invalid(element, "is " + text + "; expected " + expected);
}

Result<const Json*> find_extension(const Json& object, const std::string& parent_element,
                                   const char* name) {
  const Json* none = nullptr;
  const auto extensions = object.find("extensions");
  if (extensions == object.end()) return none;
  const std::string element = parent_element + "/extensions";
  if (!extensions->is_object()) return gltf_expected(element, *extensions, "an object");
  const auto extension = extensions->find(name);
  if (extension == extensions->end()) return none;
  if (!extension->is_object()) return gltf_expected(element + "/" + name, *extension, "an object");
  return &*extension;
}

Result<std::optional<std::size_t>> optional_id(const Json& object, const std::string& element,
                                               const char* property, const char* target,
                                               std::size_t count) {
  const auto value = object.find(property);
  if (value == object.end()) return std::optional<std::size_t>();
  const auto id = whole_number(*value);
  if (!id || *id >= count) {
    return gltf_expected(element + "/" + property, *value,
                         std::string("an index into ") + target + ", which has " +
                             std::to_string(count) + " elements");
  }
  return std::optional<std::size_t>(*id);
}

Result<std::size_t> required_id(const Json& object, const std::string& element,
                                const char* property, const char* target, std::size_t count) {
  const auto id = optional_id(object, element, property, target, count);
  if (!id) return id.error();
  if (!*id) return gltf_invalid(element + "/" + property, "is missing");
  return **id;
}

std::optional<Error> read_number(const Json& object, const std::string& element,
                                 const char* property, double& value) {
  const auto found = object.find(property);
  if (found == object.end()) return std::nullopt;
  if (!found->is_number()) return gltf_expected(element + "/" + property, *found, "a number");
  value = found->get<double>();
  return std::nullopt;
}

std::optional<Error> read_text(const Json& object, const std::string& element, const char* property,
                               std::string& value) {
  const auto found = object.find(property);
  if (found == object.end()) return std::nullopt;
  if (!found->is_string()) return gltf_expected(element + "/" + property, *found, "a string");
  value = found->get<std::string>();
  return std::nullopt;
}

}  // namespace palpate
