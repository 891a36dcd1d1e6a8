#pragma once

// The animations of an asset, and the one pose of them in which it is felt.

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

// All animations of the asset, in the order of the file, with the largest time of the keys of their
// channels' samplers. What is wrong with them is no error here: such a length is not known. Reads
// no more than kMaxGltfKeyTimes times. A section that is no array is a warning.
std::vector<AnimationDescription> list_animations(const GltfAsset& asset,
                                                  std::vector<std::string>& warnings);

// What one animation makes of the nodes that it moves, at one time (glTF 2.0, section 3.11).
//
// Channels without a node, paths other than translation, rotation, scale and weights
// (KHR_animation_pointer), and weights of a node without a mesh are passed over.
class GltfPose {
 public:
  // The rest pose: nodes are where the file has them.
  GltfPose() = default;

  // The pose that is asked for as NAME@SECONDS, or "#number@SECONDS" with the number in the file,
  // as names may be missing or repeat. The last @ counts; nothing asked for is the rest pose.
  // Before the first key of a channel that one counts, behind its last key the last one.
  //
  // The whole animation is checked, others are not looked at. Refused: an animation that is not
  // there, a time that is not a finite number of seconds, 0 or more (kInvalidArgument; the hint
  // says what there is); an animation without channels, a target that is no node, that has a
  // matrix, or that two channels share; samplers as GltfKeyframes refuses them. pose_work: a
  // budget; what is read is taken from it.
  static Result<GltfPose> choose(const GltfAsset& asset, const std::string& asked,
                                 std::size_t& pose_work, std::vector<std::string>& warnings);

  // Nothing for the rest pose.
  const std::optional<PoseDescription>& description() const { return description_; }

  // What takes the place of the node's own translation, rotation and scale.
  GltfTrs pose_of(std::size_t node) const;

  // What takes the place of the node's own morph weights, as many as its mesh has targets. Null if
  // nothing does.
  const std::vector<double>* weights_of(std::size_t node) const;

 private:
  const std::vector<double>* value_of(std::size_t node, GltfPath path) const;

  std::optional<PoseDescription> description_;
  // By node and path; channels may share them.
  std::map<std::pair<std::size_t, GltfPath>, std::shared_ptr<const std::vector<double>>> values_;
};

}  // namespace palpate
