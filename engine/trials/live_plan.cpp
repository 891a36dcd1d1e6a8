#include "engine/trials/live_plan.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "geometry/base/quoted.h"

namespace palpate {
namespace {

using Json = nlohmann::json;
using Key = ObjectReader::Key;

constexpr std::size_t kMostWords = 1000;
constexpr std::size_t kMostWordBytes = 2000;
constexpr std::size_t kMostLanguageBytes = 35;  // RFC 5646, 4.4.1

Error live_error(std::string element, std::string problem, std::string hint = {}) {
  return {ErrorCode::kInvalidContent, "", std::move(element), std::move(problem), std::move(hint)};
}

// UTF-8 in which no control character stands but newline and tab.
bool is_prose(const std::string& text) {
  const Json json(text);
  const bool is_utf8 = json.dump(-1, ' ', false, Json::error_handler_t::replace) ==
                       json.dump(-1, ' ', false, Json::error_handler_t::ignore);
  return is_utf8 && std::none_of(text.begin(), text.end(), [](char c) {
           return (c >= 0 && c < ' ' && c != '\n' && c != '\t' && c != '\r') || c == 0x7f;
         });
}

bool is_blank(const std::string& text) {
  return text.find_first_not_of(" \t\r\n") == std::string::npos;
}

Result<std::string> text_of_file(const Json& value, const std::string& element,
                                 const std::string& folder) {
  std::string name;
  ObjectReader reader(value, element);
  reader.text("file", name, Key::kRequired, kMostProseBytes);
  if (auto error = reader.finish()) return *error;
  return read_settings_text((std::filesystem::path(folder) / name).string(), kMostLiveTextBytes);
}

Result<std::string> read_text(const Json& value, const std::string& element,
                              const std::string& folder) {
  if (!value.is_string() && !value.is_object()) {
    return unexpected_value(element, value, "a text, or {\"file\": \"consent.txt\"}");
  }
  auto text = value.is_string() ? Result<std::string>(value.get<std::string>())
                                : text_of_file(value, element, folder);
  if (!text) return text.error();
  if (is_blank(*text)) return live_error(element, "is empty; expected a text");
  if (!is_prose(*text)) {
    return live_error(element,
                      "is no text; expected UTF-8 without control characters but newline and tab");
  }
  return text;
}

void read_texts(ObjectReader& reader, const std::string& folder, LivePlan& live) {
  const Json* const found = reader.find("texts");
  if (!found) return;
  const std::string element = reader.element_of("texts");
  ObjectReader texts(*found, element);
  for (std::size_t i = 0; i < kLiveTextCount; ++i) {
    const std::string name(kLiveTextNames[i]);
    const Json* const value = texts.find(name.c_str());
    if (!value) continue;
    auto text = read_text(*value, texts.element_of(name), folder);
    if (!text) return reader.fail(text.error());
    live.texts[i] = std::move(*text);
  }
  if (const auto error = texts.finish()) reader.fail(*error);
}

void read_words(ObjectReader& reader, LivePlan& live) {
  const Json* const found = reader.find("words", Key::kOptional);
  if (!found) return;
  const std::string element = reader.element_of("words");
  if (!found->is_object() || found->size() > kMostWords) {
    return reader.fail(
        unexpected_value(element, *found, "an object with a text for each word of the page"));
  }
  for (const auto& [key, value] : found->items()) {
    const bool is_word = value.is_string() &&
                         value.get_ref<const std::string&>().size() <= kMostWordBytes &&
                         !is_blank(value.get_ref<const std::string&>()) &&
                         is_prose(value.get_ref<const std::string&>());
    if (!is_word) {
      return reader.fail(unexpected_value(
          element + "/" + key, value,
          "a text of at most " + std::to_string(kMostWordBytes) + " bytes that is not blank"));
    }
    live.words[key] = value.get<std::string>();
  }
}

void read_language(ObjectReader& reader, LivePlan& live) {
  reader.text("language", live.language, Key::kOptional, kMostLanguageBytes);
  const bool is_tag = std::all_of(live.language.begin(), live.language.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-';
  });
  if (reader.ok() && !is_tag) {
    reader.fail(live_error(
        reader.element_of("language"),
        "is " + in_quotes(live.language) + "; expected a tag of a language, such as en or pt-BR"));
  }
  std::size_t direction = 0;
  reader.choice("direction", direction, {"ltr", "rtl"}, Key::kOptional);
  live.is_right_to_left = direction == 1;
}

void read_about(ObjectReader& reader, LivePlan& live) {
  if (!reader.find("about", Key::kOptional)) return;
  std::vector<std::size_t> asked;
  reader.choices("about", asked, {kAboutNames.begin(), kAboutNames.end()});
  for (const std::size_t place : asked) live.about.emplace_back(kAboutNames[place]);
}

// A force that a pointer cannot render is seen on a hand that the plan states.
void read_force(ObjectReader& reader, LivePlan& live) {
  std::size_t unused = 0;
  const bool is_seen = reader.find("force", Key::kOptional) != nullptr;
  if (is_seen) reader.choice("force", unused, {"seen"});
  const Json* const grip = reader.find("grip", is_seen ? Key::kRequired : Key::kOptional);
  if (!reader.ok() || (!grip && !is_seen)) return;
  if (!is_seen) {
    return reader.fail(live_error(reader.element_of("grip"),
                                  "is of a plan with \"force\": \"seen\"; expected no grip",
                                  "leave it out, or state \"force\": \"seen\" beside it"));
  }
  if (live.input != PlanInput::kPointer) {
    return reader.fail(live_error(reader.element_of("force"),
                                  "is seen, but the input is board, whose force is felt; expected "
                                  "no force",
                                  "leave force and grip out, or state \"mouse\" in input"));
  }
  HandImpedance hand;
  ObjectReader numbers(*grip, reader.element_of("grip"));
  numbers.number("stiffness_N_per_m", hand.stiffness_N_per_m, kGripStiffnessRange_N_per_m);
  numbers.number("damping_Ns_per_m", hand.damping_Ns_per_m, kGripDampingRange_Ns_per_m);
  numbers.number("mass_kg", hand.mass_kg, kGripMassRange_kg);
  if (const auto error = numbers.finish()) return reader.fail(*error);
  live.grip = hand;
}

// A board's own place is what its limits, the governor and its workspace go by.
void read_clutch(ObjectReader& reader, LivePlan& live) {
  reader.flag("clutch", live.permits_clutch, Key::kOptional);
  if (!reader.ok() || !live.permits_clutch || live.input == PlanInput::kPointer) return;
  reader.fail(live_error(reader.element_of("clutch"),
                         "is true with a board, whose place cannot be set back; expected false",
                         "choose a scale at which the strokes fit the workspace"));
}

}  // namespace

Result<LivePlan> read_live_plan(const Json& object, const std::string& element,
                                const std::string& folder) {
  LivePlan live;
  ObjectReader reader(object, element);
  std::size_t input = 0;
  reader.choice("input", input, {kPlanInputNames.begin(), kPlanInputNames.end()});
  live.input = static_cast<PlanInput>(input);
  read_force(reader, live);
  read_texts(reader, folder, live);
  read_words(reader, live);
  read_language(reader, live);
  reader.number("scale", live.scale, kDisplayScaleRange, Key::kOptional);
  reader.number("break_s", live.break_s, kBreakRange_s, Key::kOptional);
  read_about(reader, live);
  reader.flag("questionnaire", live.has_questionnaire, Key::kOptional);
  read_clutch(reader, live);
  reader.flag("blind", live.is_blind, Key::kOptional);
  reader.number("longest_picture_s", live.longest_picture_s, kLongestPictureRange_s,
                Key::kOptional);
  reader.number("longest_lateness_s", live.longest_lateness_s, kLongestLatenessRange_s,
                Key::kOptional);
  if (auto error = reader.finish()) return *error;
  return live;
}

}  // namespace palpate
