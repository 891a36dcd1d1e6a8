#include "benchmarks/scan_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "geometry/base/random.h"

namespace palpate::bench {
namespace {

// Cells of a block along each axis. A block that the surface does not reach is skipped as a whole.
constexpr int kBlock = 16;
constexpr int kBlockPoints = kBlock + 1;

// The six tetrahedra of a cell share its diagonal: each leads from corner 0 to corner 7 along the
// axes in a different order. Corners are numbered by bits, x first; the odd orders are mirrored.
struct Tetrahedron {
  std::array<int, 4> corners;
  bool is_mirrored;
};
constexpr std::array<Tetrahedron, 6> kTetrahedra{{{{0, 1, 3, 7}, false},
                                                  {{0, 2, 6, 7}, false},
                                                  {{0, 4, 5, 7}, false},
                                                  {{0, 1, 5, 7}, true},
                                                  {{0, 2, 3, 7}, true},
                                                  {{0, 4, 6, 7}, true}}};

// The even permutations of a tetrahedron's corners that list the inside corners first.
constexpr std::array<std::array<int, 4>, 4> kFirstOne{
    {{0, 1, 2, 3}, {1, 0, 3, 2}, {2, 0, 1, 3}, {3, 0, 2, 1}}};
constexpr std::array<std::array<int, 4>, 6> kFirstTwo{
    {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {1, 2, 0, 3}, {1, 3, 2, 0}, {2, 3, 0, 1}}};

int bit_of(int corner, int axis) {
  return corner >> axis & 1;
}

class Scanner {
 public:
  Scanner(const ScannedBody& body, double cell_m, const ScanQuality& quality)
      : body_(body),
        cell_m_(cell_m),
        quality_(quality),
        random_(quality.seed),
        // A block of clearance beside the body: noise and rounding stay inside the grid.
        blocks_(static_cast<int>(std::ceil(2.0 * ScannedBody::kHalfExtent_m / (kBlock * cell_m))) +
                2),
        low_m_(-0.5 * blocks_ * kBlock * cell_m) {
    for (int z = 0; z < blocks_; ++z) {
      for (int y = 0; y < blocks_; ++y) {
        for (int x = 0; x < blocks_; ++x) march({x * kBlock, y * kBlock, z * kBlock});
      }
    }
  }

  TriangleMesh take() {
    leave_holes();
    return std::move(mesh_);
  }

 private:
  using Cell = std::array<int, 3>;  // a point of the grid

  Vec3 position_m(const Cell& cell) const {
    // Shifted by about half a cell, so that no plane of the body lies in a plane of the grid.
    constexpr double kAside = 0.437;
    return Vec3(cell[0] + kAside, cell[1] + kAside, cell[2] + kAside) * cell_m_ +
           Vec3::Constant(low_m_);
  }

  void march(const Cell& first) {
    const double half_m = 0.5 * kBlock * cell_m_;
    const double reach_m = std::sqrt(3.0) * half_m;
    const Vec3 middle = position_m(first) + Vec3::Constant(half_m);
    if (std::abs(body_.distance_m(middle)) > reach_m) return;
    parts_ = body_.parts_near(middle, reach_m);
    for (int z = 0; z < kBlockPoints; ++z) {
      for (int y = 0; y < kBlockPoints; ++y) {
        for (int x = 0; x < kBlockPoints; ++x) {
          const Cell cell{first[0] + x, first[1] + y, first[2] + z};
          value(x, y, z) = body_.distance_m(position_m(cell), parts_);
        }
      }
    }
    for (int z = 0; z < kBlock; ++z) {
      for (int y = 0; y < kBlock; ++y) {
        for (int x = 0; x < kBlock; ++x) march_cell(first, {x, y, z});
      }
    }
  }

  double& value(int x, int y, int z) {
    return values_m_[static_cast<std::size_t>((z * kBlockPoints + y) * kBlockPoints + x)];
  }

  void march_cell(const Cell& first, const Cell& in_block) {
    std::array<double, 8> values_m;
    for (int corner = 0; corner < 8; ++corner) {
      values_m[static_cast<std::size_t>(corner)] =
          value(in_block[0] + bit_of(corner, 0), in_block[1] + bit_of(corner, 1),
                in_block[2] + bit_of(corner, 2));
    }
    const auto [least, most] = std::minmax_element(values_m.begin(), values_m.end());
    if (*least >= 0.0 || *most < 0.0) return;
    cell_ = {first[0] + in_block[0], first[1] + in_block[1], first[2] + in_block[2]};
    for (const Tetrahedron& tetrahedron : kTetrahedra) march_tetrahedron(tetrahedron, values_m);
  }

