#pragma once

// What is told of a material that is felt in several ways, each thing once.

#include <set>
#include <string>
#include <vector>

#include "engine/scene/material_effects.h"

namespace palpate {

// Gathers what is told of one material that is felt in several ways, each thing once. There may be
// as many ways as physics materials, so what is known is looked up.
class MergedReport {
 public:
  void append(const MaterialReport& more, MaterialReport& report);

 private:
  std::set<std::string> honoured_, defaulted_, not_understood_;
};

// Adds names to others that are sorted, each once.
void merge_names(const std::vector<std::string>& more, std::vector<std::string>& sorted);

}  // namespace palpate
