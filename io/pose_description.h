#pragma once

// The animations of a scene file, and the pose of one of them in which the scene is read.

#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace palpate {

struct AnimationDescription {
  std::string name;                // "animation 7" when the file gives none
  std::optional<double> length_s;  // the largest time of its keys; nothing if that cannot be read
};

struct PoseDescription {
  std::uint32_t animation = 0;  // index into the animations of the file
  double time_s = 0.0;
};

// "1.25 s", with as many digits as give the number back.
std::string seconds_text(double time_s);

// "at rest"; or "animation #0 "Walk" at 1.5 s", and where its last key is if that is earlier.
std::string pose_text(std::span<const AnimationDescription> animations,
                      const std::optional<PoseDescription>& pose);

}  // namespace palpate
