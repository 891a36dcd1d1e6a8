#pragma once

// The triangles near a proxy in the body frame, in which the exact tests are made.

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "haptics/proxy/contact.h"
#include "haptics/proxy/contact_world.h"

namespace palpate {

// Provides the triangles of a world's bodies in the body frame. The triangles of a stretched body
// are computed on request. A tick requests the same few triangles many times, so the last ones are
// kept. They stay valid, because a body's stretch never changes.
//
// Safe on the haptic thread: no allocation, lock or exception. Not thread-safe: one thread owns an
// instance.
class MadeTriangles {
 public:
  // The triangle of a face, in units of the body frame. The reference is valid until the next call.
  const TriangleGeometry& of(const ContactBody& body, const FaceRef& face) const {
    if (!body.stretch) [[likely]]
      return body.index->triangle(face.slot);
    return made(*body.stretch, *body.index, face);
  }

  // The triangle of a face at the body's corners, which must exist. Solver frame, m. The reference
  // is valid until the next call. An object provides triangles either by of() or by this function.
  [[gnu::noinline]] const TriangleGeometry& at_corners(const ContactBody& body,
                                                       const FaceRef& face) const {
    Entry& entry = entries_[(face.slot + kStride * face.body) % kCount];
    if (entry.face != face) {
      TriangleGeometry buffer;
      const Vec3 normal = body.direction_to_solver(body.triangle(face.slot, buffer).normal);
      entry = {face, body.corners->triangle(face.slot, normal)};
      ++made_count_;
    }
    return entry.triangle;
  }

  // The number of triangles computed since the last call.
  std::size_t take_made_count() { return std::exchange(made_count_, std::size_t{0}); }

 private:
  static constexpr std::size_t kCount = 16;
  static constexpr std::size_t kStride = 5;  // spreads bodies that meet in a few triangles each
  struct Entry {
    FaceRef face{~std::uint32_t{0}, ~std::uint32_t{0}};
    TriangleGeometry triangle;
  };

  [[gnu::noinline]] const TriangleGeometry& made(const Stretch& stretch, const SurfaceIndex& index,
                                                 const FaceRef& face) const {
    Entry& entry = entries_[face.slot % kCount];
    if (entry.face != face) {
      entry = {face, stretch.triangle(index.triangle(face.slot))};
      ++made_count_;
    }
    return entry.triangle;
  }

  mutable std::array<Entry, kCount> entries_;
  mutable std::size_t made_count_ = 0;
};

}  // namespace palpate
