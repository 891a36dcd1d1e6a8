#include "geometry/pack_builder.h"

#include <algorithm>
#include <cmath>
#include <future>
#include <limits>
#include <span>
#include <thread>
#include <vector>

#include "geometry/exact.h"

namespace palpate {
namespace {

constexpr std::size_t kLanes = TrianglePack::kLanes;

// A face and three times its centre: the factor does not change any order.
struct FaceCentre {
  Vec3 sum_m;
  std::uint32_t face;
};

using FaceRange = std::span<FaceCentre>;

int widest_axis(FaceRange faces) {
  Vec3 low = faces.front().sum_m;
  Vec3 high = low;
  for (const FaceCentre& f : faces) {
    low = low.cwiseMin(f.sum_m);
    high = high.cwiseMax(f.sum_m);
  }
  int axis = 0;
  (high - low).maxCoeff(&axis);
  return axis;
}

// A mesh as the index sees it.
struct MappedMesh {
  const SurfaceMesh& mesh;
  const AffineMap& map;
  std::vector<Vec3> positions;
  std::vector<Triangle> faces;
  bool mirrored;

  MappedMesh(const SurfaceMesh& m, const AffineMap& a)
      : mesh(m), map(a), faces(m.faces()), mirrored(a.linear.determinant() < 0.0) {
    positions.reserve(m.welded_positions().size());
    for (const Vec3& p : m.welded_positions()) positions.push_back(a(p));
  }

  TriangleGeometry triangle(std::uint32_t face) const {
    const Triangle& corners = faces[face];
    TriangleGeometry t{positions[corners[0]], positions[corners[1]], positions[corners[2]], {}};
    if (mirrored) std::swap(t.b, t.c);
    t.normal = exactly_collinear(t.a, t.b, t.c) ? normal_from_mesh(corners)
                                                : accurate_unit_normal(t.a, t.b, t.c);
    return t;
  }

  // Where the map squeezes a thin face to no area in double: normals map by the inverse transpose.
  Vec3 normal_from_mesh(const Triangle& corners) const {
    const auto p = mesh.welded_positions();
    const Vec3 normal = accurate_unit_normal(p[corners[0]], p[corners[1]], p[corners[2]]);
    return (map.linear.inverse().transpose() * normal).normalized();
  }
};

Box box_around(std::span<const TriangleGeometry> triangles) {
  Box box{triangles.front().a, triangles.front().a};
  for (const TriangleGeometry& t : triangles) {
    box.low = box.low.cwiseMin(t.a).cwiseMin(t.b).cwiseMin(t.c);
    box.high = box.high.cwiseMax(t.a).cwiseMax(t.b).cwiseMax(t.c);
  }
  return box;
}

// The power of two that brings lengths up to `reach` to at most 1. For a reach so small that it
// would overflow the exponent is limited; coordinates are then smaller than they could be.
double scale_for(double reach) {
  constexpr int kMostExponent = 1000;
  int exponent = 0;
  std::frexp(reach, &exponent);
  return std::ldexp(1.0, std::min(-exponent, kMostExponent));
}

float per_squared_length(const float (&from)[3][kLanes], const float (&to)[3][kLanes],
                         std::size_t lane) {
  float squared = 0.0f;
  for (int k = 0; k < 3; ++k) {
    const float edge = to[k][lane] - from[k][lane];
    squared += edge * edge;
  }
  const float inverse = 1.0f / squared;
  return std::isfinite(inverse) ? inverse : 0.0f;
}

// Single precision, relative to the middle of the box.
TrianglePack to_local(std::span<const TriangleGeometry> triangles, const Box& box, int count) {
  TrianglePack pack{};
  const Vec3 centre = 0.5 * (box.low + box.high);
  const double per_metre = scale_for((box.high - box.low).maxCoeff());
  Vec3::Map(pack.centre_m) = centre;
  pack.per_metre = per_metre;
  pack.centre_roundoff = static_cast<float>(4 * std::numeric_limits<double>::epsilon() *
                                            centre.lpNorm<1>() * per_metre);
  pack.count = count;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    const TriangleGeometry& t = triangles[lane];
    for (int k = 0; k < 3; ++k) {
      pack.a[k][lane] = static_cast<float>((t.a[k] - centre[k]) * per_metre);
      pack.b[k][lane] = static_cast<float>((t.b[k] - centre[k]) * per_metre);
      pack.c[k][lane] = static_cast<float>((t.c[k] - centre[k]) * per_metre);
      pack.normal[k][lane] = static_cast<float>(t.normal[k]);
    }
    for (int e = 0; e < 3; ++e) {
      const auto& from = e == 0 ? pack.a : e == 1 ? pack.b : pack.c;
      const auto& to = e == 0 ? pack.b : e == 1 ? pack.c : pack.a;
      pack.per_squared_edge[e][lane] = per_squared_length(from, to, lane);
    }
    pack.height[lane] = static_cast<float>(t.normal.dot(t.a - centre) * per_metre);
  }
  return pack;
}

// Splits down to clusters, then down to packs: every part but the last is full, so the packs of a
// part begin at a place that is known before.
class PackWriter {
 public:
  PackWriter(const MappedMesh& mesh, PackedSurface& surface) : mesh_(mesh), surface_(surface) {}

