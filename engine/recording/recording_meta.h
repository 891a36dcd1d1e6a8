#pragma once

// The keys and values of the table meta.

#include <cstdint>
#include <map>
#include <string>
#include <variant>

namespace palpate {

using MetaValue = std::variant<std::int64_t, double, std::string>;
using RecordingMeta = std::map<std::string, MetaValue>;

}  // namespace palpate
