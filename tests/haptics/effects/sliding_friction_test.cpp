// Continued sliding: from the first slip on, the tangential force is mu_k times the normal force in
// every tick. This holds for any further motion of the hand, whether the hand moves or the plate
// under it.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <ostream>
#include <vector>

#include <gtest/gtest.h>

#include "engine/simulation/mass_damper.h"
#include "haptics/haptic_loop.h"
#include "haptics/record_vectors.h"
#include "models/primitives.h"
#include "tests/haptics/proxy/body_hand.h"
#include "tests/haptics/three_axes.h"
#include "tests/helpers/effect_programs.h"
#include "tests/helpers/floating_point.h"
#include "tests/helpers/made.h"
#include "tests/helpers/owned_bodies.h"
#include "tests/helpers/random.h"
#include "tests/helpers/same_cone.h"
#include "tests/helpers/ticks.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::effect_entry;
using test::hand_settings;
using test::kNan;
using test::kStiffness_N_per_m;
using test::kTick_s;
using test::OwnedBodies;
using test::OwnedWorld;
using test::Random;
using test::Soup;
using test::three_axes;
using test::with_friction;

constexpr double kRatio = 1e-9;  // tolerance of the ratio of tangential to normal force

Soup plate_soup(double half_m) {
  Soup soup;
  soup.add_quad({-half_m, -half_m, 0}, {half_m, -half_m, 0}, {half_m, half_m, 0},
                {-half_m, half_m, 0});
  return soup;
}

// The hand moves over a plate at rest, or the plate moves under a hand at rest: it is shifted, or
// turned about its middle.
enum class Mover { kHand, kPlate, kTurningPlate };

struct Slide {
  double mu_s, mu_k, depth_m, damping;
  Mover mover = Mover::kHand;

  bool moves_plate() const { return mover != Mover::kHand; }
};

std::ostream& operator<<(std::ostream& out, const Slide& s) {
  return out << "mu_s " << s.mu_s << ", mu_k " << s.mu_k << ", depth " << s.depth_m << " m, B "
             << s.damping
             << (s.mover == Mover::kHand    ? ", hand moves"
                 : s.mover == Mover::kPlate ? ", plate moves"
                                            : ", plate turns");
}

Slide random_slide(Random& random) {
  Slide s;
  s.mu_k = random.uniform(0.05, 1.0);
  s.mu_s = s.mu_k * random.uniform(1.0, 3.0);
  s.depth_m = std::pow(10.0, random.uniform(-4.0, std::log10(5e-3)));
  s.damping = random.index(2) == 0 ? 0.0 : random.uniform(0.1, 5.0);
  s.mover = random.index(2) == 0 ? Mover::kHand : Mover::kPlate;
  return s;
}

// A plate and a hand, in random poses of scene and device. Positions are those of the hand in the
// plate's frame, whichever of the two moves.
class PlateHand {
 public:
  PlateHand(const Slide& slide, double half_m, Random& random)
      : slide_(slide),
        T_scene_plate_(random.pose(1.0)),
        rotation_at_start_(T_scene_plate_.rotation),
        T_device_scene_(random.pose(1.0)),
        plate_({{plate_soup(half_m), T_scene_plate_}}) {
    plate_.set_effects(with_friction(slide.mu_s, slide.mu_k));
    HapticSettings s = hand_settings(kStiffness_N_per_m, slide.damping);
    s.initial_pose = T_device_scene_;
    loop_ = test::made(HapticLoop::create(plate_.world(), three_axes(), s));
  }

  // Moves to this place in the plate's plane, pressing. The first call arrives from above.
  const TickRecord& go_to(double x_m, double y_m) { return go_to({x_m, y_m, -slide_.depth_m}); }
  const TickRecord& go_to(const Vec3& hand_plate) {
    if (!has_started_) {
      hand_scene_ = T_scene_plate_.point(hand_plate);
      const Vec3 above(hand_plate.x(), hand_plate.y(), 1e-3);
      loop_->tick(T_device_scene_.point(T_scene_plate_.point(above)), kTick_s);
      has_started_ = true;
    }
    if (slide_.mover == Mover::kTurningPlate) {
      const double angle_rad = std::atan2(hand_plate.y(), hand_plate.x());
      const Quat turn(Eigen::AngleAxisd(-angle_rad, Vec3::UnitZ()));
      T_scene_plate_.rotation = (rotation_at_start_ * turn).normalized();
    }
    if (slide_.moves_plate()) {
      T_scene_plate_.translation_m = hand_scene_ - T_scene_plate_.rotation * hand_plate;
      loop_->move_body(0, T_scene_plate_);
    } else {
      hand_scene_ = T_scene_plate_.point(hand_plate);
    }
    record_ = loop_->tick(T_device_scene_.point(hand_scene_), kTick_s);
    return record_;
  }

