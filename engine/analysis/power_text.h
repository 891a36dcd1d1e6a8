#pragma once

// The results of a PowerStudy as texts for readers.

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/analysis/power_study.h"

namespace palpate {

// A line of the table of tests, over all assumptions. A range goes from the assumption with the
// least noise to that with the most. With one noise only, the numbers of people have their bounds
// in parentheses, if these differ.
struct PowerLine {
  std::string test;                 // "Haptic, Greenhouse-Geisser"; "H - UaH, Holm"
  std::vector<std::string> people;  // one for each of kPowerPercents: "12 (11 to 13)", "5 to >60"
  std::string power;                // with power_example(): "0.81 (0.80 to 0.82)", "0.3 to 0.9"
};
std::vector<PowerLine> power_lines(const PowerStudy& study);

// The smallest number of participants under one assumption: "12", ">60", "no effect".
std::string people_text(const PowerStudy& study, std::size_t assumption, std::size_t test,
                        int percent);

// The number of participants whose power is stated: the paper's, or the largest number if that is
// smaller.
int power_example(const PowerStudy& study);

// The numbers of people at which the bounds of the 95 % interval reach the power, under one
// assumption: the first from which on the upper bound (the lower one) never falls below it. No
// value: none up to the largest number.
struct PeopleBounds {
  std::optional<int> low, high;
};
PeopleBounds people_bounds(const PowerStudy& study, std::size_t assumption, std::size_t test,
                           int percent);

// What was asked, as pairs of a name and a value.
std::vector<std::pair<std::string, std::string>> power_facts(const PowerStudy& study);

// "error 9.88 s, u 0.8, w 0.1"; "pilot"
std::string assumption_text(const PowerStudy& study, std::size_t assumption);

// The answer for a terminal.
std::string power_text(const PowerStudy& study);

}  // namespace palpate
