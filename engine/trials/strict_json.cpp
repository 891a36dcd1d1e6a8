#include "engine/trials/strict_json.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "geometry/base/printable.h"
#include "geometry/base/quoted.h"
#include "io/gltf/file.h"
#include "io/gltf/json.h"
#include "io/gltf/json_scan.h"
#include "io/gltf/json_text.h"

namespace palpate {
namespace {

using Json = nlohmann::json;

Error settings_error(std::string element, std::string problem, std::string hint = {}) {
  return {ErrorCode::kInvalidContent, "", std::move(element), std::move(problem), std::move(hint)};
}

// The library's message without the name of its exception.
std::string without_tag(std::string message) {
  const std::size_t end = message.find("] ");
  return message.starts_with("[json.exception") && end != std::string::npos
             ? message.substr(end + 2)
             : message;
}

std::string shown(const Json& value) {
  if (value.is_array()) return "a list";
  if (value.is_object()) return "an object";
  return printable(shortened(value.dump(-1, ' ', false, Json::error_handler_t::replace)));
}

}  // namespace

Result<Json> parse_strict_json(std::string_view text, const std::string& path) {
  const auto refused = [&](std::string element, std::string problem, std::string hint = {}) {
    Error error = settings_error(std::move(element), std::move(problem), std::move(hint));
    error.path = path;
    return error;
  };
  if (const std::size_t zero = text.find('\0'); zero != std::string_view::npos) {
    return refused("JSON", "byte " + std::to_string(zero) + " is zero; expected text");
  }
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);  // some editors write the mark
  const auto scan = scan_json(text);
  if (!scan) {
    Error error = scan.error();
    error.path = path;
    return error;
  }
  std::vector<std::string> warnings;
  auto json = parse_gltf_json(text, *scan, warnings);
  if (!json) return refused("JSON", without_tag(json.error().problem), json.error().hint);
  if (!warnings.empty()) {
    const std::string& warning = warnings.front();
    return refused(printable(warning.substr(0, warning.rfind(": is present more than once"))),
                   "is present more than once; expected once", "remove all but one of them");
  }
  return std::move(*json);
}

Result<std::string> read_settings_text(const std::string& path, std::uint64_t most_bytes) {
  const auto bytes = read_regular_file(path, most_bytes);
  if (!bytes) return bytes.error();
  return std::string(bytes->begin(), bytes->end());
}

std::string number_text(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

std::string text_of(const NumberRange& range) {
  const bool has_least = std::isfinite(range.least);
  const bool has_most = std::isfinite(range.most);
  if (!has_least && !has_most) return "a finite number";
  if (!has_least) return "a number of at most " + number_text(range.most);
  if (range.is_least_out) {
    return "a number above " + number_text(range.least) +
           (has_most ? " and at most " + number_text(range.most) : "");
  }
  if (!has_most) return "a number of at least " + number_text(range.least);
  return "a number from " + number_text(range.least) + " to " + number_text(range.most);
}

Error unexpected_value(const std::string& element, const Json& found, const std::string& expected,
                       std::string hint) {
  return settings_error(element, "is " + shown(found) + "; expected " + expected, std::move(hint));
}

std::string joined_words(const std::vector<std::string_view>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) text += i + 1 < words.size() ? ", " : " or ";
    text += words[i];
  }
  return text;
}

ObjectReader::ObjectReader(const Json& value, std::string element)
    : object_(value), element_(std::move(element)) {
  if (!object_.is_object()) {
    fail(unexpected_value(element_.empty() ? "JSON" : element_, object_, "an object"));
  }
}

const Json* ObjectReader::find(const char* key, Key need) {
  if (std::find(asked_.begin(), asked_.end(), key) == asked_.end()) asked_.emplace_back(key);
  if (error_) return nullptr;
  const auto found = object_.find(key);
  if (found != object_.end()) return &*found;
  if (need == Key::kRequired) fail(settings_error(element_of(key), "is missing; expected a value"));
  return nullptr;
}

void ObjectReader::text(const char* key, std::string& value, Key need, std::size_t most_bytes) {
  const Json* const found = find(key, need);
  if (!found) return;
  const auto is_good = [&](const std::string& text) {
    return !text.empty() && text.size() <= most_bytes && printable(text) == text;
  };
  if (!found->is_string() || !is_good(found->get_ref<const std::string&>())) {
    return fail(unexpected_value(
        element_of(key), *found,
        "a text of 1 to " + std::to_string(most_bytes) + " bytes without control characters"));
  }
  value = found->get<std::string>();
}

