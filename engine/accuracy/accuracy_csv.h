#pragma once

// The results of knobs as a table for other programs.

#include <span>
#include <string>
#include <string_view>

#include "engine/accuracy/measurement.h"
#include "geometry/base/result.h"

namespace palpate {

inline constexpr std::string_view kAccuracyColumns =
    "knob,method,level,value,value_unit,error_median,error_low,error_high,error_unit,raw_error,"
    "floor,at_floor,time_median,time_low,time_high,time_unit,iterations,ticks,repeats,failures,"
    "failure,on_front,recommended,is_default,preset";

// kAccuracyColumns, then a line per level of each method, and a line per preset with the name of
// the preset and without method, level and value. Low and high are quartiles. Numbers have 17
// significant digits, which give back the same double, in the unit of their column; flags are 0
// or 1. Figures are empty if every repeat failed. Fields with commas, quotes or
// line breaks are quoted (RFC 4180); lines end with "\n".
std::string accuracy_csv(std::span<const KnobResult> results);

// Writes the table to a file. Returns the path, or an error that names it.
Result<std::string> write_accuracy_csv(std::span<const KnobResult> results,
                                       const std::string& path);

}  // namespace palpate
