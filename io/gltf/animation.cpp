#include "io/gltf/animation.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>

#include <nlohmann/json.hpp>

#include "io/gltf/error.h"
#include "io/gltf/json.h"
#include "io/gltf/limits.h"
#include "io/gltf/morph.h"
#include "io/gltf/tinygltf.h"

namespace palpate {
namespace {

using Json = nlohmann::json;

// The largest number of animations named in a message.
constexpr std::size_t kMostNamed = 8;

// The array member of a JSON object with this name; null if absent.
const Json* array_in(const Json& parent, const char* name) {
  if (!parent.is_object()) return nullptr;
  const auto found = parent.find(name);
  return found == parent.end() || !found->is_array() ? nullptr : &*found;
}

const Json* object_in(const Json& parent, const char* name) {
  if (!parent.is_object()) return nullptr;
  const auto found = parent.find(name);
  return found == parent.end() || !found->is_object() ? nullptr : &*found;
}

std::string channel_element(std::size_t animation, std::size_t channel) {
  return gltf_element("animations", animation, "channels/" + std::to_string(channel));
}

std::size_t animation_count(const GltfAsset& asset) {
  const Json* animations = array_in(asset.json, "animations");
  return animations ? animations->size() : 0;
}

std::string name_of(const GltfAsset& asset, std::size_t animation) {
  const Json& json = asset.json["animations"][animation];
  const auto name = json.is_object() ? json.find("name") : json.end();
  if (name != json.end() && name->is_string() && !name->get_ref<const std::string&>().empty()) {
    return name->get<std::string>();
  }
  return "animation " + std::to_string(animation);
}

// The accessor of the times of a channel's keys.
std::optional<std::size_t> input_of(const GltfAsset& asset, const Json& animation,
                                    const Json& channel) {
  const auto id_in = [](const Json& object, const char* name, std::size_t count) {
    const auto found = object.is_object() ? object.find(name) : object.end();
    const auto id = found == object.end() ? std::nullopt : whole_number(*found);
    return id && *id < count ? std::optional<std::size_t>(*id) : std::nullopt;
  };
  const Json* samplers = array_in(animation, "samplers");
  const auto sampler = id_in(channel, "sampler", samplers ? samplers->size() : 0);
  if (!sampler) return std::nullopt;
  return id_in((*samplers)[*sampler], "input", asset.model.accessors.size());
}

// The lengths of animations, which may share their keys.
class Lengths {
 public:
  explicit Lengths(const GltfAsset& asset) : asset_(asset) {}

  std::optional<double> of(const Json& animation) {
    const Json* channels = array_in(animation, "channels");
    if (!channels || channels->empty()) return std::nullopt;
    double largest_s = 0.0;
    for (const Json& channel : *channels) {
      const auto input = input_of(asset_, animation, channel);
      const auto length_s = input ? of_accessor(*input) : std::nullopt;
      if (!length_s) return std::nullopt;
      largest_s = std::max(largest_s, *length_s);
    }
    return largest_s;
  }

 private:
  std::optional<double> of_accessor(std::size_t accessor) {
    const auto [known, is_new] = known_.try_emplace(accessor);
    if (is_new) known->second = largest_key_time_s(asset_, accessor, budget_);
    return known->second;
  }