  const TickRecord& record() const { return record_; }
  HapticLoop& loop() { return *loop_; }
  Vec3 device_m(const Vec3& p_plate) const {
    return T_device_scene_.point(T_scene_plate_.point(p_plate));
  }
  Vec3 proxy() const { return T_scene_plate_.inverse_point(vec3(record_.proxy_scene_m)); }
  bool sticks() const { return record_.friction == FrictionState::kSticks; }
  bool slides() const { return record_.friction == FrictionState::kSlides; }
  // The ratio of tangential to normal force.
  double ratio() const {
    const Vec3 f = T_scene_plate_.inverse_direction(
        T_device_scene_.inverse_direction(vec3(record_.force_device_N)));
    return std::hypot(f.x(), f.y()) / f.z();
  }

 private:
  Slide slide_;
  RigidTransform T_scene_plate_;
  Quat rotation_at_start_;
  RigidTransform T_device_scene_;
  OwnedBodies plate_;
  std::optional<HapticLoop> loop_;
  Vec3 hand_scene_ = Vec3::Zero();
  TickRecord record_;
  bool has_started_ = false;
};

// The least number of ticks until the lag is mu_s d on a straight path.
int ticks_to_slip(const Slide& s, double step_m) {
  return static_cast<int>(s.mu_s * s.depth_m / step_m) + 2;
}

// Checks the ticks of a hand in continued motion: it sticks, slips once, and slides from then on.
class Judge {
 public:
  explicit Judge(const Slide& slide) : slide_(slide) {}

  testing::AssertionResult operator()(const PlateHand& hand) {
    if (!hand.record().contact || hand.record().faults != kFaultNone) {
      return testing::AssertionFailure() << "no contact, or a fault, in tick " << ticks();
    }
    if (slips_ == 0 && hand.sticks()) {
      ++sticks_;
      if (hand.ratio() <= slide_.mu_s * (1.0 + kRatio)) return testing::AssertionSuccess();
      return testing::AssertionFailure() << "sticks at a ratio of " << hand.ratio();
    }
    ++slips_;
    const double off = std::abs(hand.ratio() - slide_.mu_k);
    worst_ = std::max(worst_, off);
    if (hand.slides() && off <= kRatio) return testing::AssertionSuccess();
    return testing::AssertionFailure()
           << "tick " << ticks() << ": " << (hand.slides() ? "slides" : "does not slide")
           << " at a ratio of " << hand.ratio() << ", " << slips_ << " ticks after the first slip";
  }
  int ticks() const { return sticks_ + slips_; }
  int sliding_ticks() const { return slips_; }
  double worst() const { return worst_; }

 private:
  Slide slide_;
  int sticks_ = 0;
  int slips_ = 0;
  double worst_ = 0.0;
};

constexpr double kPlateHalf_m = 0.6;

TEST(SlidingFriction, KeepsTheRatioInEveryTickOfAStraightPath) {
  Random random(5201);
  double worst = 0.0;
  int ticks = 0;
  for (int run = 0; run < 200; ++run) {
    const Slide slide = random_slide(random);
    const double step_m = kTick_s * std::pow(10.0, random.uniform(-3.0, 0.0));
    SCOPED_TRACE(testing::Message() << "run " << run << ": " << slide << ", step " << step_m);
    PlateHand hand(slide, kPlateHalf_m, random);
    Judge judge(slide);
    const double angle = random.uniform(-std::numbers::pi, std::numbers::pi);
    const Vec3 start = random.in_box(0.02);
    const int most = static_cast<int>(0.5 / step_m);
    const int count = std::min(most, ticks_to_slip(slide, step_m) + 400);
    for (int n = 0; n < count; ++n) {
      hand.go_to(start.x() + n * step_m * std::cos(angle),
                 start.y() + n * step_m * std::sin(angle));
      ASSERT_TRUE(judge(hand));
    }
    ASSERT_GT(judge.sliding_ticks(), 100);
    worst = std::max(worst, judge.worst());
    ticks += judge.sliding_ticks();
  }
  std::printf("straight: %d sliding ticks, ratio off by %.1e at most\n", ticks, worst);
}

