#include "io/gltf_animation.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "io/gltf_error.h"
#include "io/gltf_json.h"
#include "io/tinygltf.h"

namespace palpate {
namespace {

using Json = nlohmann::json;

// Section 3.11, table of the channel properties.
constexpr unsigned kFloatsOrNormalized =
    kGltfFloats | kGltfNormalizedSigned | kGltfNormalizedUnsigned;
constexpr GltfNumberFormat kTimes{"SCALAR", kGltfFloats, "times of keyframes"};
constexpr GltfNumberFormat kTranslations{"VEC3", kGltfFloats, "animated translations"};
constexpr GltfNumberFormat kRotations{"VEC4", kFloatsOrNormalized, "animated rotations"};
constexpr GltfNumberFormat kScales{"VEC3", kGltfFloats, "animated scales"};
constexpr GltfNumberFormat kWeights{"SCALAR", kFloatsOrNormalized, "animated weights"};

std::string animation_element(std::size_t animation, const std::string& list, std::size_t index) {
  return gltf_element("animations", animation, list + "/" + std::to_string(index));
}

const Json& animation_json(const GltfAsset& asset, std::size_t animation) {
  return asset.json["animations"][animation];
}

// The object that a JSON object has under a name; null if there is none.
const Json* object_in(const Json& parent, const char* name) {
  if (!parent.is_object()) return nullptr;
  const auto found = parent.find(name);
  return found == parent.end() || !found->is_object() ? nullptr : &*found;
}

struct Sampler {
  std::string element;
  std::size_t input = 0;  // accessors
  std::size_t output = 0;
  bool cubic = false;
};

Result<Sampler> read_sampler(const GltfAsset& asset, std::size_t animation, std::size_t channel) {
  const Json& json = animation_json(asset, animation);
  const auto samplers = json.find("samplers");
  if (samplers == json.end() || !samplers->is_array()) {
    return gltf_invalid(gltf_element("animations", animation, "samplers"),
                        "is missing, or not an array");
  }
  const auto id = required_id(
      json["channels"][channel], animation_element(animation, "channels", channel), "sampler",
      gltf_element("animations", animation, "samplers").c_str(), samplers->size());
  if (!id) return id.error();
  const Json& object = (*samplers)[*id];
  Sampler sampler{animation_element(animation, "samplers", *id)};
  if (!object.is_object()) return gltf_expected(sampler.element, object, "an object");
  const std::size_t accessors = asset.model.accessors.size();
  const auto input = required_id(object, sampler.element, "input", "/accessors", accessors);
  if (!input) return input.error();
  const auto output = required_id(object, sampler.element, "output", "/accessors", accessors);
  if (!output) return output.error();
  sampler.input = *input;
  sampler.output = *output;
  const Json interpolation = object.value("interpolation", Json("LINEAR"));
  sampler.cubic = interpolation == "CUBICSPLINE";
  if (!sampler.cubic && interpolation != "LINEAR" && interpolation != "STEP") {
    return gltf_expected(sampler.element + "/interpolation", interpolation,
                         "LINEAR, STEP or CUBICSPLINE");
  }
  return sampler;
}

// Each keyframe has that many elements of the output.
std::optional<Error> check_counts(const GltfAsset& asset, const Sampler& sampler,
                                  std::size_t elements_per_key) {
  const std::size_t keys = asset.model.accessors[sampler.input].count;
  const std::size_t elements = asset.model.accessors[sampler.output].count;
  if (elements % elements_per_key == 0 && elements / elements_per_key == keys) return std::nullopt;
  return gltf_invalid(sampler.element + "/output",
                      "accessor " + std::to_string(sampler.output) + " has " +
                          std::to_string(elements) + " elements; expected " +
                          std::to_string(elements_per_key) + " for each of " +
                          std::to_string(keys) + " keyframes");
}

}  // namespace

Result<GltfAnimations> GltfAnimations::list(const GltfAsset& asset,
                                            std::vector<std::string>& warnings) {
  GltfAnimations animations(asset);
  const auto section = asset.json.find("animations");
  if (section == asset.json.end()) return animations;
  if (!section->is_array()) {
    warnings.push_back("/animations: is not an array and is ignored");
    return animations;
  }
  for (std::size_t a = 0; a < section->size(); ++a) {
    const Json& animation = (*section)[a];
    if (!animation.is_object() || !animation.contains("channels") ||
        !animation["channels"].is_array()) {
      warnings.push_back(gltf_element("animations", a) +
                         ": has no list of channels and is ignored");
      continue;
    }
    for (std::size_t c = 0; c < animation["channels"].size(); ++c) {
      if (auto error = animations.add_channel(a, c)) return *error;
    }
  }
  return animations;
}

std::optional<Error> GltfAnimations::add_channel(std::size_t animation, std::size_t index) {
  const Json* target = object_in(animation_json(asset_, animation)["channels"][index], "target");
  if (!target || !target->contains("path")) return std::nullopt;
  constexpr std::pair<const char*, Path> kPaths[] = {{"translation", Path::kTranslation},
                                                     {"rotation", Path::kRotation},
                                                     {"scale", Path::kScale},
                                                     {"weights", Path::kWeights}};
  const auto* path = std::find_if(std::begin(kPaths), std::end(kPaths),
                                  [&](const auto& p) { return (*target)["path"] == p.first; });
  if (path == std::end(kPaths)) return std::nullopt;
  const auto node =
      optional_id(*target, animation_element(animation, "channels", index) + "/target", "node",
                  "/nodes", asset_.model.nodes.size());
  if (!node) return node.error();
  if (!*node) return std::nullopt;
  const auto [known, added] =
      channels_.try_emplace({**node, path->second}, Channel{animation, index, std::nullopt, false});
  if (added) return std::nullopt;
  if (known->second.animation != animation) {
    known->second.overrides_others = true;
  } else if (!known->second.duplicate) {
    known->second.duplicate = index;
  }
  return std::nullopt;
}

Result<GltfTrs> GltfAnimations::pose_of(std::size_t node) {
  GltfTrs pose;
  const auto translation = sample(node, Path::kTranslation, 1);
  if (!translation) return translation.error();
  if (*translation) pose.translation_m = Vec3((*translation)->data());
  const auto rotation = sample(node, Path::kRotation, 1);
  if (!rotation) return rotation.error();
  if (*rotation) pose.rotation = Eigen::Vector4d((*rotation)->data());
  const auto scale = sample(node, Path::kScale, 1);
  if (!scale) return scale.error();
  if (*scale) pose.scale = Vec3((*scale)->data());
  return pose;
}

Result<std::optional<std::vector<double>>> GltfAnimations::weights_of(std::size_t node,
                                                                      std::size_t count) {
  return sample(node, Path::kWeights, count);
}

Result<std::optional<std::vector<double>>> GltfAnimations::sample(std::size_t node, Path path,
                                                                  std::size_t width) {
  const auto found = channels_.find({node, path});
  if (found == channels_.end()) return std::optional<std::vector<double>>();
  const Channel& channel = found->second;
  const std::string element = animation_element(channel.animation, "channels", channel.index);
  if (path != Path::kWeights && !asset_.model.nodes[node].matrix.empty()) {
    return gltf_invalid(element + "/target/node", "node " + std::to_string(node) +
                                                      " has a matrix; an animated node has " +
                                                      "translation, rotation and scale instead");
  }
  if (channel.duplicate) {
    return gltf_invalid(
        animation_element(channel.animation, "channels", *channel.duplicate) + "/target",
        "is that of channel " + std::to_string(channel.index) + ", too; expected each once");
  }
  auto value = sample_channel(channel, path, width);
  if (!value) return value.error();
  sampled_.insert(channel.animation);
  overridden_ |= channel.overrides_others;
  return std::optional(std::move(*value));
}

Result<std::vector<double>> GltfAnimations::sample_channel(const Channel& channel, Path path,
                                                           std::size_t width) {
  const auto sampler = read_sampler(asset_, channel.animation, channel.index);
  if (!sampler) return sampler.error();
  if (width == 0) {
    return gltf_invalid(animation_element(channel.animation, "channels", channel.index) + "/target",
                        "animates the weights of a mesh without morph targets");
  }
  if (auto error = check_counts(asset_, *sampler, sampler->cubic ? 3 * width : width)) {
    return *error;
  }
  const auto times = read_numbers(asset_, sampler->input, kTimes, 1);
  if (!times) return times.error();
  if (times->front() < 0.0) {
    return gltf_invalid(sampler->element + "/input",
                        "accessor " + std::to_string(sampler->input) + " begins at " +
                            std::to_string(times->front()) + " s; expected 0 or later");
  }
  const GltfNumberFormat& format = path == Path::kTranslation ? kTranslations
                                   : path == Path::kRotation  ? kRotations
                                   : path == Path::kScale     ? kScales
                                                              : kWeights;
  // A keyframe of CUBICSPLINE: all in-tangents, all values, all out-tangents.
  auto values = read_numbers(asset_, sampler->output, format, sampler->cubic ? 2 * width : width);
  if (!values) return values;
  if (sampler->cubic) {
    values->erase(values->begin(),
                  values->begin() + static_cast<std::ptrdiff_t>(values->size() / 2));
  }
  if (path == Path::kRotation) {
    if (auto error =
            check_rotation(Eigen::Vector4d(values->data()), sampler->element + "/output")) {
      return *error;
    }
  }
  return values;
}

std::string GltfAnimations::description() const {
  if (sampled_.empty()) return {};
  const std::size_t first = *sampled_.begin();
  const Json name = animation_json(asset_, first).value("name", Json());
  std::string text = sampled_.size() == 1
                         ? "time 0 of animation "
                         : "time 0 of " + std::to_string(sampled_.size()) + " animations, first ";
  text += name.is_string() ? gltf_quoted(name.get<std::string>()) : std::to_string(first);
  if (overridden_) text += " (the first in the file counts where several move the same)";
  return text;
}

}  // namespace palpate