  const GltfAsset& asset_;
  std::size_t budget_ = kMaxGltfKeyTimes;
  std::map<std::size_t, std::optional<double>> known_;
};

// "#0 "Walk" of 1.5 s, #1 "Run" of 2 s"
std::string choices_text(const GltfAsset& asset) {
  std::vector<std::string> untold;
  const auto animations = list_animations(asset, untold);
  std::string text;
  for (std::size_t i = 0; i < std::min(animations.size(), kMostNamed); ++i) {
    text += (i > 0 ? ", #" : "#") + std::to_string(i) + " " + in_quotes(animations[i].name) +
            (animations[i].length_s ? " of " + seconds_text(*animations[i].length_s) : "");
  }
  if (animations.size() > kMostNamed) {
    text += " and " + std::to_string(animations.size() - kMostNamed) + " more (palpate info)";
  }
  return text;
}

Error no_such_pose(const GltfAsset& asset, const std::string& asked, const std::string& problem) {
  const bool has_any = animation_count(asset) > 0;
  return gltf_error(ErrorCode::kInvalidArgument, "pose " + in_quotes(asked), problem,
                    has_any ? "choose from " + choices_text(asset)
                            : "the file has no animation; leave the pose out to use the rest pose");
}

// "#7" -> 7
std::optional<std::size_t> number_of(std::string_view name) {
  if (!name.starts_with('#')) return std::nullopt;
  std::size_t number = 0;
  const auto [rest, failed] = std::from_chars(name.data() + 1, name.data() + name.size(), number);
  if (name.size() < 2 || failed != std::errc() || rest != name.data() + name.size()) {
    return std::nullopt;
  }
  return number;
}

Result<std::size_t> find_animation(const GltfAsset& asset, const std::string& asked,
                                   const std::string& name) {
  const std::size_t count = animation_count(asset);
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < count; ++i) {
    if (name_of(asset, i) == name) found.push_back(i);
  }
  if (found.size() == 1) return found.front();
  if (found.empty()) {
    const auto number = number_of(name);
    if (number && *number < count) return *number;
    return no_such_pose(
        asset, asked,
        in_quotes(name) + " is not among the " + std::to_string(count) + " animations of the file");
  }
  std::string numbers;
  for (std::size_t i = 0; i < std::min(found.size(), kMostNamed); ++i) {
    numbers += (i > 0 ? ", \"#" : "\"#") + std::to_string(found[i]) + "\"";
  }
  if (found.size() > kMostNamed) {
    numbers += " and " + std::to_string(found.size() - kMostNamed) + " more";
  }
  return gltf_error(
      ErrorCode::kInvalidArgument, "pose " + in_quotes(asked),
      in_quotes(name) + " is the name of " + std::to_string(found.size()) + " animations",
      "name the animation by its number in the file: " + numbers);
}

Result<PoseDescription> parse_pose(const GltfAsset& asset, const std::string& asked) {
  const std::size_t at = asked.rfind('@');
  if (at == std::string::npos) {
    return no_such_pose(asset, asked, "has no @ before a time; expected NAME@SECONDS");
  }
  if (at == 0) return no_such_pose(asset, asked, "has no name; expected NAME@SECONDS");
  double time_s = 0.0;
  const char* end = asked.data() + asked.size();
  const auto [rest, failed] = std::from_chars(asked.data() + at + 1, end, time_s);
  if (failed != std::errc() || rest != end || !std::isfinite(time_s) || !(time_s >= 0.0)) {
    return no_such_pose(asset, asked,
                        in_quotes(asked.substr(at + 1)) +
                            " is not a time; expected a finite number of seconds, 0 or more");
  }
  const auto animation = find_animation(asset, asked, asked.substr(0, at));
  if (!animation) return animation.error();
  return PoseDescription{static_cast<std::uint32_t>(*animation), time_s};
}

// The node and path that a channel animates.
struct Target {
  std::size_t node = 0;
  GltfPath path = GltfPath::kTranslation;
  std::size_t weights = 0;
};

// Nothing if the channel is ignored.
Result<std::optional<Target>> target_of(const GltfAsset& asset, const Json& channel,
                                        const std::string& element) {
  const std::optional<Target> none;
  const Json* target = object_in(channel, "target");
  if (!target || !target->contains("path")) return none;
  constexpr std::pair<const char*, GltfPath> kPaths[] = {{"translation", GltfPath::kTranslation},
                                                         {"rotation", GltfPath::kRotation},
                                                         {"scale", GltfPath::kScale},
                                                         {"weights", GltfPath::kWeights}};
  const auto* path = std::find_if(std::begin(kPaths), std::end(kPaths),
                                  [&](const auto& p) { return (*target)["path"] == p.first; });
  if (path == std::end(kPaths)) return none;
  const auto node =
      optional_id(*target, element + "/target", "node", "/nodes", asset.model.nodes.size());
  if (!node) return node.error();
  if (!*node) return none;
  Target found{**node, path->second};
  const tinygltf::Node& moved = asset.model.nodes[found.node];
  if (found.path != GltfPath::kWeights) {
    if (moved.matrix.empty()) return std::optional(found);
    return gltf_invalid(element + "/target/node",
                        "node " + std::to_string(found.node) + " has a matrix; an animated node " +
                            "has translation, rotation and scale instead");
  }
  if (moved.mesh < 0) return none;
  found.weights = morph_target_count(asset, static_cast<std::size_t>(moved.mesh));
  if (found.weights > 0) return std::optional(found);
  return gltf_invalid(element + "/target", "animates the weights of a mesh without morph targets");
}

}  // namespace