TEST(SlidingFriction, KeepsTheRatioInEveryTickOfACircle) {
  Random random(5202);
  double worst = 0.0;
  int ticks = 0;
  for (int run = 0; run < 200; ++run) {
    Slide slide = random_slide(random);
    if (run % 3 == 0) slide.mover = Mover::kTurningPlate;
    const double step_m = kTick_s * std::pow(10.0, random.uniform(-3.0, 0.0));
    const double radius_m = slide.mu_s * slide.depth_m * random.uniform(1.05, 10.0);
    SCOPED_TRACE(testing::Message() << "run " << run << ": " << slide << ", step " << step_m
                                    << ", radius " << radius_m);
    if (step_m > 0.5 * radius_m) continue;  // too coarse for a circle
    PlateHand hand(slide, kPlateHalf_m, random);
    Judge judge(slide);
    const int turn = static_cast<int>(2.0 * std::numbers::pi * radius_m / step_m);
    const int count = std::min(2 * turn, 20000) + ticks_to_slip(slide, step_m);
    for (int n = 0; n < count; ++n) {
      const double angle = n * step_m / radius_m;
      hand.go_to(radius_m * std::cos(angle), radius_m * std::sin(angle));
      ASSERT_TRUE(judge(hand));
    }
    ASSERT_GT(judge.sliding_ticks(), 0);
    worst = std::max(worst, judge.worst());
    ticks += judge.sliding_ticks();
  }
  EXPECT_GT(ticks, 100000);
  std::printf("circle: %d sliding ticks, ratio off by %.1e at most\n", ticks, worst);
}

// While the hand is at rest, the friction state, the force and the proxy stay the same, to the bit.
TEST(SlidingFriction, KeepsTheRatioWhileTheHandStopsAndMovesOn) {
  Random random(5203);
  for (int run = 0; run < 100; ++run) {
    const Slide slide = random_slide(random);
    const double step_m = kTick_s * std::pow(10.0, random.uniform(-3.0, 0.0));
    SCOPED_TRACE(testing::Message() << "run " << run << ": " << slide << ", step " << step_m);
    PlateHand hand(slide, kPlateHalf_m, random);
    Judge judge(slide);
    double x_m = 0.0;
    const int before = ticks_to_slip(slide, step_m) + 10;
    for (int n = 0; n < before; ++n) {
      hand.go_to(x_m += step_m, 0.0);
      ASSERT_TRUE(judge(hand));
    }
    ASSERT_TRUE(hand.slides());
    for (int stop = 0; stop < 3; ++stop) {
      const int slow_ticks = 60;
      for (int n = 0; n < slow_ticks; ++n) {
        hand.go_to(x_m += step_m * std::pow(0.5, n), 0.0);
        ASSERT_TRUE(judge(hand)) << "slowing down, " << n;
      }
      hand.go_to(x_m, 0.0);
      const Vec3 rest = vec3(hand.record().proxy_scene_m);
      for (int n = 0; n < 200; ++n) {
        hand.go_to(x_m, 0.0);
        ASSERT_TRUE(judge(hand)) << "at rest";
        ASSERT_EQ(vec3(hand.record().proxy_scene_m), rest);
      }
      for (int n = slow_ticks; n >= 0; --n) {
        hand.go_to(x_m += step_m * std::pow(0.5, n), 0.0);
        ASSERT_TRUE(judge(hand)) << "moving on, " << n;
      }
    }
  }
}

TEST(SlidingFriction, KeepsTheRatioWithGoalsRoundedToAnEncodersStep) {
  constexpr double kQuantum_m = 20e-6;
  Random random(5204);
  for (int run = 0; run < 100; ++run) {
    const Slide slide = random_slide(random);
    const double step_m = kTick_s * std::pow(10.0, random.uniform(-3.0, 0.0));
    SCOPED_TRACE(testing::Message() << "run " << run << ": " << slide << ", step " << step_m);
    PlateHand hand(slide, kPlateHalf_m, random);
    Judge judge(slide);
    const double angle = random.uniform(-std::numbers::pi, std::numbers::pi);
    const auto rounded = [](double x) { return kQuantum_m * std::round(x / kQuantum_m); };
    const int most = static_cast<int>(0.5 / step_m);
    const int count = std::min(most, ticks_to_slip(slide, step_m) + 1000);
    for (int n = 0; n < count; ++n) {
      hand.go_to(rounded(n * step_m * std::cos(angle)), rounded(n * step_m * std::sin(angle)));
      ASSERT_TRUE(judge(hand));
    }
    ASSERT_GT(judge.sliding_ticks(), 100);
  }
}