void ObjectReader::flag(const char* key, bool& value, Key need) {
  const Json* const found = find(key, need);
  if (!found) return;
  if (!found->is_boolean()) return fail(unexpected_value(element_of(key), *found, "true or false"));
  value = found->get<bool>();
}

void ObjectReader::number(const char* key, double& value, const NumberRange& range, Key need) {
  const Json* const found = find(key, need);
  if (!found) return;
  if (!found->is_number() || !range.contains(found->get<double>())) {
    return fail(unexpected_value(element_of(key), *found, text_of(range)));
  }
  value = found->get<double>();
}

void ObjectReader::number(const char* key, std::optional<double>& value, const NumberRange& range) {
  double present = std::numeric_limits<double>::quiet_NaN();
  number(key, present, range, Key::kOptional);
  if (!std::isnan(present)) value = present;
}

void ObjectReader::whole(const char* key, std::uint64_t& value, std::uint64_t least,
                         std::uint64_t most, Key need) {
  const Json* const found = find(key, need);
  if (!found) return;
  const auto number = whole_number(*found);
  if (!number || *number < least || *number > most) {
    const std::string range = least == most ? std::to_string(least)
                                            : "a whole number from " + std::to_string(least) +
                                                  " to " + std::to_string(most);
    return fail(unexpected_value(element_of(key), *found, range));
  }
  value = *number;
}

void ObjectReader::whole(const char* key, int& value, int least, int most, Key need) {
  auto number = static_cast<std::uint64_t>(value);
  whole(key, number, static_cast<std::uint64_t>(least), static_cast<std::uint64_t>(most), need);
  value = static_cast<int>(number);
}

void ObjectReader::numbers(const char* key, std::vector<double>& values, std::size_t count,
                           Key need) {
  const Json* const found = find(key, need);
  if (!found) return;
  const std::string expected = "a list of " + std::to_string(count) + " numbers";
  if (!found->is_array()) return fail(unexpected_value(element_of(key), *found, expected));
  if (found->size() != count) {
    return fail(settings_error(element_of(key), "is a list of " + std::to_string(found->size()) +
                                                    "; expected " + expected));
  }
  for (std::size_t i = 0; i < count; ++i) {
    if ((*found)[i].is_number()) continue;
    return fail(
        unexpected_value(element_of(key) + "/" + std::to_string(i), (*found)[i], "a number"));
  }
  values = found->get<std::vector<double>>();
}

void ObjectReader::choice(const char* key, std::size_t& value,
                          const std::vector<std::string_view>& words, Key need) {
  const Json* const found = find(key, need);
  if (!found) return;
  const auto word = found->is_string() ? std::find(words.begin(), words.end(),
                                                   found->get_ref<const std::string&>())
                                       : words.end();
  if (word == words.end()) {
    return fail(unexpected_value(element_of(key), *found, joined_words(words)));
  }
  value = static_cast<std::size_t>(word - words.begin());
}

void ObjectReader::choices(const char* key, std::vector<std::size_t>& values,
                           const std::vector<std::string_view>& words) {
  const Json* const found = find(key);
  if (!found) return;
  const std::string expected = "a list of one or more of " + joined_words(words);
  if (!found->is_array()) return fail(unexpected_value(element_of(key), *found, expected));
  if (found->empty())
    return fail(settings_error(element_of(key), "is empty; expected " + expected));
  values.clear();
  for (std::size_t i = 0; i < found->size(); ++i) {
    const Json& item = (*found)[i];
    const std::string element = element_of(key) + "/" + std::to_string(i);
    const auto word =
        item.is_string() ? std::find(words.begin(), words.end(), item.get_ref<const std::string&>())
                         : words.end();
    if (word == words.end()) return fail(unexpected_value(element, item, joined_words(words)));
    const auto place = static_cast<std::size_t>(word - words.begin());
    if (std::find(values.begin(), values.end(), place) != values.end()) {
      return fail(settings_error(
          element, "repeats " + in_quotes(std::string(*word)) + "; expected each level once"));
    }
    values.push_back(place);
  }
}

void ObjectReader::fail(Error error) {
  if (!error_) error_ = std::move(error);
}

std::optional<Error> ObjectReader::finish() {
  if (object_.is_object()) {
    for (const auto& [key, value] : object_.items()) {
      if (std::find(asked_.begin(), asked_.end(), key) != asked_.end()) continue;
      const std::vector<std::string_view> words(asked_.begin(), asked_.end());
      return settings_error(printable(element_of(shortened(key))),
                            "is not a known key; expected " + joined_words(words),
                            "correct or remove the key");
    }
  }
  return error_;
}

}  // namespace palpate
