#pragma once

// Compiles scenes that must compile.

#include <utility>

#include <gtest/gtest.h>

#include "engine/scene/scene.h"

namespace palpate::test {

inline Scene compiled(SceneDescription description, const SceneSettings& settings = {}) {
  auto scene = Scene::compile(std::move(description), settings);
  EXPECT_TRUE(scene) << scene.error().to_string();
  return std::move(*scene);
}

}  // namespace palpate::test