TEST(SlidingFriction, SticksOncePerReversal) {
  Random random(5205);
  for (int run = 0; run < 100; ++run) {
    const Slide slide = random_slide(random);
    const double step_m =
        (slide.mu_s + slide.mu_k) * slide.depth_m / std::pow(10.0, random.uniform(0.5, 3.0));
    SCOPED_TRACE(testing::Message() << "run " << run << ": " << slide << ", step " << step_m);
    PlateHand hand(slide, kPlateHalf_m, random);
    const double way_m = 4.0 * slide.mu_s * slide.depth_m;
    const int ticks = static_cast<int>(way_m / step_m) + 10;
    double x_m = 0.0;
    double heading = step_m;
    for (int reversal = 0; reversal < 4; ++reversal, heading = -heading) {
      int sticks = 0;
      bool has_slipped = false;
      for (int n = 0; n < ticks; ++n) {
        hand.go_to(x_m += heading, 0.0);
        sticks += hand.sticks();
        has_slipped = has_slipped || (reversal > 0 && n > 0 && hand.slides());
        if (reversal > 0 && has_slipped) {
          ASSERT_TRUE(hand.slides()) << "sticks twice";
        }
      }
      ASSERT_TRUE(hand.slides());
      if (reversal == 0) continue;
      const double expected = (slide.mu_s + slide.mu_k) * slide.depth_m / step_m;
      ASSERT_NEAR(sticks, expected, 1.0);
    }
  }
}

TEST(SlidingFriction, MovesOnlyInTheFirstPeriodOfATremor) {
  Random random(5206);
  for (int run = 0; run < 200; ++run) {
    Slide slide = random_slide(random);
    slide.mu_s = slide.mu_k * random.uniform(1.1, 3.0);
    SCOPED_TRACE(testing::Message() << "run " << run << ": " << slide);
    PlateHand hand(slide, kPlateHalf_m, random);
    const double step_m = 0.01 * slide.mu_s * slide.depth_m;
    double x_m = 0.0;
    for (int n = 0; n < 150; ++n) hand.go_to(x_m += step_m, 0.0);
    ASSERT_TRUE(hand.slides());
    const double amplitude_m =
        random.uniform(0.1, 0.999) * (slide.mu_s - slide.mu_k) * slide.depth_m;
    const double angle = random.uniform(-std::numbers::pi, std::numbers::pi);
    const int period = 20 + static_cast<int>(random.index(100));
    Vec3 rest = Vec3::Zero();
    for (int n = 1; n <= 10 * period; ++n) {
      const double off_m = amplitude_m * std::sin(2.0 * std::numbers::pi * n / period);
      hand.go_to(x_m + off_m * std::cos(angle), off_m * std::sin(angle));
      if (n == period) rest = hand.proxy();
      if (n <= period) continue;
      // A moving plate carries the proxy with it, up to rounding.
      ASSERT_LE((hand.proxy() - rest).norm(), slide.moves_plate() ? 1e-11 : 0.0) << n;
    }
    ASSERT_TRUE(hand.sticks());
  }
}

TEST(SlidingFriction, KeepsTheBitsOfAMillionTicksAtRest) {
  Random random(5207);
  for (const bool slides : {true, false}) {
    const Slide slide{0.6, 0.4, 2e-3, 1.0};
    PlateHand hand(slide, kPlateHalf_m, random);
    double x_m = 0.0;
    for (int n = 0; n < 40; ++n) hand.go_to(x_m += 1e-4, 0.0);
    if (!slides) hand.go_to(x_m -= 1e-4, 0.0);
    ASSERT_EQ(hand.slides(), slides);
    const Vec3 rest = vec3(hand.record().proxy_scene_m);
    for (int n = 0; n < 1000000; ++n) {
      const TickRecord& record = hand.go_to(x_m, 0.0);
      ASSERT_EQ(vec3(record.proxy_scene_m), rest) << n;
      ASSERT_EQ(hand.slides(), slides);
    }
    if (slides) {
      EXPECT_LE(std::abs(hand.ratio() - slide.mu_k), kRatio);
    }
  }
}

// Slides the hand such that its lag in the next tick is between the two cones.
void slide_on(PlateHand& hand, double& x_m) {
  for (int n = 0; n < 40; ++n) hand.go_to(x_m += 1e-4, 0.0);
  ASSERT_TRUE(hand.slides());
}

