#pragma once

// A simulated person who follows a contour from the green to the red sphere, and who sees the scene
// only in pictures that are late.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/simulation/simulated_device.h"
#include "engine/simulation/target_track.h"
#include "engine/trials/contour_place.h"
#include "engine/trials/levels.h"
#include "engine/trials/operator_parameters.h"
#include "engine/trials/seen_picture.h"
#include "engine/trials/trial.h"

namespace palpate {

// Whether a person who is lost goes back to the contour. With kOff, the person is never lost and
// only follows the track. This suits a person who stands still (speed_m_per_s 0) and therefore
// could not go back.
enum class Recovery : std::uint8_t { kOn, kOff };

// The person aims at a point that is press_depth_m inside the wall and advances along the waypoints
// of a TargetTrack. The person knows only the newest picture that is sight_delay_s old or older; a
// picture is taken display_Hz times a second and shows the pose of the scene, the proxy, the device
// point and whether there is contact. D: press_depth_m; v0: speed_m_per_s; k: gain_per_s; e0:
// comfortable_depth_m.
//
// - Begin: the person touches the contour within the green sphere and then follows it.
// - Pace: the target advances at v0 e0 / max(e0, e), e = max(0, seen |goal - proxy| -
//   D), and at most at 0.3 v0 while contact is seen and a corner lies within 10 mm ahead. The paper
//   instructs people to keep frame and ball (the displayed device and proxy) close together; we
//   take this to mean that depth slows the hand. The target waits while it is too far ahead of the
//   seen place.
// - Correction: u' = k (plan - goal along the way, both as seen), |u| <= 20 mm. The lag into the
//   wall is not corrected: in this direction, the hand yields.
// - View: with one of the followings for View::kStill, the person sees the pictures of
//   View::kStill (seen_picture.h), and believes in adapted_pose(). Once the scene has turned by
//   more than 90 deg beyond what the person adapts to, the hand moves away from where the person
//   aims. It then goes 1 m, which is an arm's length, beyond the farthest place of the path,
//   counted from its first place.
// - Recovery: the person is lost if, for 0.5 s (1.5 s in a corner), the person sees no contact that
//   moves or confirms the place on the contour. The hand then returns to the contour, 10 mm past
//   that place. If it touches a wrong part of the contour, it first moves back beside the contour,
//   on the outside.
//
// The paper describes no model of its people: all rules above are ours.
class OperatorHand final : public HandPlan {
 public:
  // proxy_radius_m: 0 for a point. `way` must outlive the hand.
  OperatorHand(const TrialWay& way, const OperatorParameters& person, Following following,
               const TrialSettings& settings, double proxy_radius_m,
               Recovery recovery = Recovery::kOn);

  HandTarget target(double time_s, const ScenePose& T_device_scene,
                    const TickRecord& last) noexcept override;

  // The point where the hand rests at time 0, 2 D outside the centre of the green sphere. Scene
  // frame.
  const Vec3& start_scene_m() const { return start_m_; }

  // The number of times that the person has been lost so far.
  std::uint64_t recoveries() const { return recoveries_; }

 private:
  struct Picture {
    double time_s;
    SeenPicture seen;
    ScenePose T_device_scene;
    Vec3 felt_device_m;  // the device point as the hand feels it
    bool contact;
    Vec3 plan_scene_m;  // where the person aimed then, without the correction
  };
  // The way back to the contour: along the contour, outside it, and then into it.
  struct Detour {
    bool is_outside = false;  // on the part outside the contour
    double outside_m = 0.0;   // place of the next point outside, along the path
    double goal_along_m = 0.0;
    Vec3 at_m = Vec3::Zero();
    double speed_m_per_s = 0.0;
    double waited_s = 0.0;  // since the goal was reached
  };
  struct Aim {
    Vec3 p_m;
    Vec3 velocity_m_per_s;
  };

  void take_picture(double time_s, const ScenePose& T_device_scene, const TickRecord& last);
  void look(double time_s);
  void see(const Picture& picture);
  ScenePose believed_pose(double time_s) const;
  bool misjudges_turn() const;
  HandTarget within_reach(const HandTarget& target) const;
  bool is_in_corner() const;
  bool has_corner_between(double first_m, double last_m) const;
  double seen_along_m() const;
  double target_along_m() const { return track_.along_m(leg_, travelled_m_); }
  double pace_m_per_s() const;
  Aim follow(double dt_s);
  void advance(double step_m);
  void correct(const Vec3& direction, double dt_s);
  Aim go_back(double dt_s);
  void lose();
  void resume();
  bool go_towards(const Vec3& to_m, double step_m);
  Vec3 beside_m(double along_m, double inward_m) const;
  Vec3 inward_at(double along_m) const;

  OperatorParameters person_;
  Following following_;
  Recovery recovery_;
  double picture_s_;
  double sphere_radius_m_;
  double proxy_radius_m_;
  ContourPlace place_;             // the place that the person has seen, along the trial's path
  HandPath path_;                  // the trial's path without detail that a hand does not follow
  std::vector<double> lengths_m_;  // of path_; every length below is along path_
  std::vector<double> way_lengths_m_;  // of the trial's path, up to each point of path_
  TargetTrack track_;
  std::vector<double> corners_m_;
  Vec3 green_m_;
  double red_along_m_;
  Vec3 start_m_;
  double reach_m_;  // from start_m_

  std::vector<Picture> pictures_;  // a ring
  std::uint64_t taken_ = 0;        // number of pictures taken
  std::uint64_t seen_ = 0;         // number of pictures seen; the last one is the newest
  ScenePose first_pose_;           // in the first picture
  ScenePose held_pose_;            // for kReplan and kFrozen
  double held_since_s_ = 0.0;
  bool saw_contact_ = false;
  bool saw_wrong_part_ = false;

  double last_time_s_ = 0.0;
  bool has_begun_ = false;     // contact within the green sphere was seen
  bool is_following_ = false;  // otherwise on a detour
  Detour detour_;
  std::size_t leg_ = 0;
  double travelled_m_ = 0.0;  // along the track
  Vec3 plan_m_;               // the target without the correction, scene frame
  Vec3 correction_m_ = Vec3::Zero();
  double lost_s_ = 0.0;
  std::uint64_t recoveries_ = 0;
};

}  // namespace palpate
