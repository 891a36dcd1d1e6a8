#pragma once

// The path of a simulated hand over a scene, chosen by the sensors of its device.

#include <cstdint>
#include <memory>
#include <vector>

#include "engine/scene/scene.h"
#include "engine/session/run_setup.h"
#include "engine/simulation/simulated_device.h"
#include "geometry/base/result.h"

namespace palpate {

struct PlannedHandSettings {
  double seconds = 28.0;  // 1 s for the approach, the rest for following the path
  std::uint64_t seed = 1;
  // How often the hand follows a contour, or how many times longer than usual its walk over a
  // surface is; at least 1.
  int laps = 1;
};

struct PlannedHand {
  std::unique_ptr<HandPlan> plan;
  Vec3 start_scene_m;  // where hand and device rest at time 0
  // One lap of the planned path, from its start point; exactly one of these two lists is empty.
  // With 2 sensors: the contour; a closed contour ends at its start point. With 3 sensors: the
  // places, points at equal distances along the whole path, reached or not. Scene frame.
  std::vector<Vec3> contour_m;
  std::vector<Vec3> places_m;
  bool is_open_contour = false;  // the contour has two ends, at the boundary of the surface
};

// With 2 sensors the hand follows the longest outline of the section at the plane height; with 3
// sensors it follows a path over the surface. Deterministic. Allocates.
//
// Errors: the scene has no surface, no section at the plane height, or no surface with clearance
// for the hand.
Result<PlannedHand> plan_hand(const Scene& scene, const RunSetup& setup,
                              const PlannedHandSettings& settings);

}  // namespace palpate
