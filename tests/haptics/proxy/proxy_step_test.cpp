#include "haptics/proxy/proxy_step.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::Random;
using Planes = ProxyStep::Planes;

// A contact with the face in this slot, at this clearance from its plane.
FaceContact wall(std::uint32_t slot, const Vec3& normal, double clearance_m = 0.0) {
  FaceContact contact{};
  contact.face.slot = slot;
  contact.normal = normal;
  contact.clearance_m = clearance_m;
  contact.feature_point = -clearance_m * normal;
  return contact;
}

ContactPlane plane_of(const FaceContact& contact) {
  return {contact.normal, std::min(0.0, -contact.clearance_m)};
}

bool add(ProxyStep& step, const FaceContact& contact) {
  return step.add(contact, plane_of(contact));
}

PlaneProjection solution_by(const std::vector<int>& active, const Vec3& displacement_m) {
  PlaneProjection solution;
  solution.displacement_m = displacement_m;
  std::copy(active.begin(), active.end(), solution.active.begin());
  solution.active_count = static_cast<int>(active.size());
  solution.solved = true;
  return solution;
}

TEST(ProxyStep, KnowsEachPlaneOnce) {
  Random random(4705);
  for (int i = 0; i < 100; ++i) {
    const Vec3 normal = random.unit_vector();
    ProxyStep step;
    EXPECT_TRUE(add(step, wall(1, normal, 0.5)));
    EXPECT_FALSE(add(step, wall(1, normal, 0.5)));
    EXPECT_FALSE(add(step, wall(2, normal, 0.75))) << "a farther face in the same direction";
    EXPECT_EQ(step.contacts()[0].face.slot, 1U);
    EXPECT_TRUE(add(step, wall(3, normal, 0.25))) << "a nearer one";
    EXPECT_EQ(step.planes().size(), 1U);
    EXPECT_EQ(step.contacts()[0].face.slot, 3U);
    EXPECT_EQ(step.planes()[0].offset_m, -0.25);
    EXPECT_TRUE(add(step, wall(4, normal.unitOrthogonal())));
    EXPECT_EQ(step.planes().size(), 2U);
  }
}

TEST(ProxyStep, KeepsOnlyTheActivePlanesIfThereIsNoSpace) {
  Random random(4706);
  ProxyStep step;
  std::vector<FaceContact> walls;
  for (std::uint32_t slot = 0; slot < kMaxContactPlanes; ++slot) {
    walls.push_back(wall(slot, random.unit_vector()));
    ASSERT_TRUE(add(step, walls.back()));
  }
  step.solve(solution_by({2, 5, 23}, Vec3::Zero()));
  ASSERT_TRUE(add(step, wall(100, random.unit_vector())));
  ASSERT_EQ(step.planes().size(), 4U);
  const std::uint32_t slots[] = {2, 5, 23, 100};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(step.contacts()[i].face.slot, slots[i]);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(step.active_contact(i).face.slot, slots[i]);
    EXPECT_EQ(step.active_plane(i).normal, walls[slots[i]].normal);
  }
}

TEST(ProxyStep, StaysOnTheFreeSideOfEveryPlaneAsItAdvances) {
  Random random(4707);
  for (int i = 0; i < 100; ++i) {
    ProxyStep step;
    const Vec3 normal = random.unit_vector();
    add(step, wall(1, normal, 0.5));
    step.set_current();
    const Vec3 displacement = random.in_box(0.25);
    step.advance(displacement);
    EXPECT_EQ(step.planes()[0].offset_m, std::min(0.0, -0.5 - normal.dot(displacement)));
    EXPECT_EQ(step.state(), Planes::kEarlier);
    step.advance(-2.0 * normal);
    EXPECT_EQ(step.planes()[0].offset_m, 0.0);
  }
}

// Two questions about the planes, answered by a flag each.
TEST(ProxyStep, AnswersAsIndependentFlagsAfterAnySequenceOfActions) {
  Random random(4708);
  ProxyStep step;
  bool is_current = false;
  bool is_over_next = false;
  int seen[3] = {};
  for (int i = 0; i < 20000; ++i) {
    const auto action = random.index(6);
    ProxyStep earlier = step;
    switch (action) {
      case 0:
        step.clear();
        is_current = is_over_next = false;
        break;
      case 1:
        step.set_current();
        is_current = true;
        is_over_next = false;
        break;
      case 2:
        step.set_earlier();
        is_current = is_over_next = false;
        break;
      case 3:
        step.set_over_next_face();
        is_current = false;
        is_over_next = true;
        break;
      case 4:
        step.advance(Vec3::UnitX());
        is_current = is_over_next = false;
        break;
      default:
        step.set_earlier();
        step.return_to(earlier);
        is_over_next = false;
    }
    ++seen[static_cast<std::size_t>(step.state())];
    ASSERT_EQ(step.is_current(), is_current) << "action " << i;
    ASSERT_EQ(step.is_over_next_face(), is_over_next) << "action " << i;
  }
  EXPECT_GT(*std::min_element(std::begin(seen), std::end(seen)), 500);
}

TEST(ProxyStep, ReturnsToItsPlanesAndTheirSolution) {
  ProxyStep step;
  add(step, wall(1, Vec3::UnitX(), 0.5));
  add(step, wall(2, Vec3::UnitY()));
  step.solve(solution_by({1}, Vec3(0.25, 0, 0)));
  step.set_current();
  const ProxyStep before = step;
  step.advance(Vec3(-0.25, 0, 0));
  step.clear();
  add(step, wall(3, Vec3::UnitZ()));
  step.return_to(before);
  EXPECT_TRUE(step.is_current());
  ASSERT_EQ(step.planes().size(), 2U);
  EXPECT_EQ(step.planes()[0].offset_m, -0.5);
  ASSERT_EQ(step.active_count(), 1);
  EXPECT_EQ(step.active_contact(0).face.slot, 2U);
  EXPECT_EQ(step.displacement_m(), Vec3(0.25, 0, 0));
}

TEST(ProxyStep, FindsTheFirstOfTheActivePlanes) {
  ProxyStep step;
  add(step, wall(1, Vec3::UnitX(), 1.0));
  add(step, wall(2, Vec3::UnitY(), 0.5));
  add(step, wall(3, Vec3::UnitZ(), 0.25));
  step.solve(solution_by({0, 1}, Vec3::Zero()));
  EXPECT_EQ(step.part_to_planes(Vec3(-2, -2, -2)), 0.25);
  EXPECT_EQ(step.part_to_planes(Vec3(-2, 1, -2)), 0.5);
  EXPECT_EQ(step.part_to_planes(Vec3(1, 1, 1)), 1.0);
  EXPECT_TRUE(step.is_off_planes(0.375));
  EXPECT_FALSE(step.is_off_planes(0.5));
  EXPECT_FALSE(step.touches_faces(0.5));
  EXPECT_TRUE(step.touches_faces(1.0));
  step.clear_solution();
  EXPECT_FALSE(step.is_off_planes(0.0)) << "no plane is active";
}

}  // namespace
}  // namespace palpate
