// For any scene and any motion of the hand, no improving segment exists from a rest of the proxy
// (rest_judge.h), and on its path the proxy neither leaks nor overlaps nor moves away from the
// goal. The tests cover points and spheres, three sensors and two, with friction and without, and
// the presets balanced and exact.
//
// The test prints one line for each class. The seed determines a scene:
//   PALPATE_SEED=N           runs only scene N
//   PALPATE_FIRST_SCENE=N    begins with scene N
//   PALPATE_REST_TICKS=N     sets the number of ticks for each class
//   PALPATE_REST_KEEP=X      sets the distance of segments from triangles to X stand-offs (1)
//   PALPATE_REST_SHOWN=N     sets the number of failures of each class that are printed in full
// A filter selects a class: --gtest_filter='*NeedleFansPoint'.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "haptics/proxy/god_object.h"
#include "tests/haptics/proxy/judging_tolerances.h"
#include "tests/haptics/proxy/work_budgets.h"
#include "tests/helpers/exact_judge.h"
#include "tests/helpers/floating_point.h"
#include "tests/helpers/hard_scenes.h"
#include "tests/helpers/made.h"
#include "tests/helpers/rest_judge.h"
#include "tests/helpers/rest_scenes.h"
#include "tests/helpers/same_cone.h"
#include "tests/helpers/soak.h"

