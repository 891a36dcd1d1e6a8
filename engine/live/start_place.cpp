#include "engine/live/start_place.h"

#include <algorithm>
#include <limits>

#include "engine/session/closed_surfaces.h"

namespace palpate {
namespace {

constexpr double kAway = 2.0;  // radii of the sphere

// The distance from p along `away` to the first leg of the path that crosses it. Both lie in the
// plane of the path, whose legs have their walls across them.
double free_m(const HandPath& path, const Vec3& p, const Vec3& away) {
  double nearest_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + 1 < path.points.size(); ++i) {
    const Vec3& a = path.points[i].p_m;
    const Vec3 leg = path.points[i + 1].p_m - a;
    const Vec3& inward = path.points[i].inward;
    const double towards = inward.dot(away);
    if (towards <= 0.0) continue;  // its wall is seen from behind
    const double distance_m = inward.dot(a - p) / towards;
    const double along = (p + distance_m * away - a).dot(leg) / leg.squaredNorm();
    if (distance_m > 0.0 && along >= 0.0 && along <= 1.0) {
      nearest_m = std::min(nearest_m, distance_m);
    }
  }
  return nearest_m;
}

}  // namespace

Result<Vec3> start_place_m(const Scene& scene, const TrialWay& way, double sphere_radius_m) {
  const HandPath& path = way.path;
  const std::size_t leg = leg_at(path.lengths_m(), way.green_along_m);
  const Vec3 away = -path.points[leg].inward;
  const double room_m = free_m(path, way.green_m, away);
  const Vec3 place_m = way.green_m + std::min(kAway * sphere_radius_m, 0.5 * room_m) * away;
  if (const auto object = enclosing_object(scene, place_m)) {
    return Error{ErrorCode::kInvalidContent, "", scene.objects()[*object].name,
                 "encloses the place beside the green sphere where a trial begins; expected room",
                 "move the start of the contour"};
  }
  return place_m;
}

}  // namespace palpate
