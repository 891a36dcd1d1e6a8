#pragma once

// The animations of a scene file, and the animation and time at which the scene is read.

#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace palpate {

struct AnimationDescription {
  std::string name;                // "animation 7" if the file gives no name
  std::optional<double> length_s;  // the largest key time; absent if unreadable
};

struct PoseDescription {
  std::uint32_t animation = 0;  // index into the animations of the file
  double time_s = 0.0;
};

// "1.25 s", with enough digits to restore the number.
std::string seconds_text(double time_s);

// "at rest" or "animation #0 "Walk" at 1.5 s". If the last key is earlier than the pose, the time
// of that key is appended.
std::string pose_text(std::span<const AnimationDescription> animations,
                      const std::optional<PoseDescription>& pose);

}  // namespace palpate
