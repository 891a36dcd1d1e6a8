// The settings of a run (run_setting.h): a line that is added to the table reaches help, plans and
// recordings. docs/generate.py lists them all on a page.

#include "engine/session/run_setting.h"

#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/cli/run_options.h"
#include "engine/recording/recording_settings.h"
#include "engine/trials/plan_device.h"

namespace palpate {
namespace {

// Two lines behind the others.
std::vector<RunSetting> with_added_settings() {
  std::vector<RunSetting> table(run_settings().begin(), run_settings().end());
  table.push_back({"anticipation.range_m",
                   in_haptics([](auto& s) -> auto& { return s.anticipation.range_m; }),
                   "--reach",
                   SettingGroup::kTouch,
                   {0.0, 2.0},
                   "reach of the hand",
                   "m",
                   "; 0 is none",
                   {"reach_m"},
                   {"hand.reach_m"}});
  table.push_back({"a4.enabled",
                   in_haptics([](auto& s) -> auto& { return s.a4.enabled; }),
                   "--turns",
                   SettingGroup::kTouch,
                   {},
                   "turn at once",
                   "",
                   "",
                   {"turns"},
                   {"hand.turns"}});
  return table;
}

nlohmann::json device() {
  return nlohmann::json::parse(
      R"({"sensors": 2, "actuators": 1, "rate_Hz": 1000, "stiffness_N_per_m": 900,
          "damping_Ns_per_m": 1, "reach_m": 0.25, "turns": true})");
}

TEST(AddedSetting, IsInTheHelpAndOnTheCommandLine) {
  const std::vector<RunSetting> table = with_added_settings();
  CLI::App app;
  RunOptions options;
  add_settings(app, options, SettingGroup::kTouch, table);
  const std::string help = app.help();
  for (const char* part : {"--reach NUMBER=0.02", "reach of the hand, m; 0 is none", "--turns",
                           "turn at once", "--stiffness NUMBER=1000"}) {
    EXPECT_NE(help.find(part), std::string::npos) << part << " in " << help;
  }
  app.parse("--reach 0.25 --turns");
  EXPECT_EQ(options.settings.haptics.anticipation.range_m, 0.25);
  EXPECT_TRUE(options.settings.haptics.a4.enabled);
  try {
    app.parse("--reach 2.5");
    FAIL() << "2.5 is accepted";
  } catch (const CLI::ParseError& error) {
    EXPECT_STREQ(error.what(), "--reach: is \"2.5\"; expected a finite number from 0 to 2");
  }
}

TEST(AddedSetting, IsInPlans) {
  const std::vector<RunSetting> table = with_added_settings();
  const auto settings = read_plan_device(device(), "/device", table);
  ASSERT_TRUE(settings.ok()) << settings.error().to_string();
  EXPECT_EQ(settings->haptics.anticipation.range_m, 0.25);
  EXPECT_TRUE(settings->haptics.a4.enabled);
  const std::string written = plan_device_json(*settings, table).dump();
  EXPECT_TRUE(written.ends_with(R"(,"reach_m":0.25,"turns":true})")) << written;
  EXPECT_EQ(written.substr(0, written.find(R"(,"reach_m")")) + "}",
            plan_device_json(*settings).dump());

  nlohmann::json beyond = device();
  beyond["reach_m"] = 2.5;
  const auto refused = read_plan_device(beyond, "/device", table);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().to_string(), "/device/reach_m: is 2.5; expected a number from 0 to 2");
  EXPECT_FALSE(read_plan_device(device(), "/device").ok());  // without the added lines
}

TEST(AddedSetting, IsInRecordings) {
  const std::vector<RunSetting> table = with_added_settings();
  RecordedSetup setup;
  setup.scene_path = std::string(PALPATE_MODELS_DIR) + "/star.glb";
  const auto scene = Scene::load(setup.scene_path, {});
  ASSERT_TRUE(scene.ok()) << scene.error().to_string();
  const auto usual = meta_of(*scene, setup, table);
  ASSERT_TRUE(usual.ok());
  EXPECT_EQ(*usual, *meta_of(*scene, setup));  // other recordings keep their keys

  setup.haptics.anticipation.range_m = 0.25;
  setup.haptics.a4.enabled = false;
  auto meta = meta_of(*scene, setup, table);
  ASSERT_TRUE(meta.ok());
  EXPECT_EQ(meta->at("hand.reach_m"), MetaValue(0.25));
  EXPECT_EQ(meta->at("hand.turns"), MetaValue(std::int64_t{0}));
  meta->merge(meta_of(SessionFacts{light_device(), {}, true}));
  const auto session = session_of(*meta, table);
  ASSERT_TRUE(session.ok()) << session.error().to_string();
  EXPECT_EQ(session->setup.haptics.anticipation.range_m, 0.25);

  (*meta)["hand.reach_m"] = std::int64_t{1};
  const auto refused = session_of(*meta, table);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().to_string(), "hand.reach_m: has another type; expected a number");
}

TEST(AddedSetting, IsCheckedForItsRange) {
  const std::vector<RunSetting> table = with_added_settings();
  const RunSetting& reach = *(table.end() - 2);
  EXPECT_FALSE(check_range(reach, 2.0));
  for (const double wrong : {-0.5, 2.5, std::numeric_limits<double>::quiet_NaN()}) {
    const auto error = check_range(reach, wrong);
    ASSERT_TRUE(error) << wrong;
    EXPECT_EQ(error->element, "anticipation.range_m");
  }
}

TEST(AddedSetting, HasNoNameOfAnother) {
  std::set<std::string> names;
  for (const RunSetting& setting : run_settings()) {
    for (const std::string& name :
         {std::string(setting.option),
          "plan " + std::string(setting.plan.name ? setting.plan.name : ""),
          "recorded " + std::string(setting.recorded.name ? setting.recorded.name : "")}) {
      const bool is_none = name.empty() || name.ends_with(' ');
      EXPECT_TRUE(is_none || names.insert(name).second) << name;
    }
  }
}

}  // namespace
}  // namespace palpate
