#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace palpate {

// Decodes base64 (RFC 4648, section 4), with or without padding. Returns no value if the text is
// not base64.
std::optional<std::vector<std::uint8_t>> base64_decoded(std::string_view text);

}  // namespace palpate
