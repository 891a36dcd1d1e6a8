#include "engine/scene/material_parameters.h"

#include <array>
#include <charconv>
#include <cstddef>
#include <utility>
#include <variant>
#include <vector>

namespace palpate {
namespace {

// The element of an override begins with this text (MaterialParameter).
constexpr const char* kOverrideElement = "`SceneSettings::overrides`";

std::string number_text(double x) {
  std::array<char, 32> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), x).ptr;
  return {text.data(), end};
}

bool is_number(const std::string& text) {
  double number = 0.0;
  const char* end = text.data() + text.size();
  const auto [rest, failed] = std::from_chars(text.data(), end, number);
  return failed == std::errc() && rest == end;
}

// How to write a value that a program wrote with the wrong type.
std::string type_hint(const MaterialValue& value) {
  const auto* text = std::get_if<std::string>(&value);
  if (text && (is_number(*text) || *text == "true" || *text == "false")) {
    return "write " + *text + " without quotation marks";
  }
  const auto* list = std::get_if<std::vector<double>>(&value);
  if (list && list->size() == 1) return "write " + number_text(list->front()) + " without brackets";
  return "";
}

}  // namespace

std::string source_of(const MaterialParameter& parameter) {
  return parameter.element.starts_with(kOverrideElement) ? kOverrideSource : kExtrasSource;
}

std::string quoted_text(std::string_view text) {
  return "\"" + std::string(text) + "\"";
}

std::string value_text(const MaterialValue& value) {
  if (const auto* number = std::get_if<double>(&value)) return number_text(*number);
  if (const auto* flag = std::get_if<bool>(&value)) return *flag ? "true" : "false";
  if (const auto* text = std::get_if<std::string>(&value)) return quoted_text(*text);
  std::string list;
  for (const double x : std::get<std::vector<double>>(value)) {
    list += (list.empty() ? "" : ", ") + number_text(x);
  }
  return "[" + list + "]";
}

Error error_at(const std::string& owner, const MaterialParameter& parameter, std::string problem,
               std::string hint) {
  const bool is_argument = source_of(parameter) == kOverrideSource;
  return {is_argument ? ErrorCode::kInvalidArgument : ErrorCode::kInvalidContent, "",
          parameter.element, owner + ": " + std::move(problem), std::move(hint)};
}

Error not_built_error(const std::string& owner, const MaterialParameter& parameter,
                      std::string_view effect) {
  return {ErrorCode::kUnsupported, "", parameter.element,
          owner + ": " + parameter.key + " requires the effect " + std::string(effect) +
              ", which is not in this build",
          "add " + std::string(effect) + " to PALPATE_EFFECTS and build again"};
}

Error parameter_error(const std::string& owner, const MaterialParameter& parameter,
                      const std::string& expected) {
  return error_at(owner, parameter,
                  parameter.key + " is " + value_text(parameter.value) + "; expected " + expected,
                  type_hint(parameter.value));
}

std::string expected_text(const ParameterKey& key) {
  if (key.kind == ParameterKey::Kind::kChoice) {
    return quoted_text(key.choices[0]) + " or " + quoted_text(key.choices[1]);
  }
  return std::string("a number ") + (key.least_is_excluded ? "above " : "from ") +
         number_text(key.least) + (key.least_is_excluded ? " and up to " : " to ") +
         number_text(key.most) + (key.unit.empty() ? "" : " ") + std::string(key.unit);
}

Result<double> checked_number(const std::string& owner, const MaterialParameter& parameter,
                              const ParameterKey& key) {
  if (key.kind == ParameterKey::Kind::kChoice) {
    const auto* text = std::get_if<std::string>(&parameter.value);
    for (std::size_t i = 0; text && i < key.choices.size(); ++i) {
      if (*text == key.choices[i]) return static_cast<double>(i);
    }
    return parameter_error(owner, parameter, expected_text(key));
  }
  const auto* number = std::get_if<double>(&parameter.value);
  const bool is_in_range = number && *number >= key.least && *number <= key.most &&
                           !(key.least_is_excluded && *number == key.least);
  if (!is_in_range) return parameter_error(owner, parameter, expected_text(key));
  return *number == 0.0 ? 0.0 : *number;  // replaces -0 by 0
}

Result<bool> checked_flag(const std::string& owner, const MaterialParameter& parameter) {
  if (const auto* flag = std::get_if<bool>(&parameter.value)) return *flag;
  const auto* number = std::get_if<double>(&parameter.value);
  if (number && (*number == 0.0 || *number == 1.0)) return *number == 1.0;
  return parameter_error(owner, parameter, "true or false, or 1 or 0");
}

}  // namespace palpate
