// The result depends on the scene only: not on its unit, its place or its pose, and not on data
// that the engine keeps from tick to tick.

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "haptics/haptic_loop.h"
#include "haptics/record_vectors.h"
#include "models/primitives.h"
#include "tests/helpers/made.h"
#include "tests/helpers/random.h"
#include "tests/helpers/ticks.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::box_soup;
using test::kTick_s;
using test::OwnedWorld;
using test::Random;
using test::Soup;

using Wide = long double;
using WideVec3 = Eigen::Matrix<Wide, 3, 1>;

constexpr int kTicks = 5000;
constexpr int kLeastContactTicks = kTicks / 100;  // whatever the seed

// A scene and a device path, both in one frame (body), about 0.2 m in size. Sizes and paths are
// chosen so that the goal slides 2 to 6 mm below surfaces and crosses many edges.
struct Scenario {
  Soup soup;
  std::vector<Vec3> path_m;
};

// A direction that wanders over the unit sphere at a constant speed.
class Wanderer {
 public:
  explicit Wanderer(Random& random)
      : up_(random.unit_vector()),
        ahead_(up_.cross(random.unit_vector()).normalized()),
        weave_rad_(random.uniform(0.2e-3, 1e-3)) {}
  const Vec3& next(double step_rad) {
    const Vec3 left = up_.cross(ahead_);
    ahead_ = (ahead_ + weave_rad_ * left).normalized();
    up_ = (up_ + step_rad * ahead_).normalized();
    ahead_ = (ahead_ - ahead_.dot(up_) * up_).normalized();
    return up_;
  }

 private:
  Vec3 up_;
  Vec3 ahead_;
  double weave_rad_;
};

// The value, at a tick, of an oscillation between two values whose period matches no mesh.
double swing(int tick, double low, double high) {
  constexpr double kPeriod_ticks = 713.0;
  return low + (high - low) * (0.5 - 0.5 * std::cos(2 * std::numbers::pi * tick / kPeriod_ticks));
}

Scenario box_scenario(Random& random) {
  const Vec3 half_m(0.1, 0.08, 0.06);
  Scenario scenario{box_soup(half_m), {}};
  Wanderer wanderer(random);
  for (int n = 0; n < kTicks; ++n) {
    const Vec3& u = wanderer.next(2e-3);
    const double to_face = 1.0 / u.cwiseAbs().cwiseQuotient(half_m).maxCoeff();
    scenario.path_m.push_back((to_face + swing(n, 8e-3, -5e-3)) * u);
  }
  return scenario;
}

Scenario bumpy_sphere_scenario(Random& random) {
  TriangleMesh mesh = bumpy_sphere(4, 0.1, 4e-3, 5);
  Scenario scenario{{std::move(mesh.positions_m), std::move(mesh.triangles)}, {}};
  Wanderer wanderer(random);
  for (int n = 0; n < kTicks; ++n) {
    scenario.path_m.push_back(swing(n, 0.115, 0.093) * wanderer.next(2e-3));
  }
  return scenario;
}

// 20,480 triangles.
Scenario fine_sphere_scenario(Random& random) {
  TriangleMesh mesh = icosphere(5, 0.1);
  Scenario scenario{{std::move(mesh.positions_m), std::move(mesh.triangles)}, {}};
  Wanderer wanderer(random);
  for (int n = 0; n < kTicks; ++n) {
    scenario.path_m.push_back(swing(n, 0.103, 0.095) * wanderer.next(1e-3));
  }
  return scenario;
}

// Rounds vertices, as for all scenes here, so that they can be moved by a kilometre without
// rounding.
Vec3 as_floats(const Vec3& p) {
  return p.cast<float>().cast<double>();
}

// Triangles that intersect each other and have open borders.
Scenario soup_scenario(Random& random) {
  Scenario scenario;
  for (int i = 0; i < 40; ++i) {
    const Vec3 centre = random.in_box(0.07);
    const Vec3 u = random.unit_vector();
    const Vec3 v = u.cross(random.unit_vector()).normalized();
    const double size_m = random.uniform(0.03, 0.08);
    scenario.soup.add(as_floats(centre + size_m * u), as_floats(centre + size_m * v),
                      as_floats(centre - size_m * (u + v)));
  }
  const Vec3 phase = random.in_box(std::numbers::pi);
  for (int n = 0; n < kTicks; ++n) {
    const double t = n * kTick_s;
    scenario.path_m.push_back(0.1 * Vec3(std::sin(1.31 * t + phase.x()),
                                         std::sin(1.73 * t + phase.y()),
                                         std::sin(2.11 * t + phase.z())));
  }
  return scenario;
}

// The placement of a scenario in the engine: the vertices are scaled, then translated; the pose
// places the body in the scene. The device frame is the scene frame.
struct Placing {
  double scale = 1.0;
  Vec3 moved_m = Vec3::Zero();
  RigidTransform T_scene_body = {};

