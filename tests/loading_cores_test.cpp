// What loading makes of a mesh does not depend on how many cores it is made on, and faces that lie
// close together end up in one pack, however small they are beside the rest.

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <new>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/scene.h"
#include "geometry/face_order.h"
#include "geometry/parallel.h"
#include "geometry/surface_index.h"
#include "geometry/surface_mesh.h"
#include "geometry/welded_surface.h"
#include "models/primitives.h"
#include "tests/random.h"

namespace palpate {
namespace {

class Cores : public testing::Test {
 protected:
  ~Cores() override { assume_cores(before_); }

 private:
  std::size_t before_ = core_count();
};

constexpr std::array<std::size_t, 4> kCoreCounts = {2, 3, 5, 16};

// ---- Sharing of work

TEST_F(Cores, RunEachCallsEveryNumberOnce) {
  for (const std::size_t cores : {1, 2, 7}) {
    assume_cores(cores);
    std::vector<std::atomic<int>> calls(1000);
    run_each(0, calls.size(), [&](std::size_t i) { ++calls[i]; });
    for (std::size_t i = 0; i < calls.size(); ++i) ASSERT_EQ(calls[i], 1) << i;
  }
}

TEST_F(Cores, RangesAreAllOfTheItemsAndNoneTwice) {
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

// Work that shares its own work again gets no more threads than there are cores.
TEST_F(Cores, NeverRunMoreThreadsThanThereAre) {
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

TEST_F(Cores, ErrorsReachTheCallerFromEveryThread) {
  for (const std::size_t cores : {1, 2, 4}) {
    assume_cores(cores);
    for (std::size_t wrong = 0; wrong < 16; ++wrong) {
      EXPECT_THROW(run_each(0, 16,
                            [&](std::size_t i) {
                              if (i == wrong) throw std::runtime_error("as it should");
                            }),
                   std::runtime_error);
    }
    // And the cores are free again.
    const SpareCore core;
    EXPECT_EQ(core.is_taken(), cores > 1);
  }
}

// ---- The same from any number of cores

struct Soup {
  std::vector<Vec3> positions;
  std::vector<Triangle> triangles;
};

// Everything that cleaning knows: repeated positions and their negative zeros, positions that
// nobody uses, triangles without area, triangles twice, edges of many faces, of either orientation.
Soup lattice_soup(test::Random& random) {
  Soup soup;
  constexpr std::uint64_t kSide = 30;
  for (int i = 0; i < 90000; ++i) {
    Vec3 p;
    for (int k = 0; k < 3; ++k) {
      p[k] = static_cast<double>(random.index(kSide)) - 10.0;
      if (p[k] == 0.0 && random.index(2) == 0) p[k] = -0.0;
    }
    soup.positions.push_back(p);
  }
  for (int i = 0; i < 150000; ++i) {
    const auto first = static_cast<std::uint32_t>(random.index(80000));
    soup.triangles.push_back({first, first + 1 + static_cast<std::uint32_t>(random.index(3)),
                              first + static_cast<std::uint32_t>(random.index(6))});
    if (random.index(10) == 0) soup.triangles.push_back(soup.triangles[random.index(i + 1)]);
  }
  return soup;
}

Soup sphere() {
  const TriangleMesh mesh = icosphere(7, 0.1);
  return {mesh.positions_m, mesh.triangles};
}

// Bytes of what loading makes of a soup.
class Made {
 public:
  explicit Made(const Soup& soup) {
    WeldedSurface welded(soup.positions, soup.triangles);
    add(welded);
    const SurfaceIndex index(MappedFaces{welded.positions(), welded.faces(), map()}, 0.01);
    add(index);
    add(SurfaceMesh(welded));
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

TEST_F(Cores, MakeTheSameOfASoupHoweverMany) {
  test::Random random(7202);
  for (const Soup& soup : {lattice_soup(random), sphere()}) {
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
    node.translation_m = Vec3(0.3 * node.mesh, 0.0, 0.0);
    description.meshes.push_back(std::move(mesh));
    description.nodes.push_back(std::move(node));
  }
  return description;
}

// Large meshes and small ones, each with its index.
TEST_F(Cores, CompileTheSameSceneHoweverMany) {
  test::Random random(7203);
  std::vector<Soup> soups = {lattice_soup(random), sphere()};
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
        const auto nearest = body.index->closest_point(queries.in_box(1.0), 100.0);
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

// ---- The order of faces

// Small triangles at random places of a box.
Soup confetti(test::Random& random, std::size_t count, double size_m) {
  Soup soup;
  for (std::size_t i = 0; i < count; ++i) {
    const auto first = static_cast<std::uint32_t>(soup.positions.size());
    const Vec3 middle = random.in_box(size_m);
    for (int k = 0; k < 3; ++k) {
      soup.positions.push_back(middle + random.in_box(0.01 * size_m));
    }
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  return soup;
}

std::vector<std::uint32_t> order_of(const Soup& soup) {
  std::vector<std::uint32_t> order(soup.triangles.size());
  order_faces({soup.positions, soup.triangles, {}}, order);
  return order;
}

// The mean extent of the boxes of sixteen faces each, of those made of faces before `count` only,
// which must be nearly all that can be.
double mean_extent(const Soup& soup, std::size_t count) {
  const std::vector<std::uint32_t> order = order_of(soup);
  double sum = 0.0;
  std::size_t packs = 0;
  for (std::size_t begin = 0; begin + 16 <= order.size(); begin += 16) {
    const auto faces = std::span(order).subspan(begin, 16);
    if (*std::max_element(faces.begin(), faces.end()) >= count) continue;
    Box box{soup.positions[soup.triangles[faces[0]][0]],
            soup.positions[soup.triangles[faces[0]][0]]};
    for (const std::uint32_t f : faces) {
      for (const std::uint32_t v : soup.triangles[f]) {
        box = box.united({soup.positions[v], soup.positions[v]});
      }
    }
    sum += (box.high - box.low).sum();
    ++packs;
  }
  EXPECT_GT(packs, (count / 16) * 9 / 10);
  return sum / static_cast<double>(packs);
}

TEST(FaceOrder, HasEveryFaceOnce) {
  test::Random random(7205);
  for (const std::size_t count : {0, 1, 15, 16, 17, 255, 256, 257, 4096, 5000, 30011}) {
    std::vector<std::uint32_t> order = order_of(confetti(random, count, 1.0));
    std::sort(order.begin(), order.end());
    for (std::size_t i = 0; i < count; ++i) ASSERT_EQ(order[i], i) << count;
  }
}

// By the definition: of a median split of 512 faces each of 256 is on its side along the widest
// axis, to the precision of the places.
TEST(FaceOrder, PutsTheHalvesOnTheirSidesOfTheMedian) {
  test::Random random(7206);
  for (int i = 0; i < 50; ++i) {
    Soup soup = confetti(random, 512, 1.0);
    for (Vec3& p : soup.positions) p.y() *= 3.0;
    const std::vector<std::uint32_t> order = order_of(soup);
    const auto place = [&](std::uint32_t f) {
      const Triangle& t = soup.triangles[f];
      return soup.positions[t[0]].y() + soup.positions[t[1]].y() + soup.positions[t[2]].y();
    };
    double low = -1e9;
    double high = 1e9;
    for (std::size_t k = 0; k < 256; ++k) low = std::max(low, place(order[k]));
    for (std::size_t k = 256; k < 512; ++k) high = std::min(high, place(order[k]));
    EXPECT_LE(low, high + 18 * 0x1p-24);  // three coordinates of up to 3, rounded to single
  }
}

void add(const Soup& part, const Vec3& middle, Soup& soup) {
  const auto first = static_cast<std::uint32_t>(soup.positions.size());
  for (const Vec3& p : part.positions) soup.positions.push_back(middle + p);
  for (const Triangle& t : part.triangles) {
    soup.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  }
}

// What is very small beside the scene is ordered as if it were alone. It is around the origin,
// where nothing is lost to the coordinates themselves; most of the faces are there, or half, or
// few.
TEST(FaceOrder, TellsFacesApartHoweverSmallBesideTheRest) {
  constexpr std::size_t kCount = 20000;
  for (const std::size_t others : {40, 10000, 20000, 100000}) {
    for (const double size_m : {1e-3, 1e-6, 1e-9, 1e-12, 1e-50, 1e-150}) {
      // The middle of all is in the cluster, or somewhere else; or they are all around it.
      for (const double side : {-10.0, -11.0, 0.0}) {
        test::Random random(7207);
        Soup soup = confetti(random, kCount, size_m);
        const double alone = mean_extent(soup, kCount);
        Soup other = confetti(random, others / 2, side == 0.0 ? 10.0 : 1.0);
        add(other, -side * Vec3(1.0, 0.1, 0.1), soup);
        for (Vec3& p : other.positions) p = -p;
        add(other, side * Vec3(1.0, 0.1, 0.1), soup);
        EXPECT_LE(mean_extent(soup, kCount), 1.1 * alone)
            << size_m << " m beside " << others << " at " << side;
      }
    }
  }
}

TEST(FaceOrder, TellsTheFacesOfTwoSmallClustersApart) {
  constexpr std::size_t kCount = 16384;
  for (const double size_m : {1e-3, 1e-5, 1e-7, 1e-9}) {
    test::Random random(7210);
    const Soup cluster = confetti(random, kCount, size_m);
    Soup two;
    for (const double side : {-1.0, 1.0}) add(cluster, Vec3(side, 0.0, 0.0), two);
    EXPECT_LE(mean_extent(two, 2 * kCount), 1.1 * mean_extent(cluster, kCount)) << size_m;
  }
}

// Sizes below what single precision has, and all in one place.
TEST(FaceOrder, TakesAnySizeThereIs) {
  constexpr std::size_t kCount = 3000;
  test::Random random(7208);
  const Soup unit = confetti(random, kCount, 1.0);
  const double of_unit = mean_extent(unit, kCount);
  for (const double scale : {1e-290, 1e-120, 1e-50, 1e50, 1e120}) {
    Soup soup = unit;
    for (Vec3& p : soup.positions) p *= scale;
    EXPECT_NEAR(mean_extent(soup, kCount) / scale, of_unit, 0.1 * of_unit) << scale;
  }
  Soup stack = unit;
  for (Triangle& t : stack.triangles) t = {0, 1, 2};
  std::vector<std::uint32_t> order = order_of(stack);
  std::sort(order.begin(), order.end());
  for (std::size_t i = 0; i < kCount; ++i) ASSERT_EQ(order[i], i);
}

// Ever smaller clusters in each other: most faces are in one bin again and again.
TEST(FaceOrder, EndsWhereClustersHoldClusters) {
  test::Random random(7209);
  Soup soup;
  double size_m = 1.0;
  for (int level = 0; level < 100; ++level, size_m /= 1000.0) {
    add(confetti(random, 200, size_m), Vec3::Zero(), soup);
  }
  std::vector<std::uint32_t> order = order_of(soup);
  std::sort(order.begin(), order.end());
  for (std::size_t i = 0; i < order.size(); ++i) ASSERT_EQ(order[i], i);
}

}  // namespace
}  // namespace palpate
