#pragma once

// The animations of an asset at time 0: the pose in which it is felt.

#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "geometry/result.h"
#include "io/gltf_accessor.h"
#include "io/gltf_transform.h"

namespace palpate {

// glTF 2.0, section 3.11 and appendix C. No keyframe may lie before time 0, and before the first
// keyframe its value holds: so the value at time 0 is that of the first keyframe under every
// interpolation (of the three vectors of CUBICSPLINE the middle one).
//
// All animations count. Where several move the same property of the same node, the first in the
// file does. Channels without a node, and paths other than translation, rotation, scale and weights
// (KHR_animation_pointer), are passed over.
//
// Not thread-safe; one per call of read_gltf(), which must not outlive the asset.
class GltfAnimations {
 public:
  // Lists the channels; their data are read when their node is asked for, so that a broken
  // animation of something that the scene does not contain does no harm. An animation without a
  // list of channels moves nothing and is a warning.
  static Result<GltfAnimations> list(const GltfAsset& asset, std::vector<std::string>& warnings);

  // What takes the place of the node's own translation, rotation and scale. Refused: a node that
  // has a matrix, two channels of one animation with the same target, samplers and accessors that
  // are missing or not as glTF asks for, a rotation that is no unit quaternion, a negative time.
  Result<GltfTrs> pose_of(std::size_t node);

  // What takes the place of the node's own morph weights, of which there are count.
  Result<std::optional<std::vector<double>>> weights_of(std::size_t node, std::size_t count);

  // Which animations made the poses asked for until now: `time 0 of animation "Walk"`. Empty if
  // none did.
  std::string description() const;

 private:
  enum class Path { kTranslation, kRotation, kScale, kWeights };
  struct Channel {
    std::size_t animation = 0;
    std::size_t index = 0;                 // in the channels of the animation
    std::optional<std::size_t> duplicate;  // a channel of this animation with the same target
    bool overrides_others = false;         // channels of later animations
  };

  explicit GltfAnimations(const GltfAsset& asset) : asset_(asset) {}

  std::optional<Error> add_channel(std::size_t animation, std::size_t index);
  // The value of the node's path at time 0, width elements; nothing if nothing animates it.
  Result<std::optional<std::vector<double>>> sample(std::size_t node, Path path, std::size_t width);
  Result<std::vector<double>> sample_channel(const Channel& channel, Path path, std::size_t width);

  const GltfAsset& asset_;
  std::map<std::pair<std::size_t, Path>, Channel> channels_;  // by node and path
  std::set<std::size_t> sampled_;                             // animations
  bool overridden_ = false;                                   // a channel of a sampled node was
};

}  // namespace palpate
