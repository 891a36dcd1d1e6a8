// Tests that the reported memory of a surface equals its allocations. This executable replaces
// operator new and delete to count allocations.

#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <malloc.h>
#include <new>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "engine/scene/scene.h"
#include "geometry/index/surface_index.h"
#include "geometry/mesh/surface_mesh.h"
#include "models/primitives.h"

namespace {

std::atomic<std::size_t> g_live_bytes{0};
std::atomic<std::size_t> g_peak_bytes{0};

void* counted(void* p) {
  if (!p) throw std::bad_alloc();
  const std::size_t bytes = ::malloc_usable_size(p);
  const std::size_t live = g_live_bytes.fetch_add(bytes) + bytes;
  std::size_t peak = g_peak_bytes.load();
  while (live > peak && !g_peak_bytes.compare_exchange_weak(peak, live)) {
  }
  return p;
}

void release(void* p) noexcept {
  if (p) g_live_bytes.fetch_sub(::malloc_usable_size(p));
  std::free(p);
}

}  // namespace

void* operator new(std::size_t size) {
  return counted(std::malloc(size ? size : 1));
}
void* operator new[](std::size_t size) {
  return operator new(size);
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  const auto align = static_cast<std::size_t>(alignment);
  return counted(std::aligned_alloc(align, (size + align - 1) / align * align));
}
void* operator new[](std::size_t size, std::align_val_t alignment) {
  return operator new(size, alignment);
}
void operator delete(void* p) noexcept {
  release(p);
}
void operator delete[](void* p) noexcept {
  release(p);
}
void operator delete(void* p, std::size_t) noexcept {
  release(p);
}
void operator delete[](void* p, std::size_t) noexcept {
  release(p);
}
void operator delete(void* p, std::align_val_t) noexcept {
  release(p);
}
void operator delete[](void* p, std::align_val_t) noexcept {
  release(p);
}
void operator delete(void* p, std::size_t, std::align_val_t) noexcept {
  release(p);
}
void operator delete[](void* p, std::size_t, std::align_val_t) noexcept {
  release(p);
}

namespace palpate {
namespace {

constexpr std::size_t kMostBytesPerTriangle = 250;

// The allocator rounds the size of blocks up, for large blocks by at most a page.
constexpr double kTolerance = 0.02;

void expect_near(std::size_t reported, std::size_t counted) {
  EXPECT_NEAR(static_cast<double>(reported), static_cast<double>(counted),
              kTolerance * static_cast<double>(counted));
}

TriangleMesh grid(std::uint32_t n) {
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i <= n; ++i) {
    for (std::uint32_t j = 0; j <= n; ++j) mesh.positions_m.emplace_back(i, j, i * j % 3);
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    for (std::uint32_t j = 0; j < n; ++j) {
      const std::uint32_t v = i * (n + 1) + j;
      mesh.triangles.push_back({v, v + n + 1, v + 1});
      mesh.triangles.push_back({v + 1, v + n + 1, v + n + 2});
    }
  }
  return mesh;
}

// Repeats every second triangle, and adds a copy of every third triangle, turned about its first
// edge. Thus duplicates are dropped, and most edges have three faces or more.
TriangleMesh damaged(TriangleMesh mesh) {
  const std::vector<Triangle> whole = mesh.triangles;
  for (std::size_t t = 0; t < whole.size(); t += 2) mesh.triangles.push_back(whole[t]);
  for (std::size_t t = 0; t < whole.size(); t += 3) {
    const auto tip = static_cast<std::uint32_t>(mesh.positions_m.size());
    mesh.positions_m.push_back(2.0 * mesh.positions_m[whole[t][2]] + Vec3::Ones());
    mesh.triangles.push_back({whole[t][1], whole[t][0], tip});
  }
  return mesh;
}

std::vector<TriangleMesh> large_meshes() {
  return {icosphere(6, 0.1), torus(1.0, 0.25, 5), grid(200)};
}

TEST(Memory, OfASurfaceIsReportedCorrectly) {
  for (TriangleMesh mesh : large_meshes()) {
    for (const TriangleMesh& input : {mesh, damaged(mesh)}) {
      const std::size_t before = g_live_bytes;
      const SurfaceMesh surface = SurfaceMesh::build(input.positions_m, input.triangles);
      expect_near(surface.memory_bytes(), g_live_bytes - before);
    }
  }
}

TEST(Memory, OfAnIndexIsReportedCorrectly) {
  for (const TriangleMesh& mesh : large_meshes()) {
    const SurfaceMesh surface = SurfaceMesh::build(mesh.positions_m, mesh.triangles);
    { const SurfaceIndex first(surface); }  // memory that Embree allocates once and keeps
    const std::size_t before = g_live_bytes;
    const SurfaceIndex index(surface);
    expect_near(index.memory_bytes(), g_live_bytes - before);
  }
}

TEST(Memory, OfALargeSurfaceWithItsIndexIsLimitedPerTriangle) {
  for (const TriangleMesh& mesh : large_meshes()) {
    const SurfaceMesh surface = SurfaceMesh::build(mesh.positions_m, mesh.triangles);
    const SurfaceIndex index(surface);
    MemoryBreakdown memory = surface.memory();
    memory += index.memory();
    EXPECT_EQ(memory.total(), surface.memory_bytes() + index.memory_bytes());
    EXPECT_LE(memory.total(), kMostBytesPerTriangle * mesh.triangles.size());
  }
}

// The peak during compilation is at most 1.5 times the limit on the kept memory.
TEST(Memory, OfCompilingALargeSurfaceIsLittleMoreThanTheKeptMemory) {
  for (TriangleMesh& mesh : large_meshes()) {
    const std::size_t triangles = mesh.triangles.size();
    SceneDescription description;
    description.tree.resize(1);
    description.nodes.emplace_back();
    description.meshes.push_back({"", std::move(mesh.positions_m), std::move(mesh.triangles)});
    g_peak_bytes = g_live_bytes.load();
    const std::size_t before = g_live_bytes;
    const Result<Scene> scene = Scene::compile(std::move(description));
    ASSERT_TRUE(scene);
    EXPECT_LE(g_peak_bytes - before, kMostBytesPerTriangle * triangles * 3 / 2);
  }
}

}  // namespace
}  // namespace palpate
