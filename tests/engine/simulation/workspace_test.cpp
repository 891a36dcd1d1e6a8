// The position of a scene in the device frame, compared with all its vertices and its sections.

#include "engine/rig/workspace.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/rig/placed_bounds.h"
#include "engine/simulation/exploration.h"
#include "engine/simulation/plane_height.h"
#include "geometry/mesh/section.h"
#include "tests/helpers/random.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

struct Part {
  test::Soup soup;
  Mat3 linear = Mat3::Identity();
  Vec3 translation_m = Vec3::Zero();
};

Scene scene_of_parts(const std::vector<Part>& parts) {
  SceneDescription description;
  for (const Part& part : parts) {
    MeshDescription mesh;
    mesh.positions = part.soup.positions;
    mesh.triangles = part.soup.triangles;
    NodeDescription node;
    node.name = "part " + std::to_string(description.nodes.size());
    node.mesh = static_cast<std::uint32_t>(description.meshes.size());
    node.linear_scene_mesh = part.linear;
    node.translation_m = part.translation_m;
    description.meshes.push_back(std::move(mesh));
    description.nodes.push_back(node);
  }
  auto scene = Scene::compile(std::move(description));
  EXPECT_TRUE(scene) << scene.error().to_string();
  return std::move(*scene);
}

std::vector<Part> random_parts(test::Random& random) {
  std::vector<Part> parts;
  const std::size_t count = 1 + random.index(6);
  for (std::size_t i = 0; i < count; ++i) {
    Part part{test::box_soup(Vec3(0.02, 0.03, 0.05))};
    part.linear = random.rotation().toRotationMatrix() *
                  Vec3(random.uniform(0.2, 2.0), random.uniform(-2.0, -0.2), 1.0).asDiagonal();
    part.translation_m = random.in_box(0.2);
    parts.push_back(std::move(part));
  }
  return parts;
}

ScenePose random_pose(test::Random& random) {
  return {random.rotation(), random.in_box(1.0)};
}

std::vector<Polyline> contours_at(const Scene& scene, const ScenePose& T_device_scene,
                                  double height_m) {
  std::vector<Vec3> positions;
  std::vector<Triangle> triangles;
  scene.append_triangles_scene(positions, triangles);
  return plane_section(positions, triangles, T_device_scene.inverse_direction(Vec3::UnitZ()),
                       height_m - T_device_scene.translation_m.z());
}

TEST(PlacedBounds, AreTightAroundAllVertices) {
  test::Random random(8101);
  for (int i = 0; i < 100; ++i) {
    const std::vector<Part> parts = random_parts(random);
    const Scene scene = scene_of_parts(parts);
    const ScenePose pose = random_pose(random);
    const Box bounds = bounds_in_device(scene, pose);
    Vec3 low = Vec3::Constant(HUGE_VAL);
    Vec3 high = -low;
    for (const Part& part : parts) {
      for (const Vec3& p : part.soup.positions) {
        const Vec3 q = pose.rotation * (part.linear * p + part.translation_m) + pose.translation_m;
        low = low.cwiseMin(q);
        high = high.cwiseMax(q);
      }
    }
    EXPECT_LT((bounds.low - low).norm() + (bounds.high - high).norm(), 1e-14) << i;
  }
}

TEST(PlaneHeight, IsTheMiddleOfAnObjectHoweverItIsPlaced) {
  test::Random random(8102);
  for (int i = 0; i < 100; ++i) {
    const Scene scene = scene_of_parts({{test::box_soup(Vec3(0.02, 0.03, 0.05))}});
    const ScenePose pose = random_pose(random);
    const auto height_m = height_with_contour_m(scene, pose);
    ASSERT_TRUE(height_m);
    EXPECT_NEAR(*height_m, pose.translation_m.z(), 1e-15) << "the middle of a box is its centre";
    EXPECT_FALSE(contours_at(scene, pose, *height_m).empty());
  }
}

TEST(PlaneHeight, HasAContourWheneverOneExists) {
  test::Random random(8103);
  for (int i = 0; i < 200; ++i) {
    const Scene scene = scene_of_parts(random_parts(random));
    const ScenePose pose = random_pose(random);
    const auto height_m = height_with_contour_m(scene, pose);
    ASSERT_TRUE(height_m);
    EXPECT_FALSE(contours_at(scene, pose, *height_m).empty()) << i;
  }
}

