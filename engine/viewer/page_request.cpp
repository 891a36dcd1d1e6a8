#include "engine/viewer/page_request.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <utility>

#include <nlohmann/json.hpp>

namespace palpate {
namespace {

using Message = nlohmann::json;

// The page counts its requests; its numbers are exact up to here.
constexpr std::uint64_t kMostId = std::uint64_t{1} << 53;

constexpr std::array<std::pair<std::string_view, PageRequest::Kind>, 7> kTypes = {{
    {"token", PageRequest::Kind::kToken},
    {"set", PageRequest::Kind::kSet},
    {"take_control", PageRequest::Kind::kTakeControl},
    {"rearm", PageRequest::Kind::kRearm},
    {"pause", PageRequest::Kind::kPause},
    {"start", PageRequest::Kind::kStart},
    {"stay", PageRequest::Kind::kStay},
}};

Error refused(std::string element, std::string problem) {
  return invalid_argument(std::move(element), std::move(problem));
}

std::optional<double> finite_number(const Message& json) {
  if (!json.is_number()) return std::nullopt;
  const double number = json.get<double>();
  if (!std::isfinite(number)) return std::nullopt;
  return number;
}

std::optional<std::array<double, 3>> axis_of(const Message& json) {
  std::array<double, 3> axis{};
  if (!json.is_array() || json.size() != axis.size()) return std::nullopt;
  for (std::size_t k = 0; k < axis.size(); ++k) {
    const auto number = finite_number(json[k]);
    if (!number) return std::nullopt;
    axis[k] = *number;
  }
  return axis;
}

Result<SettingValue> value_of(const Message& json) {
  if (json.is_boolean()) return SettingValue(json.get<bool>());
  if (const auto number = finite_number(json)) return SettingValue(*number);
  if (json.is_string()) return SettingValue(json.get<std::string>());
  std::vector<std::array<double, 3>> axes;
  const bool is_short_list = json.is_array() && json.size() <= kMostAxes;
  for (std::size_t i = 0; is_short_list && i < json.size(); ++i) {
    if (const auto axis = axis_of(json[i])) axes.push_back(*axis);
  }
  if (is_short_list && axes.size() == json.size()) return SettingValue(std::move(axes));
  return refused("value", "is not a flag, a finite number, a word or a list of at most 3 axes");
}

std::optional<Error> check_keys(const Message& json,
                                std::initializer_list<std::string_view> allowed) {
  for (const auto& item : json.items()) {
    if (std::find(allowed.begin(), allowed.end(), item.key()) == allowed.end()) {
      return refused("message", "has the unknown key \"" + item.key() + "\"");
    }
  }
  for (const std::string_view key : allowed) {
    if (key != "id" && !json.contains(key)) {
      return refused("message", "lacks the key \"" + std::string(key) + "\"");
    }
  }
  return std::nullopt;
}

std::optional<Error> check_keys(const Message& json, PageRequest::Kind kind) {
  switch (kind) {
    case PageRequest::Kind::kToken:
      return check_keys(json, {"type", "token"});
    case PageRequest::Kind::kSet:
      return check_keys(json, {"type", "id", "name", "value"});
    case PageRequest::Kind::kPause:
      return check_keys(json, {"type", "id", "value"});
    default:
      return check_keys(json, {"type", "id"});
  }
}

std::optional<Error> fill(const Message& json, PageRequest& request) {
  if (request.kind == PageRequest::Kind::kToken) {
    if (!json["token"].is_string()) return refused("token", "is not a text");
    request.token = json["token"].get<std::string>();
  }
  if (request.kind == PageRequest::Kind::kSet) {
    if (!json["name"].is_string()) return refused("name", "is not a text");
    request.name = json["name"].get<std::string>();
    auto value = value_of(json["value"]);
    if (!value) return value.error();
    request.value = std::move(*value);
  }
  if (request.kind == PageRequest::Kind::kPause) {
    if (!json["value"].is_boolean()) return refused("value", "is not true or false");
    request.value = json["value"].get<bool>();
  }
  return std::nullopt;
}

}  // namespace

int nesting_depth(std::string_view text) {
  int depth = 0;
  int deepest = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == '{' || c == '[') {
      deepest = std::max(deepest, ++depth);
    } else if (c == '}' || c == ']') {
      --depth;
    }
  }
  return deepest;
}

Result<PageRequest> parse_request(std::string_view text, std::optional<std::uint64_t>& id) {
  id.reset();
  if (nesting_depth(text) > kDeepestJson) {
    return refused("message", "is nested deeper than " + std::to_string(kDeepestJson));
  }
  const Message json = Message::parse(text, nullptr, /* allow_exceptions = */ false);
  if (!json.is_object()) return refused("message", "is not a JSON object");
  PageRequest request;
  if (json.contains("id")) {
    const Message& number = json["id"];
    if (!number.is_number_unsigned() || number.get<std::uint64_t>() > kMostId) {
      return refused("id", "is not a whole number from 0 to 2^53");
    }
    id = request.id = number.get<std::uint64_t>();
  }
  const auto type = json.find("type");
  if (type == json.end() || !type->is_string()) return refused("type", "is missing");
  const auto word = type->get<std::string>();
  const auto known =
      std::find_if(kTypes.begin(), kTypes.end(), [&](const auto& t) { return t.first == word; });
  if (known == kTypes.end()) {
    return refused("type",
                   "is unknown; expected token, set, take_control, rearm, pause, start or stay");
  }
  request.kind = known->second;
  if (auto error = check_keys(json, request.kind)) return *error;
  if (auto error = fill(json, request)) return *error;
  return request;
}

}  // namespace palpate
