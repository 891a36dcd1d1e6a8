#pragma once

// What was measured of knobs, as a table for other programs.

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

// kAccuracyColumns, then a line for each level of each method, and for each preset: that has the
// name of the preset, and no method, level or value. Low and high are quartiles. Numbers have 17
// significant digits, which give back the same double, in the unit of their column; flags are 0
// or 1. What was not measured, because every repeat failed, is empty. Fields with commas, quotes or
// line breaks are quoted (RFC 4180); lines end with "\n".
std::string accuracy_csv(std::span<const KnobResult> results);

// The same into a file. Returns the path; an error that names it if it could not be written.
Result<std::string> write_accuracy_csv(std::span<const KnobResult> results,
                                       const std::string& path);

}  // namespace palpate
