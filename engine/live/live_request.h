#pragma once

// The JSON messages of the pages of `experiment live`.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include "engine/viewer/view_model.h"
#include "geometry/base/result.h"

namespace palpate {

// The experimenter's page is the second role of the server.
inline constexpr PageRole kParticipantPage = kMainPage;
inline constexpr PageRole kExperimenterPage = 1;

struct LiveRequest {
  PageRole role = kParticipantPage;
  std::string type;
  std::optional<std::uint64_t> id;  // the page wants an answer with this number
  nlohmann::json body;              // an object with exactly the keys of its type
};

// The types of messages, their keys and whose they are: kTypes in live_request.cpp. Errors: no JSON
// object, deep nesting, a type of another role, a missing or unknown key, a value of another type,
// a text or a list that is too long. id: receives the id also of a message with an error, as far as
// it can be read.
Result<LiveRequest> parse_live_request(PageRole role, std::string_view text,
                                       std::optional<std::uint64_t>& id);

// {"type": "answer", "id": ..., "ok": ..., "problem": ...} in one line.
std::string answer_text(std::optional<std::uint64_t> id, const std::optional<std::string>& problem);

}  // namespace palpate