// Two boxes with free space between them at the middle: except for the offset into the box, no
// height nearer to the middle has a contour.
TEST(PlaneHeight, IsTheNearestHeightWithAContour) {
  const test::Soup box = test::box_soup(Vec3::Constant(0.01));
  const Scene scene = scene_of_parts({{box, Mat3::Identity(), Vec3(0, 0, -0.05)},
                                      {box, Mat3::Identity(), Vec3(0, 0, 0.04)},
                                      {box, Mat3::Identity(), Vec3(0, 0, 0.08)}});
  const double extent_m = 0.15;  // from -0.06 to 0.09; its middle is 0.015
  const auto height_m = height_with_contour_m(scene, {});
  ASSERT_TRUE(height_m);
  EXPECT_NEAR(*height_m, 0.03 + extent_m / 64, 1e-15);
  EXPECT_FALSE(contours_at(scene, {}, *height_m).empty());
  EXPECT_TRUE(contours_at(scene, {}, 0.015).empty());
}

// Boxes that meet in faces at the middle, in any rotation: the nearest height beside the faces
// depends only on the extent, not on geometry in the plane.
TEST(PlaneHeight, IsBesideFacesThatLieInTheMiddle) {
  test::Random random(8105);
  for (int i = 0; i < 100; ++i) {
    const double size = std::pow(10.0, random.uniform(-3.0, 3.0));
    const double half_m = size * random.uniform(0.5, 1.0);
    const test::Soup low = test::box_soup(Vec3(0.6 * size, 0.6 * size, 0.5 * half_m));
    const test::Soup high = test::box_soup(Vec3(size, size, 0.5 * half_m));
    const ScenePose pose{random.rotation(), size * random.in_box(1.0)};
    const Mat3 back = pose.rotation.toRotationMatrix().transpose();
    const Scene scene = scene_of_parts({{low, back, back * Vec3(0, 0, -0.5 * half_m)},
                                        {high, back, back * Vec3(0, 0, 0.5 * half_m)}});
    const auto height_m = height_with_contour_m(scene, pose);
    ASSERT_TRUE(height_m);
    const double from_middle_m = std::abs(*height_m - pose.translation_m.z());
    EXPECT_NEAR(from_middle_m, 2.0 * half_m / 64, 1e-6 * size) << i;
    const auto contours = contours_at(scene, pose, *height_m);
    ASSERT_EQ(contours.size(), 1u);
    const double side_m = *height_m > pose.translation_m.z() ? size : 0.6 * size;
    EXPECT_NEAR(length_m(contours[0]), 8.0 * side_m, 1e-6 * size);
  }
}

// A stack of plates without gaps has faces at every height except inside the plates.
TEST(PlaneHeight, IsInsideOfAPlateOfAStack) {
  std::vector<Part> parts;
  const double thick_m = 1e-4;
  for (int k = 0; k < 20; ++k) {
    parts.push_back({test::box_soup(Vec3(0.05, 0.05, 0.5 * thick_m)), Mat3::Identity(),
                     Vec3(0, 0, (k + 0.5) * thick_m)});
  }
  const auto height_m = height_with_contour_m(scene_of_parts(parts), {});
  ASSERT_TRUE(height_m);
  const double from_face = std::remainder(*height_m, thick_m) / thick_m;
  EXPECT_GT(std::abs(from_face), 0.25) << *height_m;
  EXPECT_LE(std::abs(*height_m - 10 * thick_m), thick_m);
}

TEST(PlaneHeight, IsAbsentIfAllFacesArePerpendicularToA3) {
  test::Soup sheet;
  sheet.add_quad({-0.1, -0.1, 0}, {0.1, -0.1, 0}, {0.1, 0.1, 0}, {-0.1, 0.1, 0});
  const Scene scene = scene_of_parts({{sheet}, {sheet, Mat3::Identity(), Vec3(0, 0, 0.1)}});
  EXPECT_FALSE(height_with_contour_m(scene, {}));
  const ScenePose turned{Quat(Eigen::AngleAxisd(0.5, Vec3::UnitX())), Vec3::Zero()};
  EXPECT_TRUE(height_with_contour_m(scene, turned));
}

TEST(Workspace, FitsScenesThatLeaveClearanceForTheHand) {
  const Workspace planar{2, 0.4, 0.008, 0.004};
  const Box box{Vec3(-1, -1, -5), Vec3(-1, -1, 5)};  // no extent along A1 and A2
  const auto wide = [&](double a1_m, double a2_m) {
    return Box{box.low, box.low + Vec3(a1_m, a2_m, 10.0)};
  };
  EXPECT_FALSE(check_fits(planar, wide(0.38, 0.1), 10.0))
      << "an axis that is not sensed does not count";
  EXPECT_TRUE(check_fits(planar, wide(0.39, 0.1), 10.0));
  EXPECT_TRUE(check_fits(planar, wide(0.1, 0.39), 10.0));
  EXPECT_FALSE(check_fits(planar, wide(0.005, 0.001), 10.0));
  EXPECT_TRUE(check_fits(planar, wide(0.003, 0.003), 10.0)) << "smaller than the press depth";
  EXPECT_TRUE(check_fits({3, 0.4, 0.008, 0.004}, wide(0.1, 0.1), 10.0));
  const auto no_room = check_fits({2, 0.01, 0.008, 0.004}, wide(0.1, 0.1), 10.0);
  ASSERT_TRUE(no_room);
  EXPECT_EQ(no_room->element, "device.workspace") << "no size fits";
}

