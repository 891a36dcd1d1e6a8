#include "io/gltf/extras.h"

#include <algorithm>
#include <utility>

#include <nlohmann/json.hpp>

#include "io/gltf/error.h"
#include "io/gltf/json.h"

namespace palpate {
namespace {

using Json = nlohmann::json;
using MaybeError = std::optional<Error>;

// Far more than any material needs; they limit the cost of a hostile file.
constexpr std::size_t kMaxKeyLength = 32;
constexpr std::size_t kMaxListLength = 16;
constexpr std::size_t kMaxParameters = 256;

MaybeError read_list(const Json& list, const std::string& element, MaterialValue& value) {
  if (list.size() > kMaxListLength) {
    return gltf_invalid(element, "has " + std::to_string(list.size()) +
                                     " elements; expected a list of at most " +
                                     std::to_string(kMaxListLength) + " numbers");
  }
  std::vector<double> numbers;
  for (const Json& number : list) {
    if (!number.is_number()) {
      return gltf_expected(element + "/" + std::to_string(numbers.size()), number, "a number");
    }
    numbers.push_back(number.get<double>());
  }
  value = std::move(numbers);
  return std::nullopt;
}

MaybeError read_value(const Json& json, const std::string& element, MaterialValue& value) {
  if (json.is_number()) {
    value = json.get<double>();
  } else if (json.is_boolean()) {
    value = json.get<bool>();
  } else if (json.is_string()) {
    value = json.get<std::string>();
  } else if (json.is_array()) {
    return read_list(json, element, value);
  } else {
    return gltf_expected(element, json, "a number, true or false, a string or a list of numbers");
  }
  return std::nullopt;
}

MaybeError check_length(const std::string& key, const std::string& parent_element) {
  if (key.size() <= kMaxKeyLength) return std::nullopt;
  return gltf_invalid(parent_element, "has a key of " + std::to_string(key.size()) + " bytes, " +
                                          in_quotes(key) + "; expected at most " +
                                          std::to_string(kMaxKeyLength));
}

MaybeError check_key(const std::string& key, const std::string& parent_element) {
  if (auto error = check_length(key, parent_element)) return error;
  if (key.find('.') != std::string::npos) {
    return gltf_invalid(parent_element,
                        "has the key " + in_quotes(key) + "; expected a key without a dot",
                        "write \"a\": {\"b\": 1} instead of \"a.b\": 1");
  }
  return std::nullopt;
}

}  // namespace

const Json* find_extras(const Json& object) {
  const auto extras = object.find("extras");
  return extras == object.end() || !extras->is_object() ? nullptr : &*extras;
}

const Json* find_palpate_extras(const Json& object) {
  const Json* extras = find_extras(object);
  if (extras == nullptr) return nullptr;
  const auto palpate = extras->find("palpate");
  return palpate == extras->end() ? nullptr : &*palpate;
}

MaybeError PalpateExtras::read(const Json& object, const std::string& element,
                               std::vector<MaterialParameter>& parameters) {
  const Json* palpate = find_palpate_extras(object);
  if (palpate == nullptr) return std::nullopt;
  const std::string path = element + "/extras/palpate";
  if (!palpate->is_object()) {
    Error error = gltf_expected(path, *palpate, "an object");
    error.hint =
        "write \"palpate\": {\"stiffness\": 400}; in Blender, this is a custom property palpate of "
        "the type Python with the value {\"stiffness\": 400}";
    return error;
  }
  return read_entries(*palpate, path, "", parameters);
}

MaybeError PalpateExtras::read_entries(const Json& object, const std::string& element,
                                       const std::string& prefix,
                                       std::vector<MaterialParameter>& parameters) {
  for (const auto& [key, json] : object.items()) {
    if (auto error = check_key(key, element)) return error;
    const std::string path = element + "/" + key;
    if (json.is_object() && prefix.empty()) {
      if (auto error = read_entries(json, path, key + ".", parameters)) return error;
      continue;
    }
    if (parameters.size() == kMaxParameters) {
      return gltf_invalid(path, "exceeds the number of entries; expected at most " +
                                    std::to_string(kMaxParameters) + " in total");
    }
    if (left_ == 0) {
      return gltf_error(ErrorCode::kLimitExceeded, path,
                        "raises the number of parameters of the asset to more than " +
                            std::to_string(kMaxGltfParameters) + ", the limit");
    }
    --left_;
    MaterialParameter parameter{prefix + key, {}, path};
    if (auto error = read_value(json, path, parameter.value)) return error;
    parameters.push_back(std::move(parameter));
  }
  return std::nullopt;
}

Result<MaterialParameter> parameter_of(const MaterialOverride& setting) {
  const auto as_argument = [](Error error) {
    error.code = ErrorCode::kInvalidArgument;
    return error;
  };
  MaterialParameter parameter{setting.key, setting.value,
                              "`SceneSettings::overrides` " + setting.material + "." + setting.key};
  if (setting.key.empty()) {
    return as_argument(gltf_invalid(parameter.element, "has no key; expected NAME.key=value"));
  }
  if (auto error = check_length(setting.key, parameter.element)) return as_argument(*error);
  const Json json = Json::parse(setting.value, nullptr, false);
  if (json.is_discarded()) return parameter;  // not JSON: plain text
  if (auto error = read_value(json, parameter.element, parameter.value)) {
    return as_argument(*error);
  }
  return parameter;
}

void set_parameter(const MaterialParameter& parameter, std::vector<MaterialParameter>& parameters) {
  const auto same = std::find_if(parameters.begin(), parameters.end(),
                                 [&](const auto& known) { return known.key == parameter.key; });
  if (same != parameters.end()) {
    *same = parameter;
    return;
  }
  const auto next = std::find_if(parameters.begin(), parameters.end(),
                                 [&](const auto& known) { return known.key > parameter.key; });
  parameters.insert(next, parameter);
}

}  // namespace palpate
