// Friction keeps its ratio together with texture and damping: on one material, and where materials
// with and without them border on each other. On a plane, the normal force is the part of the force
// along the plane's normal; the tangential force is the rest, less the force -K c grad h by which a
// relief of height h with compression c pushes the hand along the surface (texture.h).

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "haptics/effects/damping.h"
#include "haptics/effects/friction.h"
#include "haptics/effects/texture.h"
#include "tests/haptics/proxy/body_hand.h"
#include "tests/helpers/effect_programs.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::BodyHand;
using test::effect_entry;
using test::Random;
using test::Soup;

constexpr double kSheet_m = 0.03;      // half width
constexpr double kMapPeriod_m = 0.03;  // of a map: u = x / period, v = y / period
constexpr double kForceRatio = 1e-9;   // rounding of a force, relative: normals in the pose

struct Felt {
  FrictionCone cone;
  double damping_Ns_per_m = 0.0;  // none: the loop's
  double relief_m = 0.0;          // none: no texture
};

Felt random_felt(Random& random, bool has_damping, bool has_relief) {
  Felt felt;
  felt.cone.dynamic_friction = random.uniform(0.02, 1.5);
  felt.cone.static_friction = felt.cone.dynamic_friction * random.uniform(1.0, 1.5);
  if (has_damping) felt.damping_Ns_per_m = random.uniform(0.05, 3.0);
  if (has_relief) felt.relief_m = random.uniform(5e-5, 5e-4);
  return felt;
}

// A map of few waves, which no speed of the hand blends out.
HeightMap random_relief(Random& random) {
  std::vector<float> values(8 * 8);
  for (float& value : values) value = static_cast<float>(random.uniform(0.0, 1.0));
  return HeightMap::build(8, 8, std::move(values), MapWrap::kRepeat, MapWrap::kRepeat);
}

// A plane of strips side by side along x, each a body with a material, under a hand.
class Strips {
 public:
  Strips(std::vector<Felt> felts, Random& random)
      : felts_(std::move(felts)), hand_(soups(felts_.size()), random.pose(0.3)) {
    EffectProgram& program = hand_.effects.builder.program;
    for (std::size_t i = 0; i < felts_.size(); ++i) {
      const Felt& felt = felts_[i];
      std::vector<EffectProgramBuilder::Entry> entries{effect_entry<FrictionEffect>(
          {felt.cone.static_friction, felt.cone.dynamic_friction, nullptr})};
      if (felt.damping_Ns_per_m > 0.0) {
        entries.push_back(effect_entry<DampingEffect>({felt.damping_Ns_per_m}));
      }
      maps_.push_back(nullptr);
      SurfaceAttributes attributes;
      if (felt.relief_m > 0.0) {
        program.maps.push_back(random_relief(random));
        maps_.back() = &program.maps.back();
        entries.push_back(effect_entry<TextureEffect>({felt.relief_m, maps_.back()}));
        const SurfaceIndex& index = hand_.index(i);
        test::for_each_slot(index, [&](std::uint32_t slot) {
          const TriangleGeometry& t = index.triangle(slot);
          CornerCoordinates corners;
          const Vec3* points[] = {&t.a, &t.b, &t.c};
          for (std::size_t k = 0; k < 3; ++k) {
            corners[k] = {points[k]->x() / kMapPeriod_m, points[k]->y() / kMapPeriod_m};
          }
          attributes.texture_uv.push_back(UvMap::over(t, corners));
        });
      }
      hand_.effects.add_body(entries, std::move(attributes));
    }
    hand_.begin(test::hand_settings());
  }

  // The tangential force of the last tick, if the proxy touches this strip.
  Vec3 tangential_N(std::size_t strip) const {
    const Vec3 force_N = hand_.force();
    const Vec3 along_N(force_N.x(), force_N.y(), 0.0);
    if (!maps_[strip]) return along_N;
    const Vec3 at = hand_.proxy();
    const HeightMap::Sample sample =
        maps_[strip]->sample(at.x() / kMapPeriod_m, at.y() / kMapPeriod_m, 0.0);
    if (sample.value >= 1.0) return along_N;
    const double relief_m = felts_[strip].relief_m * (sample.value - 1.0);
    const double compression_m = std::max(0.0, -hand_.goal().z() + relief_m);
    const Vec3 slope = felts_[strip].relief_m / kMapPeriod_m * Vec3(sample.d_du, sample.d_dv, 0.0);
    return along_N + test::kStiffness_N_per_m * compression_m * slope;
  }

