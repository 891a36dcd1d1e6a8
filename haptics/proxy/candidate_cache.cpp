#include "haptics/proxy/candidate_cache.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/index/pack_queries.h"

namespace palpate {
namespace {

constexpr std::uint32_t kLanes = TrianglePack::kLanes;

// Radius of the ball, in mean pack diagonals.
constexpr double kBallPerPackDiagonal = 0.6;

// Distance from the proxy to the centre of the ball ahead of it, in radii. The proxy then has 1.5
// radii in front of it and half a radius behind it.
constexpr double kLead = 0.5;

// Largest number of bodies whose boxes are near a ball, whether they have packs there or not.
constexpr std::size_t kMostBodies = 256;

// A refill that finds too many packs halves the radius of the ball at most this many times.
constexpr int kMostRadiusHalvings = 4;

// Rounding to float, outwards from a box. The margin is two ulp, of which the conversion uses half
// an ulp; values that underflow are moved beyond the smallest normal number.
constexpr float kTwoUlp = 0x1p-22f;
constexpr float kSmallest = std::numeric_limits<float>::min();
float round_low(double x) {
  const auto rounded = static_cast<float>(x);
  return rounded - std::abs(rounded) * kTwoUlp - kSmallest;
}
float round_high(double x) {
  return -round_low(-x);
}

double finest_pack_diagonal(const LiveWorld& world) {
  double finest = world.size_m();
  for (const ContactBody& body : world.bodies()) {
    if (body.index->pack_count() > 0) {
      const double diagonal = body.index->mean_pack_diagonal_m();
      finest = std::min(finest, body.stretch ? body.stretch->mean_length_m(diagonal)
                                             : body.length_to_solver(diagonal));
    }
  }
  return finest;
}

}  // namespace

CandidateCache::CandidateCache(const LiveWorld& world, double reach_m)
    : world_(&world),
      reach_m_(reach_m),
      usual_ball_m_(kBallPerPackDiagonal * finest_pack_diagonal(world)) {}

bool CandidateCache::refill(const Vec3& p, const Vec3& ahead, WorkMeter& work) noexcept {
  if (!may_refill(p)) return false;
  failed_at_.reset();
  const double length = ahead.norm();
  const Vec3 direction = length > 0.0 ? Vec3(ahead / length) : Vec3(Vec3::Zero());
  double radius = usual_ball_m_;
  auto search = NearSearch::kWithEmbree;
  for (int halving = 0; halving <= kMostRadiusHalvings; ++halving, radius *= 0.5) {
    if (fill_ball(p + kLead * radius * direction, radius, search, work)) return true;
    search = NearSearch::kInOrder;
  }
  forget();
  failed_at_ = p;
  return false;
}

bool CandidateCache::fill_ball(const Vec3& centre, double radius_m, NearSearch search,
                               WorkMeter& work) noexcept {
  centre_ = centre;
  radius_m_ = radius_m;
  squared_radius_m2_ = radius_m * radius_m;
  body_count_ = 0;
  std::size_t used = 0;
  // Few bodies are all queried; many bodies are first excluded by their boxes.
  const bool are_many = world_->bodies().size() > kMostBodies;
  std::size_t seen = 0;
  std::size_t entered = 0;
  bool fits = true;
  const auto visit = [&](std::uint32_t b) {
    ++seen;
    if (are_many) {
      const ContactBody& body = world_->body(b);
      const Vec3 centre_body = body.to_body(centre);
      const double reach = body.reach_index(radius_m + reach_m_, centre_body);
      const double squared = body.index->box().squared_distance(body.to_index(centre_body));
      if (squared > reach * reach) return true;
      ++entered;
    }
    fits = entered <= kMostBodies && add_body(b, search, used);
    return fits;
  };
  work.add(world_->visit_resting_near(centre, radius_m + reach_m_, search, visit));
  work.add(Work::kBodySeen, seen);
  work.add(Work::kBody, are_many ? entered : body_count_);
  work.add(Work::kPackListed, fits ? used : kCapacity);
  return fits;
}

// Adds the packs of one body that are near the ball. False if they exceed the capacity.
bool CandidateCache::add_body(std::uint32_t b, NearSearch search, std::size_t& used) noexcept {
  const ContactBody& body = world_->body(b);
  const Vec3 centre_body = body.to_body(centre_);
  const Vec3 centre = body.to_index(centre_body);
  const StretchedBall ball = ball_in_index(body, centre_body);
  const std::span<std::uint32_t> unused = std::span(packs_).subspan(used);
  const std::size_t count = body.stretch
                                ? body.index->packs_near(centre, ball, unused, search)
                                : body.index->packs_near(centre, ball.radius_m, unused, search);
  if (count > unused.size()) return false;
  if (count == 0) return true;
  BodyCandidates& candidates = bodies_[body_count_];
  candidates.body = b;
  candidates.first = static_cast<std::uint32_t>(used);
  candidates.count = static_cast<std::uint32_t>(count);
  candidates.reach = body.reach_index(
      reach_m_, centre_body.cwiseAbs() + Vec3::Constant(body.length_to_body(radius_m_)));
  for (int k = 0; k < 3; ++k) {
    candidates.around.low[k] = round_low(centre[k] - ball.by_axis_m[k]);
    candidates.around.high[k] = round_high(centre[k] + ball.by_axis_m[k]);
  }
  keep_boxes(candidates);
  ++body_count_;
  used = (used + count + kLanes - 1) / kLanes * kLanes;
  return true;
}

// The ball and the reach in the index frame of a body.
StretchedBall CandidateCache::ball_in_index(const ContactBody& body,
                                            const Vec3& centre_body) const noexcept {
  const double reach_m = radius_m_ + reach_m_;
  if (body.stretch) return body.stretch->ball_index(reach_m, centre_body);
  const double reach = body.length_to_body(reach_m);
  return {reach, Vec3::Constant(reach)};
}

void CandidateCache::keep_boxes(const BodyCandidates& candidates) noexcept {
  const float infinity = std::numeric_limits<float>::infinity();
  const SurfaceIndex& index = *world_->body(candidates.body).index;
  for (std::uint32_t i = 0; i < candidates.count || i % kLanes != 0; ++i) {
    BoxPack& to = boxes_[(candidates.first + i) / kLanes];
    const std::uint32_t lane = i % kLanes;
    if (i >= candidates.count) {
      to.low[0][lane] = infinity;
      continue;
    }
    const std::uint32_t id = packs_[candidates.first + i];
    const BoxPack& from = index.cluster_boxes(id / kLanes);
    for (int k = 0; k < 3; ++k) {
      to.low[k][lane] = from.low[k][id % kLanes];
      to.high[k][lane] = from.high[k][id % kLanes];
    }
    index.prefetch_pack(id);
  }
}

std::size_t CandidateCache::packs_along(
    std::size_t n, const Vec3& p_index, const Vec3& d_index,
    std::array<std::uint32_t, kCapacity>& packs) const noexcept {
  const BodyCandidates& candidates = bodies_[n];
  const std::size_t first_box_pack = candidates.first / kLanes;
  const std::size_t box_packs = (candidates.count + kLanes - 1) / kLanes;
  const std::size_t found =
      boxes_along(std::span(boxes_).subspan(first_box_pack, box_packs), p_index, d_index,
                  candidates.reach, candidates.around, packs.data());
  for (std::size_t i = 0; i < found; ++i) packs[i] = packs_[candidates.first + packs[i]];
  return found;
}

}  // namespace palpate
