#include "geometry/pack_builder.h"

#include <algorithm>
#include <numeric>

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
  bool mirrored;

  MappedMesh(const SurfaceMesh& m, const AffineMap& a)
      : mesh(m), map(a), mirrored(a.linear.determinant() < 0.0) {
    positions.reserve(m.welded_positions().size());
    for (const Vec3& p : m.welded_positions()) positions.push_back(a(p));
  }

  TriangleGeometry triangle(std::uint32_t face) const {
    const Triangle& corners = mesh.face(face);
    TriangleGeometry t{positions[corners[0]], positions[corners[1]], positions[corners[2]], {}};
    if (mirrored) std::swap(t.b, t.c);
    t.normal = exactly_collinear(t.a, t.b, t.c) ? normal_from_mesh(corners)
                                                : accurate_unit_normal(t.a, t.b, t.c);
    return t;
  }

  // Where the map squeezes a thin face to no area in double: normals map by the inverse transpose.
  Vec3 normal_from_mesh(const Triangle& corners) const {
    const auto& p = mesh.welded_positions();
    const Vec3 normal = accurate_unit_normal(p[corners[0]], p[corners[1]], p[corners[2]]);
    return (map.linear.inverse().transpose() * normal).normalized();
  }
};

TrianglePack make_pack(const MappedMesh& mesh, FaceRange faces) {
  TrianglePack pack{};
  pack.count = static_cast<int>(faces.size());
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    const std::uint32_t face = faces[std::min(lane, faces.size() - 1)].face;
    const TriangleGeometry t = mesh.triangle(face);
    for (int k = 0; k < 3; ++k) {
      pack.a[k][lane] = t.a[k];
      pack.b[k][lane] = t.b[k];
      pack.c[k][lane] = t.c[k];
      pack.normal[k][lane] = t.normal[k];
    }
    pack.face[lane] = face;
  }
  return pack;
}

void split(const MappedMesh& mesh, FaceRange faces, std::vector<TrianglePack>& packs) {
  if (faces.size() <= kLanes) {
    packs.push_back(make_pack(mesh, faces));
    return;
  }
  const int axis = widest_axis(faces);
  // The lower half is a whole number of packs.
  const std::size_t pack_count = (faces.size() + kLanes - 1) / kLanes;
  const std::size_t middle = pack_count / 2 * kLanes;
  std::nth_element(faces.begin(), faces.begin() + static_cast<std::ptrdiff_t>(middle), faces.end(),
                   [axis](const FaceCentre& x, const FaceCentre& y) {
                     return x.sum_m[axis] != y.sum_m[axis] ? x.sum_m[axis] < y.sum_m[axis]
                                                           : x.face < y.face;
                   });
  split(mesh, faces.first(middle), packs);
  split(mesh, faces.subspan(middle), packs);
}

}  // namespace

std::vector<TrianglePack> build_packs(const SurfaceMesh& mesh, const AffineMap& map) {
  const MappedMesh mapped(mesh, map);
  std::vector<FaceCentre> centres(mesh.face_count());
  for (std::uint32_t f = 0; f < centres.size(); ++f) {
    const Triangle& corners = mesh.face(f);
    const auto& positions = mapped.positions;
    centres[f] = {positions[corners[0]] + positions[corners[1]] + positions[corners[2]], f};
  }
  std::vector<TrianglePack> packs;
  packs.reserve((centres.size() + kLanes - 1) / kLanes);
  if (!centres.empty()) split(mapped, centres, packs);
  return packs;
}

Box bounding_box(const TrianglePack& pack) {
  Box box;
  for (int k = 0; k < 3; ++k) {
    double low = pack.a[k][0];
    double high = low;
    for (const auto* corner : {&pack.a, &pack.b, &pack.c}) {
      const auto [least, most] = std::minmax_element((*corner)[k], (*corner)[k] + kLanes);
      low = std::min(low, *least);
      high = std::max(high, *most);
    }
    box.low[k] = low;
    box.high[k] = high;
  }
  return box;
}

}  // namespace palpate
