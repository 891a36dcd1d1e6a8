#pragma once

// The materials of the faces of a world's bodies, as numbers of the scene.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <vector>

namespace palpate {

// A run of consecutive faces of one mesh with one material. A run ends where the next one begins.
struct FaceMaterialRun {
  std::uint32_t first_face = 0;
  std::int32_t material = 0;
};

// Immutable once it is complete; threads may then share it. material() is safe on the haptic
// thread.
class FaceMaterials {
 public:
  // Adds a surface and returns its number. runs: in ascending order, the first from face 0 on; at
  // least one.
  std::uint32_t add_surface(const std::vector<FaceMaterialRun>& runs) {
    surfaces_.push_back(
        {static_cast<std::uint32_t>(runs_.size()), static_cast<std::uint32_t>(runs.size())});
    runs_.insert(runs_.end(), runs.begin(), runs.end());
    return static_cast<std::uint32_t>(surfaces_.size() - 1);
  }
  // Adds a body with this surface: the next one in the order of the world's bodies.
  void add_body(std::uint32_t surface) { surface_of_body_.push_back(surface); }
  void reserve(std::size_t bodies) { surface_of_body_.reserve(bodies); }

  // The material of a face of a body's mesh. The time is logarithmic in the runs of the surface.
  std::int32_t material(std::uint32_t body, std::uint32_t face) const noexcept {
    const Surface& surface = surfaces_[surface_of_body_[body]];
    const FaceMaterialRun* const runs = runs_.data() + surface.first;
    if (surface.count == 1) return runs->material;
    const auto next = std::upper_bound(
        runs, runs + surface.count, face,
        [](std::uint32_t f, const FaceMaterialRun& run) { return f < run.first_face; });
    return next == runs ? runs->material : std::prev(next)->material;
  }
  std::size_t memory_bytes() const {
    return runs_.capacity() * sizeof(FaceMaterialRun) + surfaces_.capacity() * sizeof(Surface) +
           surface_of_body_.capacity() * sizeof(std::uint32_t);
  }

 private:
  struct Surface {
    std::uint32_t first;  // of its runs
    std::uint32_t count;
  };

  std::vector<FaceMaterialRun> runs_;
  std::vector<Surface> surfaces_;
  std::vector<std::uint32_t> surface_of_body_;
};

}  // namespace palpate
