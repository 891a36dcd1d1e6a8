#pragma once

// The triangles that a proxy is about, as they are decided on.

#include <array>
#include <cstddef>
#include <cstdint>

#include "haptics/proxy/contact.h"
#include "haptics/proxy/contact_world.h"

namespace palpate {

// Triangles of a world's bodies, body frame. Those of stretched bodies are made when they are asked
// for; a tick asks for the same few many times, so the last ones are kept. How a body is stretched
// never changes, so none is out of date. No allocation; one thread owns it.
class MadeTriangles {
 public:
  // Valid until another face is asked for.
  const TriangleGeometry& of(const ContactBody& body, const FaceRef& face) const {
    if (!body.stretch) [[likely]]
      return body.index->triangle(face.slot);
    return made(*body.stretch, *body.index, face);
  }

 private:
  static constexpr std::size_t kCount = 16;
  struct Entry {
    FaceRef face{~std::uint32_t{0}, ~std::uint32_t{0}};
    TriangleGeometry triangle;
  };

  [[gnu::noinline]] const TriangleGeometry& made(const Stretch& stretch, const SurfaceIndex& index,
                                                 const FaceRef& face) const {
    Entry& entry = entries_[face.slot % kCount];
    if (entry.face != face) entry = {face, stretch.triangle(index.triangle(face.slot))};
    return entry.triangle;
  }

  mutable std::array<Entry, kCount> entries_;
};

}  // namespace palpate
