#pragma once

// Merges the reports of one material that occurs in several combinations.

#include <set>
#include <string>
#include <vector>

#include "engine/scene/material_effects.h"

namespace palpate {

// Merges the reports of one material that is combined with several physics or haptic materials.
// Equal lines are kept once. A file can contain many physics materials; the kept lines are
// therefore also stored in sets, in which the search for an equal line is fast.
class MergedReport {
 public:
  void append(const MaterialReport& more, MaterialReport& report);

 private:
  std::set<std::string> honoured_, defaulted_, not_understood_;
};

// Adds names to a sorted list of names and omits repeated names. The list stays sorted.
void merge_names(const std::vector<std::string>& more, std::vector<std::string>& sorted);

}  // namespace palpate
