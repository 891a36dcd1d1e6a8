#include "engine/shared_indices.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/SVD>

namespace palpate {
namespace {

// Deformations that differ by no more are one: a node that is turned has its own from a
// decomposition. Of their norm.
constexpr double kSameDeformation = 64 * std::numeric_limits<double>::epsilon();

// A hostile file can have any number of deformations that look alike. To share is to save memory,
// no more.
constexpr std::size_t kMostCompared = 256;

// Beside a scene so much larger, coordinates of a body in a unit of its own would leave the range
// in which signs are exact (orientation.h). Such a body has an index in metres.
constexpr double kSmallestPart = 1e-60;

// A sphere may be larger than a body. Up to so much, the unit of the index is the size of the body.
constexpr double kMostSweepPerUnit = 0x1p40;

// Sweeps are rounded up.
constexpr double kSlack = 1 + 0x1p-40;

// What uniform scales are, but for their size.
Mat3 uniform() {
  return Mat3::Identity() / std::sqrt(3.0);
}

bool is_same(const Mat3& unit, const Mat3& other) {
  return (unit - other).norm() <= kSameDeformation;
}

double sign_of(const Mat3& deformation) {
  return std::copysign(1.0, deformation.trace());
}

// Of size 1, and positive definite.
Mat3 unit_of(const Mat3& deformation) {
  return deformation / (sign_of(deformation) * deformation.stableNorm());
}

double uniform_scale(const Mat3& deformation) {
  const Vec3 diagonal = deformation.diagonal();
  if (diagonal[0] == diagonal[1] && diagonal[1] == diagonal[2]) return diagonal[0];
  return diagonal.mean();
}

bool is_within_ratio(const Mat3& unit) {
  const Vec3 stretches = Eigen::JacobiSVD<Mat3>(unit).singularValues();
  return stretches[0] <= Stretch::kMostRatio * kSlack * stretches[2];
}

// Different for different matrices, as a rule.
double key_of(const Mat3& m) {
  Mat3 weights;
  weights << 1.0, 0.7548, 0.5698, 0.4301, 0.8191, 0.6710, 0.5497, 0.4503, 0.3689;
  return m.cwiseProduct(weights).sum();
}

}  // namespace

template <typename Stored>
std::optional<std::uint32_t> IndexSharing::MatrixFinder::find(const Mat3& m,
                                                              const Stored& stored) const {
  const double tolerance = kSameDeformation * m.stableNorm();
  const double key = key_of(m);
  std::size_t left = kMostCompared;
  // The weights' norm is less than 2.
  for (auto it = by_key_.lower_bound(key - 2 * tolerance);
       it != by_key_.end() && it->first <= key + 2 * tolerance && left > 0; ++it, --left) {
    if ((stored(it->second) - m).stableNorm() <= tolerance) return it->second;
  }
  return std::nullopt;
}

void IndexSharing::MatrixFinder::add(const Mat3& m, std::uint32_t id) {
  by_key_.emplace(key_of(m), id);
}

IndexSharing::IndexSharing(const std::vector<WeldedSurface>& meshes, std::span<const Box> boxes,
                           double sweep_radius_m, double size_m)
    : meshes_(meshes),
      boxes_(boxes),
      sweep_radius_m_(sweep_radius_m),
      size_m_(size_m),
      of_mesh_(meshes.size()) {}

void IndexSharing::look_at(std::uint32_t mesh, const NodePlacement& placement) {
  OfMesh& of_mesh = of_mesh_[mesh];
  const Mat3 unit = unit_of(placement.deformation);
  if (!of_mesh.unit) of_mesh.unit = unit;
  of_mesh.is_alike = of_mesh.is_alike && is_same(unit, *of_mesh.unit);
}

IndexUse IndexSharing::use(std::uint32_t mesh, const NodePlacement& placement) {
  const Mat3& deformation = placement.deformation;
  const double sign = sign_of(deformation);
  const Vec3 columns = deformation.cwiseAbs() * (boxes_[mesh].high - boxes_[mesh].low);
  if (columns.maxCoeff() < kSmallestPart * size_m_) return alone(mesh, sign * deformation, sign);
  const Mat3 unit = unit_of(deformation);
  constexpr std::uint32_t kUniform = ~std::uint32_t{0};
  if (is_same(unit, uniform())) {
    return similar(mesh, kUniform, Mat3::Identity(), uniform_scale(deformation));
  }
  const bool is_point = sweep_radius_m_ == 0.0;
  if (is_point && !of_mesh_[mesh].is_alike && is_within_ratio(unit)) {
    return stretched(mesh, deformation);
  }
  const std::uint32_t number = deformation_of(mesh, unit, sign * deformation);
  const Mat3& base = deformations_[number].base;
  return similar(mesh, number, base, sign * (deformation.stableNorm() / base.stableNorm()));
}

// That of an earlier node, or a new one.
std::uint32_t IndexSharing::deformation_of(std::uint32_t mesh, const Mat3& unit, const Mat3& base) {
  MatrixFinder& known = of_mesh_[mesh].deformations;
  const auto found =
      known.find(unit, [&](std::uint32_t id) -> const Mat3& { return deformations_[id].unit; });
  if (found) return *found;
  const auto number = static_cast<std::uint32_t>(deformations_.size());
  deformations_.push_back({unit, base});
  known.add(unit, number);
  return number;
}

// scale: of the base, negative for a mirror.
IndexUse IndexSharing::similar(std::uint32_t mesh, std::uint32_t deformation, const Mat3& base,
                               double scale) {
  const bool is_point = sweep_radius_m_ == 0.0;
  const int exponent = is_point ? 0 : std::ilogb(scale);
  const auto [known, is_new] = shape_of_.try_emplace({mesh, deformation, exponent}, 0);
  if (is_new) known->second = add_shape(mesh, base, exponent);
  IndexShape& shape = shapes_[known->second];
  // The base is positive definite.
  const double units_per_metre = shape.map_index_mesh.linear(0, 0) / base(0, 0);
  const double metres_per_unit = scale / units_per_metre;
  shape.sweep_radius =
      std::max(shape.sweep_radius, kSlack * sweep_radius_m_ / std::abs(metres_per_unit));
  return {known->second, IndexUse::kNoStretch, metres_per_unit};
}

// A node with an index in metres.
IndexUse IndexSharing::alone(std::uint32_t mesh, const Mat3& base, double sign) {
  const Box box = box_of(mesh, base);
  shapes_.push_back({mesh, {base, -0.5 * (box.low + box.high)}, sweep_radius_m_});
  return {static_cast<std::uint32_t>(shapes_.size() - 1), IndexUse::kNoStretch, sign};
}

IndexUse IndexSharing::stretched(std::uint32_t mesh, const Mat3& deformation) {
  IndexUse use = similar(mesh, ~std::uint32_t{0}, Mat3::Identity(), 1.0);
  const AffineMap& map = shapes_[use.shape].map_index_mesh;
  const Mat3 linear = use.metres_per_unit * deformation;
  use.metres_per_unit = 1.0;
  MatrixFinder& known = of_mesh_[mesh].stretches;
  const auto found = known.find(
      linear, [&](std::uint32_t id) -> const Mat3& { return stretches_[id].linear_body_index(); });
  if (found) {
    use.stretch = *found;
    return use;
  }
  use.stretch = static_cast<std::uint32_t>(stretches_.size());
  stretches_.emplace_back(linear, Box{map(boxes_[mesh].low), map(boxes_[mesh].high)});
  known.add(linear, use.stretch);
  return use;
}

std::uint32_t IndexSharing::add_shape(std::uint32_t mesh, const Mat3& base, int exponent) {
  const Box box = box_of(mesh, base);
  const double reach = std::max((box.high - box.low).maxCoeff(),
                                std::ldexp(sweep_radius_m_, -exponent) / kMostSweepPerUnit);
  int unit = 0;
  std::frexp(reach, &unit);
  const double per_metre = std::ldexp(1.0, -unit);
  shapes_.push_back({mesh, {per_metre * base, -per_metre * (0.5 * (box.low + box.high))}, 0.0});
  return static_cast<std::uint32_t>(shapes_.size() - 1);
}

Box IndexSharing::box_of(std::uint32_t mesh, const Mat3& base) const {
  if (base == Mat3::Identity()) return boxes_[mesh];
  Box box{Vec3::Constant(std::numeric_limits<double>::infinity()),
          Vec3::Constant(-std::numeric_limits<double>::infinity())};
  for (const Vec3& p : meshes_[mesh].positions()) {
    const Vec3 q = base * p;
    box = box.united({q, q});
  }
  return box;
}

}  // namespace palpate
