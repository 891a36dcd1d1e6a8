#pragma once

// A hand that follows the outline of an object once around.

#include <array>
#include <vector>

#include "engine/contour_way.h"
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
  double lift_speed_m_per_s = 0.06;
  double patience_s = 1.0;
};

// The hand follows the contour as displayed: its plan is fixed to the scene and turns with it. It
// aims press_depth_m inside the wall it follows (ContourWay). What is small beside that it does not
// follow: it plans along a simpler contour.
//
// The hand sees the proxy. It waits where it would get too far ahead of it, and turns at a sharp
// corner only when the proxy is there. If the proxy does not come in a while, the hand lifts, and
// touches the contour again a little farther on. Otherwise its speed is such that it is round in
// time: the same everywhere as long as it never waits.
class ContourPlan final : public HandPlan {
 public:
  // contour: in the scene frame, material on the left seen from the tip of plane_normal_scene; one
  // of curves, which are all that the plane cuts.
  ContourPlan(const Polyline& contour, const std::vector<Polyline>& curves,
              const Vec3& plane_normal_scene, const ContourPlanSettings& settings);

  HandTarget target(double time_s, const ScenePose& T_device_scene,
                    const TickRecord& last) noexcept override;

  // Where the hand rests at time 0, in front of the object. Scene frame.
  const Vec3& start_scene_m() const { return start_m_; }

  // What it was given, from where the hand begins: a closed one ends there. Scene frame.
  const std::vector<Vec3>& contour_scene_m() const { return whole_contour_m_; }

 private:
  // A few points that the hand goes to one after the other, to a place of the contour at last.
  struct Detour {
    std::array<Vec3, 3> points_m;
    std::size_t count = 0;
    std::size_t next = 0;
    Vec3 from_m = Vec3::Zero();
    double way_m = 0.0;  // done since from_m
    double speed_m_per_s = 0.0;
    double ends_along_m = 0.0;

    void add(const Vec3& p_m) { points_m[count++] = p_m; }
    bool is_done() const { return next == count; }
  };
  // Where the hand aims in a tick, and which way it goes.
  struct Aim {
    Vec3 p_m;
    Vec3 direction;
    double speed_m_per_s;
  };

  const ContourWay& way() const { return ways_[is_on_right_ ? 1 : 0]; }
  std::size_t wall_at(double along_m) const;
  Vec3 place(double along_m) const;
  Vec3 inward(double along_m) const;
  bool track(const TickRecord& last);
  bool find(const TickRecord& last, double first_m, double last_m);
  bool may_advance() const;
  Aim follow(double time_s, double dt_s);
  void advance(double way_m);
  Aim detour(const TickRecord& last, double dt_s);
  void end_detour(const TickRecord& last);
  bool is_out_of_patience(bool is_in_contact, double dt_s);
  void lift(const TickRecord& last);
  void correct_lag(const Vec3& lag_m, const Vec3& direction, double dt_s);

  ContourPlanSettings settings_;
  Vec3 plane_normal_;
  std::vector<Vec3> whole_contour_m_;
  std::vector<Vec3> contour_m_;           // without what is small
  std::vector<double> contour_length_m_;  // up to each point
  bool is_closed_;
  double room_m_;  // in front of the contour
  std::vector<ContourWay> ways_;
  Vec3 start_m_;

  bool is_on_right_ = false;  // presses to the right of an open contour
  Detour detour_;
  std::size_t leg_ = 0;               // that the hand is on
  double way_m_ = 0.0;                // that it has gone
  Vec3 correction_m_ = Vec3::Zero();  // scene frame, along the present leg
  double last_time_s_ = 0.0;

  std::size_t wall_ = 0;        // that the proxy is on
  double proxy_along_m_ = 0.0;  // the contour
  double waited_s_ = 0.0;
  double waited_at_m_ = 0.0;
  double lift_step_m_ = 0.0;
};

}  // namespace palpate
