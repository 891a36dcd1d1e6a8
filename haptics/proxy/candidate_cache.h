#pragma once

// Triangles near the proxy, kept from tick to tick.

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "geometry/index/triangle_pack.h"
#include "haptics/proxy/live_world.h"
#include "haptics/proxy/work.h"

namespace palpate {

// Packs, of bodies at rest, that come within a reach of a ball around the proxy: the safe zone.
// Whatever moves inside the ball can only meet triangles of those packs, so a tick need not search
// for them: exact, as long as both ends of a step are inside.
//
// The ball's size goes by the density of the surface, not by the speed of the proxy: a ball that
// grew with the speed would find half the mesh after a leap.
class CandidateCache {
 public:
  // An apex of 1000 triangles is in some 65 packs; room for four times as many.
  static constexpr std::size_t kCapacity = 256;

  // reach_m: how far from the proxy a triangle can matter: its radius and the margins.
  CandidateCache(const LiveWorld& world, double reach_m);

  // Whether both points are inside the ball.
  bool covers(const Vec3& p, const Vec3& q) const noexcept { return covers(p) && covers(q); }
  bool covers(const Vec3& p) const noexcept {
    return (p - centre_).squaredNorm() <= squared_radius_m2_;
  }

  // Whether a refill may cover such a step.
  bool may_cover_step(const Vec3& d) const noexcept {
    return d.squaredNorm() <= 4.0 * usual_ball_m_ * usual_ball_m_;
  }

  // Whether a refill at p may succeed: none has failed near by.
  bool may_refill(const Vec3& p) const noexcept {
    return !failed_at_ || (p - *failed_at_).squaredNorm() > 0.25 * usual_ball_m_ * usual_ball_m_;
  }

  // Whether nothing is near the ball, if there is one.
  bool is_empty() const { return body_count_ == 0; }

  // Searches anew, with a ball that holds p and extends in the direction `ahead`, where the proxy
  // is going. False, with nothing cached, if there are too many packs, or bodies that have none.
  bool refill(const Vec3& p, const Vec3& ahead, WorkMeter& work) noexcept;

  // Nothing is covered any more: one of the bodies has begun to move.
  void forget() noexcept {
    squared_radius_m2_ = -1.0;
    body_count_ = 0;
    failed_at_.reset();
  }

  // The cached packs of the n-th body whose boxes come within the reach of the part of the segment
  // p to p + d that is inside the ball, index frame. Returns how many were written.
  std::size_t packs_along(std::size_t n, const Vec3& p_index, const Vec3& d_index,
                          std::array<std::uint32_t, kCapacity>& packs) const noexcept;

  std::size_t body_count() const { return body_count_; }
  std::uint32_t body(std::size_t n) const { return bodies_[n].body; }

 private:
  // Each body begins a box pack of its own.
  static constexpr std::size_t kBoxPacks = kCapacity / TrianglePack::kLanes;

  struct BodyCandidates {
    std::uint32_t body;
    std::uint32_t first;  // of packs_, at the first lane of a box pack
    std::uint32_t count;
    double reach;     // index frame
    FloatBox around;  // the ball and the reach, rounded outwards; index frame
  };

  bool fill_ball(const Vec3& centre, double radius_m, NearSearch search, WorkMeter& work) noexcept;
  bool add_body(std::uint32_t b, NearSearch search, std::size_t& used) noexcept;
  StretchedBall ball_in_index(const ContactBody& body, const Vec3& centre_body) const noexcept;
  void keep_boxes(const BodyCandidates& candidates) noexcept;

  const LiveWorld* world_;
  double reach_m_;
  double usual_ball_m_;

  Vec3 centre_ = Vec3::Zero();
  double radius_m_ = 0.0;
  double squared_radius_m2_ = -1.0;  // < 0: nothing cached, nothing covered
  std::optional<Vec3> failed_at_;    // where the last refill found too many packs, if it did
  std::size_t body_count_ = 0;
  std::array<BodyCandidates, kBoxPacks> bodies_{};
  std::array<std::uint32_t, kCapacity> packs_{};
  std::array<BoxPack, kBoxPacks> boxes_{};  // index frames
};

}  // namespace palpate
