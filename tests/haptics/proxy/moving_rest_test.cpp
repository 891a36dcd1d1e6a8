// Among bodies that move at 1e-13 m/s to 1 m/s, with or without rotation, a proxy neither leaks nor
// overlaps, and no improving segment exists from its rests. The proxy is judged in the frame of
// each body. The tests cover points and spheres, three sensors and two, with friction and without,
// and the presets balanced and exact.
//
// The seed determines a scene:
//   PALPATE_SEED=N           runs only scene N
//   PALPATE_FIRST_SCENE=N    begins with scene N
//   PALPATE_REST_TICKS=N     sets the number of ticks for each class
//   PALPATE_REST_SHOWN=N     sets the number of failures that are printed in full

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "haptics/proxy/god_object.h"
#include "tests/haptics/proxy/judging_tolerances.h"
#include "tests/haptics/proxy/work_budgets.h"
#include "tests/helpers/exact_judge.h"
#include "tests/helpers/floating_point.h"
#include "tests/helpers/made.h"
#include "tests/helpers/owned_bodies.h"
#include "tests/helpers/random.h"
#include "tests/helpers/rest_judge.h"
#include "tests/helpers/rest_scenes.h"
#include "tests/helpers/same_cone.h"
#include "tests/helpers/soak.h"
#include "tests/helpers/ticks.h"

namespace palpate {
namespace {

using test::ExactJudge;
using test::from_environment;
using test::hex;
using test::JudgedBody;
using test::kEpsilon;
using test::kNearUlps;
using test::kOverlapPerSize;
using test::kTick_s;
using test::OwnedBodies;
using test::ProxyKind;
using test::Random;
using test::RestJudge;
using test::RestScene;
using test::SameCone;
using test::Violation;

// Largest distance of bodies from the middle, in sizes; it determines the rounding of coordinates.
constexpr double kFarthest = 4.0;

// The motion of the bodies of a class.
struct Pace {
  const char* name;
  double slowest_m_per_s;
  double fastest_m_per_s;
  bool turns;
};

constexpr Pace kPaces[] = {{"Creeping", 1e-13, 1e-6, true},
                           {"Drifting", 1e-13, 1e-3, false},
                           {"Slow", 1e-4, 1e-2, true},
                           {"Fast", 1e-2, 1.0, true},
                           {"Straight", 1e-3, 1.0, false}};

struct MovingClass {
  Pace pace;
  int number;  // gives each class other random scenes
  ProxyKind proxy;

