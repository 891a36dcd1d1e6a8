#pragma once

// extras.palpate: the keys and values that a file declares for Palpate, and the parameters that a
// caller sets outside the file. The values are not interpreted here. Thread-safe.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "geometry/base/result.h"
#include "io/gltf/limits.h"
#include "io/material_description.h"

namespace palpate {

// The extras of an object of the file; null if absent or not an object. Extras may have any type;
// only an object can contain members for Palpate.
const nlohmann::json* find_extras(const nlohmann::json& object);

// The member extras.palpate of an object of the file; null if absent.
const nlohmann::json* find_palpate_extras(const nlohmann::json& object);

// Reads the extras of one asset and limits the number of their parameters.
class PalpateExtras {
 public:
  // Appends the entries of object.extras.palpate, if any, in the order of their keys. An entry of a
  // nested object has the key "outer.inner"; deeper nesting is an error. element: JSON path of the
  // object. An error if palpate is not an object, or if MaterialParameter cannot represent a key or
  // a value, or if either is too long.
  std::optional<Error> read(const nlohmann::json& object, const std::string& element,
                            std::vector<MaterialParameter>& parameters);

 private:
  std::optional<Error> read_entries(const nlohmann::json& object, const std::string& element,
                                    const std::string& prefix,
                                    std::vector<MaterialParameter>& parameters);

  std::size_t left_ = kMaxGltfParameters;
};

// The parameter that an override sets. An error (kInvalidArgument, element
// "`SceneSettings::overrides` NAME.key") if the key is empty or too long, or if the value is JSON
// other than a number, a boolean, a string or a list of numbers.
Result<MaterialParameter> parameter_of(const MaterialOverride& setting);

// Replaces the parameter with the same key, or inserts the parameter in the order of the keys.
void set_parameter(const MaterialParameter& parameter, std::vector<MaterialParameter>& parameters);

}  // namespace palpate
