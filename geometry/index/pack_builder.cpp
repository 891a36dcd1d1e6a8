#include "geometry/index/pack_builder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#if defined(__GLIBC__)
#include <malloc.h>
#endif

#include "geometry/base/parallel.h"
#include "geometry/exact/exact.h"

namespace palpate {
namespace {

constexpr std::size_t kSlots = TrianglePack::kLanes;

constexpr std::size_t kPacksWorthAThread = 1000;  // a millisecond of work
// The number of faces from which freed memory is returned to the system before packing: their packs
// use 20 MB.
constexpr std::size_t kLarge = 100000;

// Returns free memory to the system. Otherwise, the C library would keep the memory that loading
// has freed, in addition to the memory allocated next.
void give_back_free_memory() {
#if defined(__GLIBC__)
  ::malloc_trim(0);
#endif
}

// Makes the index's triangles from the faces of a mesh.
class TriangleMaker {
 public:
  explicit TriangleMaker(const MappedFaces& faces)
      : faces_(faces), is_mirrored_(faces.map_index_mesh.linear.determinant() < 0.0) {}

  TriangleGeometry triangle(std::uint32_t face) const {
    TriangleGeometry t{faces_.corner(face, 0), faces_.corner(face, 1), faces_.corner(face, 2), {}};
    if (is_mirrored_) std::swap(t.b, t.c);
    t.normal = exactly_collinear(t.a, t.b, t.c) ? normal_from_mesh(face)
                                                : accurate_unit_normal(t.a, t.b, t.c);
    return t;
  }

 private:
  // The normal of a thin face that the map compresses to zero area in double: normals map by the
  // inverse transpose.
  Vec3 normal_from_mesh(std::uint32_t face) const {
    const auto& p = faces_.positions_mesh_m;
    const Triangle& corners = faces_.faces[face];
    const Vec3 normal = accurate_unit_normal(p[corners[0]], p[corners[1]], p[corners[2]]);
    return (faces_.map_index_mesh.linear.inverse().transpose() * normal).normalized();
  }

  const MappedFaces& faces_;
  bool is_mirrored_;
};

Box box_around(std::span<const TriangleGeometry> triangles) {
  Box box{triangles.front().a, triangles.front().a};
  for (const TriangleGeometry& t : triangles) {
    box.low = box.low.cwiseMin(t.a).cwiseMin(t.b).cwiseMin(t.c);
    box.high = box.high.cwiseMax(t.a).cwiseMax(t.b).cwiseMax(t.c);
  }
  return box;
}

// The power of two that brings lengths up to `reach` to at most 1. The exponent is limited, because
// the scale of a very small reach would overflow. Coordinates are then smaller than possible.
double scale_for(double reach) {
  constexpr int kMostExponent = 1000;
  int exponent = 0;
  std::frexp(reach, &exponent);
  return std::ldexp(1.0, std::min(-exponent, kMostExponent));
}

float per_squared_length(const float (&from)[3][kSlots], const float (&to)[3][kSlots],
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
  for (std::size_t lane = 0; lane < kSlots; ++lane) {
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

// Fills pack `id` from its first `count` faces. The remaining lanes repeat the last face.
void write_pack(const TriangleMaker& maker, std::size_t id, std::size_t count,
                PackedSurface& surface) {
  std::uint32_t* const faces = &surface.faces[id * kSlots];
  TriangleGeometry* const triangles = &surface.triangles[id * kSlots];
  for (std::size_t lane = 0; lane < kSlots; ++lane) {
    const bool is_own = lane < count;
    if (!is_own) faces[lane] = faces[lane - 1];
    triangles[lane] = is_own ? maker.triangle(faces[lane]) : triangles[lane - 1];
  }
  const std::span lanes(triangles, kSlots);
  surface.boxes[id] = box_around(lanes);
  surface.packs[id] = to_local(lanes, surface.boxes[id], static_cast<int>(count));
}

}  // namespace

PackedSurface pack_surface(const MappedFaces& faces) {
  const std::size_t face_count = faces.faces.size();
  const std::size_t pack_count = (face_count + kSlots - 1) / kSlots;
  PackedSurface surface{FixedArray<TrianglePack>(pack_count), FixedArray<Box>(pack_count),
                        FixedArray<TriangleGeometry>(pack_count * kSlots),
                        FixedArray<std::uint32_t>(pack_count * kSlots)};
  // All faces are ordered first, so that the temporary memory for ordering is free before packs are
  // filled.
  order_faces(faces, {surface.faces.data(), face_count});
  if (face_count >= kLarge) give_back_free_memory();
  const TriangleMaker maker(faces);
  run_ranges(pack_count, kPacksWorthAThread, [&](std::size_t begin, std::size_t end) {
    for (std::size_t id = begin; id < end; ++id) {
      write_pack(maker, id, std::min(kSlots, face_count - id * kSlots), surface);
    }
  });
  return surface;
}

}  // namespace palpate
