#pragma once

// A hand that follows a path over the surfaces of a scene.

#include <array>
#include <vector>

#include "engine/rig/workspace.h"
#include "engine/simulation/hand_path.h"
#include "engine/simulation/simulated_device.h"
#include "engine/simulation/target_track.h"

namespace palpate {

struct PathPlanSettings {
  double press_depth_m = kHandPressDepth_m;
  double approach_s = 1.0;  // duration of the motion from free space to the wall
  double follow_s = 27.0;   // duration of the motion along the path
  // The hand observes its position along the path and corrects for lag, for example the lag from
  // the sideways push of an under-actuated device. It does not correct the lag in depth, which the
  // wall causes.
  double visual_gain_per_s = 3.0;
  double max_correction_m = 12e-3;
  double lift_speed_m_per_s = 0.06;
  double patience_s = 1.0;
  double least_ease = 0.0;  // the hand reduces its press depth by at least this share
};

// Two lengths, in units of the press depth. kRestsInFront: the distance in front of the path at
// which the hand rests. kSmallForHand: the size of the details of a path that the hand ignores.
inline constexpr double kRestsInFront = 2.0;
inline constexpr double kSmallForHand = 0.25;

// The side from which the hand follows a path. kFront: only the front. kEither: the side on which
// the hand is when it lifts. kWhereFree: the front, or the back if the hand lifts in free space
// behind the wall.
enum class PathSides : std::uint8_t { kFront, kEither, kWhereFree };

// Properties of a path that the hand must know.
struct PathFacts {
  double room_m = 0.0;  // clearance in front of the path, for a hand that rests or lifts
  // True for an open contour, which the hand first touches a little after its start.
  bool slips_off_at_ends = false;
  PathSides sides = PathSides::kFront;
  bool may_cross_itself = false;  // distant parts of the path may be near each other
  // The radius of a sphere proxy; its centre stays this far in front of the path.
  double proxy_radius_m = 0.0;
};

// A hand that follows a path over the displayed scene. The path is fixed to the scene and moves
// with it. The hand's target is press_depth_m inside the wall that it follows (TargetTrack).
//
// The hand observes the proxy. The hand waits if it gets too far ahead of the proxy. At a sharp
// edge or a new heading, it turns only when the proxy has arrived. If the proxy does not arrive
// within patience_s, the hand lifts and touches the path again a little farther on. While the hand
// neither waits nor lifts, it moves at the speed that brings it to the end on time; this speed is
// constant as long as the hand does not have to wait.
class PathPlan final : public HandPlan {
 public:
  // path: two points or more, simplified (kSmallForHand).
  PathPlan(HandPath path, const PathFacts& facts, const PathPlanSettings& settings);

  HandTarget target(double time_s, const ScenePose& T_device_scene,
                    const TickRecord& last) noexcept override;

  // The hand's rest position at time 0, in front of the object. Scene frame.
  Vec3 start_scene_m() const { return start_m_ - facts_.proxy_radius_m * inward(proxy_along_m_); }

 private:
  Vec3 to_centre_m(const TickRecord& last) const;
  HandTarget touching_target(double time_s, const ScenePose& T_device_scene,
                             const TickRecord& last) noexcept;

  // A few points that the hand visits in order; the last one is on the path.
  struct Detour {
    std::array<Vec3, 3> points_m;
    std::size_t count = 0;
    std::size_t next = 0;
    Vec3 from_m = Vec3::Zero();
    double travelled_m = 0.0;  // travelled since from_m
    double speed_m_per_s = 0.0;
    double begins_along_m = 0.0;  // lengths along the path at which the detour begins and ends
    double ends_along_m = 0.0;

    void add(const Vec3& p_m) { points_m[count++] = p_m; }
    bool is_done() const { return next == count; }
  };
  // The hand's target in a tick, and its direction of motion. inward: the direction into the wall
  // that supports the hand, or zero if there is none.
  struct Aim {
    Vec3 p_m;
    Vec3 direction;
    Vec3 inward;
    double speed_m_per_s;
  };

  const HandPath& path() const { return paths_[is_behind_ ? 1 : 0]; }
  const TargetTrack& track() const { return tracks_[is_behind_ ? 1 : 0]; }
  Vec3 place_m(double along_m) const { return point_along(path(), length_m_, along_m); }
  const Vec3& inward(double along_m) const {
    return path().points[leg_at(length_m_, along_m)].inward;
  }
  // The length along the path that corresponds to the hand's target.
  double hand_along_m() const { return track().along_m(leg_, travelled_m_); }
  bool locate_proxy(const TickRecord& last);
  bool find(const TickRecord& last, double first_m, double last_m);
  bool may_advance() const;
  bool is_behind_wall(const TickRecord& last) const;
  bool is_round_edge(const TickRecord& last) const;
  Aim follow(double time_s, double dt_s);
  double ease(double dt_s);
  void advance(double step_m);
  Aim detour(const TickRecord& last, double dt_s);
  void end_detour(const TickRecord& last);
  void go_on_from(double along_m);
  bool is_out_of_patience(bool is_in_contact, double dt_s);
  void lift(const TickRecord& last);
  Vec3 correct_lag(const Aim& aim, const TickRecord& last, double dt_s);

  PathPlanSettings settings_;
  PathFacts facts_;
  std::vector<HandPath> paths_;  // one per side
  std::vector<TargetTrack> tracks_;
  std::vector<double> length_m_;  // length of the path up to each point
  std::vector<double> turns_m_;   // places along the path where the hand takes a new heading
  Vec3 start_m_;

  bool is_behind_ = false;  // the hand follows the second side
  Detour detour_;
  std::size_t leg_ = 0;               // current leg of the hand
  double travelled_m_ = 0.0;          // length travelled along track()
  Vec3 correction_m_ = Vec3::Zero();  // scene frame, in directions without a wall
  double press_more_m_ = 0.0;         // additional press depth into the wall
  double last_time_s_ = 0.0;

  std::size_t wall_ = 0;        // current wall of the proxy
  double proxy_along_m_ = 0.0;  // the proxy's place along the path
  double waited_s_ = 0.0;
  double waited_at_m_ = 0.0;
  double lift_step_m_ = 0.0;
  double ease_ = 0.0;
};

}  // namespace palpate
