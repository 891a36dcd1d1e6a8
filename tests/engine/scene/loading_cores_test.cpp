// Tests that the result of loading a mesh does not depend on the number of cores.

#include <array>
#include <atomic>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/scene/scene.h"
#include "geometry/base/parallel.h"
#include "geometry/index/surface_index.h"
#include "geometry/mesh/surface_mesh.h"
#include "geometry/mesh/welded_surface.h"
#include "models/primitives.h"
#include "tests/helpers/generators.h"
#include "tests/helpers/random.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::Soup;

class Cores : public testing::Test {
 protected:
  ~Cores() override { assume_cores(before_); }

 private:
  std::size_t before_ = core_count();
};

constexpr std::array<std::size_t, 3> kCoreCounts = {2, 3, 16};

// ---- Sharing of work

TEST_F(Cores, RunEachCallsEveryNumberOnce) {
  for (const std::size_t cores : {1, 2, 7}) {
    assume_cores(cores);
    std::vector<std::atomic<int>> calls(1000);
    run_each(0, calls.size(), [&](std::size_t i) { ++calls[i]; });
    for (std::size_t i = 0; i < calls.size(); ++i) ASSERT_EQ(calls[i], 1) << i;
  }
}

TEST_F(Cores, CoverEachItemByExactlyOneRange) {
  test::Random random(7201);
  for (int i = 0; i < 200; ++i) {
    assume_cores(1 + random.index(9));
    std::vector<std::atomic<int>> calls(random.index(300));
    run_ranges(calls.size(), 1 + random.index(40), [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) ++calls[k];
    });
    for (const std::atomic<int>& count : calls) ASSERT_EQ(count, 1);
  }
}

// Nested parallel work does not use more threads than cores.
TEST_F(Cores, NeverRunMoreThreadsThanCores) {
  constexpr int kCores = 3;
  assume_cores(kCores);
  std::atomic<int> running{0};
  std::atomic<int> most{0};
  run_each(0, 40, [&](std::size_t) {
    run_each(0, 10, [&](std::size_t) {
      const int now = ++running;
      int seen = most;
      while (now > seen && !most.compare_exchange_weak(seen, now)) {
      }
      --running;
    });
  });
  EXPECT_LE(most, kCores);
}

TEST_F(Cores, PassErrorsOfEveryThreadToTheCaller) {
  for (const std::size_t cores : {1, 2, 4}) {
    assume_cores(cores);
    for (std::size_t wrong = 0; wrong < 16; ++wrong) {
      EXPECT_THROW(run_each(0, 16,
                            [&](std::size_t i) {
                              if (i == wrong) throw std::runtime_error("as it should");
                            }),
                   std::runtime_error);
    }
    // The cores are available again.
    const SpareCore core;
    EXPECT_EQ(core.is_taken(), cores > 1);
  }
}

// ---- Equal results for any number of cores

// A mesh with all defects that cleaning handles: repeated positions, also with negative zeros,
// unused positions, triangles without area, repeated triangles, and edges with many faces of either
// orientation.
Soup lattice_soup(test::Random& random, int positions) {
  Soup soup;
  constexpr std::uint64_t kSide = 30;
  for (int i = 0; i < positions; ++i) {
    Vec3 p;
    for (int k = 0; k < 3; ++k) {
      p[k] = static_cast<double>(random.index(kSide)) - 10.0;
      if (p[k] == 0.0 && random.index(2) == 0) p[k] = -0.0;
    }
    soup.positions.push_back(p);
  }
  for (int i = 0; i < positions * 5 / 3; ++i) {
    const auto first = static_cast<std::uint32_t>(random.index(positions - 8));
    soup.triangles.push_back({first, first + 1 + static_cast<std::uint32_t>(random.index(3)),
                              first + static_cast<std::uint32_t>(random.index(6))});
    if (random.index(10) == 0) soup.triangles.push_back(soup.triangles[random.index(i + 1)]);
  }
  return soup;
}

Soup sphere(int level) {
  const TriangleMesh mesh = icosphere(level, 0.1);
  return {mesh.positions_m, mesh.triangles};
}

