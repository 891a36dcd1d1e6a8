#pragma once

// The results of a PowerStudy for other programs.

#include <string>

#include "engine/analysis/power_study.h"
#include "engine/analysis/result_table.h"

namespace palpate {

// needed_people.csv: one row per assumption and test, with the smallest number of participants for
// each of kPowerPercents. An empty number beside has_effect = 1: more than the largest number.
// Beside has_effect = 0: the assumed means make the test's hypothesis true, so that no number
// helps. The columns at the end are the bounds of each number (people_bounds()).
ResultTable power_people_table(const PowerStudy& study);

// power.csv: one row per assumption, test and number of participants, with the power and its
// 95 % interval (wilson_interval). The power is exact, other numbers have six digits at most.
ResultTable power_curve_table(const PowerStudy& study);

// power.json: the request, the model, the pilot, the notes, and for each assumption and test the
// counts of significant data sets from 2 participants on.
std::string power_json(const PowerStudy& study);

}  // namespace palpate
