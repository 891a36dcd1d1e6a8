// The single-precision filter for triangles that a sphere cannot reach on a step, or on the first
// part of a step. It must never exclude a triangle that the sphere reaches according to long
// double.

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "geometry/index/pack_queries.h"
#include "geometry/index/simd.h"
#include "geometry/index/surface_index.h"
#include "tests/helpers/exact_judge.h"
#include "tests/helpers/random.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::Corners;
using test::ExactJudge;
using test::Random;
using test::Soup;

constexpr int kScenes = 1500;
constexpr int kStepsPerScene = 20;

double log_uniform(Random& random, double low, double high) {
  return low * std::pow(high / low, random.uniform(0.0, 1.0));
}

// Triangles of one size, some of them slivers, some far from the origin.
Soup some_triangles(Random& random) {
  Soup soup;
  const Vec3 middle = random.index(3) ? Vec3(Vec3::Zero()) : random.in_box(100.0);
  const double spread = log_uniform(random, 0.05, 3.0);
  const auto count = static_cast<int>(1 + random.index(40));
  for (int i = 0; i < count; ++i) {
    const Vec3 a = middle + random.in_box(spread);
    const Vec3 b = a + random.in_box(1.0);
    const double width = random.index(4) ? 1.0 : log_uniform(random, 1e-6, 1.0);
    soup.add(a, b, b + width * random.in_box(1.0));
  }
  return soup;
}

// A step of a sphere that almost touches, touches or penetrates a triangle.
struct Step {
  Vec3 p;
  Vec3 d;
};
Step some_step(Random& random, const std::vector<Corners>& triangles, double reach) {
  const Corners& t = triangles[random.index(triangles.size())];
  const double u = random.uniform(0.0, 1.0);
  const double v = random.uniform(0.0, 1.0 - u);
  const Vec3 place = random.index(3) ? Vec3(t.a + u * (t.b - t.a) + v * (t.c - t.a)) : t.a;
  const double gap = random.index(2) ? log_uniform(random, 1e-9, 1.0) : 0.0;
  const Vec3 away = random.unit_vector();
  Vec3 way = random.unit_vector();
  if (random.index(2)) way -= way.dot(away) * away;
  if (random.index(4) == 0) way = -away;
  return {place + (1.0 + gap) * reach * away, log_uniform(random, 1e-7, 3.0) * way};
}

class PackApproaches : public testing::TestWithParam<SimdLevel> {
 protected:
  void SetUp() override { limit_simd_level(GetParam()); }
  void TearDown() override { limit_simd_level(SimdLevel::kAvx512); }
};

TEST_P(PackApproaches, NeverExcludeATriangleInReach) {
  Random random(83);
  int lanes_told = 0;
  int lanes_out = 0;       // excluded for the whole step
  int lanes_out_part = 0;  // excluded for the first part of the step
  for (int scene = 0; scene < kScenes; ++scene) {
    const Soup soup = some_triangles(random);
    const SurfaceIndex index(SurfaceMesh::build(soup.positions, soup.triangles));
    std::vector<std::uint32_t> packs;
    std::vector<Corners> triangles;
    std::vector<int> number_of_slot(index.pack_count() * TrianglePack::kLanes, -1);
    for (std::uint32_t id = 0; id < index.pack_count(); ++id) {
      packs.push_back(id);
      for (int lane = 0; lane < index.pack(id).count; ++lane) {
        const TriangleGeometry& t = index.triangle(SurfaceIndex::slot(id, lane));
        number_of_slot[SurfaceIndex::slot(id, lane)] = static_cast<int>(triangles.size());
        triangles.push_back({t.a, t.b, t.c});
      }
    }
    if (triangles.empty()) continue;
    const ExactJudge judge(triangles);
    ASSERT_EQ(judge.triangles().size(), triangles.size());
    for (int n = 0; n < kStepsPerScene; ++n) {
      const double reach = log_uniform(random, 1e-3, 10.0);
      const auto [p, d] = some_step(random, triangles, reach);
      std::vector<PackApproach> found(packs.size());
      found.resize(lanes_in_reach(index.packs(), packs, p, d, reach, found.data()));
      std::vector<bool> is_told(triangles.size(), false);
      for (const PackApproach& in : found) {
        for (std::uint32_t lanes = in.lanes; lanes != 0;) {
          const int lane = take_lane(lanes);
          const auto number =
              static_cast<std::size_t>(number_of_slot[SurfaceIndex::slot(in.pack, lane)]);
          is_told[number] = true;
          ++lanes_told;
          const auto part = static_cast<float>(log_uniform(random, 1e-6, 1.0));
          if (in.may_be_in_reach_by(part, lane)) continue;
          ++lanes_out_part;
          ASSERT_GT(judge.distance_m(p, p + static_cast<double>(part) * d, number), reach)
              << "scene " << scene << ", step " << n << ", the first " << part;
        }
      }
      for (std::size_t i = 0; i < triangles.size(); ++i) {
        if (is_told[i]) continue;
        ++lanes_out;
        ASSERT_GT(judge.distance_m(p, p + d, i), reach) << "scene " << scene << ", step " << n;
      }
    }
  }
  std::printf("%d triangles in doubt, %d of them only later; %d ruled out\n", lanes_told,
              lanes_out_part, lanes_out);
  EXPECT_GT(lanes_out, lanes_told / 2);
  EXPECT_GT(lanes_out_part, lanes_told / 20);
}

INSTANTIATE_TEST_SUITE_P(Of, PackApproaches,
                         testing::Values(SimdLevel::kBaseline, SimdLevel::kAvx2,
                                         SimdLevel::kAvx512),
                         [](const auto& level) {
                           return std::string(level.param == SimdLevel::kBaseline ? "Sse2"
                                              : level.param == SimdLevel::kAvx2   ? "Avx2"
                                                                                  : "Avx512");
                         });

}  // namespace
}  // namespace palpate
