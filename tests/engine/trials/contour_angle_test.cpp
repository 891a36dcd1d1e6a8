// The mean contact angle of a hand without delay, against a one-dimensional model, and the
// committed table of these means.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <fstream>
#include <iostream>
#include <iterator>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "benchmarks/contour_angles.h"
#include "models/paper_objects.h"

namespace palpate {
namespace {

using bench::ContourAngle;
using bench::ContourCase;
using bench::ContourRound;

constexpr double kTick_s = 1e-3;

// ---- The model. Degrees, seconds and metres; only directions and lengths of walls.

// The angle in (-180, 180].
double wrapped_deg(double angle_deg) {
  const double turns = std::ceil((angle_deg - 180.0) / 360.0);
  return angle_deg - 360.0 * turns;
}

struct Wall {
  double normal_deg;  // of the outward normal, from A1 towards A2, before any rotation
  double begin_m;     // place on the way
  double free_m;      // the hand touches nothing over this length at the beginning of the wall
};

struct Way {
  std::vector<Wall> walls;  // the first and the last are the halves of the first wall
  double length_m = 0.0;
};

// The hand lets go for 0.2 mm after each convex corner, that is, where the contour turns left.
Way way_round(const Contour& contour_m) {
  constexpr double kFree_m = 0.2e-3;
  Way way;
  const std::size_t n = contour_m.size();
  for (std::size_t i = 0; i <= n; ++i) {
    const double x = contour_m[(i + 1) % n].x() - contour_m[i % n].x();
    const double y = contour_m[(i + 1) % n].y() - contour_m[i % n].y();
    const double normal_deg = std::atan2(y, x) * 180.0 / std::numbers::pi - 90.0;
    const bool turns_left = i > 0 && wrapped_deg(normal_deg - way.walls.back().normal_deg) > 0.0;
    way.walls.push_back({normal_deg, way.length_m, turns_left ? kFree_m : 0.0});
    way.length_m += (i % n == 0 ? 0.5 : 1.0) * std::hypot(x, y);
  }
  return way;
}

// The angle that is left of angle_deg > 0 after one tick of Figure 3: the speed is 5 deg/s at 0,
// grows linearly to 90 deg/s at 30 deg, and stays there. Midpoint steps of 0.1 ms.
double left_after_tick_deg(double angle_deg) {
  constexpr int kSteps = 10;
  constexpr double kStep_s = kTick_s / kSteps;
  const auto speed = [](double a_deg) { return std::min(90.0, 5.0 + 85.0 / 30.0 * a_deg); };
  for (int n = 0; n < kSteps; ++n) {
    const double middle_deg = angle_deg - 0.5 * kStep_s * speed(angle_deg);
    angle_deg -= kStep_s * speed(std::max(0.0, middle_deg));
    if (angle_deg <= 0.0) return 0.0;
  }
  return angle_deg;
}

// The rule with its memory: the signed angle by which the scene has to turn.
class Rule {
 public:
  explicit Rule(Alignment align) : align_(align) {}

  void lose_contact() { is_in_contact_ = false; }

  double turn_deg(double normal_deg) {
    const double turn =
        align_ == Alignment::kNearest ? to_nearest_end(normal_deg) : to_front(normal_deg);
    is_in_contact_ = true;
    return turn;
  }

 private:
  // To 0 or 180 deg. The end changes when the normal is more than 92 deg from it. A new contact
  // begins with 0.
  double to_nearest_end(double normal_deg) {
    if (!is_in_contact_) end_deg_ = 0.0;
    if (std::abs(wrapped_deg(normal_deg - end_deg_)) > 92.0) end_deg_ = 180.0 - end_deg_;
    return wrapped_deg(end_deg_ - normal_deg);
  }

  // To 0 deg by the shorter way. From 178 deg, the scene turns on as it turned. A new contact there
  // turns the scene towards A2, which is the positive direction.
  double to_front(double normal_deg) {
    if (!is_in_contact_) turns_positive_ = true;
    double turn = wrapped_deg(-normal_deg);
    if (std::abs(turn) >= 178.0 && (turn > 0.0) != turns_positive_) {
      turn += turns_positive_ ? 360.0 : -360.0;
    }
    if (turn != 0.0) turns_positive_ = turn > 0.0;
    return turn;
  }

