#pragma once

// Artificial trials, for tests of the analysis and of its report: the paper's means with random
// scatter between participants and between trials.

#include <cstdint>
#include <string>
#include <vector>

#include "engine/trials/trial_row.h"

namespace palpate::test {

struct SampleTrials {
  std::vector<std::string> followings = {""};  // "": people
  int participants = 10;
  int blocks = 3;
  std::vector<std::string> haptic = {"NoH", "UaH", "H"};
  std::vector<std::string> rotation = {"NoR", "R"};
  std::vector<std::string> objects = {"O1", "O2", "O3", "O4"};
  double effects = 1.0;       // 0: no effect of Haptic and Rotation; 1: those of the paper
  bool has_timeouts = false;  // true: about a fifth of the trials in R with `frozen` time out
  std::uint64_t seed = 1;
};

// The trials include a practice block (block 0), whose total times are a hundred times too long.
std::vector<TrialRow> sample_trials(const SampleTrials& sample);

}  // namespace palpate::test
