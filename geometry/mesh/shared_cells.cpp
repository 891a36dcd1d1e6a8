#include "geometry/mesh/shared_cells.h"

#include <algorithm>
#include <array>

namespace palpate {
namespace {

// Adding this number to a double of less than 2^51 rounds the double to a whole number, and leaves
// that number in the low bits of the sum. Unlike a conversion, this works on several numbers at
// once in every instruction set.
constexpr double kRoundToWhole = 0x1.8p52;

// Bounds the rounding of a place along the direction across the slices, relative to the sum of its
// terms: of about ten products and sums, in either way to compute it. Places of 2^48 slices and
// more are therefore always in reach of their neighbours.
constexpr double kRoundoffOfMap = 0x1p-48;

constexpr std::size_t kAtOnce = 64;

}  // namespace

const Vec3 SharedCells::kAcross = Vec3(0.4393, 0.5775, 0.6883).normalized();

SharedCells::Points::Points(std::span<const Vec3> points_mesh) {
  for (auto* axis : {&x, &y, &z}) axis->reserve(points_mesh.size());
  for (const Vec3& p : points_mesh) {
    x.push_back(p.x());
    y.push_back(p.y());
    z.push_back(p.z());
  }
}

bool SharedCells::add_all(std::span<const Vec3> points, std::uint32_t owner) {
  std::array<std::uint64_t, kMostAtOnce> keys;
  std::array<Mark, kMostAtOnce> marks;
  for (std::size_t i = 0; i < points.size(); ++i) {
    keys[i] = key_of(points[i]);
    marks[i] = mark_at(points[i]);
    fetch(keys[i]);
    __builtin_prefetch(&marks_[marks[i].word], 1);
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!add(keys[i], marks[i], owner)) return false;
  }
  return true;
}

// The slices of a block of points are found first, and their marks are fetched together: to wait
// for the memory of one mark after another would take most of the time.
void SharedCells::find_near(const Points& points, const Map& map, double radius_m,
                            std::vector<std::uint32_t>& near) const {
  near.clear();
  const Eigen::RowVector3d row = per_cell_ * (kAcross.transpose() * map.linear);
  const double offset = along(map.translation);
  // The radius and a bound on the rounding, in cells.
  const double terms = per_cell_ * (map.linear.cwiseAbs() * map.reach).sum() +
                       per_cell_ * map.translation.cwiseAbs().sum();
  const double margin = per_cell_ * radius_m + kRoundoffOfMap * (terms + 1.0);
  std::array<std::int64_t, kAtOnce> slices;
  std::array<std::uint8_t, kAtOnce> is_below, is_above;  // whether the next slice is in reach
  std::array<Mark, kAtOnce> marks;
  for (std::size_t first = 0; first < points.x.size(); first += kAtOnce) {
    const std::size_t count = std::min(points.x.size() - first, kAtOnce);
    const double* x = points.x.data() + first;
    const double* y = points.y.data() + first;
    const double* z = points.z.data() + first;
    for (std::size_t i = 0; i < count; ++i) {
      const double at = row[0] * x[i] + row[1] * y[i] + row[2] * z[i] + offset;
      const double rounded = (at - 0.5) + kRoundToWhole;
      const double within = at - (rounded - kRoundToWhole);  // 0 to 1
      slices[i] = std::bit_cast<std::int64_t>(rounded) - std::bit_cast<std::int64_t>(kRoundToWhole);
      is_below[i] = within >= margin ? 0 : 1;
      is_above[i] = within <= 1.0 - margin ? 0 : 1;
    }
    for (std::size_t i = 0; i < count; ++i) {
      marks[i] = mark_of(slices[i]);
      __builtin_prefetch(&marks_[marks[i].word]);
    }
    for (std::size_t i = 0; i < count; ++i) {
      if (is_marked(marks[i]) || (is_below[i] != 0 && is_marked(mark_of(slices[i] - 1))) ||
          (is_above[i] != 0 && is_marked(mark_of(slices[i] + 1)))) {
        near.push_back(static_cast<std::uint32_t>(first + i));
      }
    }
  }
}

}  // namespace palpate