  Alignment align_;
  bool is_in_contact_ = false;
  double end_deg_ = 0.0;
  bool turns_positive_ = true;
};

ContourAngle modelled(const Contour& contour_m, const ContourRound& round) {
  const Way way = way_round(contour_m);
  Rule rule(round.align);
  double turned_deg = round.start_orientation_deg;
  double sum_deg = 0.0;
  double contacts = 0.0;
  const double ticks = std::round(round.duration_s / kTick_s);
  std::size_t wall = 0;
  for (double tick = 0.0; tick < ticks; ++tick) {
    const double place_m = (tick + 0.5) / ticks * way.length_m;
    while (wall + 1 < way.walls.size() && place_m >= way.walls[wall + 1].begin_m) ++wall;
    if (place_m - way.walls[wall].begin_m < way.walls[wall].free_m) {
      rule.lose_contact();
      continue;
    }
    const double normal_deg = wrapped_deg(way.walls[wall].normal_deg + turned_deg);
    const double from_front_deg = std::abs(normal_deg);
    sum_deg += std::min(from_front_deg, 180.0 - from_front_deg);
    ++contacts;
    const double turn_deg = rule.turn_deg(normal_deg);
    const double left_deg = left_after_tick_deg(std::abs(turn_deg));
    turned_deg += std::copysign(std::abs(turn_deg) - left_deg, turn_deg);
  }
  return {sum_deg / contacts, contacts / ticks};
}

// ---- The tests

const std::vector<ContourCase>& measured() {
  static const auto cases = bench::measure_contour_angles(PALPATE_MODELS_DIR);
  if (cases) return *cases;
  ADD_FAILURE() << cases.error().to_string();
  static const std::vector<ContourCase> none;
  return none;
}

const Contour& contour_of(const std::string& name) {
  static const auto objects = paper_objects();
  return std::find_if(objects.begin(), objects.end(),
                      [&](const PaperObject& object) { return object.name == name; })
      ->contour_m;
}

std::string description(const ContourCase& c) {
  return c.object + (c.round.align == Alignment::kNearest ? ", nearest, " : ", forward, ") +
         std::to_string(c.round.duration_s) + " s, from " +
         std::to_string(c.round.start_orientation_deg) + " deg";
}

// The two differ by rounding: the corners in the files are floats, which turns a wall of 25 mm by
// at most 2e-5 deg, and the model's midpoint steps are wrong by at most 1e-5 deg where they cross
// 30 deg. A corner after such an error begins with it. The bound is more than 16 corners can add
// up.
TEST(HandWithoutDelay, HasTheMeanAngleOfTheOneDimensionalModel) {
  constexpr double kBound_deg = 1e-3;
  ASSERT_EQ(measured().size(), 32u);
  double worst_deg = 0.0;
  std::string worst;
  for (const ContourCase& c : measured()) {
    SCOPED_TRACE(description(c));
    const ContourAngle expected = modelled(contour_of(c.object), c.round);
    EXPECT_NEAR(c.angle.mean_deg, expected.mean_deg, kBound_deg);
    EXPECT_NEAR(c.angle.contact_share, expected.contact_share, 1e-4);
    EXPECT_EQ(c.angle.faults, kFaultNone);
    const double difference_deg = std::abs(c.angle.mean_deg - expected.mean_deg);
    if (difference_deg >= worst_deg) worst = description(c);
    worst_deg = std::max(worst_deg, difference_deg);
  }
  std::cout << "largest difference: " << worst_deg << " deg (" << worst << ")\n";
}

TEST(HandWithoutDelay, BeginsInTheMiddleBetweenTheEndsOfTheRoute) {
  for (const PaperObject& object : paper_objects()) {
    const ContourRoute route = contour_route(object.contour_m);
    const Vec3 middle_m = 0.5 * (route.start_m + route.end_m);
    const bench::ContourHand hand(object.contour_m);
    const Point2 mean_m = 0.5 * (hand.start_m() + hand.goal_m(0.0));
    // A few roundings of coordinates that are at most 0.1 m.
    EXPECT_NEAR(mean_m.x(), middle_m.x(), 0x1p-53) << object.name;
    EXPECT_NEAR(mean_m.y(), middle_m.y(), 0x1p-53) << object.name;
  }
}

TEST(HandWithoutDelay, HasTheCommittedMeans) {
  std::ifstream file(PALPATE_RESULTS_DIR "/contour_angles.csv", std::ios::binary);
  ASSERT_TRUE(file.good());
  const std::string committed{std::istreambuf_iterator<char>(file), {}};
  EXPECT_EQ(committed, bench::contour_angles_csv(measured()))
      << "run benchmarks/measure_contour_angles.py";
}

}  // namespace
}  // namespace palpate
