#include "engine/scene/shared_indices.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/base/decompositions.h"

namespace palpate {
namespace {

// Deformations whose difference is at most this part of their norm count as equal: the deformation
// of a rotated node results from a decomposition, which causes rounding errors.
constexpr double kSameDeformation = 64 * std::numeric_limits<double>::epsilon();

// Limit on the matrices compared with a new one. A hostile file can contain any number of similar
// deformations. A missed match only costs memory.
constexpr std::size_t kMostCompared = 256;

// The unit of a body is at least 2^-40 of the size of the scene. A smaller unit is lengthened in
// steps of 2^40. A tenth of a stand-off is also about 2^-40 of the scene. In units of at least this
// length, the square of a radius of 2^40 is far from overflow in single precision; an overflow
// would make empty boxes count.
constexpr int kUnitStep = 40;

// A sphere may be larger than a body. Up to 2^40 times the size of the body, the unit of the index
// is the size of the body.
constexpr int kMostSweepExponent = 40;

// The number of a deformation that is only a uniform scale.
constexpr std::uint32_t kUniform = ~std::uint32_t{0};

// Sweeps are rounded up.
constexpr double kSlack = 1 + 0x1p-40;

// The normalised deformation of all uniform scales.
Mat3 uniform() {
  return Mat3::Identity() / std::sqrt(3.0);
}

bool is_same(const Mat3& unit, const Mat3& other) {
  return (unit - other).norm() <= kSameDeformation;
}

double sign_of(const Mat3& deformation) {
  return std::copysign(1.0, deformation.trace());
}

// The norm, computed for a vector: stableNorm() of a fixed-size matrix asserts in Eigen 3.4.
double stable_norm(const Mat3& m) {
  return Eigen::Map<const Eigen::Matrix<double, 9, 1>>(m.data()).stableNorm();
}

// The normalised deformation: of norm 1 and positive definite.
Mat3 unit_of(const Mat3& deformation) {
  return deformation / (sign_of(deformation) * stable_norm(deformation));
}

double uniform_scale(const Mat3& deformation) {
  const Vec3 diagonal = deformation.diagonal();
  if (diagonal[0] == diagonal[1] && diagonal[1] == diagonal[2]) return diagonal[0];
  return diagonal.mean();
}

bool is_within_ratio(const Mat3& unit) {
  const Vec3 stretches = singular_values(unit);
  return stretches[0] <= Stretch::kMostRatio * kSlack * stretches[2];
}

// A key that usually differs for different matrices.
double key_of(const Mat3& m) {
  Mat3 weights;
  weights << 1.0, 0.7548, 0.5698, 0.4301, 0.8191, 0.6710, 0.5497, 0.4503, 0.3689;
  return m.cwiseProduct(weights).sum();
}

}  // namespace

template <typename Stored>
std::optional<std::uint32_t> IndexSharing::MatrixFinder::find(const Mat3& m,
                                                              const Stored& stored) const {
  const double tolerance = kSameDeformation * stable_norm(m);
  const double key = key_of(m);
  std::size_t left = kMostCompared;
  // The norm of the weights is less than 2, so equal matrices have keys within 2 * tolerance.
  for (auto it = by_key_.lower_bound(key - 2 * tolerance);
       it != by_key_.end() && it->first <= key + 2 * tolerance && left > 0; ++it, --left) {
    if (stable_norm(stored(it->second) - m) <= tolerance) return it->second;
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

void IndexSharing::examine(std::uint32_t mesh, const NodePlacement& placement) {
  OfMesh& of_mesh = of_mesh_[mesh];
  const Mat3 unit = unit_of(placement.deformation);
  if (!of_mesh.unit) of_mesh.unit = unit;
  of_mesh.is_alike = of_mesh.is_alike && is_same(unit, *of_mesh.unit);
}

IndexUse IndexSharing::use(std::uint32_t mesh, const NodePlacement& placement) {
  const Mat3& deformation = placement.deformation;
  const double sign = sign_of(deformation);
  const Mat3 unit = unit_of(deformation);
  if (is_same(unit, uniform())) {
    const double scale = uniform_scale(deformation);
    return similar(mesh, kUniform, Mat3::Identity(), scale, scale);
  }
  const bool is_point = sweep_radius_m_ == 0.0;
  if (is_point && !of_mesh_[mesh].is_alike && is_within_ratio(unit)) {
    return stretched(mesh, deformation);
  }
  const std::uint32_t number = deformation_of(mesh, unit, sign * deformation);
  const Mat3& base = deformations_[number].base;
  const double scale = sign * (stable_norm(deformation) / stable_norm(base));
  return similar(mesh, number, base, scale, scale);
}

// The number of an equal deformation of an earlier node, or a new number.
std::uint32_t IndexSharing::deformation_of(std::uint32_t mesh, const Mat3& unit, const Mat3& base) {
  MatrixFinder& known = of_mesh_[mesh].deformations;
  const auto found =
      known.find(unit, [&](std::uint32_t id) -> const Mat3& { return deformations_[id].unit; });
  if (found) return *found;
  const auto number = static_cast<std::uint32_t>(deformations_.size());
  deformations_.push_back({unit, base, box_of(mesh, base)});
  known.add(unit, number);
  return number;
}

// scale: factor applied to the base, negative for a mirror. least_scale: the smallest factor by
// which the body scales a length of the base.
IndexUse IndexSharing::similar(std::uint32_t mesh, std::uint32_t deformation, const Mat3& base,
                               double scale, double least_scale) {
  const bool is_point = sweep_radius_m_ == 0.0;
  const int exponent = is_point ? 0 : std::ilogb(scale);
  const Box& box = deformation == kUniform ? boxes_[mesh] : deformations_[deformation].box;
  int unit = unit_exponent(box, exponent);
  const int steps = steps_longer(std::ilogb(least_scale) + unit);
  unit += kUnitStep * steps;
  const auto [known, is_new] = shape_of_.try_emplace({mesh, deformation, exponent, steps}, 0);
  if (is_new) {
    known->second = static_cast<std::uint32_t>(shapes_.size());
    const double units_per_metre = std::ldexp(1.0, -unit);
    const Vec3 middle = 0.5 * (box.low + box.high);
    shapes_.push_back({mesh, {units_per_metre * base, -units_per_metre * middle}, 0.0});
  }
  const double metres_per_unit = std::ldexp(scale, unit);
  double& sweep_radius = shapes_[known->second].sweep_radius;
  sweep_radius = std::max(sweep_radius, kSlack * sweep_radius_m_ / std::abs(metres_per_unit));
  return {known->second, IndexUse::kNoStretch, metres_per_unit};
}

// The exponent of the unit of an index. In this unit the box, scaled by 2^exponent, has size 1. If
// the sphere is far larger than the box, the unit is longer (kMostSweepExponent).
int IndexSharing::unit_exponent(const Box& box, int exponent) const {
  const double sweep = std::ldexp(sweep_radius_m_, -exponent - kMostSweepExponent);
  int unit = 0;
  std::frexp(std::max((box.high - box.low).maxCoeff(), sweep), &unit);
  return unit;
}

// The number of steps by which a unit of about 2^exponent_m must be lengthened (kUnitStep).
int IndexSharing::steps_longer(int exponent_m) const {
  const int missing = std::ilogb(size_m_) - kUnitStep - exponent_m;
  return missing > 0 ? (missing + kUnitStep - 1) / kUnitStep : 0;
}

IndexUse IndexSharing::stretched(std::uint32_t mesh, const Mat3& deformation) {
  // A lower bound on the least singular value, from the norm and kMostRatio.
  const double least_scale = 0.5 / Stretch::kMostRatio * stable_norm(deformation);
  IndexUse use = similar(mesh, kUniform, Mat3::Identity(), 1.0, least_scale);
  const AffineMap& map = shapes_[use.shape].map_index_mesh;
  const Mat3 linear = use.metres_per_unit * deformation;
  use.metres_per_unit = 1.0;
  MatrixFinder& known = stretches_of_shape_[use.shape];
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