std::vector<AnimationDescription> list_animations(const GltfAsset& asset,
                                                  std::vector<std::string>& warnings) {
  std::vector<AnimationDescription> list;
  if (asset.json.contains("animations") && !array_in(asset.json, "animations")) {
    warnings.push_back("/animations: is not an array and is ignored");
  }
  Lengths lengths(asset);
  for (std::size_t i = 0; i < animation_count(asset); ++i) {
    list.push_back({name_of(asset, i), lengths.of(asset.json["animations"][i])});
  }
  return list;
}

Result<GltfPose> GltfPose::choose(const GltfAsset& asset, const std::string& asked,
                                  std::size_t& pose_work, std::vector<std::string>& warnings) {
  GltfPose pose;
  if (asked.empty()) return pose;
  const auto description = parse_pose(asset, asked);
  if (!description) return description.error();
  pose.description_ = *description;
  const std::size_t animation = description->animation;
  const Json* channels = array_in(asset.json["animations"][animation], "channels");
  if (!channels) {
    return gltf_invalid(gltf_element("animations", animation), "has no list of channels");
  }
  GltfKeyframes keyframes(asset, animation, description->time_s, pose_work, warnings);
  std::map<std::pair<std::size_t, GltfPath>, std::size_t> channel_of;
  for (std::size_t c = 0; c < channels->size(); ++c) {
    const std::string element = channel_element(animation, c);
    const auto target = target_of(asset, (*channels)[c], element);
    if (!target) return target.error();
    if (!*target) continue;
    const std::pair key((*target)->node, (*target)->path);
    if (const auto [first, is_new] = channel_of.emplace(key, c); !is_new) {
      return gltf_invalid(element + "/target", "is also the target of channel " +
                                                   std::to_string(first->second) +
                                                   "; expected each target once");
    }
    auto value = keyframes.value(c, (*target)->path, (*target)->weights);
    if (!value) return value.error();
    pose.values_.emplace(key, std::move(*value));
  }
  return pose;
}

const std::vector<double>* GltfPose::value_of(std::size_t node, GltfPath path) const {
  const auto found = values_.find({node, path});
  return found == values_.end() ? nullptr : found->second.get();
}

GltfTrs GltfPose::pose_of(std::size_t node) const {
  GltfTrs pose;
  if (values_.empty()) return pose;
  if (const auto* t = value_of(node, GltfPath::kTranslation)) pose.translation_m = Vec3(t->data());
  if (const auto* r = value_of(node, GltfPath::kRotation))
    pose.rotation = Eigen::Vector4d(r->data());
  if (const auto* s = value_of(node, GltfPath::kScale)) pose.scale = Vec3(s->data());
  return pose;
}

const std::vector<double>* GltfPose::weights_of(std::size_t node) const {
  return value_of(node, GltfPath::kWeights);
}

}  // namespace palpate