  Vec3 body(const Vec3& p) const { return scale * p + moved_m; }
  Vec3 scene(const Vec3& p) const { return T_scene_body.point(body(p)); }
  // Transforms back to the scenario's own frame and unit.
  WideVec3 undone(const Vec3& p_scene) const {
    const WideVec3 from_origin = p_scene.cast<Wide>() - T_scene_body.translation_m.cast<Wide>();
    const auto rotation = T_scene_body.rotation.cast<Wide>().normalized();
    const WideVec3 p_body = rotation.conjugate() * from_origin;
    return (p_body - moved_m.cast<Wide>()) / static_cast<Wide>(scale);
  }
};

std::vector<TickRecord> render(const Scenario& scenario, const Placing& placing,
                               HapticSettings settings, const ActuationModel& actuation) {
  Soup soup{{}, scenario.soup.triangles};
  for (const Vec3& p : scenario.soup.positions) soup.positions.push_back(placing.body(p));
  settings.god_object.radius_m *= placing.scale;
  const OwnedWorld world(soup, placing.T_scene_body, settings.god_object.radius_m);
  auto loop = test::made(HapticLoop::create(world.world(), actuation, settings));
  std::vector<TickRecord> records;
  for (const Vec3& p : scenario.path_m) records.push_back(loop.tick(placing.scene(p), kTick_s));
  return records;
}

HapticSettings without_a4(double radius_m) {
  HapticSettings settings;
  settings.god_object.radius_m = radius_m;
  settings.a4.enabled = false;
  return settings;
}

const ActuationModel& every_axis() {
  static const ActuationModel model = *ActuationModel::from_counts(3, 3);
  return model;
}

struct Case {
  const char* name;
  Scenario (*make)(Random&);
  double radius_m;
};

void PrintTo(const Case& c, std::ostream* out) {
  *out << c.name;
}

std::string name_of(const testing::TestParamInfo<Case>& info) {
  return info.param.name;
}

const auto kCases = testing::Values(
    Case{"box", box_scenario, 0.0}, Case{"box_by_a_sphere", box_scenario, 3e-3},
    Case{"bumpy_sphere", bumpy_sphere_scenario, 0.0},
    Case{"bumpy_sphere_by_a_sphere", bumpy_sphere_scenario, 3e-3},
    Case{"fine_sphere", fine_sphere_scenario, 0.0},
    Case{"fine_sphere_by_a_sphere", fine_sphere_scenario, 0.5e-3}, Case{"soup", soup_scenario, 0.0},
    Case{"soup_by_a_sphere", soup_scenario, 3e-3});

// ---- unit, place and pose ----------------------------------------------------------------------

double ulp_of(double x) {
  return std::nextafter(x, HUGE_VAL) - x;
}

// The allowed difference between two placements of one scenario, in the scenario's own unit.
struct Allowance {
  // Outside the solver: the goal, the origin of the solver frame and the proxy are each rounded
  // once, by half an ulp of the largest coordinate along each axis.
  double rounding_m = 0.0;
  // In the solver: heights are rounded by kHeightRoundoff of the scene's size. Where planes meet at
  // a small angle, a point moves by that amount over the sine. The clearance, at which the engine
  // no longer distinguishes two points, allows for 1 / 350. A sphere rests on curves of its own
  // radius: along such a curve, its distance to the goal stays the same to the last bit over sqrt(2
  // ulp radius).
  double solver_m = 0.0;
  double radius_m = 0.0;

  // A projection transmits a rounding of its goal at most undiminished. A sphere on an edge or
  // vertex transmits it multiplied by its radius over the goal's distance from there.
  double at(const TickRecord& record) const {
    const double to_feature_m =
        std::abs(radius_m - (vec3(record.proxy_scene_m) - vec3(record.goal_scene_m)).norm());
    const double lever = radius_m == 0.0 ? 1.0 : std::max(1.0, radius_m / to_feature_m);
    return lever * rounding_m + solver_m;
  }
};

Allowance allowance_of(const Scenario& scenario, const Placing& placing, double radius_m) {
  double largest_m = 0.0;
  Vec3 low = scenario.soup.positions.front();
  Vec3 high = low;
  for (const Vec3& p : scenario.soup.positions) {
    largest_m = std::max(largest_m, placing.body(p).cwiseAbs().maxCoeff());
    largest_m = std::max(largest_m, placing.scene(p).cwiseAbs().maxCoeff());
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double size_m = (high - low).maxCoeff();
  const SolverScale scale = SolverScale::of(size_m, radius_m);
  return {3 * (0.5 * std::sqrt(3.0)) * ulp_of(largest_m) / placing.scale,
          radius_m == 0.0 ? scale.clearance_m : std::sqrt(2 * ulp_of(size_m) * radius_m), radius_m};
}

class Placed : public testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    scenario_ = GetParam().make(random_);
    base_ = render(scenario_, {}, without_a4(GetParam().radius_m), every_axis());
    const auto in_contact = std::count_if(base_.begin(), base_.end(),
                                          [](const TickRecord& record) { return record.contact; });
    ASSERT_GT(in_contact, kLeastContactTicks);
    ASSERT_LT(in_contact, kTicks);
  }

  void expect_same(const Placing& placing) {
    const auto placed = render(scenario_, placing, without_a4(GetParam().radius_m), every_axis());
    const Allowance allowance = allowance_of(scenario_, placing, GetParam().radius_m);
    for (std::size_t n = 0; n < base_.size(); ++n) {
      const WideVec3 error =
          placing.undone(vec3(placed[n].proxy_scene_m)) - vec3(base_[n].proxy_scene_m).cast<Wide>();
      ASSERT_LE(error.norm(), allowance.at(base_[n])) << "tick " << n;
    }
  }

  Random random_{71};
  Scenario scenario_;
  std::vector<TickRecord> base_;
};

