#pragma once

// Parses the JSON of a glTF asset.

#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "geometry/base/result.h"
#include "io/gltf/json_scan.h"

namespace palpate {

// Parses text that has passed scan_json(), which gave `scan`. The text must be UTF-8 without a byte
// order mark. Zero bytes after the text, with which some exporters pad their GLB, are ignored. If
// an object repeats a key, the last value is used, as in JavaScript, and a warning names the path
// of the key. JsonScan::long_data are replaced by GltfDataUris::mark(). Error::element is "JSON".
// Thread-safe.
Result<nlohmann::json> parse_gltf_json(std::string_view text, const JsonScan& scan,
                                       std::vector<std::string>& warnings);

}  // namespace palpate
