#pragma once

// Objects with which tests run trials.

#include <map>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "engine/simulation/plane_height.h"
#include "engine/trials/trial.h"

namespace palpate::test {

// The paper's objects, in its order: O1 to O4.
inline constexpr const char* kPaperObjects[] = {"star", "labyrinth", "inverted_labyrinth", "lock"};

struct PreparedObject {
  Scene scene;
  RunSetup setup;
  TrialWay way;
};

// The device of the paper's plan.
inline RunSettings paper_device() {
  RunSettings settings;
  settings.sensors = 2;
  settings.actuators = 1;
  settings.haptics.coupling.damping_Ns_per_m = 2.0;
  return settings;
}

// The scene on a device with two sensors.
inline PreparedObject prepared(Scene scene, const RunSettings& settings = paper_device()) {
  auto setup = make_setup(settings);
  setup->haptics.plane_height_m = *height_with_contour_m(scene, setup->haptics.initial_pose);
  auto way = find_trial_way(scene, *setup, {});
  EXPECT_TRUE(way.ok());
  return {std::move(scene), std::move(*setup), std::move(*way)};
}

// One of the models; loaded once.
inline const PreparedObject& prepared_model(const std::string& name) {
  static std::map<std::string, PreparedObject> all;
  const auto found = all.find(name);
  if (found != all.end()) return found->second;
  auto scene = Scene::load(std::string(PALPATE_MODELS_DIR) + "/" + name + ".glb");
  EXPECT_TRUE(scene.ok()) << name;
  return all.emplace(name, prepared(std::move(*scene))).first->second;
}

}  // namespace palpate::test
