// The contacts of a proxy at a position: see segment_tracer.h.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "geometry/index/pack_queries.h"
#include "haptics/proxy/segment_tracer.h"

namespace palpate {
namespace {

// Limits of a search for contacts around a point: the number of bodies at rest, and the number of
// packs of all bodies. The search considers those with the lowest numbers.
constexpr std::size_t kMostBodiesAround = 64;
constexpr std::size_t kMostPacksAround = 256;
// Limit of the bodies whose boxes the search meets, near or not.
constexpr std::size_t kMostSeenAround = 1024;

// A search for contacts around a point is never cut short if it begins before this fraction (1/4)
// of the budget is used: its work is limited, and the next tick can continue after it.
constexpr WorkUnits kBeginsAroundPart = 4;

// Keeps the contacts nearest to a point p, as many as `storage` can hold.
class NearestContacts {
 public:
  NearestContacts(const Vec3& p, std::span<FaceContact> storage) : p_(p), storage_(storage) {}

  void add(const FaceContact& contact) {
    const auto is_nearer = [this](const FaceContact& a, const FaceContact& b) {
      return (a.feature_point - p_).squaredNorm() < (b.feature_point - p_).squaredNorm();
    };
    if (count_ < storage_.size()) {
      storage_[count_++] = contact;
      if (count_ == storage_.size()) std::make_heap(storage_.begin(), storage_.end(), is_nearer);
      return;
    }
    if (!is_nearer(contact, storage_.front())) return;
    std::pop_heap(storage_.begin(), storage_.end(), is_nearer);
    storage_.back() = contact;
    std::push_heap(storage_.begin(), storage_.end(), is_nearer);
  }

  std::size_t count() const { return count_; }

