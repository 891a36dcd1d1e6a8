#include "haptics/strategies/nearest_place.h"

#include <algorithm>
#include <span>

#include "geometry/index/pack_queries.h"

namespace palpate {
namespace {

// Without a last q, balls of growing radius are searched, so that a near surface is found without
// the packs that are farther away. The first radius is this part of the reach; each next one has
// twice the radius of the one before.
constexpr double kFirstPart = 1.0 / 16;

SurfacePlace place_on(const ContactBody& body, const FaceRef& face, const TriangleGeometry& t,
                      const Vec3& p_body) {
  const TrianglePoint nearest = closest_point_on_triangle(t, p_body);
  return {face, body.to_solver(nearest.point), body.direction_to_solver(nearest.direction),
          body.length_to_solver(nearest.distance)};
}

// One search. Faces are visited in ascending order, first of the bodies at rest and then of those
// that have moved; among equally near faces, the first one counts.
class PlaceSearch {
 public:
  PlaceSearch(const LiveWorld& world, const Vec3& p, WorkMeter& work)
      : world_(world), p_(p), work_(work) {}

  // The last q, now at `q`, slides by at most slide_m. place: on the face of the last q.
  void begin_at(const SurfacePlace& place, const Vec3& q, double slide_m) {
    nearest = slid = place;
    q_ = q;
    slide_m_ = slide_m;
  }

  // Considers all faces within reach_m of p. False if the budget was spent.
  bool run(double reach_m) {
    reach_m_ = reach_m;
    work_.add(world_.visit_resting_near(p_, reach_m, NearSearch::kInOrder,
                                        [&](std::uint32_t b) { return visit_body(b); }));
    for (const std::uint32_t b : world_.moving()) visit_body(b);
    return !work_.is_spent();
  }

  std::optional<SurfacePlace> nearest;
  std::optional<SurfacePlace> slid;  // the nearest place to which the last q can slide

 private:
  // False to end the search.
  bool visit_body(std::uint32_t b) {
    work_.add(Work::kBody);
    body_ = &world_.body(b);
    body_number_ = b;
    p_body_ = body_->to_body(p_);
    const Vec3 p_index = body_->to_index(p_body_);
    const double reach = body_->reach_index(reach_m_, p_body_);
    if (body_->index->box().squared_distance(p_index) > reach * reach) return !work_.is_spent();
    const QueryWork query = body_->index->visit_packs_near(
        p_index, reach, 0,
        [](void* search, std::span<const std::uint32_t> packs) {
          return std::all_of(packs.begin(), packs.end(), [&](std::uint32_t pack) {
            return static_cast<PlaceSearch*>(search)->visit_pack(pack);
          });
        },
        this);
    work_.add(query);
    return !work_.is_spent();
  }

  bool visit_pack(std::uint32_t id) {
    work_.add(Work::kPack);
    const TrianglePack& pack = body_->index->pack(id);
    std::uint32_t lanes = (1u << pack.count) - 1;
    if (!body_->stretch) {
      LaneDistances distances;
      lanes &= lanes_within(pack, p_body_, body_->length_to_body(farthest_m()), distances);
    }
    while (lanes != 0) {
      work_.add(Work::kNearestPoint);
      if (body_->stretch) work_.add(Work::kStretchedTriangle);
      const FaceRef face{body_number_, SurfaceIndex::slot(id, take_lane(lanes))};
      TriangleGeometry buffer;
      consider(place_on(*body_, face, body_->triangle(face.slot, buffer), p_body_));
    }
    return !work_.is_spent();
  }

  // No face beyond this distance can be a result.
  double farthest_m() const {
    const double to_best_m = slid ? slid->distance_m : nearest ? nearest->distance_m : reach_m_;
    return std::min(reach_m_, to_best_m);
  }

  void consider(const SurfacePlace& place) {
    if (place.distance_m > reach_m_) return;
    if (!nearest || place.distance_m < nearest->distance_m) nearest = place;
    if (!slid || !(place.distance_m < slid->distance_m)) return;
    if ((place.point_m - q_).squaredNorm() <= slide_m_ * slide_m_) slid = place;
  }

  const LiveWorld& world_;
  Vec3 p_;
  WorkMeter& work_;
  double reach_m_ = 0.0;
  Vec3 q_ = Vec3::Zero();
  double slide_m_ = 0.0;

  const ContactBody* body_ = nullptr;  // the body that is visited
  std::uint32_t body_number_ = 0;
  Vec3 p_body_ = Vec3::Zero();
};

}  // namespace

std::optional<SurfacePlace> NearestPlace::update(const LiveWorld& world, const Vec3& p,
                                                 double reach_m, WorkMeter& work) noexcept {
  PlaceSearch search(world, p, work);
  bool is_complete = true;
  if (held_) {
    const ContactBody& body = world.body(held_->face.body);
    const Vec3 p_body = body.to_body(p);
    TriangleGeometry buffer;
    const SurfacePlace place =
        place_on(body, held_->face, body.triangle(held_->face.slot, buffer), p_body);
    const double moved_m = body.length_to_solver((p_body - held_->p_body).norm());
    const double rounding_m = SolverScale::kStandOffPerSize * world.size_m();
    search.begin_at(place, body.to_solver(held_->q_body), kSlide * moved_m + rounding_m);
    is_complete = search.run(std::min(reach_m, place.distance_m));
  } else {
    double radius_m = kFirstPart * reach_m;
    while ((is_complete = search.run(radius_m)) && !search.nearest && radius_m < reach_m) {
      radius_m = std::min(2.0 * radius_m, reach_m);
    }
  }
  is_cut_short_ = !is_complete;
  if (is_cut_short_) return std::nullopt;
  held_.reset();
  if (!search.nearest) return std::nullopt;
  const bool keeps =
      search.slid && search.slid->distance_m <= search.nearest->distance_m + kNearer_m;
  const SurfacePlace& place = keeps ? *search.slid : *search.nearest;
  if (place.distance_m > reach_m) return std::nullopt;
  const ContactBody& body = world.body(place.face.body);
  held_ = Held{place.face, body.to_body(place.point_m), body.to_body(p)};
  return place;
}

}  // namespace palpate
