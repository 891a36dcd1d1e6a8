#pragma once

// A hand that follows a path over the surfaces of a scene.

#include <array>
#include <vector>

#include "engine/simulation/hand_path.h"
#include "engine/simulation/hand_way.h"
#include "engine/simulation/simulated_device.h"

namespace palpate {

struct PathPlanSettings {
  double press_depth_m = 4e-3;  // how far inside the wall the hand aims: about half a newton
  double approach_s = 1.0;      // from free space to the wall
  double follow_s = 27.0;       // to the end of the path
  // The hand watches how far along the path it is and makes up for lag, as the sideways push of an
  // under-actuated device causes; it lets the wall hold it back in depth.
  double visual_gain_per_s = 3.0;
  double max_correction_m = 12e-3;
  double lift_speed_m_per_s = 0.06;
  double patience_s = 1.0;
  double least_ease = 0.0;  // the part of the depth by which it always presses less on a wall
};

// Of a path, in press depths: how far in front of it the hand rests; what is small beside the hand,
// which follows a simpler path.
inline constexpr double kRestsInFront = 2.0;
inline constexpr double kSmallForHand = 0.25;

// From where a path can be followed: from its front alone; from whichever side a hand finds itself
// on when it is lifted; or from the other side if it finds itself there with nothing around it.
enum class PathSides : std::uint8_t { kFront, kEither, kWhereFree };

// What a hand has to know of a path.
struct PathFacts {
  double room_m = 0.0;             // in front of the path: where the hand rests and is lifted to
  bool slips_off_at_ends = false;  // an open contour: the hand touches it a little farther on
  PathSides sides = PathSides::kFront;
  bool may_cross_itself = false;  // near a place of it there are others that come much earlier
  double proxy_radius_m = 0.0;    // of a sphere, whose centre stays so far in front of the path
};

// The hand follows the path as displayed: its plan is fixed to the scene and turns with it. It aims
// press_depth_m inside the wall it follows (HandWay).
//
// The hand sees the proxy. It waits where it would get too far ahead of it, and turns at a sharp
// edge, or to another heading, only when the proxy is there. If the proxy does not come in a while,
// the hand lifts, and touches the path again a little farther on. Otherwise its speed is such that
// it is at the end in time: the same everywhere as long as it never waits.
class PathPlan final : public HandPlan {
 public:
  // path: two points or more, what is small left out.
  PathPlan(HandPath path, const PathFacts& facts, const PathPlanSettings& settings);

  HandTarget target(double time_s, const ScenePose& T_device_scene,
                    const TickRecord& last) noexcept override;

  // Where the hand rests at time 0, in front of the object. Scene frame.
  Vec3 start_scene_m() const { return start_m_ - facts_.proxy_radius_m * inward(proxy_along_m_); }

 private:
  Vec3 to_centre_m(const TickRecord& last) const;
  HandTarget touching_target(double time_s, const ScenePose& T_device_scene,
                             const TickRecord& last) noexcept;

  // A few points that the hand goes to one after the other, to a place of the path at last.
  struct Detour {
    std::array<Vec3, 3> points_m;
    std::size_t count = 0;
    std::size_t next = 0;
    Vec3 from_m = Vec3::Zero();
    double way_m = 0.0;  // done since from_m
    double speed_m_per_s = 0.0;
    double begins_along_m = 0.0;  // the path
    double ends_along_m = 0.0;

    void add(const Vec3& p_m) { points_m[count++] = p_m; }
    bool is_done() const { return next == count; }
  };
  // Where the hand aims in a tick, and which way it goes; inward: into what holds it, or zero.
  struct Aim {
    Vec3 p_m;
    Vec3 direction;
    Vec3 inward;
    double speed_m_per_s;
  };

  const HandPath& path() const { return paths_[is_behind_ ? 1 : 0]; }
  const HandWay& way() const { return ways_[is_behind_ ? 1 : 0]; }
  std::size_t wall_at(double along_m) const;
  Vec3 place(double along_m) const;
  const Vec3& inward(double along_m) const { return path().points[wall_at(along_m)].inward; }
  double hand_along_m() const;
  bool track(const TickRecord& last);
  bool find(const TickRecord& last, double first_m, double last_m);
  bool may_advance() const;
  bool is_behind_wall(const TickRecord& last) const;
  bool is_round_edge(const TickRecord& last) const;
  Aim follow(double time_s, double dt_s);
  double ease(double dt_s);
  void advance(double way_m);
  Aim detour(const TickRecord& last, double dt_s);
  void end_detour(const TickRecord& last);
  void go_on_from(double along_m);
  bool is_out_of_patience(bool is_in_contact, double dt_s);
  void lift(const TickRecord& last);
  Vec3 correct_lag(const Aim& aim, const TickRecord& last, double dt_s);

  PathPlanSettings settings_;
  PathFacts facts_;
  std::vector<HandPath> paths_;  // by side
  std::vector<HandWay> ways_;
  std::vector<double> length_m_;  // of the path, up to each point
  std::vector<double> turns_m_;   // along the path, where the hand takes another heading
  Vec3 start_m_;

  bool is_behind_ = false;  // on the second side
  Detour detour_;
  std::size_t leg_ = 0;               // that the hand is on
  double way_m_ = 0.0;                // that it has gone
  Vec3 correction_m_ = Vec3::Zero();  // scene frame, where no wall holds the hand
  double press_more_m_ = 0.0;         // into the wall
  double last_time_s_ = 0.0;

  std::size_t wall_ = 0;        // that the proxy is on
  double proxy_along_m_ = 0.0;  // the path
  double waited_s_ = 0.0;
  double waited_at_m_ = 0.0;
  double lift_step_m_ = 0.0;
  double ease_ = 0.0;
};

}  // namespace palpate