TEST(SlidingFriction, EndsWithTheContactAndWithFaultsOfZeroForce) {
  Random random(5208);
  const Slide slide{0.8, 0.4, 2e-3, 0.0};
  const auto sticks_after = [&](auto&& interrupt) {
    PlateHand hand(slide, kPlateHalf_m, random);
    double x_m = 0.0;
    slide_on(hand, x_m);
    interrupt(hand, x_m);
    const Vec3 before = vec3(hand.record().proxy_scene_m);
    hand.go_to(x_m += 1e-4, 0.0);
    return hand.sticks() && vec3(hand.record().proxy_scene_m) == before;
  };
  EXPECT_FALSE(sticks_after([](PlateHand&, double) {}));
  EXPECT_TRUE(sticks_after([](PlateHand& hand, double x_m) {
    hand.go_to({x_m, 0.0, 1e-4});
    EXPECT_EQ(hand.record().friction, FrictionState::kNone);
    // The hand enters the plate obliquely: at once, the lag is between 0.4 and 0.8 times the depth.
    hand.go_to(x_m + 1.2e-3, 0.0);
    EXPECT_TRUE(hand.sticks());
    EXPECT_NEAR(hand.proxy().x(), x_m + 1.2e-3 * 0.1 / 2.1, 1e-9);
  }));
  EXPECT_TRUE(sticks_after([](PlateHand& hand, double) {
    const TickRecord& bad = hand.loop().tick({kNan, 0, 0}, kTick_s);
    EXPECT_EQ(bad.friction, FrictionState::kNone);
  }));
  EXPECT_TRUE(sticks_after([](PlateHand& hand, double x_m) {
    hand.loop().tick(hand.device_m({x_m, 0.0, -2e-3}), 2.0);  // not a valid time step
  }));
  EXPECT_TRUE(sticks_after([](PlateHand& hand, double) {
    EXPECT_EQ(hand.loop().tick(hand.device_m({50.0, 0.0, 0.0}), kTick_s).faults, kFaultJump);
  }));
  // A damper gives a non-finite force in a tick that is too short.
  Slide damped = slide;
  damped.damping = 2.0;
  PlateHand hand(damped, kPlateHalf_m, random);
  double x_m = 0.0;
  slide_on(hand, x_m);
  const TickRecord& none = hand.loop().tick(hand.device_m({x_m, 0.0, -3e-3}), 1e-312);
  EXPECT_NE(none.faults & kFaultNonFiniteForce, 0u);
  EXPECT_EQ(none.friction, FrictionState::kNone);
  hand.go_to(x_m += 1e-4, 0.0);
  EXPECT_TRUE(hand.sticks());
}

TEST(SlidingFriction, EndsWithPlaceAndEndFrictionOfTheGodObject) {
  const OwnedWorld world(plate_soup(0.1));
  test::SameCone cone({0.8, 0.4});
  const FrictionSource source{cone};
  constexpr double kDepth_m = 1e-3;
  auto god_object = test::made(GodObject::create(world.world(), {}));
  const auto go_to = [&](double x_m) {
    return god_object.move_with_friction({x_m, 0, -kDepth_m}, std::nullopt, source);
  };
  const auto slide = [&] {
    god_object.place({0, 0, 1e-3});
    go_to(0.0);
    EXPECT_EQ(go_to(1e-3).friction, FrictionState::kSlides);
    EXPECT_EQ(go_to(1e-3).friction, FrictionState::kSlides);
  };
  slide();
  EXPECT_TRUE(go_to(1.1e-3).slid);
  god_object.end_friction();
  const ProxyState stuck = go_to(1.2e-3);
  EXPECT_EQ(stuck.friction, FrictionState::kSticks);
  EXPECT_FALSE(stuck.slid);
  slide();
  god_object.place({0, 0, 1e-3});
  // Half of the path is above the surface.
  EXPECT_EQ(go_to(1.2e-3).friction, FrictionState::kSticks);
  slide();
  god_object.move_to({1e-3, 0, -kDepth_m});  // without friction
  EXPECT_EQ(go_to(1.6e-3).friction, FrictionState::kSticks);
}

