#pragma once

#include <string>

#include "engine/report/human_units.h"

namespace palpate {

// A share of 1 as a text: "12.5 %".
inline std::string percent_text(double share) {
  return short_number(100.0 * share) + " %";
}

}  // namespace palpate