  std::string full_name() const {
    return std::string(pace.name) + (proxy == ProxyKind::kPoint ? "Point" : "Sphere");
  }
};

void PrintTo(const MovingClass& moving_class, std::ostream* out) {
  *out << moving_class.full_name();
}

struct MovingTotals {
  int scenes = 0;
  int ticks = 0;
  int contacts = 0;
  int ran_out = 0;  // ticks that ran out of work
  int capped = 0;   // other capped ticks in contact
  int held_bodies = 0;
  int judged = 0;
  int leaks = 0;
  int overlaps = 0;
  int false_rests = 0;
  double worst_gain = 0.0;
  std::set<std::uint64_t> failing_scenes;
  std::uint64_t shown = 0;
};

// The constant velocity of a body, which sometimes reverses.
struct Motion {
  Vec3 velocity_m_per_s;
  Vec3 turn_rad_per_s;
};

RigidTransform moved(const RigidTransform& T, const Motion& motion) {
  RigidTransform to = T;
  const Vec3 turn_rad = kTick_s * motion.turn_rad_per_s;
  const double angle_rad = turn_rad.norm();
  if (angle_rad > 0.0) {
    const Quat turn(Eigen::AngleAxisd(angle_rad, turn_rad / angle_rad));
    to.rotation = (turn * T.rotation).normalized();
  }
  to.translation_m += kTick_s * motion.velocity_m_per_s;
  return to;
}

double log_uniform(Random& random, double low, double high) {
  return low * std::pow(high / low, random.uniform(0.0, 1.0));
}

// Two to four bodies of different classes, scaled to one size.
struct Scene {
  std::vector<OwnedBodies::Placed> bodies;
  double radius_m = 0.0;
};

Scene random_scene(const MovingClass& moving_class, Random& random) {
  constexpr double kSize_m = 0.15;
  for (int i = 0; i < moving_class.number; ++i) random.index(2);
  const ProxyKind proxy = moving_class.proxy;
  Scene scene;
  const auto classes = test::rest_classes();
  for (auto count = 2 + random.index(3); count > 0; --count) {
    RestScene body = classes[random.index(classes.size())].make(proxy, random);
    Vec3 low = body.soup.positions.front();
    Vec3 high = low;
    for (const Vec3& p : body.soup.positions) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    const double scale = kSize_m / (high - low).maxCoeff();
    const Vec3 middle = 0.5 * (low + high);
    for (Vec3& p : body.soup.positions) p = scale * (p - middle);
    const bool is_upright = random.index(3) == 0;
    const Vec3 place = random.in_box(0.1);
    scene.bodies.push_back(
        {body.soup, {is_upright ? Quat(Quat::Identity()) : random.rotation(), place}});
  }
  if (proxy == ProxyKind::kSphere) scene.radius_m = log_uniform(random, 1e-5, 1e-2);
  return scene;
}

class MovingScene {
 public:
  MovingScene(const MovingClass& moving_class, std::uint64_t seed, Random& random)
      : seed_(seed),
        random_(random),
        pace_(moving_class.pace),
        scene_(random_scene(moving_class, random)),
        radius_m_(scene_.radius_m),
        bodies_(scene_.bodies, radius_m_),
        accuracy_(test::with_some_budget(random.index(4) ? Accuracy::balanced() : Accuracy::exact(),
                                         seed)),
        god_object_(test::made(GodObject::create(bodies_.world(), {radius_m_, accuracy_}))),
        size_m_(bodies_.world().size_m),
        round_m_(kEpsilon * (size_m_ + radius_m_)),
        rests_(size_m_, radius_m_, god_object_.scale().stand_off_m) {
    for (std::size_t b = 0; b < scene_.bodies.size(); ++b) {
      judges_.emplace_back(bodies_.triangles(b));
      motions_.push_back(b == 0 && random.index(2) ? Motion{Vec3::Zero(), Vec3::Zero()}
                                                   : some_motion());
    }
    if (random.index(5) == 0) plane_normal_ = random.unit_vector();
    if (random.index(4) == 0) {
      const double mu_s = random.uniform(0.0, 1.5);
      cone_ = SameCone({mu_s, random.index(2) ? mu_s : mu_s * random.uniform(0.0, 1.0)});
    }
    goal_ = pick_start();
    god_object_.place(goal_);
    state_.proxy = god_object_.proxy();
    if (random.index(2)) {
      hand_.emplace(triangles_at_first(), std::vector<Vec3>(), radius_m_,
                    god_object_.scale().stand_off_m, 0.0, goal_, random);
    }
    aim_at_something();
  }

  // Simulates and judges a tick. False if the proxy leaked, so that later ticks cannot be judged.
  bool tick(MovingTotals& totals) {
    for (std::uint32_t b = 0; b < judges_.size(); ++b) {
      if (!move(b, totals)) return false;
    }
    make_goal();
    state_ = cone_ ? god_object_.move_with_friction(goal_, plane_normal_, friction())
                   : god_object_.move_to(goal_, plane_normal_);
    ++tick_;
    ++totals.ticks;
    totals.contacts += state_.in_contact;
    const bool ran_out = state_.work >= accuracy_.work_budget;
    totals.ran_out += ran_out;
    totals.capped += state_.in_contact && state_.capped && !ran_out;
    for (std::uint32_t b = 0; b < judges_.size(); ++b) {
      std::vector<Vec3> path_body;
      for (const Vec3& p : god_object_.path()) path_body.push_back(placed(b).to_body(p));
      if (!is_free(b, path_body, "follows the goal", totals)) return false;
    }
    const double extent_m = std::max({size_m_, radius_m_, state_.proxy.norm(), goal_.norm()});
    const auto farther =
        test::moves_away(god_object_.path(), goal_, radius_m_, kEpsilon * extent_m);
    EXPECT_FALSE(farther) << "piece " << (farther ? farther->piece : 0)
                          << " of the path increases the distance to the goal, tick " << tick_
                          << ", PALPATE_SEED=" << seed_;
    if (!state_.capped) judge_rest(totals);
    return true;
  }

 private:
  const ContactBody& placed(std::uint32_t b) const { return god_object_.world().body(b); }

  FrictionSource friction() { return FrictionSource{*cone_}; }

  Motion some_motion() {
    const double speed = log_uniform(random_, pace_.slowest_m_per_s, pace_.fastest_m_per_s);
    Motion motion{speed * random_.unit_vector(), Vec3::Zero()};
    if (pace_.turns && random_.index(2)) {
      motion.turn_rad_per_s = 10 * speed * random_.uniform(0.0, 2.0) * random_.unit_vector();
    }
    return motion;
  }