// Reads the size from the error's text, as a user does.
TEST(Workspace, IsFittedByTheSizeThatTheErrorNames) {
  test::Random random(8104);
  for (int i = 0; i < 100; ++i) {
    std::vector<Part> parts = random_parts(random);
    const double size = std::pow(10.0, random.uniform(-6.0, 6.0));
    for (Part& part : parts) {
      part.linear *= size;
      part.translation_m *= size;
    }
    // Workspaces from the smallest with clearance for a hand.
    const double extent_m =
        random.index(2) == 0 ? random.uniform(0.1, 2.0) : random.uniform(0.0201, 0.04);
    const Workspace workspace{random.index(2) == 0 ? 2 : 3, extent_m, 0.008, 0.004};
    const ScenePose pose = random_pose(random);
    const Scene scene = scene_of_parts(parts);
    const Box bounds = bounds_in_device(scene, pose);
    const double largest_m = scene.statistics().extent_m.maxCoeff();
    const auto error = check_fits(workspace, bounds, largest_m);
    if (!error) continue;
    const std::string option = "`SceneSettings::fit_size_m` ";
    const std::size_t at = error->hint.find(option);
    ASSERT_NE(at, std::string::npos) << error->to_string();
    const double factor = std::stod(error->hint.substr(at + option.size())) / largest_m;
    EXPECT_FALSE(
        check_fits(workspace, {factor * bounds.low, factor * bounds.high}, factor * largest_m))
        << error->to_string();
    const double widest_m = factor * (bounds.high - bounds.low).head(workspace.sensors).maxCoeff();
    const double wanted_m = std::min(0.5 * extent_m, 0.99 * (extent_m - 0.016));
    EXPECT_NEAR(widest_m, wanted_m, 0.011 * wanted_m);
  }
}

// A workspace of 20 mm fits a single size, which three digits cannot express.
TEST(Workspace, TooSmallForEverySizeIsRejectedWithTheLeastUsableOne) {
  const Box box{Vec3::Zero(), Vec3::Constant(0.1)};
  for (const double extent_m : {0.001, 0.016, 0.02, 0.02005}) {
    const auto error = check_fits({2, extent_m, 0.008, 0.004}, box, 0.1);
    ASSERT_TRUE(error);
    EXPECT_EQ(error->element, "device.workspace");
    EXPECT_NE(error->problem.find("at least 0.0201 m"), std::string::npos) << error->problem;
  }
  const auto error = check_fits({2, 0.0201, 0.008, 0.004}, box, 0.1);
  ASSERT_TRUE(error);
  EXPECT_EQ(error->element, "scene") << "a size fits";
}

// ---- clearance for a walking hand ---------------------------------------------------------------

// Plans an exploration and stops before its first tick.
Result<ExplorationRun> planned(const Scene& scene, int sensors) {
  RunSettings options;
  options.sensors = sensors;
  options.default_actuators = 1;
  const auto setup = make_setup(options);
  if (!setup) return setup.error();
  ExplorationSettings settings;
  StopFlag at_once;
  at_once.request();
  return explore(
      scene, *setup, settings, [](double) {}, &at_once);
}

Scene beam(double length_m, double slenderness) {
  const double half_m = 0.5 * length_m;
  return scene_of_parts(
      {{test::box_soup(Vec3(half_m, half_m / slenderness, half_m / slenderness))}});
}

// With the option of the hint, the hand finds a path.
TEST(RoomForAHand, IsFoundWithTheProposalOfTheError) {
  std::set<std::string> proposed;
  constexpr double length_m = 0.2;
  for (const double slenderness : {3000.0, 10000.0}) {
    const auto refused = planned(beam(length_m, slenderness), 3);
    if (refused) continue;
    const std::string& hint = refused.error().hint;
    SCOPED_TRACE(hint);
    const std::string size = "`SceneSettings::fit_size_m` ";
    if (const std::size_t at = hint.find(size); at != std::string::npos) {
      const double size_m = std::stod(hint.substr(at + size.size()));
      EXPECT_LE(size_m, 0.384) << "the workspace";
      EXPECT_TRUE(planned(beam(size_m, slenderness), 3));
      proposed.insert("size");
    } else {
      ASSERT_NE(hint.find("`RunSettings::sensors` 2"), std::string::npos);
      EXPECT_TRUE(planned(beam(length_m, slenderness), 2));
      proposed.insert("sensors");
    }
  }
  EXPECT_FALSE(proposed.empty());
}

}  // namespace
}  // namespace palpate
