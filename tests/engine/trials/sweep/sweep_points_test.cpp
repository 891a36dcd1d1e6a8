// The points of a sweep, without running any.

#include "engine/trials/sweep/sweep_points.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/trials/operator_file.h"
#include "engine/trials/sweep/latin_hypercube.h"
#include "engine/trials/sweep/sweep_rows.h"
#include "tests/engine/trials/added_column.h"
#include "tests/engine/trials/sweep/small_sweep.h"

namespace palpate {
namespace {

using test::small_sweep;
using test::small_sweep_json;
using test::sweep_of;

constexpr int kAllPoints = 1 + 18 + 6;  // of small_sweep_json(): base, levels, hypercube

TEST(AddedColumn, IsEverywhereInSweeps) {
  SweepRow row;
  row.point = 3;
  row.varied = kScale;
  row.values[kScale] = 0.5;
  row.means[1] = 21.0;
  test::expect_added_column_everywhere(sweep_table(), row);
}

TEST(LatinHypercube, HasOnePointInEachIntervalOfEachDimension) {
  for (const std::size_t count : {1u, 2u, 7u, 100u, 1000u}) {
    for (const char* const dimension : {"sight_delay_s", "scale"}) {
      std::set<double> intervals;
      for (const double x : hypercube_coordinates(23, dimension, count)) {
        EXPECT_GE(x, 0.0);
        EXPECT_LT(x, 1.0);
        intervals.insert(std::floor(x * static_cast<double>(count)));
      }
      EXPECT_EQ(intervals.size(), count);
    }
  }
}

TEST(LatinHypercube, DimensionsAndSeedsAreUncorrelated) {
  constexpr std::size_t kCount = 10'000;
  const auto a = hypercube_coordinates(23, "a", kCount);
  for (const auto& b :
       {hypercube_coordinates(23, "b", kCount), hypercube_coordinates(24, "a", kCount)}) {
    double sum = 0.0;
    for (std::size_t i = 0; i < kCount; ++i) sum += (a[i] - 0.5) * (b[i] - 0.5);
    // The correlation of n independent pairs has the standard deviation 1 / sqrt(n).
    EXPECT_LT(std::abs(12.0 * sum / kCount), 5.0 / std::sqrt(kCount));
  }
}

TEST(SweepPoints, AreTheBaseEachOtherLevelAndTheHypercube) {
  const Sweep sweep = small_sweep();
  const auto points = sweep_points(sweep);
  ASSERT_EQ(points.size(), static_cast<std::size_t>(kAllPoints));
  EXPECT_EQ(points.front().block, SweepBlock::kBase);
  // Twelve parameters with two levels each. The base plan has one level of the last six; its
  // persons draw the first six, so that both levels are new.
  std::map<std::size_t, std::vector<double>> levels;
  for (const SweepPoint& point : points) {
    if (point.block != SweepBlock::kOneAtATime) continue;
    levels[*point.varied].push_back(*point.values[*point.varied]);
    EXPECT_EQ(point.participants, 2);
    for (std::size_t i = 0; i < kSweepParameterCount; ++i) {
      if (i != *point.varied) {
        EXPECT_EQ(point.values[i], points.front().values[i]);
      }
    }
  }
  EXPECT_EQ(levels[kSightDelay], (std::vector<double>{0.1, 0.2}));
  EXPECT_EQ(levels[kDeviceStiffness], (std::vector<double>{500.0}));
  EXPECT_EQ(levels[kSweptFollowing],
            (std::vector<double>{static_cast<double>(Following::kFrozen)}));
  EXPECT_EQ(levels[kScale], (std::vector<double>{0.5}));
}

TEST(SweepPoints, OfTheHypercubeLieInTheRangesOfLiterature) {
  nlohmann::json json = small_sweep_json();
  json["hypercube"]["points"] = 200;
  const auto points = sweep_points(sweep_of(json));
  const OperatorFile literature = *load_operator("literature");
  std::map<std::size_t, std::pair<double, double>> expected = {{kDeviceStiffness, {500.0, 1000.0}},
                                                               {kComfortableDepth, {0.005, 0.01}},
                                                               {kStartOrientation, {0.0, 45.0}}};
  for (std::size_t i = 0; i < kSweepParameterCount; ++i) {
    for (std::size_t j = 0; j < kPersonParameterCount; ++j) {
      if (sweep_parameters()[i].name != person_parameters()[j].name) continue;
      expected[i] = {literature.ranges[j].low, literature.ranges[j].high};
    }
  }
  ASSERT_EQ(expected.size(), 9u);
  for (const auto& [parameter, range] : expected) {
    std::set<double> intervals;
    for (const SweepPoint& point : points) {
      if (point.block != SweepBlock::kHypercube) continue;
      const double share = (*point.values[parameter] - range.first) / (range.second - range.first);
      EXPECT_TRUE(share >= 0.0 && share <= 1.0) << sweep_parameters()[parameter].name;
      intervals.insert(std::floor(share * 200.0));
    }
    EXPECT_GE(intervals.size(), 199u);  // a value on a border may be rounded into its neighbour
  }
  for (const std::size_t listed : {std::size_t{kSweptFollowing}, std::size_t{kScale}}) {
    const auto first = std::count_if(points.begin(), points.end(), [&](const SweepPoint& point) {
      return point.block == SweepBlock::kHypercube &&
             *point.values[listed] == (listed == kScale ? 0.5 : 0.0);
    });
    EXPECT_EQ(first, 100);
  }
}

TEST(SweepPoints, OfOneParameterDoNotDependOnTheOthers) {
  nlohmann::json json = small_sweep_json();
  json["parameters"].erase("force_noise");
  json["parameters"].erase("scale");
  const auto all = sweep_points(small_sweep());
  const auto fewer = sweep_points(sweep_of(json));
  for (std::size_t i = 1; i <= 6; ++i) {
    EXPECT_EQ(all[all.size() - i].values[kSightDelay], fewer[fewer.size() - i].values[kSightDelay]);
    EXPECT_FALSE(fewer[fewer.size() - i].values[kForceNoise].has_value());
  }
}

}  // namespace
}  // namespace palpate
