#pragma once

// A search for the closed surfaces that enclose a point, with counted work.

#include <array>
#include <cstdint>
#include <span>

#include "geometry/index/inside.h"
#include "geometry/mesh/closed_parts.h"
#include "haptics/proxy/live_world.h"
#include "haptics/proxy/work.h"

namespace palpate {

// The search for the closed part of one body that encloses a point: a segment from the point to the
// outside crosses each part that does an odd number of times (inside.h). Of nested shells of one
// mesh, each encloses what is in it, so that a cavity is enclosed as well. Open parts enclose
// nothing. The search can stop at any pack and continue in a later tick.
//
// No allocation, lock or exception; safe on the haptic thread. One thread owns an object.
class EnclosureSearch {
 public:
  enum class Result : std::uint8_t {
    kCutShort,   // the work is spent: call again
    kUndecided,  // the point lies on the surface, or every segment meets an edge
    kOutside,
    kInside
  };

  // Begins with a point of the index frame.
  void begin(const Vec3& p_index) noexcept;
  // Searches on, at least one pack. parts: of the body's mesh; at least one. It and the index must
  // be those of the calls before.
  Result search(const SurfaceIndex& index, const ClosedParts& parts, WorkMeter& work) noexcept;

 private:
  struct Visit;

  void begin_probe(int attempt) noexcept;
  // Returns false if the segment cannot be decided.
  bool count(std::uint32_t part) noexcept;

  Vec3 point_ = Vec3::Zero();
  int attempt_ = 0;
  std::uint32_t next_pack_ = 0;  // all packs before it have been searched
  bool is_undecided_ = false;
  std::uint32_t crossings_ = 0;
  // The parts that were crossed, each with the parity of its crossings.
  std::array<std::uint32_t, kMostCrossings> crossed_{};
  std::array<bool, kMostCrossings> is_odd_{};
  std::size_t crossed_count_ = 0;
};

// Finds a body that encloses a point, among all bodies of a world. The point may move while the
// search goes on, as long as it crosses no surface: each body is tested where point and body are at
// that time. Bodies may move.
//
// As EnclosureSearch.
class EnclosingBodySearch {
 public:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  enum class State : std::uint8_t { kSearches, kOutside, kInside };

  // parts: one per body, none of them null; they outlive the search.
  explicit EnclosingBodySearch(std::span<const ClosedParts* const> parts) : parts_(parts) {}

  // Begins again.
  void begin() noexcept;
  State search(const LiveWorld& world, const Vec3& p_solver, WorkMeter& work) noexcept;
  // The body that encloses the point; kNone until the search has found one.
  std::uint32_t body() const noexcept { return found_; }

 private:
  bool test(const LiveWorld& world, std::uint32_t body, const Vec3& p_solver,
            WorkMeter& work) noexcept;
  bool test_resting(const LiveWorld& world, const Vec3& p_solver, WorkMeter& work) noexcept;
  bool test_moving(const LiveWorld& world, const Vec3& p_solver, WorkMeter& work) noexcept;

  std::span<const ClosedParts* const> parts_;
  EnclosureSearch search_;
  std::uint32_t tested_ = kNone;   // the body whose test was cut short
  bool are_resting_done_ = false;  // only moving bodies are left
  std::uint32_t next_ = 0;         // body, then index into the moving bodies
  std::uint32_t found_ = kNone;
};

}  // namespace palpate
