#pragma once

// A hand that wanders over a surface with three sensed axes.

#include <span>
#include <vector>

#include "engine/scene.h"
#include "engine/simulated_device.h"

namespace palpate {

struct SurfaceWalkSettings {
  double press_depth_m = 4e-3;
  double speed_m_per_s = 0.04;
  double duration_s = 28.0;
  double seconds_per_waypoint = 4.0;
  double search_s = 0.5;  // how long the hand feels back for a surface it has lost
  std::uint64_t seed = 1;
};

// Touches down on a random point of the surface (uniform by area) and walks from there towards the
// next, each within reach of the one before. It aims along the face it feels and press_depth_m
// below it, as a hand does that looks at the proxy. A waypoint that is not reached in its time is
// given up. A hand that loses the surface presses back to where it was for a while before it goes
// straight to the waypoint.
class SurfaceWalk final : public HandPlan {
 public:
  SurfaceWalk(const Scene& scene, const SurfaceWalkSettings& settings);

  HandTarget target(double time_s, const ScenePose& T_device_scene,
                    const TickRecord& last) noexcept override;

  const Vec3& start_scene_m() const { return start_m_; }

  // The places aimed at so far that have been reached or given up, scene frame.
  std::span<const Vec3> places_scene_m() const {
    return std::span(waypoints_m_).first(next_ + (reached_[next_] ? 1 : 0));
  }

 private:
  SurfaceWalkSettings settings_;
  std::vector<Vec3> waypoints_m_;  // scene frame
  std::vector<bool> reached_;
  Vec3 start_m_;
  Vec3 last_normal_;  // scene frame, of the last contact, or where it will touch down
  double last_contact_s_ = 0.0;
  std::size_t next_ = 0;
  double given_up_at_s_ = 0.0;
};

}  // namespace palpate
