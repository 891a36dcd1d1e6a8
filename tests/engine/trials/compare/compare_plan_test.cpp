// The plans of comparisons of strategies, without running them.

#include "engine/trials/compare/compare_plan.h"

#include <filesystem>
#include <set>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "tests/engine/trials/compare/compare_settings.h"
#include "tests/helpers/gltf_builder.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;
using test::nine_strategies;
using test::settings_of;
using test::TemporaryFolder;

TEST(CompareList, ReadsNamesInOrder) {
  const CompareSettings settings = settings_of("a4,anisotropic:0.25,none,anisotropic:2");
  ASSERT_EQ(settings.strategies.size(), 4u);
  EXPECT_EQ(settings.strategies[0].type, &kA4Strategy);
  EXPECT_EQ(settings.strategies[1], (Strategy{&kAnisotropicStrategy, 0.25}));
  EXPECT_EQ(settings.strategies[3].parameter, 2.0);
  const auto several = settings_of("cd,anisotropic,mask").strategies;
  ASSERT_EQ(several.size(), 8u);
  EXPECT_EQ(several[1], *parse_strategy("anisotropic:0.0625"));
  EXPECT_EQ(several[6], *parse_strategy("anisotropic:16"));
  EXPECT_EQ(name_of(several[7]), "mask");
  EXPECT_EQ(settings_of("a4-passive").strategies[0], *parse_strategy("a4-passive"));
  EXPECT_EQ(every_strategy(), "none,mask,full,a4,a4-anticipate,a4-passive,anisotropic,cd");
}

TEST(CompareList, RefusesUnknownEmptyAndRepeatedNames) {
  const std::pair<const char*, const char*> lists[] = {
      {"", "is \"\""},
      {"mask,", "is \"\""},
      {",mask", "is \"\""},
      {"mask a4", "is \"mask a4\""},
      {"mask,A4", "is \"A4\""},
      {"anisotropic:32", "from 0.0625 to 16"},
      {"anisotropic:", "from 0.0625 to 16"},
      {"mask,a4,mask", "has mask twice"},
      {"a4-passive,a4-passive:10", "has a4-passive:10 twice"},
      {"anisotropic,anisotropic", "has anisotropic:0.0625 twice"},
      {"anisotropic:2,anisotropic:2.0", "has anisotropic:2 twice"},
      {"anisotropic:4,anisotropic", "has anisotropic:4 twice"}};
  for (const auto& [list, problem] : lists) {
    const auto settings = with_strategies({}, list);
    ASSERT_FALSE(settings.ok()) << list;
    EXPECT_EQ(settings.error().element, "strategies");
    EXPECT_NE(settings.error().to_string().find(problem), std::string::npos)
        << settings.error().to_string();
  }
}

TEST(ComparePlan, IsThePlanOfTheFileThatIsWritten) {
  const TemporaryFolder folder;
  CompareSettings settings = nine_strategies();
  settings.scene.node = "";
  settings.scene.scale = 0.75;
  settings.scene.close_gaps_m = 0.0005;
  settings.device.actuated_axes = {Vec3(0.6, 0.8, 0.0)};
  settings.device.actuators.reset();
  settings.device.haptics.god_object.accuracy = Accuracy::exact();
  settings.device.haptics.coupling.velocity.method = VelocityMethod::kAdaptive;
  settings.device.encoder_quantum_m = 3e-5;
  settings.device.max_force_N = 4.0;
  settings.device.haptics.god_object.radius_m = 0.001;
  settings.device.device.mass_kg = 0.25;
  fs::create_directories(folder.path("deep/er"));
  const auto plan = compare_plan(settings);
  ASSERT_TRUE(plan.ok()) << plan.error().to_string();
  folder.write("deep/er/plan.json", compare_plan_text(settings, folder.path("deep/er")));
  const auto read = load_plan(folder.path("deep/er/plan.json"));
  ASSERT_TRUE(read.ok()) << read.error().to_string();
  EXPECT_EQ(read->hash, plan->hash);
  EXPECT_EQ(read->canonical, plan->canonical);
  ASSERT_EQ(read->objects.size(), 2u);
  for (const PlanObject& object : read->objects) {
    EXPECT_TRUE(fs::exists(object.path)) << object.path;
    EXPECT_EQ(object.scene.scale, 0.75);
    EXPECT_EQ(object.scene.close_gaps_m, 0.0005);
  }
  EXPECT_EQ(read->device.actuated_axes.front(), Vec3(0.6, 0.8, 0.0));
  EXPECT_EQ(read->device.haptics.god_object.accuracy.work_budget, Accuracy::exact().work_budget);
  EXPECT_EQ(read->device.haptics.coupling.velocity.method, VelocityMethod::kAdaptive);
  EXPECT_EQ(read->device.encoder_quantum_m, 3e-5);
  EXPECT_EQ(read->device.max_force_N, 4.0);
  EXPECT_EQ(read->device.haptics.god_object.radius_m, 0.001);
  EXPECT_EQ(read->device.device.mass_kg, 0.25);
  EXPECT_EQ(read->device.haptics.coupling.damping_Ns_per_m, 2.0);
  EXPECT_EQ(read->followings, std::vector<Following>{Following::kDelayed});
}

TEST(ComparePlan, HasTheSeedAndEachStrategy) {
  const auto plan = compare_plan(nine_strategies());
  ASSERT_TRUE(plan.ok());
  EXPECT_EQ(plan->seed, 2005u);
  EXPECT_EQ(plan->strategies.size(), 3u + 6u);
}

TEST(ComparePlan, NamesObjectsLikeFilesAndNoneTwice) {
  const TemporaryFolder folder;
  fs::create_directories(folder.path("other"));
  CompareSettings settings = nine_strategies();
  settings.scenes = {"a/star.glb", "b/star.glb", "my star \u00e9.gltf", ".glb",
                     std::string(60, 'x') + ".glb"};
  const auto plan = compare_plan(settings);
  ASSERT_TRUE(plan.ok()) << plan.error().to_string();
  std::set<std::string> names;
  for (const PlanObject& object : plan->objects) names.insert(object.name);
  EXPECT_EQ(names,
            (std::set<std::string>{"star", "star-2", "my_star___", "_.glb", std::string(36, 'x')}));
}

}  // namespace
}  // namespace palpate
