// The knobs of mesh and solver agree with theory. All tests use one fixed seed.

#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "engine/accuracy/knobs.h"
#include "engine/accuracy/measurement.h"
#include "engine/accuracy/pressed_path.h"
#include "tests/engine/accuracy/measured_knobs.h"

namespace palpate {
namespace {

MeasurementEffort contact_effort() {
  MeasurementEffort effort;
  effort.quick = true;
  effort.seed = 7;
  return effort;
}

KnobResult measured_contact(const std::vector<Knob>& knobs, const std::string& name) {
  return test::measured(knobs, name, contact_effort());
}

void expect_known_orders(const KnobResult& result) {
  for (const MethodResult& method : result.methods) {
    if (!method.expected_order) continue;
    ASSERT_TRUE(method.order.has_value()) << result.knob.name << ", " << method.name;
    EXPECT_NEAR(*method.order, *method.expected_order, 0.15)
        << result.knob.name << ", " << method.name;
  }
}

void expect_no_failure(const KnobResult& result) {
  for (const MethodResult& method : result.methods) {
    for (const LevelResult& level : method.levels) {
      EXPECT_EQ(level.failures, 0) << method.name << ", " << level.label << ": " << level.failure;
      EXPECT_GT(level.ticks, 0u);
    }
  }
}

// The largest error of a sphere with edges h is h^2 / (6 R). The root mean square is between a
// third of it and all of it: 0.48 of it on an equilateral triangle.
TEST(MeshKnobs, DepthIsOfSecondOrder) {
  const KnobResult result = measured_contact(mesh_knobs(contact_effort()), "mesh_depth");
  expect_no_failure(result);
  expect_known_orders(result);
  for (const LevelResult& level : result.methods[0].levels) {
    const double most_m = level.value * level.value / (6.0 * 0.1);
    EXPECT_LT(level.error.median, most_m) << level.label;
    EXPECT_GT(level.error.median, most_m / 3.0) << level.label;
  }
}

// Likewise h / (sqrt(3) R).
TEST(MeshKnobs, DirectionIsOfFirstOrder) {
  const KnobResult result = measured_contact(mesh_knobs(contact_effort()), "mesh_angle");
  expect_no_failure(result);
  expect_known_orders(result);
  for (const LevelResult& level : result.methods[0].levels) {
    const double most_deg = level.value / (std::sqrt(3.0) * 0.1) * 180.0 / 3.14159265358979;
    EXPECT_LT(level.error.median, most_deg) << level.label;
    EXPECT_GT(level.error.median, most_deg / 3.0) << level.label;
  }
}

TEST(MeshKnobs, SphereProxiesHaveTheErrorsOfPoints) {
  const KnobResult result = measured_contact(mesh_knobs(contact_effort()), "proxy_radius");
  expect_no_failure(result);
  for (const MethodResult& method : result.methods) {
    for (std::size_t l = 0; l < method.levels.size(); ++l) {
      const double point_deg = result.methods[0].levels[l].error.median;
      EXPECT_NEAR(method.levels[l].error.median, point_deg, 0.05 * point_deg) << method.name;
    }
  }
}

// A capped proxy is feasible and lags: with more steps it is at no level farther from the converged
// proxy.
TEST(SolverKnobs, MoreStepsAreNoLessExact) {
  const KnobResult result = measured_contact(solver_knobs(contact_effort()), "solver_iterations");
  expect_no_failure(result);
  const auto& levels = result.methods[0].levels;
  for (std::size_t l = 1; l < levels.size(); ++l) {
    EXPECT_LE(levels[l].raw_error, levels[l - 1].raw_error) << levels[l].label;
  }
  EXPECT_GT(levels.front().raw_error, 1e-3);
  EXPECT_TRUE(levels.back().at_floor);
}

TEST(SolverKnobs, AFinerToleranceIsNoLessExact) {
  const KnobResult result = measured_contact(solver_knobs(contact_effort()), "solver_tolerance");
  expect_no_failure(result);
  const auto& levels = result.methods[0].levels;
  for (std::size_t l = 1; l < levels.size(); ++l) {
    EXPECT_LE(levels[l].raw_error, levels[l - 1].raw_error) << levels[l].label;
  }
  EXPECT_FALSE(levels.front().at_floor);
  EXPECT_TRUE(levels.back().at_floor);
}

TEST(SolverKnobs, KeptCandidatesChangeNothing) {
  const KnobResult result = measured_contact(solver_knobs(contact_effort()), "candidate_reuse");
  expect_no_failure(result);
  for (std::size_t l = 0; l < result.methods[0].levels.size(); ++l) {
    EXPECT_EQ(result.methods[0].levels[l].raw_error, result.methods[1].levels[l].raw_error);
    EXPECT_TRUE(result.methods[0].levels[l].at_floor);
  }
}

// A mesh placed by its node is as exact a kilometre away as at the origin. A mesh placed by its
// vertices has lost digits in the file: half a step of single precision there is at most 2^-24
// times the coordinate.
TEST(NarrowPhaseKnob, ErrorsAreTheRoundingOfTheFile) {
  const KnobResult result = measure(narrow_phase_knob(contact_effort()), contact_effort(), nullptr);
  ASSERT_EQ(result.methods.size(), 4u);
  for (const LevelResult& level : result.methods[0].levels) {
    EXPECT_EQ(level.failures, 0);
    EXPECT_TRUE(level.at_floor) << level.label;
  }
  for (const LevelResult& level : result.methods[2].levels) {
    EXPECT_EQ(level.failures, 0);
    EXPECT_LT(level.error.median, 2.0 * 0x1p-24 * level.value) << level.label;
  }
  ASSERT_TRUE(result.methods[2].order.has_value());
  EXPECT_NEAR(*result.methods[2].order, 1.0, 0.15);
}

TEST(CertificationKnob, FindsTheBottomOfEveryGroove) {
  const KnobResult result =
      measure(certification_knob(contact_effort()), contact_effort(), nullptr);
  for (const LevelResult& level : result.methods[0].levels) {
    EXPECT_EQ(level.failures, 0) << level.label << ": " << level.failure;
    EXPECT_TRUE(level.at_floor) << level.label;
  }
}

// The next ticks continue the motion of a capped tick: with more work the proxy lags less, and the
// default is enough for an easy scene.
TEST(WorkBudgetKnob, MoreWorkIsNoLessExact) {
  const KnobResult result = measure(work_budget_knob(contact_effort()), contact_effort(), nullptr);
  expect_no_failure(result);
  ASSERT_EQ(result.methods.size(), 2u);
  const auto& hard = result.methods[0].levels;
  EXPECT_GT(hard.front().raw_error, 1e-5);
  EXPECT_LT(hard.back().raw_error, 0.5 * hard.front().raw_error);
  for (const LevelResult& level : result.methods[1].levels) {
    if (level.value >= static_cast<double>(Accuracy::balanced().work_budget)) {
      EXPECT_TRUE(level.at_floor) << level.label;
    }
  }
}

TEST(SmoothSurfaces, HaveTheirNormals) {
  SeededRandom random(9);
  for (const SmoothSurface& surface :
       {smooth_sphere(0.1), smooth_torus(0.1, 0.04), smooth_bumpy_sphere(0.1, 3e-3, 7)}) {
    for (int n = 0; n < 100; ++n) {
      const SmoothPoint at = surface(random.in_box(0.1));
      EXPECT_NEAR(at.normal.norm(), 1.0, 1e-12);
      // A point moved along the tangent plane is off the surface by the square of the displacement.
      constexpr double kMoved_m = 1e-6;
      const Vec3 along = at.normal.cross(random.unit_vector()).normalized();
      const SmoothPoint moved = surface(at.point_m + kMoved_m * along);
      const double off_m = at.normal.dot(moved.point_m - at.point_m);
      EXPECT_LT(std::abs(off_m), 1e3 * kMoved_m * kMoved_m);
    }
  }
}

}  // namespace
}  // namespace palpate
