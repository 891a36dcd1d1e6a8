#pragma once

// The parameters of one simulated person, and how this person follows a scene that turns.

#include <array>
#include <cstdint>
#include <string_view>

namespace palpate {

// What the display shows of a scene that turns (seen_picture.h).
enum class View : std::uint8_t {
  kTurning,  // the scene as it turns in the device frame; the paper's people saw this
  kStill     // the scene in its first pose; the proxy and the device point move in its place
};
inline constexpr std::array<std::string_view, 2> kViewNames = {"turning", "still"};

// What a simulated person believes about the pose of a scene that turns (operator_hand.h): with
// View::kTurning one of the first four, with View::kStill one of the others.
enum class Following : std::uint8_t {
  kDelayed,      // the pose in the newest picture that the person has seen
  kPredict,      // that pose, turned about the seen proxy by the seen rate times the picture's age
  kReplan,       // a seen pose, held for replan_s
  kFrozen,       // the pose seen when contact was last lost or a corner last passed
  kAdaptsNone,   // the first pose, moved to where the person feels the hand
  kAdaptsHalf,   // the same, turned by half of the seen turn
  kAdaptsWhole,  // the same, turned by the seen turn: the belief of kDelayed
};
inline constexpr std::array<std::string_view, 7> kFollowingNames = {
    "delayed", "predict", "replan", "frozen", "adapts-0", "adapts-0.5", "adapts-1"};
// The followings for each view are consecutive.
inline constexpr std::size_t kTurningFollowings = 4;

// What a person with View::kStill adapts to: the share a of the seen turn by which the believed
// pose is turned. Requires one of the last three followings.
inline double adapted_share(Following following) {
  return 0.5 * (static_cast<int>(following) - static_cast<int>(Following::kAdaptsNone));
}

inline View view_of(Following following) {
  return static_cast<std::size_t>(following) < kTurningFollowings ? View::kTurning : View::kStill;
}

// The parameters of a simulated person. An operator file gives the range of each parameter but the
// last, and the source of the range (operator_file.h).
struct OperatorParameters {
  double sight_delay_s = 0.15;            // > 0, from a picture to the hand
  double replan_s = 0.35;                 // > 0, for Following::kReplan
  double gain_per_s = 3.0;                // >= 0, of the correction along the way
  double force_noise = 0.05;              // >= 0, standard deviation as a share of the hand's force
  double intention_noise_m = 2e-3;        // >= 0, standard deviation along each axis
  double intention_noise_Hz = 1.0;        // > 0, its natural frequency
  double hand_stiffness_N_per_m = 443.0;  // > 0
  double hand_damping_Ns_per_m = 15.0;    // >= 0
  double press_depth_m = 8e-3;            // > 0, of the target inside the wall
  double speed_m_per_s = 0.045;           // >= 0, along the way
  double comfortable_depth_m = 5e-3;      // > 0, beyond press_depth_m: deeper, the hand slows
};

}  // namespace palpate
