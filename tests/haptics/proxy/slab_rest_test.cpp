// A point between two slabs that are about as far apart as it comes near to both. Positions are
// known from the gap alone: in a constant gap the point follows the goal along the slabs and leaves
// at the rims; in a gap that converges it rests where it stops at both slabs, and never creeps on.

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "haptics/proxy/god_object.h"
#include "tests/helpers/exact_judge.h"
#include "tests/helpers/floating_point.h"
#include "tests/helpers/hard_scenes.h"
#include "tests/helpers/made.h"
#include "tests/helpers/random.h"
#include "tests/helpers/rest_judge.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::ExactJudge;
using test::kEpsilon;
using test::OwnedWorld;
using test::Random;
using test::Soup;

constexpr int kSlabTrials = 300;
constexpr int kTicksBetween = 200;
constexpr double kHalfWidth = 0.2;  // half the width of the slabs, in sizes

// Two sheets with a gap that narrows linearly along x. The frame of the slabs has its origin in the
// lower sheet, and its unit is the size of the scene. With a constant gap, the sheets are squares;
// otherwise each is a triangle, and the proxy meets no other face beside it.
class SlabPair {
 public:
  // The gap at x = -kHalfWidth and at x = kHalfWidth, in stand-offs.
  SlabPair(double wide, double narrow, Random& random)
      : size_m_(std::pow(10.0, random.uniform(-3.0, 3.0))),
        pose_(random.index(3) ? random.pose(size_m_) : RigidTransform{}),
        wide_(wide),
        narrow_(narrow),
        world_(soup()),
        exact_(test::solver_triangles(world_)) {}

  double gap_so(double x) const {
    return wide_ + (narrow_ - wide_) * (x + kHalfWidth) / (2 * kHalfWidth);
  }
  // The point at x, y, at a height in units of the gap there: 0 is the lower sheet, 1 the upper.
  Vec3 solver(double x, double y, double height) const {
    const double z = height * gap_so(x) * SolverScale::kStandOffPerSize;
    return world_.world().to_solver(pose_.point(size_m_ * Vec3(x, y, z)));
  }
  Vec3 slab(const Vec3& p_solver) const {
    return pose_.inverse_point(world_.world().to_scene(p_solver)) / size_m_;
  }
  Vec3 direction(const Vec3& d) const { return size_m_ * pose_.direction(d); }
  // The distance from the nearer of the two sheets, in stand-offs.
  double clearance_so(const Vec3& p_solver) const {
    return exact_.distance_m(p_solver) / (SolverScale::kStandOffPerSize * world_.world().size_m);
  }

  double size_m() const { return world_.world().size_m; }
  const ContactWorld& world() const { return world_.world(); }
  const ExactJudge& exact() const { return exact_; }

 private:
  Soup soup() const {
    Soup soup;
    for (const double height : {0.0, 1.0}) {
      const auto at = [&](double x, double y) -> Vec3 {
        return size_m_ * Vec3(x, y, height * gap_so(x) * SolverScale::kStandOffPerSize);
      };
      if (wide_ == narrow_) {
        soup.add_quad(at(-kHalfWidth, -kHalfWidth), at(kHalfWidth, -kHalfWidth),
                      at(kHalfWidth, kHalfWidth), at(-kHalfWidth, kHalfWidth));
      } else {
        soup.add(at(-kHalfWidth, -0.3), at(2 * kHalfWidth, 0.0), at(-kHalfWidth, 0.3));
      }
    }
    for (Vec3& p : soup.positions) p = pose_.point(p);
    // Two specks in the corners of a cube give the scene its size.
    const Vec3 middle = pose_.point(Vec3::Zero());
    for (const double side : {-0.5, 0.5}) {
      const Vec3 corner = middle + side * size_m_ * Vec3::Ones();
      const double speck_m = 1e-3 * side * size_m_;
      soup.add(corner, corner - speck_m * Vec3::UnitX(), corner - speck_m * Vec3::UnitY());
    }
    return soup;
  }

  double size_m_;
  RigidTransform pose_;
  double wide_;
  double narrow_;
  OwnedWorld world_;
  ExactJudge exact_;
};

constexpr double kStopHeight = SolverScale::kStopPerStandOff;

// The rounding of a distance of the proxy from a sheet, in stand-offs: 64 ulps of the size.
constexpr double kHeightRound = 64 * kEpsilon / SolverScale::kStandOffPerSize;

// An improving segment gains more than this, in sizes.
constexpr double kLeastGain = 1e-9;

double power_between(Random& random, double low, double high) {
  return low * std::pow(high / low, random.uniform(0.0, 1.0));
}

