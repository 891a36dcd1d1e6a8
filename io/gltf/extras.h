#pragma once

// extras.palpate: what a file declares for Palpate alone, as keys and values; and the parameters
// that a caller gives beside the file. Nothing is interpreted here. Thread-safe.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "geometry/base/result.h"
#include "io/gltf/limits.h"
#include "io/material_description.h"

namespace palpate {

// What an object of the file has as extras.palpate; null if it has none. Extras may be of any type;
// only those of an object can be meant for Palpate.
const nlohmann::json* find_palpate_extras(const nlohmann::json& object);

// Reads the extras of one asset, of which it bounds the number of parameters.
class PalpateExtras {
 public:
  // Appends the entries of object.extras.palpate, if there are any, in the order of their keys; an
  // entry of an object inside it is "outer.inner", deeper it does not go. element: JSON path of the
  // object. An error if what is there is no object, or a key or a value is none that
  // MaterialParameter can hold, or too long.
  std::optional<Error> read(const nlohmann::json& object, const std::string& element,
                            std::vector<MaterialParameter>& parameters);

 private:
  std::optional<Error> read_entries(const nlohmann::json& object, const std::string& element,
                                    const std::string& prefix,
                                    std::vector<MaterialParameter>& parameters);

  std::size_t left_ = kMaxGltfParameters;
};

// The parameter that an override sets. An error (kInvalidArgument, element
// "`SceneSettings::overrides` NAME.key") if its text is JSON, but neither a number, true, false, a
// text nor a list of numbers; or if the key is empty or too long.
Result<MaterialParameter> parameter_of(const MaterialOverride& setting);

// Puts the parameter in place of the one with its key, or where it belongs by its key.
void set_parameter(const MaterialParameter& parameter, std::vector<MaterialParameter>& parameters);

}  // namespace palpate
