// Tests the memory limit of loading, the sources of this limit, and that declared memory needs
// equal the actual allocations. This executable replaces operator new to count allocations.

#include "engine/scene/memory_budget.h"

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>

#include "engine/scene/scene.h"
#include "geometry/index/box_tree.h"
#include "geometry/index/surface_index.h"
#include "geometry/mesh/surface_mesh.h"
#include "geometry/mesh/welded_surface.h"
#include "models/primitives.h"
#include "tests/helpers/peak_memory.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

// ---- Numbers of bytes that a user writes

TEST(ParseBytes, AcceptsEachUnit) {
  const auto bytes = [](const char* text) {
    const auto parsed = parse_bytes(text);
    return parsed ? *parsed : 0;
  };
  EXPECT_EQ(bytes("1"), 1u);
  EXPECT_EQ(bytes("123456"), 123456u);
  EXPECT_EQ(bytes("7B"), 7u);
  EXPECT_EQ(bytes("500M"), 500'000'000u);
  EXPECT_EQ(bytes("500MB"), 500'000'000u);
  EXPECT_EQ(bytes("2G"), 2'000'000'000u);
  EXPECT_EQ(bytes("1.5GiB"), std::uint64_t{3} << 29);
  EXPECT_EQ(bytes("3kib"), 3072u);
  EXPECT_EQ(bytes("2k"), 2000u);
  EXPECT_EQ(bytes("0.5T"), 500'000'000'000u);
}

TEST(ParseBytes, RefusesOtherTextsAndNamesTheOption) {
  for (const char* text : {"0", "-1", "0.4", "nan", "inf", "1e9", "G", "12 M", "12Q", "12Gi",
                           "12iB", "99999999999999999999", "9T9", "0x10", " 5"}) {
    const auto parsed = parse_bytes(text);
    ASSERT_FALSE(parsed) << text;
    EXPECT_EQ(parsed.error().element, "max_memory_bytes");
    EXPECT_NE(parsed.error().problem.find(text), std::string::npos);
  }
}

TEST(BytesText, HasThreeDigitsAndAUnit) {
  EXPECT_EQ(bytes_text(999), "999 bytes");
  EXPECT_EQ(bytes_text(1000), "1.00 kB");
  EXPECT_EQ(bytes_text(12'340'000), "12.3 MB");
  EXPECT_EQ(bytes_text(999'600'000), "1.00 GB");
  EXPECT_EQ(bytes_text(1'500'000'000), "1.50 GB");
}

// ---- Free memory of the system

class FreeMemory : public testing::Test {
 protected:
  FreeMemory() {
    std::filesystem::create_directories(root_);
    sources_ = {root_ + "/meminfo", root_ + "/cgroup", root_ + "/groups", root_ + "/statm"};
    write("meminfo", "MemTotal: 9000000 kB\nMemFree: 1 kB\nMemAvailable: 8000000 kB\n");
  }
  ~FreeMemory() override { std::filesystem::remove_all(root_); }

  void write(const std::string& name, const std::string& text) {
    const std::filesystem::path path = root_ + "/" + name;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path) << text;
  }

  std::string root_ = testing::TempDir() + "palpate_free_memory_" + std::to_string(::getpid());
  MemorySources sources_;
};

TEST_F(FreeMemory, OfTheMachineIsTheAvailableMemory) {
  const MemoryLimit limit = default_memory_limit(sources_);
  EXPECT_EQ(limit.bytes, std::uint64_t{4'000'000} * 1024);
  EXPECT_NE(limit.origin.find("the machine"), std::string::npos) << limit.origin;
}

TEST_F(FreeMemory, OfAControlGroupIsTheLeastOfItsParentGroups) {
  write("cgroup", "0::/outer/inner\n");
  write("groups/memory.max", "7000000000\n");
  write("groups/memory.current", "1000000000\n");
  write("groups/outer/memory.max", "3000000000\n");
  write("groups/outer/memory.current", "2500000000\n");
  write("groups/outer/memory.stat", "anon 5\ninactive_file 300000000\nactive_file 200000000\n");
  write("groups/outer/inner/memory.max", "max\n");
  write("groups/outer/inner/memory.current", "2000000000\n");
  const MemoryLimit limit = default_memory_limit(sources_);
  EXPECT_EQ(limit.bytes, 500'000'000u);
  EXPECT_NE(limit.origin.find("/outer"), std::string::npos) << limit.origin;
}

TEST_F(FreeMemory, OfAControlGroupOfVersionOneIsFoundInAContainer) {
  write("cgroup", "5:cpu:/docker/x\n4:memory:/docker/x\n");
  write("groups/memory/memory.limit_in_bytes", "800000000\n");
  write("groups/memory/memory.usage_in_bytes", "600000000\n");
  EXPECT_EQ(default_memory_limit(sources_).bytes, 100'000'000u);
}

TEST_F(FreeMemory, OfAGroupOverItsLimitIsZero) {
  write("cgroup", "0::/\n");
  write("groups/memory.max", "1000\n");
  write("groups/memory.current", "2000\n");
  EXPECT_EQ(default_memory_limit(sources_).bytes, 0u);
}

TEST_F(FreeMemory, IsUnlimitedIfTheSystemReportsNothing) {
  std::filesystem::remove_all(root_);
  EXPECT_EQ(default_memory_limit(sources_).bytes, std::numeric_limits<std::uint64_t>::max());
}

// ---- Declared and allocated memory

// Tolerances of an estimate, relative to the allocated memory: too small, too large, and the
// rounding of blocks.
constexpr double kTooLittle = 0.02;
constexpr double kTooMuchKept = 0.10;
constexpr double kTooMuchPeak = 0.40;  // of tables that are at worst twice as large as they are
constexpr std::size_t kRounding = 6000;

void expect_covers(std::uint64_t said, std::size_t taken, double too_much,
                   const std::string& what) {
  const auto s = static_cast<double>(said);
  const auto t = static_cast<double>(taken);
  const auto rounding = static_cast<double>(kRounding);
  EXPECT_GE(s, t * (1.0 - kTooLittle) - rounding) << what;
  EXPECT_LE(s, t * (1.0 + too_much) + rounding) << what;
}

TriangleMesh patch(std::size_t triangles) {
  TriangleMesh mesh;
  const auto n =
      static_cast<std::uint32_t>(std::ceil(std::sqrt(static_cast<double>(triangles) / 2.0)));
  for (std::uint32_t i = 0; i <= n; ++i) {
    for (std::uint32_t j = 0; j <= n; ++j) mesh.positions_m.emplace_back(i, j, 0.1 * (i * j % 7));
  }
  for (std::uint32_t t = 0; t < triangles; ++t) {
    const std::uint32_t v = t / 2 / n * (n + 1) + t / 2 % n;
    if (t % 2 == 0) {
      mesh.triangles.push_back({v, v + n + 1, v + 1});
    } else {
      mesh.triangles.push_back({v + 1, v + n + 1, v + n + 2});
    }
  }
  return mesh;
}

// Triangles without common vertices.
TriangleMesh soup(std::size_t triangles) {
  test::Random random(8101);
  TriangleMesh mesh;
  for (std::uint32_t t = 0; t < 3 * triangles; t += 3) {
    for (int i = 0; i < 3; ++i) mesh.positions_m.push_back(random.unit_vector());
    mesh.triangles.push_back({t, t + 1, t + 2});
  }
  return mesh;
}

constexpr std::size_t kSizes[] = {1, 2, 16, 17, 100, 256, 257, 1000, 4097, 20000, 100000};

template <typename Check>
void check_meshes(const Check& check) {
  for (const std::size_t triangles : kSizes) {
    check(patch(triangles), "patch of " + std::to_string(triangles));
    check(soup(triangles), "soup of " + std::to_string(triangles));
  }
}

TEST(MemoryNeedOf, AnIndexEqualsItsAllocations) {
  check_meshes([](const TriangleMesh& mesh, const std::string& what) {
    const WeldedSurface welded(mesh.positions_m, mesh.triangles);
    const MappedFaces faces{welded.positions(), welded.faces(), {}};
    { const SurfaceIndex first(faces); }  // memory that Embree allocates once and keeps
    const MemoryNeed need = SurfaceIndex::memory_need(welded.face_count());
    const test::PeakMemory memory;
    const std::size_t before = test::held_memory();
    const SurfaceIndex index(faces);
    // Embree allocates its memory from the C library.
    expect_covers(need.kept, index.memory_bytes(), kTooMuchKept, what + ", reported");
    EXPECT_GE(index.memory_bytes() + kRounding, test::held_memory() - before) << what;
    expect_covers(need.peak, memory.bytes(), kTooMuchPeak, what + ", peak");
  });
}

TEST(MemoryNeedOf, AWeldedSurfaceIsAtLeastItsAllocations) {
  check_meshes([](const TriangleMesh& mesh, const std::string& what) {
    std::vector<Vec3> positions = mesh.positions_m;
    std::vector<Triangle> triangles = mesh.triangles;
    const MemoryNeed need = WeldedSurface::memory_need(positions.size(), triangles.size());
    const test::PeakMemory memory;
    const std::size_t before = test::held_memory();
    const WeldedSurface welded(std::move(positions), std::move(triangles));
    // Welding may reduce the number of positions.
    EXPECT_GE(need.kept + kRounding + before, test::held_memory()) << what;
    expect_covers(need.peak, memory.bytes(), 1.0, what);
  });
}

TEST(MemoryNeedOf, AdjacencyEqualsItsAllocations) {
  check_meshes([](const TriangleMesh& mesh, const std::string& what) {
    WeldedSurface welded(mesh.positions_m, mesh.triangles);
    const MemoryNeed need = SurfaceMesh::memory_need(welded);
    const SurfaceMesh surface(welded);
    const MemoryBreakdown reported = surface.memory();
    expect_covers(need.kept, reported.adjacency, kTooMuchKept, what);
  });
}

TEST(MemoryNeedOf, ATreeOfBodiesEqualsItsAllocations) {
  test::Random random(8102);
  for (const std::size_t count : {9u, 100u, 1000u, 30000u, 200000u}) {
    std::vector<Box> boxes;
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3 p = random.unit_vector();
      boxes.push_back({p, p + Vec3::Constant(0.01)});
    }
    const MemoryNeed need = BoxTree::memory_need(count);
    const BoxTree tree(boxes, 0.0);
    // Embree allocates its memory in blocks that halve or double.
    expect_covers(need.kept, tree.memory_bytes(), 0.7, std::to_string(count));
    EXPECT_GE(need.peak, need.kept);
  }
}

// ---- Refusals

SceneDescription ball(int level) {
  TriangleMesh mesh = icosphere(level, 0.1);
  SceneDescription description;
  description.path = "ball.glb";
  description.meshes.push_back({"ball", std::move(mesh.positions_m), std::move(mesh.triangles)});
  description.nodes.emplace_back();
  description.nodes.back().name = "the ball";
  return description;
}

Result<Scene> compile_with(SceneDescription description, std::uint64_t bytes) {
  SceneSettings settings;
  settings.max_memory_bytes = bytes;
  return Scene::compile(std::move(description), settings);
}

TEST(MemoryBudget, IsSufficientIfItIsSlightlyLargerThanTheScene) {
  { const auto first = compile_with(ball(3), 0); }
  for (const int level : {4, 5, 6}) {
    const test::PeakMemory memory;
    const std::size_t before = test::held_memory();
    SceneDescription description = ball(level);
    ASSERT_TRUE(compile_with(std::move(description), 0));
    const std::size_t peak = memory.bytes();
    EXPECT_EQ(test::held_memory(), before);
    const auto refused = compile_with(ball(level), peak * 6 / 10);
    ASSERT_FALSE(refused) << level;
    EXPECT_EQ(refused.error().code, ErrorCode::kLimitExceeded);
    const auto enough = compile_with(ball(level), peak * 14 / 10 + 20'000);
    EXPECT_TRUE(enough) << enough.error().to_string();
  }
}

TEST(MemoryBudget, NamesLimitOriginStepNodeAndOptionWhenExceeded) {
  const auto refused = compile_with(ball(5), 4'000'000);
  ASSERT_FALSE(refused);
  const std::string text = refused.error().to_string();
  for (const char* part :
       {"ball.glb", "node \"the ball\"", "indices", "4.00 MB", "max_memory_bytes"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << " in " << text;
  }
}

// Many separate triangles, placed many times so close to each other that their boxes overlap.
SceneDescription loose_triangles(std::uint32_t triangles, int nodes, double apart_m) {
  test::Random random(7);
  MeshDescription mesh;
  mesh.name = "grass";
  for (std::uint32_t t = 0; t < triangles; ++t) {
    const Vec3 at = random.in_box(1.0);
    for (int k = 0; k < 3; ++k) mesh.positions.push_back(at + random.in_box(0.1));
    mesh.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  SceneDescription description;
  description.path = "grass.glb";
  description.meshes.push_back(std::move(mesh));
  for (int i = 0; i < nodes; ++i) {
    NodeDescription node;
    node.name = "tuft " + std::to_string(i);
    node.translation_m = Vec3(apart_m * i, 0, 0);
    description.nodes.push_back(std::move(node));
  }
  return description;
}

// The search for seams stays within the budget and needs few bytes for a vertex without a seam.
TEST(MemoryBudget, CountsTheSearchForSeams) {
  constexpr std::uint32_t kTriangles = 1000;
  constexpr int kNodes = 400;
  const test::PeakMemory memory;
  const std::size_t before = test::held_memory();
  ASSERT_TRUE(compile_with(loose_triangles(kTriangles, kNodes, 1e-3), 0));
  const std::size_t peak = memory.bytes() - before;
  EXPECT_LT(peak, 40u * 3 * kTriangles * kNodes);
  const auto refused = compile_with(loose_triangles(kTriangles, kNodes, 1e-3), peak / 3);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().to_string().find("joining nodes that meet"), std::string::npos)
      << refused.error().to_string();
  EXPECT_TRUE(compile_with(loose_triangles(kTriangles, kNodes, 1e-3), peak * 14 / 10));
  // If all vertices meet, each vertex needs more memory, which is counted as well.
  const test::PeakMemory again;
  const std::size_t held = test::held_memory();
  ASSERT_TRUE(compile_with(loose_triangles(kTriangles, kNodes, 0.0), 0));
  const std::size_t all_meet = again.bytes() - held;
  EXPECT_GT(all_meet, 2 * peak);
  const auto refused_again = compile_with(loose_triangles(kTriangles, kNodes, 0.0), all_meet / 2);
  ASSERT_FALSE(refused_again);
  EXPECT_EQ(refused_again.error().code, ErrorCode::kLimitExceeded);
}

// Packs that are not full and Embree's objects count as well.
TEST(MemoryBudget, CountsTheWholeMemoryOfAnIndexOfOneTriangle) {
  SceneDescription description;
  description.path = "scales.glb";
  description.meshes.push_back(
      {"leaf", {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}, {Triangle{0, 1, 2}}});
  constexpr int kNodes = 1000;
  for (int i = 0; i < kNodes; ++i) {
    NodeDescription node;
    node.name = "leaf " + std::to_string(i);
    // Sheared so strongly that no two nodes can share an index.
    node.linear_scene_mesh(0, 1) = 500.0 + i;
    node.translation_m = Vec3(i, 0, 0);
    description.nodes.push_back(std::move(node));
  }
  const auto scene = Scene::compile(description);
  ASSERT_TRUE(scene);
  EXPECT_GE(scene->statistics().memory.total(),
            scene->statistics().indices * (sizeof(TrianglePack) + 16 * sizeof(TriangleGeometry)));
  EXPECT_TRUE(compile_with(description, 2 * scene->statistics().memory.total()));
  EXPECT_FALSE(compile_with(description, scene->statistics().memory.total() / 2));
}

}  // namespace
}  // namespace palpate
