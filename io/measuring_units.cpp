#include "io/measuring_units.h"

#include <algorithm>
#include <iterator>

#include "io/ascii.h"

namespace palpate {
namespace {

struct LengthName {
  std::string_view name;
  LengthUnit unit;
};

constexpr LengthUnit kDecimetre = {"dm", 1.0, -1};
constexpr LengthUnit kCentimetre = {"cm", 1.0, -2};
constexpr LengthUnit kMillimetre = {"mm", 1.0, -3};
constexpr LengthUnit kMicrometre = {"um", 1.0, -6};
constexpr LengthUnit kNanometre = {"nm", 1.0, -9};
constexpr LengthUnit kKilometre = {"km", 1.0, 3};
constexpr LengthUnit kInch = {"in", 254.0, -4};
constexpr LengthUnit kFoot = {"ft", 3048.0, -4};
constexpr LengthUnit kYard = {"yd", 9144.0, -4};
constexpr LengthUnit kMil = {"mil", 254.0, -7};

constexpr LengthName kLengthNames[] = {
    {"m", kMetre},
    {"meter", kMetre},
    {"metre", kMetre},
    {"mtr", kMetre},
    {"metro", kMetre},
    {"m\u00e8tre", kMetre},
    {"dm", kDecimetre},
    {"decimeter", kDecimetre},
    {"decimetre", kDecimetre},
    {"dezimeter", kDecimetre},
    {"cm", kCentimetre},
    {"centimeter", kCentimetre},
    {"centimetre", kCentimetre},
    {"zentimeter", kCentimetre},
    {"centim\u00e8tre", kCentimetre},
    {"centimetro", kCentimetre},
    {"mm", kMillimetre},
    {"millimeter", kMillimetre},
    {"millimetre", kMillimetre},
    {"millim\u00e8tre", kMillimetre},
    {"milimetro", kMillimetre},
    {"um", kMicrometre},
    {"micron", kMicrometre},
    {"micrometer", kMicrometre},
    {"micrometre", kMicrometre},
    {"mikrometer", kMicrometre},
    {"microm\u00e8tre", kMicrometre},
    {"nm", kNanometre},
    {"nanometer", kNanometre},
    {"nanometre", kNanometre},
    {"km", kKilometre},
    {"kilometer", kKilometre},
    {"kilometre", kKilometre},
    {"in", kInch},
    {"inch", kInch},
    {"inche", kInch},
    {"zoll", kInch},
    {"pouce", kInch},
    {"\"", kInch},
    {"\u2033", kInch},
    {"ft", kFoot},
    {"foot", kFoot},
    {"feet", kFoot},
    {"'", kFoot},
    {"\u2032", kFoot},
    {"yd", kYard},
    {"yard", kYard},
    {"mil", kMil},
    {"thou", kMil},
};

struct TimeName {
  std::string_view name;
  TimeUnit unit;
};

constexpr TimeUnit kMillisecond = {"ms", {1, 6}};
constexpr TimeUnit kMicrosecond = {"us", {1, 3}};
constexpr TimeUnit kNanosecond = {"ns", {1, 0}};
constexpr TimeUnit kMinute = {"min", {60, 9}};
constexpr TimeUnit kHour = {"h", {3600, 9}};
constexpr TimeUnit kDay = {"d", {86400, 9}};

constexpr TimeName kTimeNames[] = {
    {"s", kSecond},
    {"sec", kSecond},
    {"second", kSecond},
    {"sekunde", kSecond},
    {"sekunden", kSecond},
    {"sek", kSecond},
    {"seconde", kSecond},
    {"segundo", kSecond},
    {"ms", kMillisecond},
    {"msec", kMillisecond},
    {"milli", kMillisecond},
    {"millisecond", kMillisecond},
    {"millisec", kMillisecond},
    {"millisekunde", kMillisecond},
    {"millisekunden", kMillisecond},
    {"milliseconde", kMillisecond},
    {"us", kMicrosecond},
    {"usec", kMicrosecond},
    {"micro", kMicrosecond},
    {"microsecond", kMicrosecond},
    {"microsec", kMicrosecond},
    {"mikrosekunde", kMicrosecond},
    {"mikrosekunden", kMicrosecond},
    {"microseconde", kMicrosecond},
    {"ns", kNanosecond},
    {"nsec", kNanosecond},
    {"nano", kNanosecond},
    {"nanosecond", kNanosecond},
    {"nanosec", kNanosecond},
    {"nanosekunde", kNanosecond},
    {"nanosekunden", kNanosecond},
    {"min", kMinute},
    {"minute", kMinute},
    {"minuten", kMinute},
    {"h", kHour},
    {"hr", kHour},
    {"hour", kHour},
    {"stunde", kHour},
    {"stunden", kHour},
    {"d", kDay},
    {"day", kDay},
};

constexpr std::string_view kCountNames[] = {"sample", "smp", "tick", "frame", "count",
                                            "cnt",    "row", "step", "cycle", "index"};

// The name, or the name without the s of a plural.
template <typename Names>
auto find_name(const Names& names, std::string_view text) {
  const auto named = [](std::string_view name) {
    return [name](const auto& entry) { return entry.name == name; };
  };
  auto found = std::find_if(std::begin(names), std::end(names), named(text));
  constexpr std::size_t kShortest = 3;  // "s" and "ms" are no plurals
  if (found == std::end(names) && text.size() > kShortest && text.ends_with('s')) {
    text.remove_suffix(1);
    found = std::find_if(std::begin(names), std::end(names), named(text));
  }
  return found;
}

// A capital M followed by a small letter is the prefix "mega".
bool is_mega(std::string_view text) {
  return text == "Mm" || text == "Ms" || text == "Msec";
}

}  // namespace

std::string folded_unit(std::string_view text) {
  std::string folded;
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::string_view rest = text.substr(i);
    if (rest.starts_with("\u00b5") || rest.starts_with("\u03bc") || rest.starts_with("\u039c")) {
      folded += 'u';
      ++i;
      continue;
    }
    folded += lower(text[i]);
  }
  if (folded.size() > 1 && folded.ends_with('.')) folded.pop_back();
  return folded;
}

std::optional<LengthUnit> find_length_unit(std::string_view text) {
  if (is_mega(text)) return std::nullopt;
  const auto* found = find_name(kLengthNames, folded_unit(text));
  if (found == std::end(kLengthNames)) return std::nullopt;
  return found->unit;
}

std::optional<TimeUnit> find_time_unit(std::string_view text) {
  if (is_mega(text)) return std::nullopt;
  const auto* found = find_name(kTimeNames, folded_unit(text));
  if (found == std::end(kTimeNames)) return std::nullopt;
  return found->unit;
}

bool is_count_unit(std::string_view text) {
  std::string name = folded_unit(text);
  const auto is_known = [&] {
    return std::find(std::begin(kCountNames), std::end(kCountNames), name) != std::end(kCountNames);
  };
  if (is_known()) return true;
  if (!name.ends_with('s')) return false;
  name.pop_back();
  return is_known();
}

}  // namespace palpate
