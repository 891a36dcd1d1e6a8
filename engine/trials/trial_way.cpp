#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include "engine/simulation/contour_path.h"
#include "engine/simulation/path_plan.h"
#include "engine/simulation/reachable_outlines.h"
#include "engine/trials/contour_place.h"
#include "engine/trials/trial.h"
#include "engine/trials/trial_clock.h"
#include "geometry/mesh/collinear_runs.h"

namespace palpate {
namespace {

// A contact moves the place on the contour by up to kReach_m: two contacts could pass the least
// part of a shorter way.
constexpr double kShortestWay_m = 2.0 * ContourPlace::kReach_m / TrialClock::kLeastWay;

// Detail of the contour below this share of a sphere's radius is left out.
constexpr double kDetail = 1.0 / 64;
// Gaps of the contour below this share are closed.
constexpr double kGap = 1.0 / 8;

// Where the file states no spheres: their distance from the middle of the longest wall, and its
// largest share of a short wall.
constexpr double kFromMiddle_m = 10e-3;
constexpr double kMostOfWall = 0.25;

// The path begins this far before the green sphere, so that contacts before the centre lie on it;
// at most this share of the contour.
constexpr double kLeadIn_m = 30e-3;
constexpr double kMostLeadIn = 0.25;

// A closed curve with the length up to each of its points, and up to its end.
class ClosedCurve {
 public:
  explicit ClosedCurve(std::vector<Vec3> points_m) : points_m_(std::move(points_m)) {
    lengths_m_.push_back(0.0);
    for (std::size_t i = 0; i < points_m_.size(); ++i) {
      lengths_m_.push_back(lengths_m_.back() + (next(i) - points_m_[i]).norm());
    }
  }

  struct Place {
    double along_m;
    double distance_m;
  };
  Place nearest(const Vec3& p) const {
    Place found{0.0, (p - points_m_.front()).norm()};
    for (std::size_t i = 0; i < points_m_.size(); ++i) {
      const double length_m = lengths_m_[i + 1] - lengths_m_[i];
      if (length_m == 0.0) continue;
      const Vec3 tangent = (next(i) - points_m_[i]) / length_m;
      const double at_m = std::clamp((p - points_m_[i]).dot(tangent), 0.0, length_m);
      const double distance_m = (p - points_m_[i] - at_m * tangent).norm();
      if (distance_m < found.distance_m) found = {lengths_m_[i] + at_m, distance_m};
    }
    return found;
  }
  double length_m() const { return lengths_m_.back(); }
  std::size_t longest_leg() const {
    std::size_t longest = 0;
    for (std::size_t i = 0; i < points_m_.size(); ++i) {
      if (leg_m(i) > leg_m(longest)) longest = i;
    }
    return longest;
  }
  double leg_m(std::size_t i) const { return lengths_m_[i + 1] - lengths_m_[i]; }
  double leg_begins_m(std::size_t i) const { return lengths_m_[i]; }

  Vec3 at(double along_m) const {
    const double at_m = wrapped(along_m);
    const std::size_t i = leg_at(lengths_m_, at_m);
    return points_m_[i] + (at_m - lengths_m_[i]) * (next(i) - points_m_[i]).normalized();
  }
  double wrapped(double along_m) const {
    return along_m - length_m() * std::floor(along_m / length_m());
  }

  // Once round and more: from a place, over `more_m` more than the whole length.
  std::vector<Vec3> opened_at(double from_m, double more_m) const {
    std::vector<Vec3> open{at(from_m)};
    const double first_m = wrapped(from_m);
    const std::size_t n = points_m_.size();
    const double end_m = first_m + length_m() + more_m;
    for (std::size_t k = leg_at(lengths_m_, first_m) + 1;; ++k) {
      const double along_m = lengths_m_[k % n] + static_cast<double>(k / n) * length_m();
      if (along_m >= end_m) break;
      if (along_m > first_m) open.push_back(points_m_[k % n]);
    }
    open.push_back(at(end_m));
    return open;
  }

