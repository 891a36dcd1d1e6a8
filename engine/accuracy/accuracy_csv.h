#pragma once

// The results of knobs (knob.h) as a table for other programs.

#include <span>
#include <string>
#include <string_view>

#include "engine/accuracy/measurement.h"

namespace palpate {

inline constexpr std::string_view kAccuracyColumns =
    "knob,method,level,value,value_unit,error_median,error_low,error_high,error_unit,raw_error,"
    "floor,at_floor,time_median,time_low,time_high,time_unit,iterations,ticks,repeats,failures,"
    "failure,on_front,recommended,is_default,preset";

// The first line is kAccuracyColumns. One line follows for each level of each method, then one for
// each preset. The line of a preset has the name of the preset and no method, level or value. The
// columns `*_low` and `*_high` contain quartiles. Numbers have 17 significant digits, so that
// reading them restores the same doubles. Numbers are in the units that the columns `*_unit` state;
// flags are 0 or 1. The numbers of a level are empty if every repeat failed. Fields with commas,
// quotation marks or line breaks are quoted (RFC 4180). Lines end with "\n".
std::string accuracy_csv(std::span<const KnobResult> results);

}  // namespace palpate
