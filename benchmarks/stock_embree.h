#pragma once

// Embree without Palpate is the first peer, that is, the first library with which Palpate is
// compared. It answers the same queries as Palpate in float, on its own triangle geometry, with the
// point query callback described in Embree's tutorials.

#include <cstdint>
#include <memory>
#include <optional>

#include "models/primitives.h"

namespace palpate::bench {

struct StockPoint {
  Eigen::Vector3f point_m;
  float distance_m;
  std::uint32_t triangle;
};

class StockSurface {
 public:
  explicit StockSurface(const TriangleMesh& mesh);
  ~StockSurface();
  StockSurface(StockSurface&&) noexcept;
  StockSurface& operator=(StockSurface&&) noexcept;

  // The nearest surface point closer than radius_m.
  std::optional<StockPoint> closest_point(const Eigen::Vector3f& p, float radius_m) const noexcept;

  // The fraction of the segment p to p + d at which it first meets a triangle.
  std::optional<float> first_hit(const Eigen::Vector3f& p, const Eigen::Vector3f& d) const noexcept;

 private:
  struct Buffers;
  std::unique_ptr<Buffers> buffers_;
};

}  // namespace palpate::bench
