#pragma once

// The candidate packs near the proxy, kept from tick to tick.

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "geometry/index/triangle_pack.h"
#include "haptics/proxy/live_world.h"
#include "haptics/proxy/work.h"

namespace palpate {

// Keeps a ball around the proxy; the ball is called the safe zone. Also keeps all packs of bodies
// at rest that come within reach_m of the ball. A step with both ends inside the ball can meet only
// triangles of these packs, so a tick needs no search of the index for such a step. The results are
// the same as with a search.
//
// The size of the ball depends on the density of the surface and not on the speed of the proxy,
// because a ball that grew with the speed would contain half the mesh after a large step.
//
// Points are in the solver frame in metres, except where a name ends in _index. Safe on the haptic
// thread: no allocation, lock or exception. Not thread-safe: one thread owns a cache.
class CandidateCache {
 public:
  // Capacity in packs. The triangles around an apex of 1000 triangles occupy about 65 packs; the
  // capacity is four times this number.
  static constexpr std::size_t kCapacity = 256;

  // reach_m: the distance from the proxy's centre within which a triangle can matter, which is the
  // radius plus the margins. The world must outlive the cache.
  CandidateCache(const LiveWorld& world, double reach_m);

  // Whether both points are inside the ball.
  bool covers(const Vec3& p, const Vec3& q) const noexcept { return covers(p) && covers(q); }
  bool covers(const Vec3& p) const noexcept {
    return (p - centre_).squaredNorm() <= squared_radius_m2_;
  }

  // Whether a refilled ball may contain a step of this length.
  bool may_cover_step(const Vec3& d) const noexcept {
    return d.squaredNorm() <= 4.0 * usual_ball_m_ * usual_ball_m_;
  }

  // Whether a refill at p may succeed, because the last failed refill was not nearby.
  bool may_refill(const Vec3& p) const noexcept {
    return !failed_at_ || (p - *failed_at_).squaredNorm() > 0.25 * usual_ball_m_ * usual_ball_m_;
  }

  // Whether the cache holds no packs. If covers() is true as well, no triangle of a resting body is
  // near the ball.
  bool is_empty() const { return body_count_ == 0; }

  // Searches for the packs of a new ball, which contains p and extends from there in the direction
  // `ahead` of the proxy's motion. Adds its work to `work`. Returns false and leaves the cache
  // empty if too many packs, or too many bodies, are near.
  bool refill(const Vec3& p, const Vec3& ahead, WorkMeter& work) noexcept;

  // Empties the cache. To be called when a body moves for the first time.
  void forget() noexcept {
    squared_radius_m2_ = -1.0;
    body_count_ = 0;
    failed_at_.reset();
  }

  // Writes those cached packs of the n-th body whose boxes come within the reach of the segment p
  // to p + d. Only the part of the segment inside the ball counts. p and d are in the index frame
  // of the body. Returns the number of packs written.
  std::size_t packs_along(std::size_t n, const Vec3& p_index, const Vec3& d_index,
                          std::array<std::uint32_t, kCapacity>& packs) const noexcept;

  std::size_t body_count() const { return body_count_; }
  std::uint32_t body(std::size_t n) const { return bodies_[n].body; }

 private:
  // The packs of each body begin at a new box pack.
  static constexpr std::size_t kBoxPacks = kCapacity / TrianglePack::kLanes;

  struct BodyCandidates {
    std::uint32_t body;
    std::uint32_t first;  // position in packs_, the first lane of a box pack
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
  std::optional<Vec3> failed_at_;    // proxy position of the last refill, if it failed
  std::size_t body_count_ = 0;
  std::array<BodyCandidates, kBoxPacks> bodies_{};
  std::array<std::uint32_t, kCapacity> packs_{};
  std::array<BoxPack, kBoxPacks> boxes_{};  // index frames
};

}  // namespace palpate