namespace palpate {
namespace {

using test::Corners;
using test::DeviceMotion;
using test::ExactJudge;
using test::from_environment;
using test::hex;
using test::kEpsilon;
using test::kNearUlps;
using test::kOverlapPerSize;
using test::OwnedWorld;
using test::ProxyKind;
using test::Random;
using test::Rest;
using test::RestClass;
using test::RestHand;
using test::RestJudge;
using test::RestScene;
using test::SameCone;
using test::Violation;

// Largest distance of a corner from the plane of motion for each step of the tick, in ulps of the
// size of the scene and of coordinates. The number of steps counts as at least that of a balanced
// tick.
constexpr double kOffPlaneUlps = 6;
constexpr int kStepsAtLeast = 64;

// The number of ticks of a class. A soak test has ten million ticks over all classes. Huge spheres
// have a tenth of the ticks, since each takes long.
int ticks_of(const RestClass& rest_class) {
  const auto classes = static_cast<int>(test::rest_classes().size());
  const int ticks = test::in_soak_or_else(11'000'000 / classes, 4'000);
  const bool is_huge = std::string(rest_class.name).starts_with("Huge");
  return static_cast<int>(from_environment("PALPATE_REST_TICKS",
                                           static_cast<std::uint64_t>(ticks / (is_huge ? 10 : 1))));
}

constexpr int kTicksPerScene = 100;

double kept_by_ways() {
  const char* text = std::getenv("PALPATE_REST_KEEP");
  return text ? std::atof(text) : 1.0;
}

struct RestTotals {
  int scenes = 0;
  int ticks = 0;
  int contacts = 0;
  int ran_out = 0;  // ticks that ran out of work
  int capped = 0;   // other capped ticks in contact
  int judged = 0;   // rests that were judged
  int unproven = 0;
  int leaks = 0;
  int overlaps = 0;
  int false_rests = 0;
  int farther = 0;
  int most_iterations = 0;
  double worst_gain_m = 0.0;
  std::set<std::uint64_t> failing_scenes;
  std::uint64_t shown = 0;

  bool is_clean() const { return leaks + overlaps + false_rests + farther == 0; }
};

// A run of one proxy and one hand in one scene.
class RestRun {
 public:
  RestRun(const RestClass& rest_class, std::uint64_t seed, Random& random)
      : seed_(seed),
        random_(random),
        scene_(rest_class.make(rest_class.proxy, random)),
        radius_m_(scene_.radius_m),
        world_(scene_.soup, {}, radius_m_),
        exact_(test::solver_triangles(world_)),
        accuracy_(test::with_some_budget(random.index(4) ? Accuracy::balanced() : Accuracy::exact(),
                                         seed)),
        god_object_(test::made(GodObject::create(world_.world(), {radius_m_, accuracy_}))),
        size_m_(world_.world().size_m),
        round_m_(kEpsilon * std::max(size_m_, radius_m_)),
        rests_(size_m_, radius_m_, kept_by_ways() * god_object_.scale().stand_off_m),
        start_(pick_start()),
        hand_(exact_.triangles(), aims(), radius_m_, god_object_.scale().stand_off_m, scene_.grid_m,
              start_, random),
        device_(exact_.triangles(), aims(), start_, random) {
    is_device_ = scene_.grid_m == 0.0 && size_m_ > 0.05 && random.index(3) == 0;
    if (random.index(5) == 0) {
      plane_normal_ = random.index(2) ? random.unit_vector() : Vec3(Vec3::Unit(random.index(3)));
    }
    if (random.index(4) == 0) {
      const double mu_s = random.uniform(0.0, random.index(3) ? 1.0 : 4.0);
      cone_ = SameCone({mu_s, random.index(2) ? mu_s : mu_s * random.uniform(0.0, 1.0)});
    }
    god_object_.place(start_);
    state_.proxy = god_object_.proxy();
  }

  // Simulates and judges a tick. False if the proxy leaked, so that later ticks cannot be judged.
  bool tick(RestTotals& totals) {
    goal_ = is_device_ ? device_.next_goal(state_) : hand_.next_goal(state_);
    if (plane_normal_) goal_ -= plane_normal_->dot(goal_ - state_.proxy) * *plane_normal_;
    state_ = cone_ ? god_object_.move_with_friction(goal_, plane_normal_, friction())
                   : god_object_.move_to(goal_, plane_normal_);
    ++tick_;
    ++totals.ticks;
    totals.contacts += state_.in_contact;
    if (state_.work >= accuracy_.work_budget) {
      ++totals.ran_out;
    } else {
      totals.capped += state_.capped && state_.in_contact;
    }
    totals.most_iterations = std::max(totals.most_iterations, state_.iterations);
    if (!judge_path(totals)) return false;
    judge_rest(totals);
    return true;
  }

 private:
  std::vector<Vec3> aims() const {
    std::vector<Vec3> solver;
    for (const Vec3& p : scene_.aims) solver.push_back(world_.world().to_solver(p));
    return solver;
  }

  // A start that the proxy fits in, usually near a face.
  Vec3 pick_start() {
    const double room_m = radius_m_ + 1e-7 * std::max(size_m_, radius_m_);
    for (const Vec3& start : scene_.starts) {
      const Vec3 p = world_.world().to_solver(start);
      if (exact_.distance_m(p) > room_m) return p;
    }
    const std::vector<Corners>& all = exact_.triangles();
    for (int trial = 0;; ++trial) {
      const Corners& t = all[random_.index(all.size())];
      const double away_m = radius_m_ + size_m_ * std::pow(10.0, random_.uniform(-6.0, -1.0));
      Vec3 start = (t.a + t.b + t.c) / 3.0 + away_m * random_.unit_vector();
      if (trial > 50) start = random_.in_box(size_m_ + 4 * radius_m_);
      if (exact_.distance_m(start) > room_m) return start;
    }
  }

  FrictionSource friction() { return FrictionSource{*cone_}; }

  void show(RestTotals& totals, const std::string& what) const {
    totals.failing_scenes.insert(seed_);
    static const std::uint64_t most = from_environment("PALPATE_REST_SHOWN", 1);
    if (totals.shown++ >= most) return;
    std::printf("  PALPATE_SEED=%llu, tick %d, radius %g m, goal %s, iterations %d%s",
                static_cast<unsigned long long>(seed_), tick_, radius_m_, hex(goal_).c_str(),
                state_.iterations, accuracy_.iterations > 64 ? ", exact" : "");
    if (cone_)
      std::printf(", friction %g, %g", cone_->cone.static_friction, cone_->cone.dynamic_friction);
    if (plane_normal_) std::printf(", in the plane with normal %s", hex(*plane_normal_).c_str());
    std::printf("\n    %s\n", what.c_str());
  }

  // The distances of the nearest triangles from the proxy, in stand-offs.
  std::string surroundings() const {
    std::vector<double> heights;
    for (std::size_t i = 0; i < exact_.triangles().size(); ++i) {
      const double height_m = exact_.distance_m(state_.proxy, state_.proxy, i) - radius_m_;
      heights.push_back(height_m / god_object_.scale().stand_off_m);
    }
    std::sort(heights.begin(), heights.end());
    std::string text = "distances from triangles in stand-offs:";
    char number[32];
    for (std::size_t i = 0; i < std::min<std::size_t>(8, heights.size()); ++i) {
      std::snprintf(number, sizeof number, " %.6g", heights[i]);
      text += number;
    }
    return text;
  }

  bool judge_path(RestTotals& totals) const {
    const auto path = god_object_.path();
    EXPECT_TRUE(!path.empty() && path.back() == state_.proxy && state_.proxy.allFinite() &&
                state_.normal.allFinite());
    for (const Vec3& corner : path) {
      if (!plane_normal_) break;
      const double off_m = std::abs(plane_normal_->dot(corner - goal_));
      const double round_m = round_m_ + kEpsilon * (corner.norm() + goal_.norm());
      EXPECT_LE(off_m, kOffPlaneUlps * std::max(kStepsAtLeast, state_.iterations) * round_m)
          << "a corner is off the plane of motion, PALPATE_SEED=" << seed_ << ", tick " << tick_;
    }
    const double least_m = radius_m_ - kNearUlps * round_m_;
    const std::optional<Violation> touch =
        radius_m_ == 0.0 ? exact_.touch_of_point(path) : exact_.touch_of_sphere(path, least_m);
    if (touch) {
      const bool is_overlap =
          radius_m_ > 0.0 && touch->distance_m < radius_m_ - kOverlapPerSize * size_m_;
      ++(is_overlap ? totals.overlaps : totals.leaks);
      show(totals, std::string(is_overlap ? "overlap" : "leak") + ": piece " +
                       std::to_string(touch->piece) + " of the path is " +
                       std::to_string(touch->distance_m) + " m from triangle " +
                       std::to_string(touch->triangle));
      return false;
    }
    if (const auto farther = test::moves_away(path, goal_, radius_m_, round_m_)) {
      ++totals.farther;
      show(totals, "piece " + std::to_string(farther->piece) + " of " +
                       std::to_string(path.size() - 1) + " increases the distance to the goal by " +
                       std::to_string(farther->by_m / god_object_.scale().stand_off_m) +
                       " stand-offs");
      return false;
    }
    return true;
  }

  void judge_rest(RestTotals& totals) const {
    if (state_.capped) return;
    Rest rest{state_.proxy, goal_, plane_normal_, cone_ ? cone_->cone.static_friction : 0.0};
    if ((goal_ - state_.proxy).norm() <= rests_.tolerance_m()) return;
    ++totals.judged;
    const test::JudgedBody body{&exact_, {}};
    const auto [way, is_proven] = rests_.judged(std::span(&body, 1), rest);
    totals.unproven += !is_proven;
    if (!way) return;
    ++totals.false_rests;
    totals.worst_gain_m = std::max(totals.worst_gain_m, way->gain_m / size_m_);
    show(totals, "false rest: " + test::to_text(*way) + "\n    " + surroundings());
  }

  std::uint64_t seed_;
  Random& random_;
  RestScene scene_;
  double radius_m_;
  OwnedWorld world_;
  ExactJudge exact_;
  Accuracy accuracy_;
  GodObject god_object_;
  double size_m_;
  double round_m_;
  RestJudge rests_;
  Vec3 start_;
  RestHand hand_;
  DeviceMotion device_;
  bool is_device_ = false;
  std::optional<Vec3> plane_normal_;
  std::optional<SameCone> cone_;
  ProxyState state_;
  Vec3 goal_ = Vec3::Zero();
  int tick_ = 0;
};

void print(const RestClass& rest_class, const RestTotals& t) {
  const int uncapped = t.contacts - t.capped;
  std::printf(
      "%-22s %5d scenes %8d ticks %8d contacts, %d ran out, %8d uncapped, capped %6.2f %%, "
      "leaks %d, overlaps %d, farther %d, false rests %d of %d (worst %.2g sizes; %d unproven), "
      "iterations <= %d\n",
      rest_class.full_name().c_str(), t.scenes, t.ticks, t.contacts, t.ran_out, uncapped,
      t.contacts ? 100.0 * t.capped / t.contacts : 0.0, t.leaks, t.overlaps, t.farther,
      t.false_rests, t.judged, t.worst_gain_m, t.unproven, t.most_iterations);
  if (t.failing_scenes.empty()) return;
  std::printf("  failing scenes (%zu):", t.failing_scenes.size());
  int listed = 0;
  for (const std::uint64_t seed : t.failing_scenes) {
    if (++listed > 20) break;
    std::printf(" %llu", static_cast<unsigned long long>(seed));
  }
  std::printf("%s\n", listed > 20 ? " ..." : "");
  std::fflush(stdout);
}

class Rests : public testing::TestWithParam<RestClass> {};

TEST_P(Rests, LeaveNoImprovingSegment) {
  const RestClass& rest_class = GetParam();
  RestTotals totals;
  const int ticks = ticks_of(rest_class);
  for (std::uint64_t seed = from_environment("PALPATE_FIRST_SCENE", 1); totals.ticks < ticks;
       ++seed) {
    Random random(seed);
    RestRun run(rest_class, random.seed(), random);
    ++totals.scenes;
    for (int tick = 0; tick < kTicksPerScene && run.tick(totals); ++tick) {
    }
    if (std::getenv("PALPATE_SEED")) break;
  }
  print(rest_class, totals);
  EXPECT_EQ(totals.leaks, 0);
  EXPECT_EQ(totals.overlaps, 0);
  EXPECT_EQ(totals.farther, 0);
  EXPECT_EQ(totals.false_rests, 0);
  // A single scene gives no meaningful rate of capped ticks.
  if (totals.scenes > 1) {
    EXPECT_LE(totals.capped, rest_class.most_capped * totals.contacts);
  }
}

// Hands that never rest, in three dimensions, without friction and without a work limit, so that
// the proxy moves in most ticks.
class RestlessHands : public testing::TestWithParam<RestClass> {};

TEST_P(RestlessHands, AreSeldomCapped) {
  const RestClass& rest_class = GetParam();
  int contacts = 0;
  int capped = 0;
  int ticks = 0;
  for (std::uint64_t seed = from_environment("PALPATE_FIRST_SCENE", 1);
       ticks < ticks_of(rest_class); ++seed) {
    Random random(seed);
    const RestScene scene = rest_class.make(rest_class.proxy, random);
    const OwnedWorld world(scene.soup, {}, scene.radius_m);
    const std::vector<Corners> triangles = test::solver_triangles(world);
    auto god_object = test::made(
        GodObject::create(world.world(), {scene.radius_m, test::with_budget({}, test::kNoBudget)}));
    ProxyState state;
    state.proxy = Vec3(0.0, 0.0, 1.1 * scene.radius_m + world.world().size_m);
    god_object.place(state.proxy);
    RestHand hand(triangles, {}, scene.radius_m, god_object.scale().stand_off_m, 0.0, state.proxy,
                  random);
    hand.never_rest();
    for (int tick = 0; tick < kTicksPerScene; ++tick, ++ticks) {
      state = god_object.move_to(hand.next_goal(state));
      contacts += state.in_contact;
      capped += state.in_contact && state.capped;
    }
    if (std::getenv("PALPATE_SEED")) break;
  }
  std::printf("%-22s restless: %d contacts, capped %.2f %%\n", rest_class.full_name().c_str(),
              contacts, 100.0 * capped / std::max(1, contacts));
  EXPECT_LE(capped, rest_class.most_capped * contacts);
}

INSTANTIATE_TEST_SUITE_P(Of, RestlessHands, testing::ValuesIn(test::restless_classes()),
                         [](const auto& rest_class) { return rest_class.param.full_name(); });

// Spheres that are much larger than triangles need not reach their rest in one tick. If the goal
// stays, they do so in a few ticks without a work limit.
class LargeSpheres : public testing::TestWithParam<RestClass> {};

TEST_P(LargeSpheres, RestForAConstantGoalWithinTenTicksAndStayThere) {
  constexpr int kTicks = 10;
  constexpr double kStaysWithin = 1e-9;  // largest motion of a proxy at rest, in sizes
  const int goals = std::max(200, ticks_of(GetParam()) / 10);
  int late = 0;
  int most = 0;
  int goal_count = 0;
  int left = 0;
  for (std::uint64_t seed = from_environment("PALPATE_FIRST_SCENE", 1); goal_count < goals;
       ++seed) {
    Random random(seed);
    const RestScene scene = GetParam().make(GetParam().proxy, random);
    const OwnedWorld world(scene.soup, {}, scene.radius_m);
    const std::vector<Corners> triangles = test::solver_triangles(world);
    const double size_m = world.world().size_m;
    const Accuracy accuracy = test::with_budget(
        random.index(4) ? Accuracy::balanced() : Accuracy::exact(), test::kNoBudget);
    auto god_object = test::made(GodObject::create(world.world(), {scene.radius_m, accuracy}));
    ProxyState state;
    state.proxy = Vec3(0.0, 0.0, scene.radius_m + size_m);
    god_object.place(state.proxy);
    RestHand hand(triangles, {}, scene.radius_m, god_object.scale().stand_off_m, 0.0, state.proxy,
                  random);
    for (int i = 0; i < 20; ++i, ++goal_count) {
      const Vec3 goal = hand.next_goal(state);
      int tick = 0;
      do {
        state = god_object.move_to(goal);
        ++tick;
      } while (state.capped && tick < 10 * kTicks);
      most = std::max(most, tick);
      if (tick > 1 && !state.capped) {
        const ProxyState held = god_object.move_to(goal);
        left += held.capped || (held.proxy - state.proxy).norm() > kStaysWithin * size_m;
      }
      if (tick <= kTicks) continue;
      if (++late <= 3) {
        std::printf("  PALPATE_SEED=%llu, goal %d %s, radius %g m: %d ticks\n",
                    static_cast<unsigned long long>(random.seed()), i, hex(goal).c_str(),
                    scene.radius_m, tick);
      }
    }
    if (std::getenv("PALPATE_SEED")) break;
  }
  std::printf("%-22s %d goals, %d late, at most %d ticks\n", GetParam().full_name().c_str(),
              goal_count, late, most);
  EXPECT_EQ(late, 0);
  EXPECT_EQ(left, 0) << "proxies left a rest for a goal that had waited";
}

INSTANTIATE_TEST_SUITE_P(Of, LargeSpheres, testing::ValuesIn(test::large_sphere_classes()),
                         [](const auto& rest_class) { return rest_class.param.full_name(); });

INSTANTIATE_TEST_SUITE_P(Of, Rests, testing::ValuesIn(test::rest_classes()),
                         [](const auto& rest_class) { return rest_class.param.full_name(); });

}  // namespace
}  // namespace palpate