TEST_P(Placed, GivesTheSameResultInEveryUnit) {
  for (const double scale : {1e-3, 0.37, 12.9, 1e3}) {
    SCOPED_TRACE(testing::Message() << "times " << scale);
    expect_same({.scale = scale});
  }
}

TEST_P(Placed, GivesTheSameResultAKilometreAway) {
  const Vec3 away_m(1000.0, -700.0, 300.0);
  {
    SCOPED_TRACE("vertices");
    expect_same({.moved_m = away_m});
  }
  SCOPED_TRACE("pose");
  expect_same({.T_scene_body = {Quat::Identity(), away_m}});
}

TEST_P(Placed, GivesTheSameResultInRandomPoses) {
  for (const double away_m : {1.0, 1.0, 1000.0, 1000.0}) {
    const RigidTransform pose = random_.pose(away_m);
    SCOPED_TRACE(testing::Message() << pose.rotation << ", " << pose.translation_m.transpose());
    expect_same({.T_scene_body = pose});
  }
}

// All numbers of a tick, with lengths and forces divided by the scale.
std::vector<std::uint64_t> bits_of(const TickRecord& r, double scale = 1.0) {
  std::vector<std::uint64_t> bits{r.contact, r.faults, static_cast<std::uint64_t>(r.iterations)};
  const auto add = [&](const auto& v, double by) {
    for (int k = 0; k < v.size(); ++k) bits.push_back(std::bit_cast<std::uint64_t>(v[k] / by));
  };
  for (const Vec3& v : {vec3(r.goal_scene_m), vec3(r.proxy_scene_m), vec3(r.full_force_device_N),
                        vec3(r.force_device_N), pose_before(r).translation_m}) {
    add(v, scale);
  }
  add(vec3(r.normal_scene), 1.0);
  add(pose_before(r).rotation.coeffs(), 1.0);
  bits.push_back(std::bit_cast<std::uint64_t>(r.alpha_rad));
  return bits;
}

// Scaling by a power of two causes no rounding, and the engine has no absolute length.
TEST_P(Placed, GivesTheSameBitsIfScaledByAPowerOfTwo) {
  HapticSettings settings = without_a4(GetParam().radius_m);
  settings.a4.enabled = true;
  const ActuationModel one_axis = *ActuationModel::from_counts(3, 1);
  const auto base = render(scenario_, {}, settings, one_axis);
  double turned_rad = 0.0;
  for (const TickRecord& record : base) {
    turned_rad =
        std::max(turned_rad, pose_before(record).rotation.angularDistance(Quat::Identity()));
  }
  ASSERT_GT(turned_rad, 0.05);
  for (const double scale : {0x1p-10, 0x1p-1, 0x1p3, 0x1p10}) {
    SCOPED_TRACE(testing::Message() << "times " << scale);
    const auto scaled = render(scenario_, {.scale = scale}, settings, one_axis);
    for (std::size_t n = 0; n < base.size(); ++n) {
      ASSERT_EQ(bits_of(scaled[n], scale), bits_of(base[n])) << "tick " << n;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, Placed, kCases, name_of);

// ---- data kept between ticks --------------------------------------------------------------------

class Candidates : public testing::TestWithParam<Case> {};

TEST_P(Candidates, GiveTheSameBitsWhetherReusedOrFetchedAnew) {
  Random random(72);
  const Scenario scenario = GetParam().make(random);
  HapticSettings settings = without_a4(GetParam().radius_m);
  ASSERT_TRUE(settings.god_object.accuracy.reuse_candidates);
  const auto reused = render(scenario, {}, settings, every_axis());
  settings.god_object.accuracy.reuse_candidates = false;
  const auto fetched = render(scenario, {}, settings, every_axis());
  int in_contact = 0;
  for (std::size_t n = 0; n < reused.size(); ++n) {
    ASSERT_EQ(bits_of(fetched[n]), bits_of(reused[n])) << "tick " << n;
    in_contact += reused[n].contact;
  }
  EXPECT_GT(in_contact, kLeastContactTicks);
}

INSTANTIATE_TEST_SUITE_P(Scenes, Candidates, kCases, name_of);

}  // namespace
}  // namespace palpate
