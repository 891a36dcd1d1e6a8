// The hard case of long runs: quantities that could drift with time.

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "haptics/record_vectors.h"
#include "tests/engine/session/hard_case_device.h"
#include "tests/helpers/hard_case_shapes.h"
#include "tests/helpers/made.h"
#include "tests/helpers/soak.h"
#include "tests/helpers/ticks.h"

namespace palpate {
namespace {

using test::device;
using test::device_name;
using test::HardDevice;
using test::in_soak_or_else;
using test::kTick_s;
using test::OwnedWorld;
using test::Random;
using test::settings;
using test::trials;

// ---- 20 soak -----------------------------------------------------------------------------------

class HardCase20_Soak : public testing::TestWithParam<HardDevice> {};

// A long random motion over the star while the scene turns. The test examines the two quantities
// that could drift, the quaternion and the clearance; the exact judge would take most of the time.
TEST_P(HardCase20_Soak, KeepsTheQuaternionAndTheClearance) {
  const int ticks = in_soak_or_else(10000000, trials(100000));
  const auto [sensors, actuators, radius] = GetParam();
  Random random(311);
  const OwnedWorld world(test::paper_object_soup(paper_objects().front()), {}, radius);
  auto loop = test::made(HapticLoop::create(world.world(), device(sensors, actuators),
                                            settings(1000.0, 2.0, true, radius)));
  const SolverScale scale = SolverScale::of(world.world().size_m, radius);
  // The least clearance of a point; that of a sphere is half a stand-off.
  const double kept_m = radius + (1 - 1e-3) * scale.clearance_m;
  Vec3 at_m(0.2, 0.0, 0.0);  // in the scene, outside
  loop.tick(at_m, kTick_s);
  const Vec3 reach_m(0.07, 0.07, 0.015);
  std::uint64_t contact_ticks = 0;
  double least_m = 1.0;
  double worst_norm = 0.0;
  bool finite = true;
  for (int n = 0; n < ticks; ++n) {
    const Vec3 step =
        random.index(1000) == 0 ? Vec3(0.1 * random.unit_vector()) : Vec3(random.in_box(1e-3));
    // Most positions are within the star, so that the hand presses from its previous side. The
    // positions are in the scene frame, since A4 turns the star away from a hand that stays behind.
    at_m = (at_m + step).cwiseMin(reach_m).cwiseMax(-reach_m);
    const TickRecord& record = loop.tick(loop.T_device_scene().point(at_m), kTick_s);
    finite =
        finite && vec3(record.force_device_N).allFinite() && vec3(record.proxy_scene_m).allFinite();
    contact_ticks += record.contact;
    worst_norm = std::max(worst_norm, std::abs(loop.T_device_scene().rotation.norm() - 1.0));
    const Vec3 proxy = world.world().to_solver(vec3(record.proxy_scene_m));
    const auto nearest = world.index().closest_point(proxy, radius + 2 * scale.stand_off_m);
    if (nearest) least_m = std::min(least_m, nearest->distance_m);
  }
  EXPECT_TRUE(finite);
  EXPECT_LE(worst_norm, 4 * 0x1p-52);
  EXPECT_GT(contact_ticks, static_cast<std::uint64_t>(ticks / 10));
  // The transformation of the proxy to the scene frame adds one rounding.
  EXPECT_GE(least_m, kept_m - 8 * 0x1p-52 * world.world().size_m);
}

INSTANTIATE_TEST_SUITE_P(Devices, HardCase20_Soak,
                         testing::Values(HardDevice{3, 1, 0.0}, HardDevice{2, 1, 0.0},
                                         HardDevice{3, 2, 2e-3}),
                         device_name);

}  // namespace
}  // namespace palpate
