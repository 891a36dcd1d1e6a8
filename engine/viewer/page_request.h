#pragma once

// The JSON messages of the page.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "geometry/base/result.h"

namespace palpate {

// A flag, a number, a choice, or a list of axes.
using SettingValue = std::variant<bool, double, std::string, std::vector<std::array<double, 3>>>;

struct PageRequest {
  enum class Kind : std::uint8_t { kToken, kSet, kTakeControl, kRearm, kPause, kStart, kStay };
  Kind kind = Kind::kToken;
  std::optional<std::uint64_t> id;  // the page wants an answer with this number
  std::string name;                 // kSet
  SettingValue value;               // kSet; kPause: a flag
  std::string token;                // kToken
};

inline constexpr int kDeepestJson = 8;
inline constexpr std::size_t kMostAxes = 3;

// How deep lists and objects of a text are nested, which need not be JSON.
int nesting_depth(std::string_view text);

// Reads one message:
//   {"type":"token","token":"..."}, {"type":"set","id":1,"name":"a4","value":true},
//   {"type":"take_control","id":2}, {"type":"rearm","id":3}, {"type":"pause","id":4,"value":true},
//   {"type":"start","id":5}, {"type":"stay","id":6}
// Objects and lists may be nested kDeepestJson deep; other keys and other values are an error. id:
// receives the id also of a message with an error, as far as it can be read.
Result<PageRequest> parse_request(std::string_view text, std::optional<std::uint64_t>& id);

}  // namespace palpate
