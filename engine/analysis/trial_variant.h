#pragma once

// The settings that make several experiments of one plan, as its trials state them.

#include <string>
#include <tuple>

#include "engine/trials/trial_row.h"

namespace palpate {

// The levels of view, align, start orientation and scale of a trial (plan.h).
struct TrialVariant {
  std::string view = "turning";
  std::string align = "nearest";
  double start_orientation_deg = 0.0;
  double scale = 1.0;

  bool operator==(const TrialVariant& other) const = default;
  // What the paper did comes first: the scene turns, its first pose is not turned, and the objects
  // have their size.
  bool operator<(const TrialVariant& other) const { return key() < other.key(); }

 private:
  std::tuple<bool, bool, bool, double, bool, double> key() const {
    return {view != "turning",     align != "nearest", start_orientation_deg != 0.0,
            start_orientation_deg, scale != 1.0,       scale};
  }
};

inline TrialVariant variant_of(const TrialRow& row) {
  return {row.view, row.align, row.start_orientation_deg, row.scale};
}

// "view still, start 45 deg, scale 0.5": the settings in which the variant differs from `plain`;
// empty if it does not.
std::string variant_name(const TrialVariant& variant, const TrialVariant& plain = {});

}  // namespace palpate
