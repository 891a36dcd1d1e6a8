#pragma once

// The faces around a proxy at rest, and the lines along which it may leave them. Private to the
// files god_object*.cpp.

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <span>

#include "haptics/proxy/god_object.h"

namespace palpate {

// Distance from the proxy, in stand-offs, within which faces are examined. The distance is large
// because nearly coplanar faces that meet at a vertex separate only at a distance of many
// stand-offs from it.
constexpr double kAroundPerStandOff = 64.0;

// The largest number of faces whose planes are intersected in pairs.
constexpr std::size_t kMostCrossing = 32;

// The largest number of planes that are intersected. Each face gives two: its own plane, and the
// plane through its nearest point that is perpendicular to the direction from this point to the
// proxy. Any two planes may intersect; the steepest descent in a plane counts as a line, too.
constexpr std::size_t kMostPlanes = 2 * kMostCrossing;
constexpr std::size_t kMostLines = kMostPlanes * (kMostPlanes + 1) / 2;

// The largest number of faces near the proxy that are examined.
constexpr std::size_t kMostAround = 256;

// The component of the lag along the line in which two planes intersect. Solver frame, m.
struct LineStep {
  Vec3 step;
  double length_m;
  std::size_t order;  // position in the order in which the lines were found
};

// The faces around a proxy that planes hold, sorted by distance. Allocated once, since it is large.
struct GodObject::Surroundings {
  std::array<FaceContact, kMostAround> faces;    // contact with the plane of each face
  std::array<FaceContact, kMostAround> nearest;  // contact with the nearest point of each face
  std::array<FaceContact, kMostAround> scratch;
  std::optional<Vec3> of;  // proxy position that these faces belong to
  std::size_t count = 0;
  std::size_t touched_count = 0;  // the first touched_count faces touch the proxy
  std::array<LineStep, kMostLines> lines;
  std::size_t line_count = 0;

  std::span<const FaceContact> all_faces() const { return std::span(faces).first(count); }
  std::span<const FaceContact> all_nearest() const { return std::span(nearest).first(count); }
  std::span<const FaceContact> all_touched() const {
    return std::span(nearest).first(touched_count);
  }
  // The nearest faces that do not touch the proxy.
  std::span<const FaceContact> all_untouched() const {
    const std::size_t end = std::max(touched_count, std::min(count, kMostCrossing));
    return std::span(nearest).first(end).subspan(touched_count);
  }
};

}  // namespace palpate
