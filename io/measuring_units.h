#pragma once

// The units of length and time that a text file can name.

#include <optional>
#include <string>
#include <string_view>

#include "io/decimal_time.h"

namespace palpate {

// A unit of length: value * factor * 10^power metres.
struct LengthUnit {
  std::string_view name;  // "mm"
  double factor = 1.0;
  int power = 0;

  bool operator==(const LengthUnit&) const = default;
};

struct TimeUnit {
  std::string_view name;  // "ms"
  TimeScale scale;
};

inline constexpr LengthUnit kMetre = {"m", 1.0, 0};
inline constexpr TimeUnit kSecond = {"s", {1, 9}};

// Symbols and English, German, French and Spanish names, such as "mm", "Millimeter" and "\u00b5m".
// Upper and lower case are equivalent, but for "Mm" and "Ms", the mega units: they are not known.
// Thread-safe.
std::optional<LengthUnit> find_length_unit(std::string_view text);
std::optional<TimeUnit> find_time_unit(std::string_view text);

// A count of samples, such as "samples" and "ticks": a time only at a known rate.
bool is_count_unit(std::string_view text);

// Small letters, without blanks at the ends; the two micro signs become "u".
std::string folded_unit(std::string_view text);

// For messages.
inline constexpr std::string_view kLengthUnits = "m, dm, cm, mm, um, nm, km, in, ft, yd or mil";
inline constexpr std::string_view kTimeUnits = "s, ms, us, ns, min, h or d";

}  // namespace palpate
