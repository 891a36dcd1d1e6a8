#pragma once

// The parameters that a sweep can vary.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "engine/trials/plan.h"
#include "engine/trials/strict_json.h"

namespace palpate {

enum SweepParameterIndex : std::size_t {
  kSightDelay,
  kIntentionNoise,
  kForceNoise,
  kPressDepth,
  kHandStiffness,
  kSpeed,
  kDeviceStiffness,
  kComfortableDepth,
  kSweptFollowing,
  kAlign,
  kStartOrientation,
  kScale,
  kSweepParameterCount
};

// A parameter. Its value is a number or one of a few words.
struct SweepParameter {
  std::string_view name;  // key of sweep files, column of sweep.csv
  std::string_view unit;  // "1": dimensionless; empty for words
  std::string_view meaning;
  NumberRange valid;                        // of a number
  std::span<const std::string_view> words;  // empty: the value is a number
  // For a parameter of the hand: it replaces the draws of this parameter for all participants, and
  // the range of the hypercube is that of the operator `literature`.
  double OperatorParameters::*drawn;
  // The hypercube draws from the listed levels. Otherwise it draws between the ends of the range.
  bool is_listed;
};
const std::array<SweepParameter, kSweepParameterCount>& sweep_parameters();

// The value of each parameter at a point of a sweep: a number, or the index of a word. No value:
// each participant has its own.
using SweepValues = std::array<std::optional<double>, kSweepParameterCount>;

// The value that a plan has for all its participants, and a plan with another value. The plan must
// have one following, one start orientation and one scale.
std::optional<double> sweep_value(const ExperimentPlan& plan, std::size_t parameter);
void set_sweep_value(ExperimentPlan& plan, std::size_t parameter, double value);

// "0.117", "delayed"
std::string sweep_value_text(std::size_t parameter, double value);

}  // namespace palpate
