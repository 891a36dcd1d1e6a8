#pragma once

#include <string_view>

namespace palpate {

// The words of a participant's page in English, as a JSON object of keys and texts
// (page/live_words.json). The page uses them where the server sends no others.
std::string_view live_words_json() noexcept;

}  // namespace palpate