  void march_tetrahedron(const Tetrahedron& tetrahedron, const std::array<double, 8>& values_m) {
    const auto corner = [&](int i) { return tetrahedron.corners[static_cast<std::size_t>(i)]; };
    const auto is_inside = [&](int i) {
      return values_m[static_cast<std::size_t>(corner(i))] < 0.0;
    };
    const auto vertex = [&](int i, int j) { return vertex_on(corner(i), corner(j), values_m); };
    int inside = 0;
    for (int i = 0; i < 4; ++i) inside += is_inside(i);
    if (inside == 1 || inside == 3) {
      for (const auto& [i, j, k, l] : kFirstOne) {
        if (is_inside(i) != (inside == 1)) continue;
        add_triangle(vertex(i, j), vertex(i, k), vertex(i, l),
                     tetrahedron.is_mirrored != (inside == 3));
      }
    }
    if (inside != 2) return;
    for (const auto& [i, j, k, l] : kFirstTwo) {
      if (!is_inside(i) || !is_inside(j)) continue;
      add_triangle(vertex(i, k), vertex(i, l), vertex(j, l), tetrahedron.is_mirrored);
      add_triangle(vertex(i, k), vertex(j, l), vertex(j, k), tetrahedron.is_mirrored);
    }
  }

  void add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c, bool is_mirrored) {
    if (is_mirrored) std::swap(b, c);
    mesh_.triangles.push_back({a, b, c});
  }

  // The vertex on the edge between two corners of the cell; neighbouring cells share it.
  std::uint32_t vertex_on(int i, int j, const std::array<double, 8>& values_m) {
    if (i > j) std::swap(i, j);
    Cell from = cell_;
    Cell to = cell_;
    for (int k = 0; k < 3; ++k) {
      from[static_cast<std::size_t>(k)] += bit_of(i, k);
      to[static_cast<std::size_t>(k)] += bit_of(j, k);
    }
    const auto side = static_cast<std::uint64_t>(blocks_ * kBlock + 1);
    const std::uint64_t point =
        (static_cast<std::uint64_t>(from[2]) * side + static_cast<std::uint64_t>(from[1])) * side +
        static_cast<std::uint64_t>(from[0]);
    const std::uint64_t edge = point * 8 + static_cast<std::uint64_t>(j - i);
    const auto [place, is_new] =
        vertices_.try_emplace(edge, static_cast<std::uint32_t>(mesh_.positions_m.size()));
    if (is_new) {
      const double at_from_m = values_m[static_cast<std::size_t>(i)];
      const double part = at_from_m / (at_from_m - values_m[static_cast<std::size_t>(j)]);
      mesh_.positions_m.push_back(
          seen_at(position_m(from) + part * (position_m(to) - position_m(from))));
    }
    return place->second;
  }

  // The position that the scanner reports for a point of the surface.
  Vec3 seen_at(const Vec3& p) {
    const double error_m = quality_.noise_cells * cell_m_ * random_.normal();
    return (p + error_m * body_.outwards(p, parts_)).cast<float>().cast<double>();
  }

  void leave_holes() {
    SeededRandom random(quality_.seed);
    std::vector<Vec3> middles;
    for (int i = 0; i < quality_.holes; ++i) {
      middles.push_back(body_.surface_near(random.in_box(ScannedBody::kHalfExtent_m)));
    }
    const double squared_m2 = quality_.hole_radius_m * quality_.hole_radius_m;
    std::erase_if(mesh_.triangles, [&](const Triangle& t) {
      return std::any_of(middles.begin(), middles.end(), [&](const Vec3& middle) {
        return (mesh_.positions_m[t[0]] - middle).squaredNorm() < squared_m2;
      });
    });
  }

  const ScannedBody& body_;
  double cell_m_;
  ScanQuality quality_;
  SeededRandom random_;
  int blocks_;  // along each axis
  double low_m_;
  Cell cell_{};
  ScannedBody::Parts parts_;  // near the block
  std::array<double, kBlockPoints * kBlockPoints * kBlockPoints> values_m_{};
  std::unordered_map<std::uint64_t, std::uint32_t> vertices_;  // key: the edge of the grid
  TriangleMesh mesh_;
};

}  // namespace

TriangleMesh scan_of(const ScannedBody& body, double cell_m, const ScanQuality& quality) {
  return Scanner(body, cell_m, quality).take();
}

}  // namespace palpate::bench
