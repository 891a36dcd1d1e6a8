#include "tests/engine/analysis/sample_trials.h"

#include <cmath>

#include "geometry/base/random.h"

namespace palpate::test {
namespace {

double of_haptic(const std::string& haptic, double none, double actuated, double full) {
  if (haptic == "NoH") return none;
  return haptic == "UaH" ? actuated : full;
}

}  // namespace

std::vector<TrialRow> sample_trials(const SampleTrials& sample) {
  SeededRandom random(sample.seed);
  std::vector<TrialRow> rows;
  const auto add = [&](TrialRow row, double person, double object) {
    const bool is_r = row.rotation == "R";
    const double r = is_r ? 0.5 : -0.5;
    const double e = sample.effects;
    const double time = 27.0 + e * of_haptic(row.haptic, 2.0, 0.3, -2.0) + 4.0 * e * r +
                        3.0 * person + 5.0 * object - row.block + 5.0 * random.normal();
    const double losses = 22.0 + e * of_haptic(row.haptic, 2.0, 0.0, -1.5) + 2.0 * e * r +
                          2.0 * person + 0.3 * (time - 27.0) + 2.0 * random.normal();
    const double depth_dm = 0.067 + e * of_haptic(row.haptic, 0.034, 0.001, -0.036) -
                            e * r * of_haptic(row.haptic, -0.01, 0.02, -0.01) + 0.004 * person +
                            0.008 * random.normal();
    const double angle = 41.0 - 17.0 * e * r + 2.0 * person + 3.0 * random.normal();
    const bool is_lost =
        sample.has_timeouts && row.following == "frozen" && is_r && random.uniform(0.0, 1.0) < 0.2;
    if (is_lost) row.status = TrialStatus::kTimeout;
    if (!is_lost) {
      const double scale = row.block == 0 ? 100.0 : 1.0;
      row.measures[kTotalTime] = scale * std::max(8.0, time);
      row.measures[kLosses] = std::max(0.0, std::round(losses));
      row.measures[kLosses100ms] = std::max(0.0, std::round(0.5 * losses));
      row.measures[kLossesPerSecond] = *row.measures[kLosses] / *row.measures[kTotalTime];
      row.measures[kPenetration] = 0.1 * std::max(0.001, depth_dm);
      row.measures[kPenetrationDm] = std::max(0.001, depth_dm);
      row.measures[kContactAngle] = std::max(1.0, angle);
    }
    rows.push_back(std::move(row));
  };
  for (const std::string& following : sample.followings) {
    for (int p = 1; p <= sample.participants; ++p) {
      const double person = random.normal();
      for (int block = 0; block <= sample.blocks; ++block) {
        int trial = 0;
        for (const std::string& haptic : sample.haptic) {
          for (const std::string& rotation : sample.rotation) {
            for (std::size_t o = 0; o < sample.objects.size(); ++o) {
              TrialRow row;
              row.following = following;
              row.participant = std::to_string(p);
              row.block = block;
              row.trial = ++trial;
              row.haptic = haptic;
              row.rotation = rotation;
              row.object = sample.objects[o];
              add(std::move(row), person, 0.5 * static_cast<double>(o));
            }
          }
        }
      }
    }
  }
  return rows;
}

}  // namespace palpate::test
