#include "engine/live/live_request.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "engine/viewer/page_request.h"

namespace palpate {
namespace {

using Message = nlohmann::json;

constexpr std::uint64_t kMostId = std::uint64_t{1} << 53;
constexpr std::size_t kMostTextBytes = 4000;
constexpr std::size_t kMostTimes = 100;
constexpr double kLongestTime_ms = 1e9;  // 11 days after the page was opened
constexpr std::size_t kMostAnswers = 10;

enum class Value : std::uint8_t {
  kText,
  kFlag,
  kWhole,
  kNumber,
  kTimes,
  kTexts,
  kFlagOrNull,
  kNumberOrNull,
  kRatings
};

struct KeyRule {
  std::string_view name;
  Value value;
};

struct TypeRule {
  std::string_view name;
  PageRole role;
  std::array<KeyRule, 9> keys = {};  // up to the first without a name
};

// A trial may end while somebody makes up their mind: they say which one they mean.
constexpr std::array<KeyRule, 9> kWhichTrial = {
    {{"block", Value::kWhole}, {"place", Value::kWhole}, {"attempt", Value::kWhole}}};

constexpr std::array kTypes = {
    TypeRule{"next", kParticipantPage, {{{"step", Value::kText}}}},
    TypeRule{"consent", kParticipantPage, {{{"value", Value::kFlag}}}},
    TypeRule{"about", kParticipantPage, {{{"answers", Value::kTexts}}}},
    TypeRule{"rated", kParticipantPage, {{{"answers", Value::kRatings}}}},
    TypeRule{"checked",
             kParticipantPage,
             {{{"input", Value::kText},
               {"motion", Value::kText},
               {"css_px_per_mm", Value::kNumber},
               {"device_pixel_ratio", Value::kNumber},
               {"width_px", Value::kNumber},
               {"height_px", Value::kNumber},
               {"refresh_Hz", Value::kNumber},
               {"unadjusted", Value::kFlagOrNull},
               {"stroke_ratio", Value::kNumberOrNull}}}},
    TypeRule{"ready", kParticipantPage, {{{"trial", Value::kWhole}}}},
    TypeRule{"left", kParticipantPage, {{{"why", Value::kText}}}},
    TypeRule{"frames", kParticipantPage, {{{"times_ms", Value::kTimes}}}},
    TypeRule{"pause", kParticipantPage},
    TypeRule{"go_on", kParticipantPage},
    TypeRule{"stop", kParticipantPage, {{{"keep", Value::kFlag}}}},
    TypeRule{"note", kExperimenterPage, {{{"text", Value::kText}}}},
    TypeRule{"pause", kExperimenterPage},
    TypeRule{"go_on", kExperimenterPage},
    TypeRule{"repeat", kExperimenterPage},
    TypeRule{"skip", kExperimenterPage, kWhichTrial},
    TypeRule{"rearm", kExperimenterPage},
    TypeRule{"abort", kExperimenterPage, kWhichTrial},
};

Error refused(std::string element, std::string problem) {
  return invalid_argument(std::move(element), std::move(problem));
}

bool is_number(const Message& json) {
  return json.is_number() && std::isfinite(json.get<double>());
}

bool is_time(const Message& json) {
  if (!is_number(json)) return false;
  const double time_ms = json.get<double>();
  return time_ms >= 0.0 && time_ms <= kLongestTime_ms;
}

bool is_text(const Message& json) {
  return json.is_string() && json.get_ref<const std::string&>().size() <= kMostTextBytes;
}

bool fits(const Message& json, Value value) {
  switch (value) {
    case Value::kText:
      return is_text(json);
    case Value::kFlag:
      return json.is_boolean();
    case Value::kWhole:
      return json.is_number_unsigned() && json.get<std::uint64_t>() <= kMostId;
    case Value::kNumber:
      return is_number(json);
    case Value::kTimes:
      return json.is_array() && json.size() <= kMostTimes &&
             std::all_of(json.begin(), json.end(), is_time) &&
             std::is_sorted(json.begin(), json.end());
    case Value::kTexts:
      return json.is_object() && json.size() <= kMostAnswers &&
             std::all_of(json.begin(), json.end(), is_text);
    case Value::kRatings:
      return json.is_object() && json.size() <= kMostAnswers &&
             std::all_of(json.begin(), json.end(),
                         [](const Message& rating) { return fits(rating, Value::kWhole); });
    case Value::kFlagOrNull:
      return json.is_null() || json.is_boolean();
    case Value::kNumberOrNull:
      return json.is_null() || is_number(json);
  }
  return false;
}

std::optional<Error> check_keys(const Message& json, const TypeRule& type) {
  const auto end = std::find_if(type.keys.begin(), type.keys.end(),
                                [](const KeyRule& key) { return key.name.empty(); });
  const std::span keys(type.keys.begin(), end);
  for (const auto& item : json.items()) {
    const auto is_named = [&](const KeyRule& key) { return key.name == item.key(); };
    if (item.key() == "type" || item.key() == "id" ||
        std::any_of(keys.begin(), keys.end(), is_named)) {
      continue;
    }
    return refused("message", "has the unknown key \"" + item.key() + "\"");
  }
  for (const KeyRule& key : keys) {
    const std::string name(key.name);
    if (!json.contains(name)) return refused("message", "lacks the key \"" + name + "\"");
    if (!fits(json[name], key.value)) return refused(name, "has a value of another type or size");
  }
  return std::nullopt;
}

}  // namespace

Result<LiveRequest> parse_live_request(PageRole role, std::string_view text,
                                       std::optional<std::uint64_t>& id) {
  id.reset();
  if (nesting_depth(text) > kDeepestJson) {
    return refused("message", "is nested deeper than " + std::to_string(kDeepestJson));
  }
  LiveRequest request{role, {}, {}, Message::parse(text, nullptr, /* allow_exceptions = */ false)};
  if (!request.body.is_object()) return refused("message", "is not a JSON object");
  if (request.body.contains("id")) {
    if (!fits(request.body["id"], Value::kWhole)) {
      return refused("id", "is not a whole number from 0 to 2^53");
    }
    id = request.id = request.body["id"].get<std::uint64_t>();
  }
  const auto type = request.body.find("type");
  if (type == request.body.end() || !type->is_string()) return refused("type", "is missing");
  request.type = type->get<std::string>();
  const auto known = std::find_if(kTypes.begin(), kTypes.end(), [&](const TypeRule& t) {
    return t.role == role && t.name == request.type;
  });
  if (known == kTypes.end()) return refused("type", "is unknown, or of another role");
  if (auto error = check_keys(request.body, *known)) return *error;
  return request;
}

std::string answer_text(std::optional<std::uint64_t> id,
                        const std::optional<std::string>& problem) {
  nlohmann::ordered_json json = {
      {"type", "answer"}, {"id", id ? Message(*id) : Message()}, {"ok", !problem}};
  if (problem) json["problem"] = *problem;
  return json.dump(-1, ' ', false, Message::error_handler_t::replace);
}

}  // namespace palpate