// The hand moves on over adjacent plates with different materials.
TEST(SlidingFriction, ContinuesAcrossMaterials) {
  Random random(5209);
  const FrictionEffect::Parameters materials[] = {
      {1.5, 0.5, nullptr}, {0.6, 0.5, nullptr}, {0.9, 0.3, nullptr}, {0.3, 0.3, nullptr}};
  constexpr double kWidth_m = 0.05;
  constexpr double kDepth_m = 2e-3;
  for (int run = 0; run < 20; ++run) {
    const RigidTransform pose = random.pose(0.5);
    std::vector<OwnedBodies::Placed> placed;
    test::EffectBodies effects;
    for (int i = 0; i < 4; ++i) {
      Soup soup;
      const double x = i * kWidth_m;
      soup.add_quad({x, -0.1, 0}, {x + kWidth_m, -0.1, 0}, {x + kWidth_m, 0.1, 0}, {x, 0.1, 0});
      placed.push_back({soup, pose});
      effects.add_body({effect_entry<FrictionEffect>(materials[i])});
    }
    OwnedBodies bodies(placed);
    bodies.set_effects(effects.finish());
    auto loop = test::made(HapticLoop::create(bodies.world(), three_axes(), hand_settings()));
    loop.tick(pose.point({0.01, 0, 1e-3}), kTick_s);
    const double step_m = random.uniform(2e-5, 1e-3);
    bool has_slipped = false;
    int slid_on[4] = {};
    for (double x_m = 0.01; x_m < 3.9 * kWidth_m; x_m += step_m) {
      const TickRecord& record = loop.tick(pose.point({x_m, 0.02, -kDepth_m}), kTick_s);
      has_slipped = has_slipped || record.friction == FrictionState::kSlides;
      if (!has_slipped) continue;
      ASSERT_EQ(record.friction, FrictionState::kSlides) << x_m;
      const double proxy_m = pose.inverse_point(vec3(record.proxy_scene_m)).x();
      const Vec3 f = pose.inverse_direction(vec3(record.force_device_N));
      const auto i = static_cast<std::size_t>(proxy_m / kWidth_m);
      // On a border, either side's cone may have limited the slide.
      if (std::abs(proxy_m / kWidth_m - std::round(proxy_m / kWidth_m)) < step_m / kWidth_m)
        continue;
      ASSERT_NEAR(std::hypot(f.x(), f.y()) / f.z(), materials[i].dynamic_friction, kRatio) << x_m;
      ++slid_on[i];
    }
    for (const int ticks : slid_on) EXPECT_GT(ticks, 5);
  }
}

// In a groove along y, each side bears d / (2 cos r) of the depth d, with r its slope angle;
// together the sides hold mu d / cos r.
TEST(SlidingFriction, ContinuesAlongAGroove) {
  Random random(5212);
  constexpr double kDepth_m = 2e-3;
  constexpr double kHalfLength_m = 0.3;
  for (int run = 0; run < 60; ++run) {
    const double rise_rad = random.uniform(0.05, 1.3);
    const double mu_k = random.uniform(0.05, 0.8);
    const double mu_s = mu_k * random.uniform(1.0, 3.0);
    const double x = 0.1 * std::cos(rise_rad);
    const double z = 0.1 * std::sin(rise_rad);
    Soup groove;
    groove.add_quad({0, -kHalfLength_m, 0}, {x, -kHalfLength_m, z}, {x, kHalfLength_m, z},
                    {0, kHalfLength_m, 0});
    groove.add_quad({-x, -kHalfLength_m, z}, {0, -kHalfLength_m, 0}, {0, kHalfLength_m, 0},
                    {-x, kHalfLength_m, z});
    const RigidTransform pose = random.pose(0.5);
    OwnedWorld world(groove, pose);
    world.set_effects(with_friction(mu_s, mu_k));
    auto loop = test::made(HapticLoop::create(world.world(), three_axes(), hand_settings()));
    const double lag_m = mu_k * kDepth_m / std::cos(rise_rad);
    const double step_m = random.uniform(0.01, 0.3) * lag_m;
    loop.tick(pose.point({0, -0.1, 1e-3}), kTick_s);
    bool has_slipped = false;
    int slides = 0;
    double y_m = -0.1;
    for (int n = 0; n < 600 && y_m < 0.2; ++n, y_m += step_m) {
      const TickRecord& record = loop.tick(pose.point({0, y_m, -kDepth_m}), kTick_s);
      has_slipped = has_slipped || record.friction == FrictionState::kSlides;
      if (!has_slipped) continue;
      ASSERT_EQ(record.friction, FrictionState::kSlides)
          << "rise " << rise_rad << ", mu " << mu_s << " " << mu_k << ", tick " << n;
      const Vec3 f = pose.inverse_direction(vec3(record.force_device_N));
      // The stand-offs lift the corner by their length over sine and cosine, compared with 2 mm.
      ASSERT_NEAR(std::abs(f.y()) / f.z(), mu_k / std::cos(rise_rad), 1e-6) << n;
      ++slides;
    }
    EXPECT_GT(slides, 50);
  }
}

