#pragma once

// The simulated person of the canonical protocol, who presses on a wall and strokes along it.

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "engine/simulation/simulated_device.h"
#include "engine/trials/levels.h"
#include "engine/trials/operator_parameters.h"

namespace palpate {

enum class CanonicalMotion : std::uint8_t { kPressed, kStroked };
inline constexpr ConditionLevels<CanonicalMotion, 2> kCanonicalMotionLevels = {
    {{"pressed", "the target goes to the press depth in 1 s and is held for 2 s",
      CanonicalMotion::kPressed},
     {"stroked", "then it moves 100 mm along the wall as seen", CanonicalMotion::kStroked}}};
inline constexpr auto kCanonicalMotionNames = names_of(kCanonicalMotionLevels);
static_assert(are_in_order(kCanonicalMotionLevels));

// The target goes into the wall in kPress_s, is held for kHold_s, and in a stroke then moves by
// kStroke_m along the wall.
inline constexpr double kPress_s = 1.0;
inline constexpr double kHold_s = 2.0;
inline constexpr double kStroke_m = 0.1;
// The distance outside the wall from which the hand comes, in press depths.
inline constexpr double kComesFrom = 2.0;

// From the first seen picture to the end of the motion. Requires speed_m_per_s > 0 for a stroke.
double canonical_duration_s(const OperatorParameters& person, CanonicalMotion motion);

// The person aims at a point in the frame of canonical_wall.h, at the wall as seen: in the newest
// picture that is sight_delay_s old or older (Following::kDelayed). A picture shows the pose of the
// wall, as in OperatorHand. D: press_depth_m; v0: speed_m_per_s.
//
// - The target moves from 2 D outside the wall to D inside it, at constant speed, and is held
// there.
// - A stroke then goes along +y at v0. On an object with material on its left, as in all trials,
//   the hand moves in this direction.
//
// The speed depends neither on the depth nor on the lag: OperatorHand's pace, correction and
// recovery are those of a person who follows a contour.
class CanonicalHand final : public HandPlan {
 public:
  // proxy_radius_m: 0 for a point. Requires canonical_duration_s() to be finite.
  CanonicalHand(const OperatorParameters& person, CanonicalMotion motion, double display_Hz,
                double proxy_radius_m);

  HandTarget target(double time_s, const ScenePose& T_device_scene,
                    const TickRecord& last) noexcept override;

  // The point where the hand rests until the person sees the first picture. Scene frame.
  Vec3 start_scene_m() const { return {outside_m_, 0.0, 0.0}; }

  // Whether the motion has ended.
  bool is_over() const { return is_over_; }

 private:
  struct Picture {
    double time_s;
    ScenePose T_device_scene;
  };

  const Picture* newest_seen(double time_s, const ScenePose& T_device_scene);
  HandTarget aim(double moving_s) const;

  CanonicalMotion motion_;
  double sight_delay_s_;
  double press_depth_m_;
  double speed_m_per_s_;
  double duration_s_;
  double picture_s_;
  double outside_m_;  // x of the start

  std::vector<Picture> pictures_;  // a ring
  std::uint64_t taken_ = 0;        // number of pictures taken
  std::uint64_t seen_ = 0;         // number of pictures seen; the last one is the newest
  double begun_s_ = 0.0;           // when the first picture was seen
  bool is_over_ = false;
};

}  // namespace palpate
