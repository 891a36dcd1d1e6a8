#pragma once

// Measures knobs by name, for their tests.

#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "engine/accuracy/measurement.h"

namespace palpate::test {

// Coarse meshes and short paths, and one seed for all.
inline constexpr MeasurementEffort kEffort{.quick = true, .seed = 1};

// Tolerance between a fitted order and that of theory.
inline constexpr double kOrderTolerance = 0.15;

// Measures the knob of this name; a test failure if it does not exist.
inline KnobResult measured(const std::vector<Knob>& knobs, const std::string& name,
                           const MeasurementEffort& effort = kEffort) {
  for (const Knob& knob : knobs) {
    if (knob.name == name) return measure(knob, effort, nullptr);
  }
  ADD_FAILURE() << "there is no knob " << name;
  return {};
}

// The method of this name; a test failure if it does not exist.
inline const MethodResult& method_of(const KnobResult& result, std::string_view name) {
  for (const MethodResult& m : result.methods) {
    if (m.name == name) return m;
  }
  ADD_FAILURE() << "there is no method " << name;
  return result.methods.front();
}

}  // namespace palpate::test