// The path leads around a sphere of triangles. All edges are convex, so the surface bends away at
// each.
TEST(SlidingFriction, ContinuesOverTheEdgesOfAMesh) {
  Random random(5210);
  constexpr double kRadius_m = 0.05;
  const TriangleMesh mesh = icosphere(4, kRadius_m);
  for (const double proxy_radius_m : {0.0, 2e-3}) {
    OwnedWorld world(Soup{mesh.positions_m, mesh.triangles}, {}, proxy_radius_m);
    world.set_effects(with_friction(0.8, 0.4));
    // If a sphere is within a stand-off h of an edge and of the face beyond, either may hold it:
    // their normals differ by sqrt(2 h / r), and the ratio by (1 + 0.4^2) times that.
    const double stand_off_m = SolverScale::of(world.world().size_m, proxy_radius_m).stand_off_m;
    const double rounded =
        proxy_radius_m > 0.0 ? 1.16 * std::sqrt(2 * stand_off_m / proxy_radius_m) : 1e-9;
    for (int run = 0; run < 20; ++run) {
      HapticSettings s = hand_settings();
      s.god_object.radius_m = proxy_radius_m;
      auto loop = test::made(HapticLoop::create(world.world(), three_axes(), s));
      const Vec3 u = random.unit_vector();
      const Vec3 v = u.cross(random.unit_vector()).normalized();
      loop.tick((kRadius_m + proxy_radius_m + 1e-3) * u, kTick_s);
      const double deep_m = kRadius_m + proxy_radius_m - random.uniform(1e-3, 3e-3);
      const double step_rad = random.uniform(1e-3, 2e-2);
      bool has_slipped = false;
      int slides = 0;
      int capped = 0;
      // Ticks in which a sphere that came down from one face to another has its lag below the
      // dynamic cone. It slides again when its lag has grown back to that cone.
      int shorter = 0;
      for (double angle = 0.0; angle < 6.0; angle += step_rad) {
        const TickRecord& record =
            loop.tick(deep_m * (std::cos(angle) * u + std::sin(angle) * v), kTick_s);
        ASSERT_TRUE(record.contact);
        has_slipped = has_slipped || record.friction == FrictionState::kSlides;
        if (!has_slipped) continue;
        const bool is_shorter = record.friction == FrictionState::kSticks;
        ASSERT_FALSE(is_shorter && proxy_radius_m == 0.0) << run << " " << angle;
        const double press_N = vec3(record.force_device_N).dot(vec3(record.normal_scene));
        const double side_N =
            (vec3(record.force_device_N) - press_N * vec3(record.normal_scene)).norm();
        if ((record.faults & kFaultSolverCapped) != 0) {
          ++capped;
          continue;
        }
        if (is_shorter) {
          ++shorter;
          ASSERT_LT(side_N / press_N, 0.4) << run << " " << angle;
          continue;
        }
        ASSERT_NEAR(side_N / press_N, 0.4, rounded) << run << " " << angle;
        ++slides;
      }
      EXPECT_GT(slides, 200);
      EXPECT_LE(capped, proxy_radius_m > 0.0 ? slides / 100 : 0) << run;
      EXPECT_LE(shorter, slides / 100) << run;
    }
  }
}

// Two steps per tick are too few to pass an edge, so the motion is capped at each edge.
TEST(SlidingFriction, ContinuesThroughCappedTicks) {
  const TriangleMesh mesh = icosphere(5, 0.05);
  OwnedWorld world(Soup{mesh.positions_m, mesh.triangles});
  world.set_effects(with_friction(0.9, 0.3));
  HapticSettings s = hand_settings();
  s.god_object.accuracy.iterations = 2;
  auto loop = test::made(HapticLoop::create(world.world(), three_axes(), s));
  loop.tick({0, 0, 0.052}, kTick_s);
  for (int n = 0; n < 20; ++n) loop.tick({0, 0, 0.047}, kTick_s);
  int capped = 0;
  bool has_slipped = false;
  for (double angle = 0.0; angle < 3.0; angle += 2e-3) {
    const Vec3 at = 0.047 * Vec3(std::sin(angle), 0.1 * angle, std::cos(angle)).normalized();
    const TickRecord& record = loop.tick(at, kTick_s);
    has_slipped = has_slipped || record.friction == FrictionState::kSlides;
    capped += has_slipped && (record.faults & kFaultSolverCapped) != 0;
    ASSERT_FALSE(has_slipped && record.friction != FrictionState::kSlides) << angle;
  }
  std::printf("capped: %d ticks\n", capped);
  EXPECT_TRUE(has_slipped);
  EXPECT_GT(capped, 20);
}

