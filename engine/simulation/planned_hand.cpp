#include "engine/simulation/planned_hand.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "engine/simulation/clearance_hint.h"
#include "engine/simulation/contour_path.h"
#include "engine/simulation/path_plan.h"
#include "engine/simulation/reachable_outlines.h"
#include "engine/simulation/surface_path.h"
#include "geometry/mesh/section.h"

namespace palpate {
namespace {

PlannedHand hand_on(HandPath path, const PathFacts& facts, const PathPlanSettings& settings) {
  auto plan = std::make_unique<PathPlan>(std::move(path), facts, settings);
  const Vec3 start = plan->start_scene_m();
  return {std::move(plan), start, {}, {}};
}

PathPlanSettings plan_settings(const PlannedHandSettings& settings) {
  PathPlanSettings plan;
  plan.follow_s = settings.seconds - plan.approach_s;
  return plan;
}

Result<PlannedHand> plan_contour(const Scene& scene, const RunSetup& setup,
                                 const PlannedHandSettings& settings) {
  const ScenePose& pose = setup.haptics.initial_pose;
  const Vec3 normal = pose.inverse_direction(Vec3::UnitZ());
  const PathPlanSettings plan = plan_settings(settings);
  const double small_m = kSmallForHand * plan.press_depth_m;
  PathFacts facts;
  facts.proxy_radius_m = setup.haptics.god_object.radius_m;
  const auto found =
      reachable_outlines(scene, pose, setup.haptics.plane_height_m, small_m, facts.proxy_radius_m);
  if (!found) return found.error();
  const Outline& followed = found->front();
  std::vector<Polyline> obstacles;
  for (const Outline& outline : *found) obstacles.push_back(outline.curve);
  facts.slips_off_at_ends = !followed.curve.closed;
  facts.sides = followed.has_two_sides ? PathSides::kEither : PathSides::kFront;
  // A sphere also needs clearance for its other half.
  double room_m = kRestsInFront * plan.press_depth_m + facts.proxy_radius_m;
  std::vector<Vec3> contour = open_contour(followed.curve, obstacles, normal, room_m);
  facts.room_m = std::max(0.0, room_m - facts.proxy_radius_m);
  HandPath path = contour_path(contour, normal, small_m);
  if (settings.laps > 1) {
    path = followed.curve.closed ? repeated(path, settings.laps) : to_and_fro(path, settings.laps);
    facts.may_cross_itself = true;  // it passes every place several times
  }
  PlannedHand hand = hand_on(std::move(path), facts, plan);
  hand.contour_m = std::move(contour);
  hand.is_open_contour = !followed.curve.closed;
  return hand;
}

// A hand that explores a surface. On a small object the path is at most kMostExtents times the
// largest extent of the object.
constexpr double kWalkSpeed_m_per_s = 0.04;
constexpr double kMostExtents = 5.0;
constexpr double kSecondsPerHeading = 3.0;
constexpr double kSecondsPerPlace = 0.5;
constexpr int kMostWalkLaps = 16;

// The hand presses lightly: along an axis without a motor no wall resists it, so that it would
// reach its full press depth, and the sideways force there grows with the depth.
constexpr double kLightTouch = 0.6;

// A walk of `laps` laps: a path of path_laps laps, followed to and fro.
struct Walk {
  int times;  // how often the path is followed
  double speed_m_per_s;
  SurfacePathSettings path;
};

Walk walk_of(const Scene& scene, const PlannedHandSettings& settings, const PathPlanSettings& plan,
             int path_laps) {
  Walk walk;
  walk.times = (settings.laps + path_laps - 1) / path_laps;
  walk.path.length_m = std::min(kWalkSpeed_m_per_s * plan.follow_s / walk.times,
                                path_laps * kMostExtents * scene.statistics().extent_m.maxCoeff());
  walk.speed_m_per_s = walk.times * walk.path.length_m / plan.follow_s;
  walk.path.leg_m = kSecondsPerHeading * walk.speed_m_per_s;
  walk.path.room_m = plan.press_depth_m;
  walk.path.seed = settings.seed;
  return walk;
}

Result<PlannedHand> plan_walk(const Scene& scene, const RunSetup& setup,
                              const PlannedHandSettings& settings) {
  PathPlanSettings plan = plan_settings(settings);
  plan.least_ease = kLightTouch;
  // A long path needs a long first leg, which a rough surface may not have.
  int path_laps = std::min(settings.laps, kMostWalkLaps);
  Walk walk = walk_of(scene, settings, plan, path_laps);
  std::optional<SurfacePath> found = plan_surface_path(scene, walk.path);
  while (!found && path_laps > 1) {
    path_laps /= 2;
    walk = walk_of(scene, settings, plan, path_laps);
    found = plan_surface_path(scene, walk.path);
  }
  if (!found) {
    return Error{ErrorCode::kInvalidArgument, "", "scene",
                 "has no surface with clearance for the hand in front of it",
                 clearance_hint(scene, setup, walk.path)};
  }
  PathFacts facts;
  facts.proxy_radius_m = setup.haptics.god_object.radius_m;
  facts.room_m = std::min(kRestsInFront * plan.press_depth_m, 0.5 * found->free_m);
  facts.sides = found->is_open ? PathSides::kWhereFree : PathSides::kFront;
  facts.may_cross_itself = true;
  HandPath path = simplified(found->path, kSmallForHand * plan.press_depth_m);
  PlannedHand hand = hand_on(to_and_fro(path, walk.times), facts, plan);
  hand.places_m = places_along(found->path, kSecondsPerPlace * walk.speed_m_per_s);
  return hand;
}

}  // namespace

Result<PlannedHand> plan_hand(const Scene& scene, const RunSetup& setup,
                              const PlannedHandSettings& settings) {
  if (scene.objects().empty()) {
    return Error{ErrorCode::kEmptyScene, "", "scene",
                 "has media but no surface for the hand to follow",
                 "replay a path through the scene"};
  }
  return setup.actuation.is_planar() ? plan_contour(scene, setup, settings)
                                     : plan_walk(scene, setup, settings);
}

}  // namespace palpate
