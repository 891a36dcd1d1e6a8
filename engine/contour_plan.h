#pragma once

// A hand that follows the outline of an object once around.

#include <vector>

#include "engine/simulated_device.h"
#include "geometry/section.h"

namespace palpate {

struct ContourPlanSettings {
  double press_depth_m = 4e-3;  // how far inside the wall the hand aims: about half a newton
  double approach_s = 1.0;      // from free space to the wall
  double turn_s = 27.0;         // once around
  // The hand watches how far along the contour it is and makes up for lag, as the sideways push of
  // an under-actuated device causes; it lets the wall hold it back in depth.
  double visual_gain_per_s = 3.0;
  double max_correction_m = 12e-3;
};

// The hand follows the contour as displayed: its plan is fixed to the scene and turns with it. It
// aims press_depth_m inside the wall it follows. At a convex corner sharper than 45 deg it goes on
// along the old wall by its press depth before it turns: aiming along the old wall only, it would
// press ever deeper and never come round (numerics: corners of 90 deg and less). In a concave
// corner it presses into both walls. Speed along the plan is constant.
//
// Progress does not wait for the proxy: a proxy that stalls shows in turn_fraction().
class ContourPlan final : public HandPlan {
 public:
  // contour: in the scene frame, material on the left seen from the tip of plane_normal_scene.
  ContourPlan(const Polyline& contour, const Vec3& plane_normal_scene,
              const ContourPlanSettings& settings);

  HandTarget target(double time_s, const ScenePose& T_device_scene,
                    const TickRecord& last) noexcept override;
  double turn_fraction() const override;

  // Where the hand rests at time 0, outside the object. Scene frame.
  const Vec3& start_scene_m() const { return waypoints_.front(); }

 private:
  void plan_corner(const Vec3& corner, const Vec3& tangent_in, const Vec3& tangent_out);
  void finish_plan();
  void track(const TickRecord& last);
  void correct_lag(const Vec3& lag_m, const Vec3& direction, double time_s);

  ContourPlanSettings settings_;
  Vec3 plane_normal_;
  std::vector<Vec3> contour_;           // starts and ends in the middle of the longest wall
  std::vector<double> contour_length_;  // up to each point
  std::vector<Vec3> waypoints_;         // start, touch-down, then around
  std::vector<double> arrival_s_;       // at each waypoint
  std::size_t leg_ = 0;                 // that the hand is on
  Vec3 correction_m_ = Vec3::Zero();    // scene frame, along the present leg
  double corrected_at_s_ = 0.0;
  std::size_t wall_ = 0;  // that the proxy is on
  double farthest_m_ = 0.0;
};

}  // namespace palpate
