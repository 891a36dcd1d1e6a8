#include "haptics/proxy/slide_extrapolation.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::Random;

// Slides of lengths 1, k, k^2, ... in one direction add up to 1 / (1 - k). The factors and sums are
// exact in binary.
TEST(SlideExtrapolation, ReachesTheSumOfShrinkingSlides) {
  for (const double k : {0.5, 0.75, 0.875}) {
    SlideExtrapolation extrapolation;
    Vec3 proxy = Vec3::Zero();
    extrapolation.begin(proxy);
    Vec3 slide(1, 0, 0);
    for (int i = 0; i < 6; ++i) {
      proxy += slide;
      const double reach = extrapolation.reach_of(slide, proxy, 0.0);
      EXPECT_EQ(reach, i == 0 ? 1.0 : 1.0 / (1.0 - k)) << "slide " << i << ", k = " << k;
      slide *= k;
    }
  }
}

TEST(SlideExtrapolation, ReachesNoFartherThanTheSlideAfterATurn) {
  Random random(4704);
  for (int i = 0; i < 100; ++i) {
    SlideExtrapolation extrapolation;
    const Vec3 first = random.unit_vector();
    const Vec3 across = first.unitOrthogonal();
    const Vec3 second = 0.5 * across;
    extrapolation.begin(Vec3::Zero());
    EXPECT_EQ(extrapolation.reach_of(first, first, 0.0), 1.0);
    EXPECT_EQ(extrapolation.reach_of(second, first + second, 0.0), 1.0);
  }
}

TEST(SlideExtrapolation, GrowsByAFactorWhileSlidesDoNotShrink) {
  SlideExtrapolation extrapolation;
  extrapolation.begin(Vec3::Zero());
  const Vec3 slide(1, 0, 0);
  Vec3 proxy = slide;
  EXPECT_EQ(extrapolation.reach_of(slide, proxy, 0.0), 1.0);
  proxy += slide;
  EXPECT_EQ(extrapolation.reach_of(slide, proxy, 0.0), 4.0);
  proxy += slide;
  EXPECT_EQ(extrapolation.reach_of(slide, proxy, 0.0), 16.0);
  extrapolation.fail(128.0, 1.0);
  proxy += slide;
  EXPECT_EQ(extrapolation.reach_of(slide, proxy, 0.0), 8.0);
  proxy += slide;
  EXPECT_EQ(extrapolation.reach_of(slide, proxy, 1000.0), 1000.0);  // of a slide of length 1
}

TEST(SlideExtrapolation, LeapsEveryEightStepsAndFartherAfterEachSuccess) {
  SlideExtrapolation extrapolation;
  Vec3 proxy = Vec3::Zero();
  extrapolation.begin(proxy);
  double reach = 1.0;
  for (const bool is_nearer : {true, true, false, true}) {
    const Vec3 from = proxy;
    for (int step = 1; step <= 8; ++step) {
      proxy += Vec3(0.125, 0, 0);
      EXPECT_EQ(extrapolation.is_leap_due(), step == 8);
    }
    EXPECT_EQ(extrapolation.leap_from(proxy), reach * (proxy - from));
    extrapolation.end_leap(proxy, is_nearer);
    reach = is_nearer ? 4.0 * reach : 1.0;
  }
}

// A leap for which too few steps are left stays due.
TEST(SlideExtrapolation, TriesAgainALeapThatHasNotBeenMade) {
  SlideExtrapolation extrapolation;
  extrapolation.begin(Vec3::Zero());
  for (int step = 1; step < 8; ++step) EXPECT_FALSE(extrapolation.is_leap_due());
  EXPECT_TRUE(extrapolation.is_leap_due());
  EXPECT_TRUE(extrapolation.is_leap_due());
}

TEST(SlideExtrapolation, KnowsTheLastFeatureUntilTheSphereBecomesSlowAgain) {
  SlideExtrapolation extrapolation;
  FaceContact edge{};
  edge.face.slot = 7;
  edge.normal = edge.feature_point = Vec3::UnitZ();
  extrapolation.begin(Vec3::Zero());
  EXPECT_FALSE(extrapolation.go_round(edge));
  const auto last = extrapolation.go_round(edge);
  ASSERT_TRUE(last);
  EXPECT_EQ(last->face.slot, 7U);
  extrapolation.begin(Vec3::Zero());
  EXPECT_FALSE(extrapolation.go_round(edge));
}

}  // namespace
}  // namespace palpate
