#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace palpate {

// The number of bytes that a base64 text (RFC 4648, section 4), with or without padding, encodes.
// No value if no base64 text has this length.
std::optional<std::size_t> base64_size(std::string_view text);

// Decodes base64 into base64_size(text) bytes, which may begin where the text begins. Returns false
// if the text is not base64; the bytes are then undefined.
bool decode_base64(std::string_view text, std::uint8_t* bytes);

}  // namespace palpate
