#pragma once

// Small comparisons of strategies.

#include <string>

#include <gtest/gtest.h>

#include "engine/trials/compare/compare_plan.h"
#include "tests/engine/trials/prepared_object.h"

namespace palpate::test {

inline std::string model_path(const std::string& name) {
  return std::string(PALPATE_MODELS_DIR) + "/" + name + ".glb";
}

inline CompareSettings settings_of(const std::string& strategies, int hands = 5) {
  CompareSettings settings;
  settings.scenes = {model_path("star"), model_path("lock")};
  settings.device = paper_device();
  settings.hands = hands;
  auto all = with_strategies(settings, strategies);
  EXPECT_TRUE(all.ok()) << all.error().to_string();
  return *all;
}

inline const CompareSettings& nine_strategies() {
  static const CompareSettings settings = settings_of("none,mask,a4,anisotropic");
  return settings;
}

}  // namespace palpate::test
