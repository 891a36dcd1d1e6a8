#pragma once

// A question about the number of people: the effects, the variances, and the power of each test.

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/analysis/power_paper.h"
#include "engine/analysis/power_pilot.h"
#include "engine/analysis/power_run.h"
#include "geometry/base/result.h"

namespace palpate {

// The outcomes, and their names in --measure.
struct PowerMeasure {
  std::string_view name;
  Outcome outcome;
  std::string_view not_normal;  // why the outcome is not normal; empty: no warning
};
inline constexpr std::array<PowerMeasure, 4> kPowerMeasures = {
    {{"time", Outcome::kTime, "a time: it has a long tail and no negative values"},
     {"losses", Outcome::kLosses, "a count: it has whole values only, and none below 0"},
     {"penetration", Outcome::kPenetration, ""},
     {"angle", Outcome::kContactAngle, ""}}};

inline constexpr int kMostPowerParticipants = 200;
inline constexpr int kMostPowerSets = 1'000'000;
inline constexpr int kMostPowerTrials = 1'000;
// The powers for which the smallest number of participants is found, in percent.
inline constexpr std::array<int, 2> kPowerPercents = {80, 90};

// What the options say. Elements of errors are the options.
struct PowerRequest {
  std::string measure = "time";
  // "NoH-NoR=29, NoH-R=31, ...", each condition once; empty: the paper's.
  std::string effects;
  std::string pilot;  // file of trials; empty: none
  std::string following;
  std::optional<double> error_sd;          // of one trial; no value: the paper's
  std::optional<double> share_u, share_w;  // of the variance of one trial; no value: the grid
  // Of a participant in a condition; no value: the pilot's, rounded, or the paper's without a
  // pilot.
  std::optional<int> trials;
  PowerSettings settings;
};

// Where the variances of one model come from.
struct PowerAssumption {
  std::string error_from;  // "paper, F of Haptic"; "paper's paired difference"; "--error"; "pilot"
  double error_sd = 0.0;   // of one trial: sqrt(u + w + e)
  double share_u = 0.0, share_w = 0.0;  // of u + w + e
};

struct PowerStudy {
  PowerRequest request;
  const PowerMeasure* measure = nullptr;
  bool has_paper_effects = false;
  PowerModel model;
  std::vector<PowerAssumption> assumptions;  // one for each of model.variances
  std::vector<PaperScatter> paper_scatter;   // from which the error follows; empty: not the paper's
  std::optional<PilotEstimate> pilot;
  PowerTests tests;
  PowerCounts counts;  // of simulate_power()

  const PowerSettings& settings() const { return request.settings; }
  double noise(std::size_t model_index) const { return model.noise(model_index); }
  // Whether all assumptions have the same noise, and therefore the same answers.
  bool has_one_noise() const;
  // The models by ascending noise.
  std::vector<std::size_t> by_noise() const;
};

// The model of a request, without counts.
//
// Errors: an effect that is no number, is not finite or beyond kMostPowerValue, an unknown,
// repeated or missing condition; shares with a sum above 1, or that leave no variance to w and e; a
// pilot together with --error or a share; --following without a pilot; those of read_pilot() and
// estimate_pilot(); means or shares so large that their rounding would hide the scatter.
Result<PowerStudy> prepare_power(const PowerRequest& request);

}  // namespace palpate