// The plate trembles along its normal, and along its plane together with the hand. Neither makes
// the contact stick longer than the added depth requires.
TEST(SlidingFriction, ContinuesWhileThePlateMovesWithTheHand) {
  Random random(5211);
  const RigidTransform pose = random.pose(0.5);
  OwnedBodies bodies({{plate_soup(0.3), pose}});
  bodies.set_effects(with_friction(0.9, 0.3));
  auto loop = test::made(HapticLoop::create(bodies.world(), three_axes(), hand_settings()));
  const double depth_m = 2e-3;
  loop.tick(pose.point({0, 0, 1e-3}), kTick_s);
  double x_m = 0.0;
  for (int n = 0; n < 40; ++n) loop.tick(pose.point({x_m += 1e-4, 0, -depth_m}), kTick_s);
  Vec3 proxy =
      pose.inverse_point(vec3(loop.tick(pose.point({x_m, 0, -depth_m}), kTick_s).proxy_scene_m));
  for (int n = 1; n <= 500; ++n) {
    const Vec3 shift = 1e-4 * n * Vec3(0.6, 0.8, 0.0) + 1e-5 * (n % 3) * Vec3::UnitZ();
    const RigidTransform moved{pose.rotation, pose.point(shift)};
    loop.move_body(0, moved);
    const TickRecord& record = loop.tick(moved.point({x_m, 0, -depth_m}), kTick_s);
    ASSERT_EQ(record.friction, FrictionState::kSlides) << n;
    ASSERT_LE((moved.inverse_point(vec3(record.proxy_scene_m)) - proxy).norm(), 1e-11);
  }
}

// ---- a device with mass, pulled along the plate by a spring -------------------------------------

// The depth is constant. The spring pulls from a place that moves at a constant speed.
struct Pulled {
  double speed_m_per_s;
  double seconds;
  int slips = 0;                 // from sticking to sliding
  int sticking = 0;              // ticks after the first slip
  int sliding = 0;               // ticks after the first slip
  double slowest_m_per_s = 0.0;  // after the first slip

  static constexpr double kDepth_m = 2e-3;  // 2 N
  static constexpr double kMass_kg = 0.2;
  static constexpr double kDamping_Ns_per_m = 1.0;
  static constexpr double kSpring_N_per_m = 50.0;

  void run() {
    OwnedWorld world(plate_soup(1.5));
    world.set_effects(with_friction(1.0, 0.4));
    auto loop = test::made(HapticLoop::create(world.world(), three_axes(), hand_settings()));
    constexpr double kStart_m = -1.0;
    loop.tick({kStart_m, 0, 1e-3}, kTick_s);
    MassDamper device(kMass_kg, kDamping_Ns_per_m);
    device.put({kStart_m, 0, -kDepth_m}, Vec3::Zero());
    bool has_slipped = false;
    bool slid = false;
    const int ticks = static_cast<int>(seconds / kTick_s);
    for (int n = 0; n < ticks; ++n) {
      const TickRecord& record = loop.tick(device.position_m(), kTick_s);
      const bool slides = record.friction == FrictionState::kSlides;
      slips += slides && !slid;
      slid = slides;
      has_slipped = has_slipped || slides;
      sticking += has_slipped && !slides;
      sliding += slides;
      if (slides) {
        ASSERT_NEAR(std::abs(vec3(record.force_device_N).x()),
                    0.4 * vec3(record.force_device_N).z(), 1e-9);
      }
      constexpr int kSubsteps = 10;
      for (int i = 0; i < kSubsteps; ++i) {
        const double time_s = (n + static_cast<double>(i) / kSubsteps) * kTick_s;
        const double pull_N =
            kSpring_N_per_m * (kStart_m + speed_m_per_s * time_s - device.position_m().x());
        device.advance({vec3(record.force_device_N).x() + pull_N, 0.0, 0.0}, kTick_s / kSubsteps);
      }
      if (has_slipped && n > ticks / 2) {
        slowest_m_per_s = std::min(slowest_m_per_s, device.velocity_m_per_s().x());
      }
    }
  }
};

// Each slip relaxes the spring below its initial extension, so that it must be stretched again.
TEST(SlidingFriction, CausesStickSlipOfADeviceWithMassPulledSlowly) {
  Pulled slow{5e-3, 60.0};
  slow.run();
  std::printf("slow: %d slips, %d ticks sticking, %d sliding\n", slow.slips, slow.sticking,
              slow.sliding);
  EXPECT_GE(slow.slips, 4);
  EXPECT_LE(slow.slips, 20);
  EXPECT_GT(slow.sticking, 10 * slow.sliding);
}

// Let V be the speed, w = sqrt(k / m) and A = (mu_s - mu_k) N / (m w). The device's speed
// oscillates about V by sqrt(V^2 + A^2), with damping. If V is large enough, the speed never
// returns to zero.
TEST(SlidingFriction, ContinuesForADeviceWithMassPulledFast) {
  Pulled fast{0.5, 4.0};
  fast.run();
  std::printf("fast: %d slips, %d ticks sticking, %d sliding\n", fast.slips, fast.sticking,
              fast.sliding);
  EXPECT_EQ(fast.slips, 1);
  EXPECT_EQ(fast.sticking, 0);
  EXPECT_GT(fast.sliding, 3000);
}

}  // namespace
}  // namespace palpate
