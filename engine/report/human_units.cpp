#include "engine/report/human_units.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>

namespace palpate {
namespace {

struct Prefix {
  std::string_view written;  // in a Quantity
  std::string_view shown;
  double factor;
};

// From large to small.
constexpr std::array kPrefixes = {Prefix{"M", "M", 1e6},  Prefix{"k", "k", 1e3},
                                  Prefix{"", "", 1.0},    Prefix{"m", "m", 1e-3},
                                  Prefix{"u", "µ", 1e-6}, Prefix{"n", "n", 1e-9}};
constexpr std::array<std::string_view, 6> kBases = {"m", "s", "N", "J", "W", "Hz"};

// Below this multiple of the smallest prefixed unit, a power of ten is clearer.
constexpr double kLeastOfSmallest = 1e-3;

// "us/s" is the prefix u, the base s and the rest "/s".
struct Parts {
  Prefix prefix;
  std::string_view base;
  std::string_view rest;
};

std::optional<Parts> parts_of(std::string_view unit) {
  const std::size_t slash = std::min(unit.find('/'), unit.size());
  const std::string_view head = unit.substr(0, slash);
  for (const std::string_view base : kBases) {
    if (!head.ends_with(base)) continue;
    for (const Prefix& prefix : kPrefixes) {
      if (head.substr(0, head.size() - base.size()) == prefix.written) {
        return Parts{prefix, base, unit.substr(slash)};
      }
    }
  }
  return std::nullopt;
}

// Kilometres and kiloseconds are not used.
bool is_too_large(const Prefix& prefix, std::string_view base) {
  return prefix.factor > 1.0 && (base == "m" || base == "s");
}

}  // namespace

DisplayUnit display_unit(double typical, std::string_view unit) {
  const std::optional<Parts> parts = parts_of(unit);
  if (!parts) return {1.0, std::string(unit)};
  const double in_base = std::abs(typical) * parts->prefix.factor;
  const auto in = [&](const Prefix& prefix) {
    return DisplayUnit{
        parts->prefix.factor / prefix.factor,
        std::string(prefix.shown) + std::string(parts->base) + std::string(parts->rest)};
  };
  const auto plain = std::find_if(kPrefixes.begin(), kPrefixes.end(),
                                  [](const Prefix& p) { return p.written.empty(); });
  if (!(in_base >= kLeastOfSmallest * kPrefixes.back().factor)) return in(*plain);
  // A number that rounds to 1000 gets the next unit.
  constexpr double kRounded = 0.9995;
  for (const Prefix& prefix : kPrefixes) {
    if (!is_too_large(prefix, parts->base) && in_base >= kRounded * prefix.factor) {
      return in(prefix);
    }
  }
  return in(kPrefixes.back());
}

std::string short_number(double value) {
  if (value == 0.0) return "0";
  if (!std::isfinite(value)) return value > 0.0 ? "unbounded" : "none";
  constexpr int kDigits = 3;
  constexpr double kPlainFrom = 1e-3, kPlainTo = 1e6;
  std::array<char, 32> text;
  const auto written = [&](std::chars_format format, int precision) {
    const auto end =
        std::to_chars(text.data(), text.data() + text.size(), value, format, precision);
    return std::string(text.data(), end.ptr);
  };
  const double size = std::abs(value);
  if (size >= kPlainTo || size < kPlainFrom) {
    std::string number = written(std::chars_format::general, kDigits);
    for (const char* padded : {"e-0", "e+0", "e+"}) {  // 1e-07 is 1e-7
      const std::size_t at = number.find(padded);
      if (at == std::string::npos) continue;
      number.replace(at, std::string_view(padded).size(), padded[1] == '-' ? "e-" : "e");
    }
    return number;
  }
  const int before_point = static_cast<int>(std::floor(std::log10(size))) + 1;
  std::string number = written(std::chars_format::fixed, std::max(0, kDigits - before_point));
  if (number.find('.') == std::string::npos) return number;
  number.erase(number.find_last_not_of('0') + 1);
  if (number.back() == '.') number.pop_back();
  return number;
}

std::string order_number(double order) {
  std::array<char, 32> text;
  if (std::abs(order) < 0.005) order = 0.0;  // no "-0.00"
  const auto end =
      std::to_chars(text.data(), text.data() + text.size(), order, std::chars_format::fixed, 2);
  return std::string(text.data(), end.ptr);
}

std::string human(double value, std::string_view unit) {
  if (value == 0.0) return "0";
  const DisplayUnit shown = display_unit(value, unit);
  const std::string number = short_number(value * shown.factor);
  return shown.name.empty() ? number : number + " " + shown.name;
}

std::string with_unit(std::string_view name, std::string_view unit) {
  return unit.empty() ? std::string(name) : std::string(name) + " (" + std::string(unit) + ")";
}

}  // namespace palpate