 private:
  const Vec3& next(std::size_t i) const { return points_m_[(i + 1) % points_m_.size()]; }
  std::vector<Vec3> points_m_;
  std::vector<double> lengths_m_;
};

struct Spheres {
  double green_m, red_m;  // along the curve
};

Error no_way(const std::string& element, const std::string& problem, const std::string& hint) {
  return {ErrorCode::kInvalidArgument, "", element, problem, hint};
}

Spheres on_longest_wall(const ClosedCurve& curve) {
  const std::size_t wall = curve.longest_leg();
  const double from_middle_m = std::min(kFromMiddle_m, kMostOfWall * curve.leg_m(wall));
  const double middle_m = curve.leg_begins_m(wall) + 0.5 * curve.leg_m(wall);
  return {middle_m + from_middle_m, middle_m - from_middle_m};
}

Result<Spheres> as_stated(const ClosedCurve& curve, const ContourDescription& stated,
                          const Vec3& plane_normal, double plane_offset_m, double radius_m) {
  Spheres spheres{};
  for (const bool is_green : {true, false}) {
    Vec3 p = is_green ? stated.start_scene_m : stated.end_scene_m;
    p -= (plane_normal.dot(p) - plane_offset_m) * plane_normal;
    const ClosedCurve::Place place = curve.nearest(p);
    if (place.distance_m > radius_m) {
      std::ostringstream problem;
      problem << (is_green ? "start_m" : "end_m") << " is " << place.distance_m
              << " m from the contour in the plane of the device; expected at most " << radius_m
              << " m, the radius of the sphere";
      return no_way(stated.element, problem.str(), "move the point onto the contour");
    }
    (is_green ? spheres.green_m : spheres.red_m) = place.along_m;
  }
  return spheres;
}

// The outline on which the spheres lie: the nearest to the stated start, or else the longest.
const Outline& chosen_outline(const std::vector<Outline>& found,
                              const std::optional<Vec3>& start_scene_m) {
  if (!start_scene_m) return found.front();
  const auto distance_m = [&](const Outline& outline) {
    return ClosedCurve(outline.curve.points_m).nearest(*start_scene_m).distance_m;
  };
  return *std::min_element(found.begin(), found.end(), [&](const Outline& a, const Outline& b) {
    return distance_m(a) < distance_m(b);
  });
}

// The contour that the scene states; null if it states none.
Result<const ContourDescription*> stated_contour(const Scene& scene) {
  const std::vector<ContourDescription>& stated = scene.contours();
  if (stated.empty()) return static_cast<const ContourDescription*>(nullptr);
  if (stated.size() > 1) {
    return no_way(stated[1].element, "is the second contour of the scene; expected one",
                  "load one node, or delete the others");
  }
  const ContourDescription& contour = stated.front();
  if (!contour.problem.empty()) return no_way(contour.element, contour.problem, contour.hint);
  return &contour;
}

// The contour on which the spheres lie, in the plane of the device, without small detail.
Result<ClosedCurve> find_curve(const Scene& scene, const RunSetup& setup,
                               const ContourDescription* stated, const Vec3& plane_normal,
                               double radius_m) {
  const auto found =
      reachable_outlines(scene, setup.haptics.initial_pose, setup.haptics.plane_height_m,
                         kGap * radius_m, setup.haptics.god_object.radius_m);
  if (!found) return found.error();
  std::optional<Vec3> start_m;
  if (stated) start_m = stated->start_scene_m;
  const Outline& outline = chosen_outline(*found, start_m);
  if (!outline.curve.closed) {
    return no_way("scene", "has an open contour in the plane of the device; expected a closed one",
                  "close the mesh, or choose another plane height");
  }
  std::vector<Vec3> points =
      without_collinear_points(outline.curve.points_m, true, plane_normal, kDetail * radius_m);
  if (points.size() < 2) {
    return no_way("scene", "has a contour that is smaller than the spheres", "enlarge the scene");
  }
  return ClosedCurve(std::move(points));
}

// Refuses a way from the green to the red sphere that is too short.
std::optional<Error> check_way(double way_m, const ClosedCurve& curve,
                               const ContourDescription* stated) {
  std::ostringstream problem;
  if (way_m < 0.5 * curve.length_m()) {
    problem << "states a way of " << way_m << " m from start_m to end_m with material on the left; "
            << "expected the long way round the contour of " << curve.length_m() << " m";
    return no_way(stated->element, problem.str(), "swap start_m and end_m");
  }
  if (way_m < kShortestWay_m) {
    problem << "has a way of " << way_m << " m from the green to the red sphere; expected at least "
            << kShortestWay_m << " m";
    return no_way("scene", problem.str(), "enlarge the scene");
  }
  return std::nullopt;
}

}  // namespace

Result<TrialWay> find_trial_way(const Scene& scene, const RunSetup& setup,
                                const TrialSettings& settings) {
  if (!setup.actuation.is_planar()) {
    return no_way("device.sensors", "is 3; expected 2", "a trial follows a contour in a plane");
  }
  const auto stated = stated_contour(scene);
  if (!stated) return stated.error();
  const ScenePose& pose = setup.haptics.initial_pose;
  const Vec3 normal = pose.inverse_direction(Vec3::UnitZ());
  const double offset_m = setup.haptics.plane_height_m - pose.translation_m.z();
  const double radius_m = settings.sphere_radius_m;
  const auto curve = find_curve(scene, setup, *stated, normal, radius_m);
  if (!curve) return curve.error();
  Spheres spheres = on_longest_wall(*curve);
  if (*stated) {
    const auto read = as_stated(*curve, **stated, normal, offset_m, radius_m);
    if (!read) return read.error();
    spheres = *read;
  }
  const double way_m = curve->wrapped(spheres.red_m - spheres.green_m);
  if (auto error = check_way(way_m, *curve, *stated)) return *error;
  TrialWay way;
  const double lead_in_m = std::min(kLeadIn_m, kMostLeadIn * curve->length_m());
  way.path = contour_path(curve->opened_at(spheres.green_m - lead_in_m, lead_in_m), normal,
                          kDetail * radius_m);
  way.green_along_m = lead_in_m;
  way.red_along_m = lead_in_m + way_m;
  way.green_m = curve->at(spheres.green_m);
  way.red_m = curve->at(spheres.red_m);
  return way;
}

}  // namespace palpate
