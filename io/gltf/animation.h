#pragma once

// The animations of an asset, and the pose in which the asset is read.

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "geometry/base/result.h"
#include "io/gltf/accessor.h"
#include "io/gltf/keyframes.h"
#include "io/gltf/transform.h"
#include "io/pose_description.h"

namespace palpate {

// All animations of the asset, in the order of the file. The length of each is the largest key time
// of its channels' samplers. An invalid animation is not an error here; its length is unknown.
// Reads at most kMaxGltfKeyTimes times. If the section "animations" is not an array, there is a
// warning.
std::vector<AnimationDescription> list_animations(const GltfAsset& asset,
                                                  std::vector<std::string>& warnings);

// The pose of the nodes that one animation moves, at one time (glTF 2.0, section 3.11).
//
// Channels without a node are ignored, and so are weights of a node without a mesh. Also ignored
// are paths other than translation, rotation, scale and weights, such as those of
// KHR_animation_pointer.
class GltfPose {
 public:
  // The rest pose: nodes have the transforms of the file.
  GltfPose() = default;

  // The pose named by NAME@SECONDS or by "#number@SECONDS", where number is the animation's number
  // in the file. The second form exists because names may be missing or repeated. The last @
  // separates name and time; an empty text is the rest pose. Before the first key of a channel, the
  // channel's first value applies; after the last key, the channel's last value applies.
  //
  // The whole animation is checked; other animations are not. An unknown animation is an error, and
  // so is a time that is not a finite, non-negative number of seconds (kInvalidArgument); the hint
  // lists the animations. Further errors: an animation without channels; a target that is not a
  // node, that has a matrix, or that two channels share; the errors of GltfKeyframes. pose_work: a
  // budget, from which the number of elements read is subtracted.
  static Result<GltfPose> choose(const GltfAsset& asset, const std::string& asked,
                                 std::size_t& pose_work, std::vector<std::string>& warnings);

  // Absent for the rest pose.
  const std::optional<PoseDescription>& description() const { return description_; }

  // The values that replace the node's own translation, rotation and scale.
  GltfTrs pose_of(std::size_t node) const;

  // The values that replace the node's own morph weights, one for each target of its mesh. Null if
  // the animation does not set them.
  const std::vector<double>* weights_of(std::size_t node) const;

 private:
  const std::vector<double>* value_of(std::size_t node, GltfPath path) const;

  std::optional<PoseDescription> description_;
  // One entry for each pair of node and path that is animated. Several channels may share one
  // value.
  std::map<std::pair<std::size_t, GltfPath>, std::shared_ptr<const std::vector<double>>> values_;
};

}  // namespace palpate