 private:
  Vec3 p_;
  std::span<FaceContact> storage_;
  std::size_t count_ = 0;
};

}  // namespace

FaceContact SegmentTracer::nearest_contact(const FaceRef& face, const Vec3& p) const noexcept {
  work_.add_of_solver(Work::kContact);
  const auto [frame, t] = seat_of(face);
  const TrianglePoint nearest = closest_point_on_triangle(t, frame.to_body(p));
  FaceContact contact{face, frame.direction_to_solver(nearest.direction),
                      frame.length_to_solver(nearest.distance) - radius_m_, nearest.feature,
                      frame.to_solver(nearest.point)};
  const bool is_at_corners = &frame == &solver_frame_;
  if (is_at_corners && contact.feature == TriangleFeature::kEdge) {
    contact.normal = across_edge(contact);
  }
  return contact;
}

Vec3 SegmentTracer::edge_direction(const FaceContact& contact) const noexcept {
  work_.add_of_solver(Work::kContact);
  const auto [frame, t] = seat_of(contact.face);
  const Vec3 p_frame = frame.to_body(contact.feature_point);
  Vec3 nearest = Vec3::Zero();
  double least = std::numeric_limits<double>::infinity();
  for (const auto& [from, to] : {std::pair(t.a, t.b), std::pair(t.b, t.c), std::pair(t.c, t.a)}) {
    const Vec3 direction = (to - from).normalized();
    const double distance = (p_frame - from).cross(direction).norm();
    if (distance >= least) continue;
    least = distance;
    nearest = direction;
  }
  return frame.direction_to_solver(nearest);
}

FaceContact SegmentTracer::contact_at(const FaceRef& face, const Vec3& p,
                                      const Vec3& side) const noexcept {
  const FaceContact nearest = nearest_contact(face, p);
  if (radius_m_ > 0.0) return nearest;
  const auto [frame, t] = seat_of(face);
  if (!is_rather_over(t, frame.direction_to_body(nearest.normal))) return nearest;
  const bool can_tell = nearest.clearance_m >= scale_.clearance_m;
  FaceContact contact = contact_over(face, p, can_tell ? nearest.normal : side);
  contact.feature = nearest.feature;
  return contact;
}

FaceContact SegmentTracer::contact_over(const FaceRef& face, const Vec3& p,
                                        const Vec3& side) const noexcept {
  work_.add_of_solver(Work::kContact);
  const auto [frame, t] = seat_of(face);
  const Vec3 p_frame = frame.to_body(p);
  const bool is_front = t.normal.dot(frame.direction_to_body(side)) >= 0.0;
  const Vec3 normal = is_front ? t.normal : Vec3(-t.normal);
  const double height = normal.dot(p_frame - t.a);
  return {face, frame.direction_to_solver(normal), frame.length_to_solver(height),
          TriangleFeature::kFace, frame.to_solver(p_frame - height * normal)};
}

std::optional<FaceContact> SegmentTracer::contact_over_next(const FaceRef& left, const Vec3& p,
                                                            const Vec3& q) noexcept {
  const ContactBody& body = world_->body(left.body);
  const Vec3 p_body = body.to_body(p);
  const Vec3 q_body = body.to_body(q);
  const std::uint32_t pack = left.slot / TrianglePack::kLanes;
  work_.add(Work::kPack);
  PackLanes near;
  if (lanes_in_the_way(body.index->packs(), {&pack, 1}, body.to_index(p_body),
                       body.to_index(q_body - p_body), body.reach_index(0.0, p_body), &near) == 0) {
    return {};
  }
  std::optional<FaceContact> nearest;
  while (near.lanes != 0) {
    const FaceRef face{left.body, SurfaceIndex::slot(pack, take_lane(near.lanes))};
    const auto [frame, t] = seat_of(face);
    const Vec3 p_frame = frame.to_body(p);
    const double height = t.normal.dot(p_frame - t.a);
    const double height_m = frame.length_to_solver(height);
    const bool is_between = height * t.normal.dot(frame.to_body(q) - t.a) < 0.0;
    if (!is_between || std::abs(height_m) < scale_.clearance_m || !prism_contains(t, p_frame)) {
      continue;
    }
    if (nearest && nearest->clearance_m <= std::abs(height_m)) continue;
    const Vec3 side = height_m < 0.0 ? Vec3(-t.normal) : t.normal;
    nearest = contact_over(face, p, frame.direction_to_solver(side));
  }
  return nearest;
}

bool SegmentTracer::is_over(const FaceContact& contact, const Vec3& p) const noexcept {
  if (radius_m_ > 0.0) {
    // A sphere that still touches the face is held here as well by the tangent plane that stopped
    // it.
    return contact_at(contact.face, p, contact.normal).clearance_m <= scale_.stand_off_m;
  }
  if (contact.feature != TriangleFeature::kFace) return false;
  const auto [frame, t] = seat_of(contact.face);
  return prism_contains(t, frame.to_body(p));
}

std::size_t SegmentTracer::contacts_in_front(const Vec3& p, double reach_m,
                                             std::span<FaceContact> contacts) noexcept {
  NearestContacts nearest(p, contacts);
  // A search that begins with most of the budget left is completed even if it exceeds the budget.
  may_stop_around_ = kBeginsAroundPart * work_.used() > work_.budget();
  std::size_t packs_left = kMostPacksAround;
  std::size_t bodies_left = kMostBodiesAround;
  std::size_t seen_left = accuracy_.counting == CountingRule::kFirst
                              ? std::numeric_limits<std::size_t>::max()
                              : kMostSeenAround;
  const auto add = [&](const FaceContact& contact) { nearest.add(contact); };
  const auto visit = [&](std::uint32_t b) {
    work_.add(Work::kBodySeen);
    const ContactBody& body = world_->body(b);
    const Vec3 p_body = body.to_body(p);
    const double reach = body.reach_index(reach_m, p_body);
    if (body.index->box().squared_distance(body.to_index(p_body)) > reach * reach) {
      return --seen_left > 0;
    }
    visit_contacts(b, p, reach_m, packs_left, add);
    return --bodies_left > 0 && packs_left > 0 && !is_cut_short_;
  };
  work_.add(world_->visit_resting_near(p, reach_m, NearSearch::kInOrder, visit));
  for (const std::uint32_t b : world_->moving()) visit_contacts(b, p, reach_m, packs_left, add);
  return nearest.count();
}

template <typename Visitor>
void SegmentTracer::visit_contacts(std::uint32_t b, const Vec3& p, double reach_m,
                                   std::size_t& packs_left, const Visitor& visit) noexcept {
  if (packs_left == 0 || is_cut_short_) return;
  const ContactBody& body = world_->body(b);
  const Vec3 p_body = body.to_body(p);
  const bool is_at_corners = has_contacts_at_corners(body);
  const double apart_m = is_at_corners ? kMostApartPerStandOff * scale_.stand_off_m : 0.0;
  work_.add(Work::kBody);
  const auto consider_pack = [&](std::uint32_t pack) {
    const int count = body.index->pack(pack).count;
    if (may_stop_around_ && work_.is_spent()) {
      memory_->progress.reset();  // this search is not a trace that can be resumed
      is_cut_short_ = true;
      return false;
    }
    work_.add(Work::kPack);
    work_.add(Work::kNearestPoint, static_cast<std::size_t>(count));
    if (body.stretch) work_.add(Work::kStretchedTriangle, static_cast<std::size_t>(count));
    for (int lane = 0; lane < count; ++lane) {
      const FaceRef face{b, SurfaceIndex::slot(pack, lane)};
      TriangleGeometry buffer;
      const auto [frame, t] =
          is_at_corners ? seat_of(face) : Seat{body, body.triangle(face.slot, buffer)};
      const Vec3 p_frame = frame.to_body(p);
      const TrianglePoint nearest = closest_point_on_triangle(t, p_frame);
      if (nearest.distance > frame.length_to_body(reach_m)) continue;
      visit({face, frame.direction_to_solver(t.normal),
             frame.length_to_solver(t.normal.dot(p_frame - t.a)), TriangleFeature::kFace,
             frame.to_solver(nearest.point)});
    }
    return --packs_left > 0;
  };
  using ConsiderPack = decltype(consider_pack);
  count(body.index->visit_packs_near(
      body.to_index(p_body), body.reach_index(reach_m + apart_m, p_body), 0,
      [](void* state, std::span<const std::uint32_t> packs) {
        return std::all_of(packs.begin(), packs.end(), *static_cast<ConsiderPack*>(state));
      },
      const_cast<void*>(static_cast<const void*>(&consider_pack))));
}

std::size_t SegmentTracer::contacts_around(const Vec3& p, double reach_m,
                                           std::span<FaceContact> contacts) noexcept {
  const std::size_t count = contacts_in_front(p, reach_m, contacts);
  for (FaceContact& contact : contacts.first(count)) {
    if (contact.clearance_m >= 0.0) continue;
    contact.normal = -contact.normal;
    contact.clearance_m = -contact.clearance_m;
  }
  return count;
}

}  // namespace palpate
