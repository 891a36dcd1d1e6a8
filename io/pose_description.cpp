#include "io/pose_description.h"

#include <array>
#include <charconv>

#include "geometry/base/quoted.h"

namespace palpate {

std::string seconds_text(double time_s) {
  std::array<char, 32> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), time_s).ptr;
  return std::string(text.data(), end) + " s";
}

std::string pose_text(std::span<const AnimationDescription> animations,
                      const std::optional<PoseDescription>& pose) {
  if (!pose) return "at rest";
  const AnimationDescription& animation = animations[pose->animation];
  std::string text = "animation #" + std::to_string(pose->animation) + " " +
                     in_quotes(animation.name) + " at " + seconds_text(pose->time_s);
  if (animation.length_s && pose->time_s > *animation.length_s) {
    text += ", after its last key at " + seconds_text(*animation.length_s);
  }
  return text;
}

}  // namespace palpate
