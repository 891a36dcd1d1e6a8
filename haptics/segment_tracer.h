#pragma once

// Continuous collision of the proxy along a straight step.

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "geometry/triangle.h"
#include "haptics/accuracy.h"
#include "haptics/contact_world.h"

namespace palpate {

// Names one triangle of the world.
struct FaceRef {
  std::uint32_t body = 0;
  std::uint32_t pack = 0;
  std::uint32_t lane = 0;
  friend bool operator==(const FaceRef&, const FaceRef&) = default;
};

// A contact plane of a face at some proxy position. Solver frame, metres.
struct FaceContact {
  FaceRef face;
  Vec3 normal;         // unit, from the surface to the proxy
  double clearance_m;  // of the proxy's surface above the face, along the normal
  TriangleFeature feature = TriangleFeature::kFace;
  Vec3 feature_point;  // the point touched
};

// Where a step is stopped.
struct TraceHit {
  FaceContact contact;   // at the stopping point
  double fraction;       // of the step that may be taken, in [0, 1]
  double meet_fraction;  // of the step at which proxy and face would meet, >= fraction
};

// Answers "how far can the proxy go" against every triangle of a world. Points and spheres.
//
// A step without a hit is certified: no triangle touches the swept proxy, up to a rounding bound
// that errs on the side of a hit. A step that is stopped is cut short by the stand-off, so what
// remains of it is certified as well.
//
// Triangles are taken from a cache of the packs within a ball around the proxy while the step stays
// inside that ball, and from a segment query otherwise. No allocation, lock or exception. One
// instance serves one thread.
class SegmentTracer {
 public:
  // The world must outlive the tracer. radius_m >= 0; the world's indices must have been built for
  // sweeps of at least radius_m + the stand-off.
  SegmentTracer(const ContactWorld& world, double radius_m, const Accuracy& accuracy = {});

  // The first obstacle of the proxy on its way from p to p + d.
  std::optional<TraceHit> trace(const Vec3& p, const Vec3& d) noexcept;

  // The contact of a proxy at p with one face, on the side given by the earlier normal.
  FaceContact contact_at(const FaceRef& face, const Vec3& p, const Vec3& side) const noexcept;

  // True iff p lies over the face (its prism), or over the edge or vertex that it touches.
  bool is_over(const FaceContact& contact, const Vec3& p) const noexcept;

  // Contacts of a proxy at p with the faces closer than reach_m, seen from their fronts.
  // Returns how many were written, at most contacts.size().
  std::size_t contacts_near(const Vec3& p, double reach_m,
                            std::span<FaceContact> contacts) const noexcept;

  const SolverScale& scale() const { return scale_; }
  double radius_m() const { return radius_m_; }

 private:
  // An apex of 1000 triangles is in 125 packs; this is as much again.
  static constexpr std::size_t kCacheCapacity = 256;

  struct CachedPack {
    std::uint32_t body;
    std::uint32_t pack;
  };
  struct Search;

  bool fill_cache(const Vec3& p, const Vec3& d) noexcept;
  void search_cache(Search& search) const noexcept;
  void search_segment(Search& search) const noexcept;

  const ContactWorld* world_;
  double radius_m_;
  SolverScale scale_;
  Accuracy accuracy_;
  double default_ball_m_;

  std::array<CachedPack, kCacheCapacity> cached_packs_{};
  std::size_t cached_count_ = 0;
  Vec3 ball_centre_ = Vec3::Zero();
  double ball_radius_m_ = -1.0;  // < 0: nothing cached
};

}  // namespace palpate