  // The strips at a place: two on a border.
  std::vector<std::size_t> strips_at(double x_m) const {
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < felts_.size(); ++i) {
      if (std::abs(x_m - middle_m(i)) <= 0.5 * width_m() + hand_.tolerance_m()) found.push_back(i);
    }
    return found;
  }
  const Felt& felt(std::size_t strip) const { return felts_[strip]; }
  BodyHand& hand() { return hand_; }

 private:
  static std::vector<Soup> soups(std::size_t count) {
    std::vector<Soup> soups(count);
    const double width_m = 2 * kSheet_m / static_cast<double>(count);
    for (std::size_t i = 0; i < count; ++i) {
      const double x = -kSheet_m + width_m * static_cast<double>(i);
      soups[i].add_quad({x, -kSheet_m, 0}, {x + width_m, -kSheet_m, 0}, {x + width_m, kSheet_m, 0},
                        {x, kSheet_m, 0});
    }
    return soups;
  }
  double width_m() const { return 2 * kSheet_m / static_cast<double>(felts_.size()); }
  double middle_m(std::size_t i) const {
    return -kSheet_m + width_m() * (static_cast<double>(i) + 0.5);
  }

  std::vector<Felt> felts_;
  std::vector<const HeightMap*> maps_;
  BodyHand hand_;
};

struct Ticks {
  int slides = 0;
  int sticks = 0;
  int crossings = 0;  // ticks that end on another strip than the one before
};

// A hand that strokes the strips at changing depths, speeds and directions.
void stroke(Strips& strips, Random& random, int ticks, Ticks& sum) {
  BodyHand& hand = strips.hand();
  hand.go_to({-0.5 * kSheet_m, 0, 1e-3});
  Vec3 goal(-0.5 * kSheet_m, 0, -5e-4);
  Vec3 way = Vec3::UnitX();
  double step_m = 1e-4;
  std::optional<std::size_t> last;
  for (int tick = 0; tick < ticks; ++tick) {
    if (random.index(200) == 0) way = Vec3(random.uniform(-1, 1), random.uniform(-0.3, 0.3), 0.0);
    if (random.index(50) == 0) {
      step_m = std::pow(10.0, random.uniform(-5.0, -3.4));
    }
    goal += step_m * way;
    for (int axis = 0; axis < 2; ++axis) {
      if (std::abs(goal[axis]) > 0.9 * kSheet_m) way[axis] = -std::copysign(1.0, goal[axis]);
    }
    goal.z() = -1e-3 - 9e-4 * std::sin(0.03 * tick);
    hand.go_to(goal);
    const TickRecord& record = hand.record();
    ASSERT_TRUE(record.contact) << tick;
    const auto ends_on = strips.strips_at(hand.proxy().x());
    ASSERT_FALSE(ends_on.empty());
    const double rounding_N = kForceRatio * (hand.force().norm() + test::kStiffness_N_per_m * 1e-3);
    const bool slides = record.friction == FrictionState::kSlides;
    const double normal_N = hand.force().z();
    ASSERT_GE(normal_N, -rounding_N) << tick;
    Vec3 lag = hand.proxy() - hand.goal();
    lag.z() = 0.0;
    // On a border, one of its sides bears the force.
    double off_N = std::numeric_limits<double>::infinity();
    for (const std::size_t strip : ends_on) {
      const Vec3 tangential_N = strips.tangential_N(strip);
      const FrictionCone& cone = strips.felt(strip).cone;
      const double above_N = tangential_N.norm() - cone.static_friction * normal_N;
      const Vec3 slide_N = cone.dynamic_friction * normal_N * lag.normalized();
      off_N = std::min(off_N, slides ? (tangential_N - slide_N).norm() : above_N);
    }
    ASSERT_LE(off_N, rounding_N) << "tick " << tick << ", strip " << ends_on[0];
    const std::size_t strip = ends_on[0];
    const bool presses = normal_N > rounding_N;
    sum.slides += slides && presses;
    sum.sticks += record.friction == FrictionState::kSticks && presses;
    sum.crossings += last && *last != strip;
    last = strip;
  }
}

