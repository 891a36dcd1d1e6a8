// Tests that a failed allocation anywhere leads to an Error that names the step, and that all
// memory is freed. This executable replaces operator new and delete.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/rig/replay.h"
#include "engine/scene/scene.h"
#include "engine/simulation/exploration.h"
#include "geometry/base/memory_ledger.h"
#include "geometry/base/parallel.h"
#include "io/gltf/reader.h"
#include "models/primitives.h"
#include "tests/helpers/gltf_seeds.h"
#include "tests/helpers/peak_memory.h"
#include "tests/helpers/soak.h"

// Embree leaks a few hundred bytes if a build fails for lack of memory.
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libembree";
}

namespace palpate {
namespace {

using test::BoundedMemory;
using test::FailingMemory;
using test::in_soak_or_else;

class OutOfMemory : public testing::TestWithParam<std::size_t> {
 protected:
  OutOfMemory() { assume_cores(GetParam()); }
  ~OutOfMemory() override { assume_cores(before_); }

 private:
  std::size_t before_ = core_count();
};
INSTANTIATE_TEST_SUITE_P(Cores, OutOfMemory, testing::Values(1, 4));

// The outcome of a call. The text of the Error is made here, while memory may still be short.
struct Outcome {
  bool is_ok = false;
  ErrorCode code = ErrorCode::kInvalidArgument;
  bool names_something = false;
};

template <typename T>
Outcome outcome_of(const Result<T>& result) {
  if (result) return {true, {}, false};
  return {false, result.error().code, !result.error().problem.empty()};
}

void expect_ok_or_out_of_memory(const Outcome& outcome, const std::string& what) {
  if (outcome.is_ok) return;
  EXPECT_EQ(outcome.code, ErrorCode::kOutOfMemory) << what;
  EXPECT_TRUE(outcome.names_something) << what;
}

// The increase of allocated memory during a call. Libraries allocate some memory once, for example
// for their errors; the next equal call does not allocate it again. A leak occurs in every call.
template <typename Call>
std::size_t leaked_by(const Call& call) {
  const std::size_t before = test::held_memory();
  call();
  if (test::held_memory() == before) return 0;
  const std::size_t between = test::held_memory();
  call();
  return test::held_memory() - between;
}

// Runs the call with less and less memory than it needs, and with failures at a sample of all
// allocations.
template <typename Call>
void run_out_of_memory(const std::string& name, std::size_t bounds, std::size_t failures,
                       const Call& call) {
  ASSERT_TRUE(call().is_ok) << name;  // allocates memory that is kept for good
  std::size_t peak = 0;
  std::size_t calls = 0;
  {
    const test::PeakMemory memory;
    const FailingMemory never(~std::size_t{0});
    ASSERT_TRUE(call().is_ok) << name;
    peak = memory.bytes();
    calls = FailingMemory::calls();
  }
  std::size_t refused = 0;
  const auto expect_no_harm = [&](const std::string& what, const auto& call_short_of_memory) {
    Outcome outcome;
    const std::size_t leaked = leaked_by([&] { outcome = call_short_of_memory(); });
    refused += outcome.is_ok ? 0 : 1;
    expect_ok_or_out_of_memory(outcome, name + what);
    EXPECT_EQ(leaked, 0u) << name << what;
  };
  for (std::size_t i = 1; i < bounds; ++i) {
    expect_no_harm(", bound " + std::to_string(i), [&] {
      const BoundedMemory bound(peak * i / bounds);
      return call();
    });
  }
  EXPECT_GT(refused, bounds / 4) << name;
  for (std::size_t n = 0; n < calls; n += std::max<std::size_t>(1, calls / failures)) {
    expect_no_harm(", call " + std::to_string(n), [&] {
      const FailingMemory failing(n);
      return call();
    });
  }
}

TEST_P(OutOfMemory, IsReportedForEveryFeatureOfAFile) {
  for (const test::GltfSeed& seed : test::gltf_seeds()) {
    const std::span bytes(reinterpret_cast<const std::uint8_t*>(seed.bytes.data()),
                          seed.bytes.size());
    run_out_of_memory(seed.name, in_soak_or_else(200, 20), in_soak_or_else(1000, 40), [&] {
      auto description = read_gltf_bytes(bytes, "", seed.name);
      if (!description) return outcome_of(description);
      return outcome_of(Scene::compile(std::move(*description)));
    });
  }
}

TEST_P(OutOfMemory, IsReportedWhileASceneWithEffectsIsLoaded) {
  for (const char* name : {"star", "gallery", "effect_texture", "effect_magnet", "effect_shading",
                           "effect_viscosity", "effect_friction_map"}) {
    const std::string path = std::string(PALPATE_MODELS_DIR "/") + name + ".glb";
    run_out_of_memory(name, in_soak_or_else(400, 25), in_soak_or_else(4000, 60),
                      [&] { return outcome_of(Scene::load(path)); });
  }
}

// Compiles the result of `make`. make() may throw: it is code of the test.
template <typename Make>
Outcome compile_what(const Make& make) {
  std::optional<SceneDescription> description;
  try {
    description = make();
  } catch (const std::bad_alloc&) {
    return {false, ErrorCode::kOutOfMemory, true};
  }
  return outcome_of(Scene::compile(std::move(*description)));
}

// Several threads take part, and Embree builds a tree of several levels.
TEST_P(OutOfMemory, IsReportedForALargeMesh) {
  const TriangleMesh mesh = icosphere(6, 0.1);
  run_out_of_memory("mesh", 30, 60, [&] {
    return compile_what([&] {
      SceneDescription description;
      description.tree.resize(1);
      description.nodes.emplace_back();
      description.meshes.push_back({"ball", mesh.positions_m, mesh.triangles});
      return description;
    });
  });
}

TEST_P(OutOfMemory, IsReportedForManyNodes) {
  const TriangleMesh mesh = icosphere(1, 0.1);
  run_out_of_memory("nodes", 25, 60, [&] {
    return compile_what([&] {
      SceneDescription description;
      description.meshes.push_back({"ball", mesh.positions_m, mesh.triangles});
      for (int i = 0; i < 300; ++i) {
        NodeDescription node;
        node.name = "a node with a long name, number " + std::to_string(i);
        node.linear_scene_mesh *= 1.0 + 0.01 * (i % 50);
        node.translation_m = Vec3(i % 20, i / 20, 0);
        description.nodes.push_back(std::move(node));
      }
      return description;
    });
  });
}

RunSetup setup_of(int sensors) {
  RunSettings options;
  options.sensors = sensors;
  options.default_actuators = sensors;
  auto setup = make_setup(options);
  if (!setup) ADD_FAILURE() << setup.error().to_string();
  return *setup;
}

TEST_P(OutOfMemory, IsReportedInARunAndAReplay) {
  const auto scene = Scene::load(PALPATE_MODELS_DIR "/star.glb");
  ASSERT_TRUE(scene);
  ExplorationSettings settings;
  settings.seconds = 2.0;
  settings.virtual_time = true;
  for (const int sensors : {2, 3}) {
    const RunSetup setup = setup_of(sensors);
    run_out_of_memory("run", 8, 16,
                      [&] { return outcome_of(explore(*scene, setup, settings, [](double) {})); });
  }
  const RunSetup setup = setup_of(3);
  const std::vector<Vec3> path(500, Vec3(0.0, 0.0, 0.01));
  run_out_of_memory("replay", 10, 30, [&] { return outcome_of(replay(*scene, setup, path, 2)); });
}

TEST(OutOfMemoryAtOnce, NamesTheStepTheFileAndWhatToDo) {
  const std::string path = PALPATE_MODELS_DIR "/gallery.glb";
  ASSERT_TRUE(Scene::load(path));
  std::optional<Error> error;
  {
    const BoundedMemory bound(200'000);
    const auto scene = Scene::load(path);
    if (!scene) error = scene.error();
  }
  ASSERT_TRUE(error);
  EXPECT_EQ(error->code, ErrorCode::kOutOfMemory);
  EXPECT_EQ(error->path, path);
  EXPECT_NE(error->problem.find("not enough memory for"), std::string::npos) << error->problem;
  EXPECT_NE(error->hint.find("ulimit"), std::string::npos) << error->hint;
}

}  // namespace
}  // namespace palpate