// All results of loading a soup of triangles, as bytes.
class Made {
 public:
  explicit Made(const Soup& soup) {
    WeldedSurface welded(soup.positions, soup.triangles);
    add(welded);
    const SurfaceIndex index(MappedFaces{welded.positions(), welded.faces(), map()}, 0.01);
    add(index);
    add(SurfaceMesh(welded));
  }
  explicit Made(const Scene& scene) {
    for (std::size_t body = 0; body < scene.objects().size(); ++body) {
      add(*scene.world().bodies[body].index);
      add(scene.mesh(scene.objects()[body].mesh));
    }
    std::vector<Vec3> positions_m;
    std::vector<Triangle> triangles;
    scene.append_triangles_scene(positions_m, triangles);
    add_all(positions_m);
    add_all(triangles);
    const SceneStatistics& s = scene.statistics();
    for (const JoinStatistics& j : {s.rounding_joins, s.gap_joins}) {
      for (const std::size_t n :
           {j.joined_edges, j.joined_vertices, j.divided_edges, j.ambiguous_edges}) {
        add_bytes(&n, sizeof n);
      }
    }
    for (const std::size_t n : {s.seam_vertices, s.seam_places, s.seam_nodes, s.changed_nodes,
                                s.divided_edges, s.apart_vertices, s.indices}) {
      add_bytes(&n, sizeof n);
    }
    for (const std::string& line : s.notes) bytes_ += line;
    for (const std::string& line : s.warnings) bytes_ += line;
  }

  bool operator==(const Made&) const = default;

 private:
  // A mirror and a shear.
  static AffineMap map() {
    AffineMap map;
    map.linear = Vec3(1.0, -2.0, 0.5).asDiagonal();
    map.linear(0, 1) = 0.25;
    map.translation_m = Vec3(1.0, 2.0, 3.0);
    return map;
  }

  void add_bytes(const void* data, std::size_t size) {
    bytes_.append(static_cast<const char*>(data), size);
  }
  template <typename Range>
  void add_all(const Range& range) {
    add_bytes(range.data(), range.size() * sizeof(*range.data()));
  }

  void add(const WeldedSurface& welded) {
    add_all(welded.positions());
    add_all(welded.faces());
    add_all(welded.mates().aligned.span());
    add_all(welded.mates().misaligned);
    for (std::size_t f = 0; f < welded.face_count(); ++f) {
      const std::uint32_t source = welded.source_triangle(f);
      add_bytes(&source, sizeof source);
    }
  }

  void add(const SurfaceMesh& mesh) {
    const CleaningReport& r = mesh.report();
    for (const std::size_t n :
         {r.triangles_in, r.triangles, r.dropped_degenerate, r.dropped_duplicate, r.welded_vertices,
          r.split_vertices, r.boundary_edges, r.non_manifold_edges}) {
      add_bytes(&n, sizeof n);
    }
    const OpenMeshSurface& surface = mesh.surface();
    add_bytes(surface.points(), surface.n_vertices() * sizeof(Vec3));
    for (const auto h : surface.halfedges()) {
      for (const int id : {surface.next_halfedge_handle(h).idx(), surface.to_vertex_handle(h).idx(),
                           surface.face_handle(h).idx()}) {
        add_bytes(&id, sizeof id);
      }
    }
  }

  void add(const SurfaceIndex& index) {
    for (std::uint32_t id = 0; id < index.pack_count(); ++id) {
      add_bytes(&index.pack(id), sizeof(TrianglePack));
      for (int lane = 0; lane < TrianglePack::kLanes; ++lane) {
        const std::uint32_t slot = SurfaceIndex::slot(id, lane);
        const std::uint32_t face = index.face(slot);
        add_bytes(&face, sizeof face);
        add_bytes(&index.triangle(slot), sizeof(TriangleGeometry));
      }
    }
  }

  std::string bytes_;
};