TEST(PointBetweenSlabs, FollowsTheGoalInAConstantGapAndLeavesAtTheRims) {
  Random random(91);
  for (int trial = 0; trial < kSlabTrials; ++trial) {
    const double gap = random.index(2) ? 2 * kStopHeight : random.uniform(1.0, 3.0);
    const SlabPair slabs(gap, gap, random);
    auto god_object = test::made(GodObject::create(slabs.world(), {}));
    const double y = random.uniform(-0.9, 0.9) * kHalfWidth;
    god_object.place(slabs.solver(-1.2 * kHalfWidth, y, 0.5));
    const double inside = power_between(random, 1e-6, 1.0);
    const Vec3 first = slabs.solver((inside - 1.0) * kHalfWidth, y, 0.5);
    ASSERT_EQ(god_object.move_to(first).proxy, first) << "trial " << trial;
    // Behind a slab, at any depth: the point goes to the foot of the goal.
    const double at_x = random.uniform(-0.99, 0.99) * kHalfWidth;
    const double at_y = random.uniform(-0.99, 0.99) * kHalfWidth;
    const double deep = (random.index(2) ? 1.0 : -1.0) * power_between(random, 1e-7, 0.1);
    const Vec3 behind = slabs.solver(at_x, at_y, 0.0) + slabs.direction({0.0, 0.0, deep});
    const ProxyState held = god_object.move_to(behind);
    const Vec3 foot = slabs.slab(held.proxy);
    EXPECT_FALSE(held.capped);
    // A distance s from the foot is a gain of s^2 / (2 depth).
    const double off = std::hypot(foot.x() - at_x, foot.y() - at_y);
    EXPECT_LE(off * off, 2 * kLeastGain * (std::abs(deep) + kLeastGain))
        << "trial " << trial << ", " << gap;
    // A goal beside the slabs is reached.
    const double out = random.uniform(1.01, 2.0) * kHalfWidth;
    const Vec3 beside = slabs.solver(random.index(2) ? out : -out, at_y, 0.5);
    const ProxyState left = god_object.move_to(beside);
    EXPECT_LE((left.proxy - beside).norm(), 2 * kLeastGain * slabs.size_m())
        << "trial " << trial << ", gap " << gap;
  }
}

TEST(PointBetweenSlabs, RestsWhereItStopsAtBothSlabsIfTheyConvergeAndNeverCreepsOn) {
  Random random(92);
  for (int trial = 0; trial < kSlabTrials; ++trial) {
    const double wide = power_between(random, 3.0, 1e5);
    const double narrow = random.uniform(0.05, 0.4);
    const SlabPair slabs(wide, narrow, random);
    auto god_object = test::made(GodObject::create(slabs.world(), {}));
    const double y = random.uniform(-0.3, 0.3) * kHalfWidth;
    god_object.place(slabs.solver(-1.2 * kHalfWidth, y, 0.5));
    const Vec3 first = slabs.solver(-0.95 * kHalfWidth, y, 0.5);
    ASSERT_EQ(god_object.move_to(first).proxy, first) << "trial " << trial;
    // Goals behind either slab, where the gap is narrower than a stop.
    const auto x_of = [&](double gap) {
      return -kHalfWidth + 2 * kHalfWidth * (wide - gap) / (wide - narrow);
    };
    // A step that is shorter than a hundredth of a stand-off has converged.
    const double within = (0.02 + 4 * kHeightRound) * 2 * kHalfWidth / (wide - narrow);
    for (int tick = 0; tick < kTicksBetween; ++tick) {
      const double deep = (random.index(2) ? 1.0 : -1.0) * power_between(random, 1e-3, 0.1);
      const double goal_x = random.uniform(x_of(0.5), kHalfWidth);
      const Vec3 goal = slabs.solver(goal_x, y, 0.5) + slabs.direction({0.0, 0.0, deep});
      const ProxyState state = god_object.move_to(goal);
      EXPECT_FALSE(state.capped);
      EXPECT_NEAR(slabs.slab(state.proxy).x(), x_of(2 * kStopHeight), within)
          << "trial " << trial << ", tick " << tick;
      EXPECT_GE(slabs.clearance_so(state.proxy), kStopHeight - kHeightRound)
          << "trial " << trial << ", tick " << tick;
    }
    const Vec3 out = slabs.solver(-1.5 * kHalfWidth, y, 0.5);
    const ProxyState left = god_object.move_to(out);
    EXPECT_LE((left.proxy - out).norm(), 2 * kLeastGain * slabs.size_m()) << "trial " << trial;
  }
}

// The judge of rests reads a start slope as the engine's statement does: a segment into a gap that
// narrows is not free, however small the angle and however short the segment.
TEST(PointBetweenSlabs, IsJudgedByTheSlopeAtItsStart) {
  Random random(93);
  for (int trial = 0; trial < kSlabTrials; ++trial) {
    const bool narrows = trial % 2 == 0;
    const double angle_so = narrows ? power_between(random, 0.1, 1e4) : 0.0;
    const SlabPair slabs(2 * kStopHeight + 0.5 * angle_so, 2 * kStopHeight - 0.5 * angle_so,
                         random);
    const double stand_off_m = SolverScale::kStandOffPerSize * slabs.size_m();
    const test::RestJudge judge(slabs.size_m(), 0.0, stand_off_m);
    const Vec3 proxy = slabs.solver(0.0, 0.0, 0.5);
    const double far = power_between(random, 1e-2, 1.0) * kHalfWidth;
    const Vec3 goal = slabs.solver(far, 0.0, 0.5);
    const Vec3 back = slabs.solver(-far, 0.0, 0.5);
    EXPECT_EQ(judge.escape_from(slabs.exact(), {proxy, goal}).has_value(), !narrows)
        << "trial " << trial << ", the slabs converge by " << angle_so << " stand-offs";
    EXPECT_TRUE(judge.escape_from(slabs.exact(), {proxy, back})) << "trial " << trial;
  }
}

}  // namespace
}  // namespace palpate