  Vec3 pick_start() {
    for (;;) {
      const Vec3 start = random_.in_box(0.2);
      bool is_free = true;
      for (std::uint32_t b = 0; b < judges_.size(); ++b) {
        is_free =
            is_free && judges_[b].distance_m(placed(b).to_body(start)) > 1.01 * radius_m_ + 1e-6;
      }
      if (is_free) return start;
    }
  }

  // Moves one body; the proxy moves straight in its frame. A body far from the middle turns back.
  bool move(std::uint32_t b, MovingTotals& totals) {
    const RigidTransform now = placed(b).T_solver_body;
    Motion& motion = motions_[b];
    if (motion.velocity_m_per_s.isZero(0.0)) return true;
    if (random_.index(50) == 0) motion = some_motion();
    if (now.translation_m.norm() > 0.2 && now.translation_m.dot(motion.velocity_m_per_s) > 0.0) {
      motion.velocity_m_per_s *= -1.0;
    }
    std::vector<Vec3> starts;
    for (std::uint32_t other = 0; other < judges_.size(); ++other) {
      starts.push_back(placed(other).to_body(god_object_.proxy()));
    }
    const BodyMotion step{b, moved(now, motion)};
    totals.held_bodies += god_object_.move_bodies(std::span(&step, 1), plane_normal_) != 0;
    for (std::uint32_t other = 0; other < judges_.size(); ++other) {
      const Vec3 path[] = {starts[other], placed(other).to_body(god_object_.proxy())};
      if (!is_free(other, path, "is pushed", totals)) return false;
    }
    return true;
  }

  void aim_at_something() {
    aimed_body_ = static_cast<std::uint32_t>(random_.index(judges_.size()));
    const auto& triangles = judges_[aimed_body_].triangles();
    const test::Corners& t = triangles[random_.index(triangles.size())];
    aim_body_ = random_.index(2) ? t.a : Vec3((t.a + t.b + t.c) / 3.0);
    aim_body_ += random_.index(3) ? random_.in_box(0.02) : Vec3(Vec3::Zero());
  }

  // The triangles at the initial poses, for a hand that does not follow the motion of bodies.
  const std::vector<test::Corners>& triangles_at_first() {
    for (std::uint32_t b = 0; b < judges_.size(); ++b) {
      for (const test::Corners& t : judges_[b].triangles()) {
        at_first_.push_back(
            {placed(b).to_solver(t.a), placed(b).to_solver(t.b), placed(b).to_solver(t.c)});
      }
    }
    return at_first_;
  }

  // Moves the goal towards a point of a body, sometimes in one tick, or keeps it for some ticks.
  void follow_a_body() {
    if (random_.index(20) == 0) aim_at_something();
    if (random_.index(4) == 0) is_resting_ = !is_resting_;
    if (is_resting_) return;
    const double part = random_.index(4) ? random_.uniform(0.0, 0.3) : 1.0;
    goal_ += part * (placed(aimed_body_).to_solver(aim_body_) - goal_);
  }

  void make_goal() {
    if (hand_) {
      goal_ = hand_->next_goal(state_);
    } else {
      follow_a_body();
    }
    if (plane_normal_) {
      goal_ -= plane_normal_->dot(goal_ - god_object_.proxy()) * *plane_normal_;
    }
  }

  void show(MovingTotals& totals, const std::string& what) const {
    totals.failing_scenes.insert(seed_);
    static const std::uint64_t most = from_environment("PALPATE_REST_SHOWN", 1);
    if (totals.shown++ >= most) return;
    std::printf("  PALPATE_SEED=%llu, tick %d, radius %g m, goal %s%s",
                static_cast<unsigned long long>(seed_), tick_, radius_m_, hex(goal_).c_str(),
                accuracy_.iterations > 64 ? ", exact" : "");
    if (cone_)
      std::printf(", friction %g, %g", cone_->cone.static_friction, cone_->cone.dynamic_friction);
    if (plane_normal_) std::printf(", in the plane with normal %s", hex(*plane_normal_).c_str());
    std::printf("\n    %s\n", what.c_str());
  }

  bool is_free(std::uint32_t b, std::span<const Vec3> path_body, const char* when,
               MovingTotals& totals) const {
    const double least_m = radius_m_ - kFarthest * kNearUlps * round_m_;
    const std::optional<Violation> touch = radius_m_ == 0.0
                                               ? judges_[b].touch_of_point(path_body)
                                               : judges_[b].touch_of_sphere(path_body, least_m);
    if (!touch) return true;
    const double too_near_m = radius_m_ - touch->distance_m;
    const bool is_overlap = radius_m_ > 0.0 && too_near_m > kOverlapPerSize * size_m_;
    ++(is_overlap ? totals.overlaps : totals.leaks);
    char text[160];
    std::snprintf(text, sizeof text,
                  "%s: the proxy is %.4g m too near to triangle %zu of body %u when it %s",
                  is_overlap ? "overlap" : "leak", too_near_m, touch->triangle, b, when);
    show(totals, text);
    return false;
  }

