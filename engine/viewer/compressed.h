#pragma once

#include <string>
#include <string_view>

namespace palpate {

// The bytes in the format gzip, as browsers accept it. The same bytes give the same result.
std::string gzip_compressed(std::string_view bytes);

}  // namespace palpate
