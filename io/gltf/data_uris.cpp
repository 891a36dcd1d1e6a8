#include "io/gltf/data_uris.h"

#include <charconv>
#include <limits>
#include <utility>

#include "io/base64.h"
#include "io/gltf/error.h"

namespace palpate {
namespace {

constexpr std::string_view kBase64Marker = ";base64";
constexpr std::size_t kNotBase64 = std::numeric_limits<std::size_t>::max();  // in place of a size

Error not_base64() {
  return gltf_invalid({}, "the data URI is not valid base64");
}

}  // namespace

GltfDataUris::GltfDataUris(std::string_view text, std::vector<JsonTextPart> data)
    : source_(text), data_(std::move(data)) {}

GltfDataUris::GltfDataUris(std::span<std::uint8_t> text, std::vector<JsonTextPart> data)
    : source_(reinterpret_cast<const char*>(text.data()), text.size()),
      text_(text.data()),
      data_(std::move(data)),
      decoded_bytes_(data_.size()) {}

std::optional<std::size_t> GltfDataUris::number_of(std::string_view uri) const {
  const std::size_t comma = uri.find(',');
  if (comma == std::string_view::npos) return std::nullopt;
  const std::string_view mark = uri.substr(comma + 1);
  std::size_t number = 0;
  if (!mark.starts_with('*')) return std::nullopt;
  const char* const end = mark.data() + mark.size();
  const auto [rest, failed] = std::from_chars(mark.data() + 1, end, number);
  if (failed != std::errc() || rest != end || number >= data_.size()) return std::nullopt;
  return number;
}

Result<GltfSource::Part> GltfDataUris::bytes(std::string_view uri) {
  const std::size_t comma = uri.find(',');
  if (comma == std::string_view::npos || !uri.substr(0, comma).ends_with(kBase64Marker)) {
    return gltf_invalid(
        {}, "the data URI is not marked as base64; expected data:MEDIA/TYPE;base64,...");
  }
  const auto number = number_of(uri);
  if (number && text_ != nullptr) return decoded_in_text(*number);
  const std::string_view data =
      number ? source_.substr(data_[*number].begin, data_[*number].end - data_[*number].begin)
             : uri.substr(comma + 1);
  const auto size = base64_size(data);
  if (!size) return not_base64();
  GltfSource::Part part{FileBytes(*size), {}};
  if (!decode_base64(data, part.storage.data())) return not_base64();
  part.bytes = part.storage.span();
  return part;
}

// Each byte is written behind the digits from which it is decoded. Data that are no base64 are
// destroyed by the attempt, so that a second one must not read them.
Result<GltfSource::Part> GltfDataUris::decoded_in_text(std::size_t number) {
  const JsonTextPart& part = data_[number];
  std::uint8_t* const begin = text_ + part.begin;
  std::optional<std::size_t>& size = decoded_bytes_[number];
  if (!size) {
    const std::string_view data = source_.substr(part.begin, part.end - part.begin);
    size = base64_size(data).value_or(kNotBase64);
    if (*size != kNotBase64 && !decode_base64(data, begin)) size = kNotBase64;
  }
  if (*size == kNotBase64) return not_base64();
  return GltfSource::Part{{}, {begin, *size}};
}

}  // namespace palpate