  void judge_rest(MovingTotals& totals) const {
    const Vec3& proxy = god_object_.proxy();
    if ((goal_ - proxy).norm() <= rests_.tolerance_m()) return;
    ++totals.judged;
    std::vector<JudgedBody> bodies;
    for (std::uint32_t b = 0; b < judges_.size(); ++b) {
      bodies.push_back({&judges_[b], placed(b).T_solver_body});
    }
    const auto way = rests_.escape_from(
        bodies, {proxy, goal_, plane_normal_, cone_ ? cone_->cone.static_friction : 0.0});
    if (!way) return;
    ++totals.false_rests;
    totals.worst_gain = std::max(totals.worst_gain, way->gain_m / size_m_);
    show(totals, "false rest: " + test::to_text(*way));
  }

  std::uint64_t seed_;
  Random& random_;
  Pace pace_;
  Scene scene_;
  double radius_m_;
  OwnedBodies bodies_;
  Accuracy accuracy_;
  GodObject god_object_;
  double size_m_;
  double round_m_;
  RestJudge rests_;
  std::vector<ExactJudge> judges_;
  std::vector<Motion> motions_;
  std::optional<Vec3> plane_normal_;
  std::optional<SameCone> cone_;
  Vec3 goal_ = Vec3::Zero();
  ProxyState state_;
  std::vector<test::Corners> at_first_;
  std::optional<test::RestHand> hand_;
  Vec3 aim_body_ = Vec3::Zero();
  std::uint32_t aimed_body_ = 0;
  bool is_resting_ = false;
  int tick_ = 0;
};

void print(const MovingClass& moving_class, const MovingTotals& t) {
  std::printf(
      "%-16s %5d scenes %8d ticks %8d contacts, %d ran out, capped %6.2f %%, bodies held %d, "
      "leaks "
      "%d, overlaps %d, false rests %d of %d (worst %.2g sizes)\n",
      moving_class.full_name().c_str(), t.scenes, t.ticks, t.contacts, t.ran_out,
      t.contacts ? 100.0 * t.capped / t.contacts : 0.0, t.held_bodies, t.leaks, t.overlaps,
      t.false_rests, t.judged, t.worst_gain);
  if (t.failing_scenes.empty()) return;
  std::printf("  failing scenes (%zu):", t.failing_scenes.size());
  int listed = 0;
  for (const std::uint64_t seed : t.failing_scenes) {
    if (++listed > 20) break;
    std::printf(" %llu", static_cast<unsigned long long>(seed));
  }
  std::printf("\n");
  std::fflush(stdout);
}

class MovingRests : public testing::TestWithParam<MovingClass> {};

TEST_P(MovingRests, LeaveNoImprovingSegment) {
  constexpr int kTicksPerScene = 200;
  const MovingClass& moving_class = GetParam();
  MovingTotals totals;
  const auto ticks = static_cast<int>(
      from_environment("PALPATE_REST_TICKS", test::in_soak_or_else<std::uint64_t>(200'000, 8'000)));
  for (std::uint64_t seed = from_environment("PALPATE_FIRST_SCENE", 1); totals.ticks < ticks;
       ++seed) {
    Random random(seed);
    MovingScene scene(moving_class, random.seed(), random);
    ++totals.scenes;
    const int before = totals.ticks;
    while (totals.ticks < before + kTicksPerScene && scene.tick(totals)) {
    }
    if (std::getenv("PALPATE_SEED")) break;
  }
  print(moving_class, totals);
  EXPECT_EQ(totals.leaks, 0);
  EXPECT_EQ(totals.overlaps, 0);
  EXPECT_EQ(totals.false_rests, 0);
  EXPECT_LT(2 * totals.capped, totals.contacts);
}

std::vector<MovingClass> moving_classes() {
  std::vector<MovingClass> classes;
  for (const Pace& pace : kPaces) {
    for (const ProxyKind proxy : {ProxyKind::kPoint, ProxyKind::kSphere}) {
      classes.push_back({pace, static_cast<int>(classes.size()), proxy});
    }
  }
  return classes;
}

INSTANTIATE_TEST_SUITE_P(Of, MovingRests, testing::ValuesIn(moving_classes()),
                         [](const auto& moving_class) { return moving_class.param.full_name(); });

}  // namespace
}  // namespace palpate
