// The picture of `run`: what it tells where there is no room for it, or nothing to draw it with.

#include "engine/cli/path_picture.h"

#include <cstdlib>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace palpate {
namespace {

// `run` refuses the one, and does without the other.
TEST(PathPicture, ThatFindsNoRoomIsToldFromOneThatCannotBeDrawn) {
  const auto scene = Scene::load(std::string(PALPATE_MODELS_DIR) + "/star.glb", {});
  ASSERT_TRUE(scene);
  RunSettings options;
  options.sensors = 2;
  options.actuators = 1;
  const auto setup = make_setup(options);
  ASSERT_TRUE(setup);
  ExplorationSettings settings;
  settings.seconds = 3.0;
  settings.virtual_time = true;
  auto run = explore(*scene, *setup, settings, [](double) {});
  ASSERT_TRUE(run);
  const std::vector<ExplorationRun> runs{std::move(*run)};
  const auto full = write_path_picture(runs, "star", "/dev/full");
  ASSERT_FALSE(full);
  EXPECT_EQ(full.error().code, ErrorCode::kFileUnwritable);
  EXPECT_EQ(full.error().path, "/dev/full");
  const std::string path = std::getenv("PATH");
  ::setenv("PATH", "/nowhere", 1);
  const auto missing = write_path_picture(runs, "star", "/dev/full");
  ::setenv("PATH", path.c_str(), 1);
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::kUnsupported);
  EXPECT_NE(missing.error().hint.find("the traces are complete"), std::string::npos);
}

}  // namespace
}  // namespace palpate