  // Large parts are shared among up to `threads` threads, which changes nothing in the result.
  void split(FaceRange faces, std::size_t first_pack, unsigned threads) {
    if (faces.size() <= kLanes) return write_pack(faces, first_pack);
    const std::size_t middle = partition(faces);
    const auto split_high = [&](unsigned high_threads) {
      split(faces.subspan(middle), first_pack + middle / kLanes, high_threads);
    };
    if (threads < 2 || faces.size() < kWorthAThread) {
      split(faces.first(middle), first_pack, 1);
      return split_high(1);
    }
    // Deferred, and then done at the end of this block, where no thread can be had.
    const auto high =
        std::async(std::launch::async | std::launch::deferred, split_high, threads / 2);
    split(faces.first(middle), first_pack, threads - threads / 2);
    high.wait();
  }

 private:
  static constexpr std::size_t kWorthAThread = 20000;  // a few milliseconds of work

  // Orders a part so that whole clusters, or packs, lie on either side of the number it returns.
  static std::size_t partition(FaceRange faces) {
    const int axis = widest_axis(faces);
    const std::size_t whole = faces.size() > kLanes * kLanes ? kLanes * kLanes : kLanes;
    const std::size_t count = (faces.size() + whole - 1) / whole;
    const std::size_t middle = count / 2 * whole;
    std::nth_element(faces.begin(), faces.begin() + static_cast<std::ptrdiff_t>(middle),
                     faces.end(), [axis](const FaceCentre& x, const FaceCentre& y) {
                       return x.sum_m[axis] != y.sum_m[axis] ? x.sum_m[axis] < y.sum_m[axis]
                                                             : x.face < y.face;
                     });
    return middle;
  }

  void write_pack(FaceRange faces, std::size_t id) {
    TriangleGeometry* const triangles = &surface_.triangles[id * kLanes];
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const std::uint32_t face = faces[std::min(lane, faces.size() - 1)].face;
      surface_.faces[id * kLanes + lane] = face;
      triangles[lane] = lane < faces.size() ? mesh_.triangle(face) : triangles[lane - 1];
    }
    const std::span lanes(triangles, kLanes);
    surface_.boxes[id] = box_around(lanes);
    surface_.packs[id] = to_local(lanes, surface_.boxes[id], static_cast<int>(faces.size()));
  }

  const MappedMesh& mesh_;
  PackedSurface& surface_;
};

}  // namespace

PackedSurface pack_surface(const SurfaceMesh& mesh, const AffineMap& map) {
  const MappedMesh mapped(mesh, map);
  FixedArray<FaceCentre> centres(mesh.face_count());
  for (std::uint32_t f = 0; f < centres.size(); ++f) {
    const Triangle& corners = mapped.faces[f];
    const auto& positions = mapped.positions;
    centres[f] = {positions[corners[0]] + positions[corners[1]] + positions[corners[2]], f};
  }
  const std::size_t pack_count = (centres.size() + kLanes - 1) / kLanes;
  PackedSurface surface{FixedArray<TrianglePack>(pack_count), FixedArray<Box>(pack_count),
                        FixedArray<TriangleGeometry>(pack_count * kLanes),
                        FixedArray<std::uint32_t>(pack_count * kLanes)};
  if (centres.empty()) return surface;
  PackWriter(mapped, surface)
      .split(FaceRange(&centres[0], centres.size()), 0, std::thread::hardware_concurrency());
  return surface;
}

}  // namespace palpate
