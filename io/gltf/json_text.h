#pragma once

// The JSON of a glTF asset, from its text.

#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "geometry/base/result.h"

namespace palpate {

// Parses UTF-8 without a byte order mark, which check_json_size() has admitted. Zero bytes behind
// the text, with which some exporters fill their GLB, are passed over. Where an object has a key
// more than once, the last one counts, as in JavaScript, and that is a warning by the path of the
// key. Error::element is "JSON". Thread-safe.
Result<nlohmann::json> parse_gltf_json(std::string_view text, std::vector<std::string>& warnings);

}  // namespace palpate