TEST_F(Cores, LoadASoupWithEqualResultsForAnyNumber) {
  test::Random random(7202);
  for (const Soup& soup : {lattice_soup(random, 90'000), sphere(7)}) {
    assume_cores(1);
    const Made alone(soup);
    for (const std::size_t cores : kCoreCounts) {
      assume_cores(cores);
      EXPECT_TRUE(Made(soup) == alone) << cores << " cores";
    }
  }
}

SceneDescription scene_of(const std::vector<Soup>& soups) {
  SceneDescription description;
  for (const Soup& soup : soups) {
    MeshDescription mesh;
    mesh.positions = soup.positions;
    mesh.triangles = soup.triangles;
    NodeDescription node;
    node.name = "node " + std::to_string(description.meshes.size());
    node.mesh = static_cast<std::uint32_t>(description.meshes.size());
    node.translation_m = Vec3(0.3 * node.mesh, 0.0, node.mesh == 0 ? 100.0 : 0.0);
    description.meshes.push_back(std::move(mesh));
    description.nodes.push_back(std::move(node));
  }
  return description;
}

// Large meshes and small ones, each with its index. The first one, which is 30 m wide, is apart:
// the search for its contacts with all others would take most of the time.
TEST_F(Cores, CompileASceneWithEqualResultsForAnyNumber) {
  test::Random random(7203);
  std::vector<Soup> soups = {lattice_soup(random, 9'000), sphere(6)};
  for (int i = 0; i < 40; ++i) {
    const TriangleMesh small = icosphere(1 + static_cast<int>(random.index(3)), 0.1);
    soups.push_back({small.positions_m, small.triangles});
  }
  const auto points = [&](std::size_t cores) {
    assume_cores(cores);
    const auto scene = Scene::compile(scene_of(soups));
    EXPECT_TRUE(scene);
    std::vector<double> numbers;
    test::Random queries(7204);
    for (const ContactBody& body : scene->world().bodies) {
      for (int i = 0; i < 20; ++i) {
        const auto nearest = body.index->closest_point(
            body.length_to_body(1.0) * queries.in_box(1.0), body.length_to_body(100.0));
        if (!nearest) continue;
        numbers.insert(numbers.end(), {nearest->point_m.x(), nearest->point_m.y(),
                                       nearest->point_m.z(), static_cast<double>(nearest->face)});
      }
    }
    const CleaningReport& cleaning = scene->statistics().cleaning;
    numbers.push_back(static_cast<double>(cleaning.triangles));
    numbers.push_back(static_cast<double>(cleaning.split_vertices));
    numbers.push_back(static_cast<double>(scene->statistics().memory.total()));
    return numbers;
  };
  const std::vector<double> alone = points(1);
  for (const std::size_t cores : kCoreCounts) EXPECT_EQ(points(cores), alone) << cores << " cores";
}

// Surfaces of generators, whose first and last column are joined, with a gap that is closed; and a
// bond of boxes with rounded translations, whose nodes meet at T-junctions.
SceneDescription scene_with_seams() {
  SceneDescription description;
  const auto add_node = [&](std::size_t mesh, const Vec3& at_m) {
    NodeDescription node;
    node.name = "node " + std::to_string(description.nodes.size());
    node.mesh = static_cast<std::uint32_t>(mesh);
    node.translation_m = at_m.cast<float>().cast<double>();
    node.product = TransformProduct::of(Mat3::Identity(), node.translation_m);
    description.nodes.push_back(node);
  };
  const auto add_mesh = [&](const Soup& soup) {
    MeshDescription mesh;
    mesh.positions = soup.positions;
    mesh.triangles = soup.triangles;
    description.meshes.push_back(std::move(mesh));
    return description.meshes.size() - 1;
  };
  using Floats = test::Generators<float>;
  using Doubles = test::Generators<double>;
  double x_m = 0.0;
  for (const auto& mesh : Floats::kinds(40)) add_node(add_mesh(mesh.soup), {x_m += 4.0, 0, 0});
  for (const auto& mesh : Doubles::kinds(40)) add_node(add_mesh(mesh.soup), {x_m += 4.0, 0, 0});
  add_node(add_mesh(Floats::sphere(1.0f, 160, 80)), {0, 6, 0});  // large enough for threads
  Soup squares;
  for (const double y : {0.0, 1.002}) {
    squares.add_quad({0, y, 0}, {1, y, 0}, {1, y + 1, 0}, {0, y + 1, 0});
  }
  add_node(add_mesh(squares), {0, 12, 0});
  const Vec3 half_m(1.0 / 7, 1.0 / 9, 1.0 / 11);
  const std::size_t box = add_mesh(test::box_soup(half_m.cast<float>().cast<double>()));
  for (int z = 0; z < 4; ++z) {
    for (int x = 0; x < 5; ++x) {
      add_node(box, {(2 * x + z % 2) * half_m.x(), -6, 2 * z * half_m.z()});
    }
  }
  return description;
}

TEST_F(Cores, JoinSeamsWithEqualBitsForAnyNumber) {
  SceneSettings settings;
  settings.close_gaps_m = 0.003;
  const auto made = [&](std::size_t cores) {
    assume_cores(cores);
    const auto scene = Scene::compile(scene_with_seams(), settings);
    EXPECT_TRUE(scene) << scene.error().to_string();
    const SceneStatistics& s = scene->statistics();
    EXPECT_GT(s.rounding_joins.joined_vertices, 100u);
    EXPECT_EQ(s.gap_joins.joined_edges, 1u);
    EXPECT_GT(s.changed_nodes, 5u);
    EXPECT_GT(s.divided_edges, 10u);
    return Made(*scene);
  };
  const Made alone = made(1);
  for (const std::size_t cores : {2, 8}) EXPECT_TRUE(made(cores) == alone) << cores << " cores";
}

}  // namespace
}  // namespace palpate
