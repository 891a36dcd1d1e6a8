#pragma once

// Measures knobs by name, for their tests.

#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "engine/accuracy/measurement.h"

namespace palpate::test {

// Coarse meshes, short paths, and the same seed for all knobs.
inline constexpr MeasurementEffort kEffort{.quick = true, .seed = 1};

// The largest allowed difference between a fitted order and the order that theory predicts.
inline constexpr double kOrderTolerance = 0.15;

// Measures the knob of this name. The test fails if there is no such knob.
inline KnobResult measured(const std::vector<Knob>& knobs, const std::string& name,
                           const MeasurementEffort& effort = kEffort) {
  for (const Knob& knob : knobs) {
    if (knob.name == name) return measure(knob, effort, nullptr);
  }
  ADD_FAILURE() << "there is no knob " << name;
  return {};
}

// The method of this name. The test fails if there is no such method.
inline const MethodResult& method_of(const KnobResult& result, std::string_view name) {
  for (const MethodResult& m : result.methods) {
    if (m.name == name) return m;
  }
  ADD_FAILURE() << "there is no method " << name;
  return result.methods.front();
}

}  // namespace palpate::test