TEST(FrictionWithEffects, SlidesWithTheRatioOnOneMaterial) {
  Random random(5410);
  for (const auto& [has_damping, has_relief] :
       std::vector<std::pair<bool, bool>>{{true, false}, {false, true}, {true, true}}) {
    Ticks sum;
    for (int run = 0; run < 10; ++run) {
      Strips strips({random_felt(random, has_damping, has_relief)}, random);
      ASSERT_NO_FATAL_FAILURE(stroke(strips, random, 1500, sum));
    }
    EXPECT_GT(sum.slides, 5000) << has_damping << has_relief;
    EXPECT_GT(sum.sticks, 300) << has_damping << has_relief;
  }
}

// One side of each border has a texture, a damper, both or neither, at random.
TEST(FrictionWithEffects, EndsInTheConeOfTheMaterialBehindABorder) {
  Random random(5411);
  Ticks sum;
  for (int run = 0; run < 40; ++run) {
    std::vector<Felt> felts;
    const std::size_t count = 2 + random.index(4);
    for (std::size_t i = 0; i < count; ++i) {
      felts.push_back(random_felt(random, random.index(2) == 0, random.index(2) == 0));
    }
    Strips strips(felts, random);
    ASSERT_NO_FATAL_FAILURE(stroke(strips, random, 1500, sum));
  }
  EXPECT_GT(sum.slides, 20000);
  EXPECT_GT(sum.sticks, 2000);
  EXPECT_GT(sum.crossings, 100);
}

// The largest jump of the force of a border would be that of its faces: over a border from ice to
// rubber, no tick has more tangential force than the lag and the damper of the hand explain.
TEST(FrictionWithEffects, ABorderAddsNoForceThatSpringAndDamperDoNotHave) {
  Random random(5412);
  int crossings = 0;
  for (int run = 0; run < 40; ++run) {
    Felt ice = random_felt(random, random.index(2) == 0, false);
    ice.cone = {0.02, 0.02};
    Felt rubber = random_felt(random, random.index(2) == 0, random.index(2) == 0);
    rubber.cone = {1.2, 1.2};
    Strips strips({ice, rubber}, random);
    BodyHand& hand = strips.hand();
    const double step_m = std::pow(10.0, random.uniform(-5.0, -3.4));
    const double depth_m = random.uniform(5e-4, 3e-3);
    hand.go_to({-20 * step_m, 0.01, 1e-3});
    Vec3 last_lag = Vec3::Zero();
    bool was_on_ice = true;
    for (int tick = 0; tick < 80; ++tick) {
      hand.go_to({(tick - 20) * step_m, 0.01 + 0.3 * tick * step_m, -depth_m});
      const Vec3 lag = hand.proxy() - hand.goal();
      const bool is_on_ice = hand.proxy().x() < 0.0;
      const Felt& felt = strips.felt(is_on_ice ? 0 : 1);
      const Vec3 tangential_N = strips.tangential_N(is_on_ice ? 0 : 1);
      const double most_N = test::kStiffness_N_per_m * std::hypot(lag.x(), lag.y()) +
                            felt.damping_Ns_per_m * (lag - last_lag).norm() / 1e-3;
      if (tick > 0) {
        ASSERT_LE(tangential_N.norm(), most_N + kForceRatio * hand.force().norm()) << tick;
      }
      crossings += was_on_ice && !is_on_ice;
      was_on_ice = is_on_ice;
      last_lag = lag;
    }
  }
  EXPECT_EQ(crossings, 40);
}

}  // namespace
}  // namespace palpate
