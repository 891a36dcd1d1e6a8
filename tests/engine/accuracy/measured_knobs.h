#pragma once

// Knobs by name, measured, for the tests of them.

#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "engine/accuracy/measurement.h"

namespace palpate::test {

// Coarse meshes and short paths, and one seed for all.
inline constexpr StudyEffort kEffort{.quick = true, .seed = 1};

// Of a fitted order, to that of theory.
inline constexpr double kOrderTolerance = 0.15;

// Of the knobs the one of that name; a failure if there is none.
inline KnobResult measured(const std::vector<Knob>& knobs, const std::string& name,
                           const StudyEffort& effort = kEffort) {
  for (const Knob& knob : knobs) {
    if (knob.name == name) return measure(knob, effort, nullptr);
  }
  ADD_FAILURE() << "there is no knob " << name;
  return {};
}

// Likewise of its methods.
inline const MethodResult& method_of(const KnobResult& result, std::string_view name) {
  for (const MethodResult& m : result.methods) {
    if (m.name == name) return m;
  }
  ADD_FAILURE() << "there is no method " << name;
  return result.methods.front();
}

}  // namespace palpate::test
