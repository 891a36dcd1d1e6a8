// What the page of `view` may make of a wall on a device that moves motors.

#include "engine/cli/page_stiffness.h"

#include <cmath>
#include <memory>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include "tests/helpers/gltf_builder.h"
#include "tests/helpers/made.h"

namespace palpate {
namespace {

constexpr double kPeriod_s = 1e-3;

DeviceDescription judged_device() {
  DeviceDescription device;
  device.name = "board";
  device.moves_motors = true;
  device.motor_count = 3;
  device.peak_force_N = 10.0;
  device.mass_kg = 0.1;
  device.damping_Ns_per_m = 0.5;
  device.delay = {1e-3, 3e-3};
  return device;
}

PreparedRun prepared_run(const test::TemporaryFolder& folder, double stiffness_N_per_m) {
  test::GltfBuilder gltf;
  const auto positions = gltf.add_positions(
      {{0.0f, 0.0f, 0.0f}, {0.1f, 0.0f, 0.0f}, {0.0f, 0.1f, 0.0f}, {0.0f, 0.0f, 0.1f}});
  const auto indices = gltf.add_indices({0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3});
  gltf.json["materials"] = {
      {{"name", "wood"}, {"extras", {{"palpate", {{"stiffness", 100.0}, {"damping", 0.1}}}}}}};
  gltf.add_mesh(
      {{{"attributes", {{"POSITION", positions}}}, {"indices", indices}, {"material", 0}}});
  gltf.add_node({{"mesh", 0}});
  RunSettings settings;
  settings.haptics.coupling.stiffness_N_per_m = stiffness_N_per_m;
  return {test::made(Scene::load(gltf.write_glb(folder), {})), test::made(make_setup(settings))};
}

struct JudgedPage {
  explicit JudgedPage(double stiffness_N_per_m, const std::string& allowed = "")
      : prepared(prepared_run(folder, stiffness_N_per_m)) {
    RunStiffness chosen;
    chosen.zones = zones(0.0);
    chosen.peak_force_N = 10.0;
    chosen.allowed = allowed;
    chosen.worst = {"surfaces without their own", stiffness_N_per_m, chosen.zones};
    judge = make_wall_judge(device, prepared, chosen);
  }
  StiffnessZones zones(double damping) const {
    return test::made(stiffness_zones(device, damping, kPeriod_s));
  }
  // The refusal, or what the person is told.
  std::string set(const std::string& name, double value) {
    const auto told = judge->judge(name, value);
    if (!told) return told.error().element + ": " + told.error().problem;
    judge->keep();
    return *told;
  }

  test::TemporaryFolder folder;
  DeviceDescription device = judged_device();
  PreparedRun prepared;
  std::unique_ptr<WallJudge> judge;
};

std::string fits(double stiffness_N_per_m) {
  return "expected at most " + std::to_string(std::lround(std::floor(stiffness_N_per_m))) +
         " N/m: no damping that the delay of 1 to 3 ms permits brings the device to rest";
}

TEST(PageStiffness, IsToldInItsZoneAndRefusedBeyond) {
  JudgedPage page(50.0);
  const StiffnessZones zones = page.zones(0.0);
  EXPECT_EQ(page.set("stiffness", 0.99 * zones.stable_N_per_m), "");
  const double controlled = std::round(1.5 * zones.stable_N_per_m);
  const std::string loop = " N/m of \"surfaces without their own\": ";
  std::ostringstream told;
  told << "stiffness " << controlled << loop
       << "calm only by the controller, which damps the motion";
  EXPECT_EQ(page.set("stiffness", controlled), told.str());
  EXPECT_EQ(page.set("stiffness", controlled + 1.0), "") << "told once";
  EXPECT_EQ(page.set("stiffness", 5000.0), "stiffness: is 5000 N/m; " + fits(zones.calm_N_per_m));
  EXPECT_EQ(page.set("stiffness", std::floor(zones.calm_N_per_m)), "") << "the value that fits";
  EXPECT_EQ(page.set("stiffness", 100.0), "stiffness 100" + loop + "stable");
}

TEST(PageStiffness, OfAMaterialIsJudgedWithItsOwnDamping) {
  JudgedPage page(50.0);
  const StiffnessZones own = page.zones(0.1);
  EXPECT_EQ(page.set("material/wood/stiffness", 5000.0),
            "material/wood/stiffness: is 5000 N/m; " + fits(own.calm_N_per_m));
  EXPECT_EQ(page.set("material/wood/stiffness", 0.99 * own.stable_N_per_m), "");
  // Without its damping, the same stiffness is not stable by itself.
  EXPECT_NE(page.set("material/wood/damping", 0.0).find("calm only by the controller"),
            std::string::npos);
}

TEST(PageStiffness, ADampingThatTakesTheWallAwayIsRefused) {
  JudgedPage page(140.0);
  const std::string refused = page.set("damping", 50.0);
  EXPECT_EQ(refused.find("damping: is refused: the stiffness of \"surfaces without their own\" "
                         "then is 140 N/m; expected at most 0 N/m"),
            0u)
      << refused;
  EXPECT_EQ(page.set("damping", 0.2), "");
}

TEST(PageStiffness, LeavesOtherSettingsAndValuesThatAreNoneToThePage) {
  JudgedPage page(50.0);
  for (const char* name : {"material/wood/dynamicFriction", "force", "material/", "stiff", ""}) {
    EXPECT_EQ(page.set(name, 1e6), "") << name;
  }
  EXPECT_EQ(page.set("stiffness", -1.0), "");
  EXPECT_EQ(page.set("damping", std::nan("")), "");
}

TEST(PageStiffness, ThatThePersonAllowedIsToldAsUnstable) {
  JudgedPage page(50.0, "a test");
  EXPECT_EQ(page.set("stiffness", 5000.0),
            "stiffness 5000 N/m of \"surfaces without their own\": unstable, and allowed, because: "
            "a test");
}

}  // namespace
}  // namespace palpate
