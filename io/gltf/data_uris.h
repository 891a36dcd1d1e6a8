#pragma once

// The data URIs of one glTF asset. Long base64 data stay in the text of the JSON, and are decoded
// where they are: a copy in the parsed JSON and one of the decoded bytes would take more memory
// than the file.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/base/result.h"
#include "io/gltf/json_spaces.h"
#include "io/gltf/source.h"

namespace palpate {

// Not thread-safe; one per call of read_gltf().
class GltfDataUris {
 public:
  GltfDataUris() = default;
  // data: JsonScan::long_data of the text, which must outlive this object.
  GltfDataUris(std::string_view text, std::vector<JsonTextPart> data);
  // The same, for a text that the data may be decoded into. Its other bytes stay as they are.
  GltfDataUris(std::span<std::uint8_t> text, std::vector<JsonTextPart> data);

  // What parse_gltf_json() writes in the place of long data. No base64 begins like it.
  static std::string mark(std::size_t number) { return "*" + std::to_string(number); }

  static bool is_data_uri(std::string_view uri) { return uri.starts_with("data:"); }

  // Whether bytes() needs no memory for this data URI.
  bool is_in_text(std::string_view uri) const { return text_ != nullptr && number_of(uri); }

  // The content of a data URI (base64, any media type). The bytes are valid as long as the part and
  // this object. Error::element is empty.
  Result<GltfSource::Part> bytes(std::string_view uri);

 private:
  // The number of the data of which this URI has a mark.
  std::optional<std::size_t> number_of(std::string_view uri) const;
  Result<GltfSource::Part> decoded_in_text(std::size_t number);

  std::string_view source_;
  std::uint8_t* text_ = nullptr;  // null: the text must not be changed
  std::vector<JsonTextPart> data_;
  std::vector<std::optional<std::size_t>> decoded_bytes_;  // of data decoded in the text
};

}  // namespace palpate
