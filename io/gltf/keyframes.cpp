#include "io/gltf/keyframes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "io/gltf/error.h"
#include "io/gltf/json.h"
#include "io/gltf/limits.h"
#include "io/gltf/tinygltf.h"
#include "io/gltf/transform.h"

namespace palpate {
namespace {

using Json = nlohmann::json;
using Eigen::Vector4d;

// Section 3.11, table of the channel properties.
constexpr unsigned kFloatsOrNormalized =
    kGltfFloats | kGltfNormalizedSigned | kGltfNormalizedUnsigned;
constexpr GltfNumberFormat kTimes{"SCALAR", kGltfFloats, "times of keyframes"};
constexpr GltfNumberFormat kKeyedTranslations{"VEC3", kGltfFloats, "animated translations"};
constexpr GltfNumberFormat kKeyedRotations{"VEC4", kFloatsOrNormalized, "animated rotations"};
constexpr GltfNumberFormat kKeyedScales{"VEC3", kGltfFloats, "animated scales"};
constexpr GltfNumberFormat kKeyedWeights{"SCALAR", kFloatsOrNormalized, "animated weights"};

const GltfNumberFormat& format_of(GltfPath path) {
  switch (path) {
    case GltfPath::kTranslation:
      return kKeyedTranslations;
    case GltfPath::kRotation:
      return kKeyedRotations;
    case GltfPath::kScale:
      return kKeyedScales;
    default:
      return kKeyedWeights;
  }
}

std::string element_in(std::size_t animation, const std::string& list, std::size_t index) {
  return gltf_element("animations", animation, list + "/" + std::to_string(index));
}

// The numbers of all keys of a sampler, key by key: `width` numbers each, or, for a spline, `width`
// numbers each for the in-tangent, the value and the out-tangent.
class Keys {
 public:
  Keys(std::span<const double> numbers, std::size_t width, bool is_cubic)
      : numbers_(numbers), width_(width), is_cubic_(is_cubic) {}

  std::size_t count() const { return numbers_.size() / stride(); }
  std::span<const double> value(std::size_t key) const { return part(key, is_cubic_ ? 1 : 0); }
  std::span<const double> in_tangent(std::size_t key) const { return part(key, 0); }
  std::span<const double> out_tangent(std::size_t key) const { return part(key, 2); }

 private:
  std::size_t stride() const { return is_cubic_ ? 3 * width_ : width_; }
  std::span<const double> part(std::size_t key, std::size_t which) const {
    return numbers_.subspan(key * stride() + which * width_, width_);
  }

  std::span<const double> numbers_;
  std::size_t width_;
  bool is_cubic_;
};

// Appendix C.3, and C.4 for the shorter arc. The quaternions are at most a quarter turn of the
// sphere apart, so the sine is 0 only if they are equal.
Vector4d slerp(const Vector4d& from, const Vector4d& to, double share) {
  const Vector4d a = from.normalized();
  const Vector4d b = a.dot(to) < 0.0 ? Vector4d(-to.normalized()) : Vector4d(to.normalized());
  const double angle = 2.0 * std::atan2((b - a).norm(), (b + a).norm());
  const double sine = std::sin(angle);
  if (sine == 0.0) return a;
  return (std::sin((1.0 - share) * angle) * a + std::sin(share * angle) * b) / sine;
}

std::vector<double> linear(const Keys& keys, const GltfKeyInterval& at) {
  const auto a = keys.value(at.before);
  const auto b = keys.value(at.after);
  std::vector<double> value(a.size());
  for (std::size_t i = 0; i < value.size(); ++i) {
    value[i] = (1.0 - at.share) * a[i] + at.share * b[i];
  }
  return value;
}

// Appendix C.5.
std::vector<double> cubic(const Keys& keys, const GltfKeyInterval& at) {
  const double t = at.share;
  const double t2 = t * t;
  const double t3 = t2 * t;
  const auto a = keys.value(at.before);
  const auto out = keys.out_tangent(at.before);
  const auto b = keys.value(at.after);
  const auto in = keys.in_tangent(at.after);
  std::vector<double> value(a.size());
  for (std::size_t i = 0; i < value.size(); ++i) {
    value[i] = (2.0 * t3 - 3.0 * t2 + 1.0) * a[i] + at.interval_s * (t3 - 2.0 * t2 + t) * out[i] +
               (3.0 * t2 - 2.0 * t3) * b[i] + at.interval_s * (t3 - t2) * in[i];
  }
  return value;
}

}  // namespace

// Searches backwards: a key is used if no later key has an earlier time.
GltfKeyInterval find_key_interval(const std::vector<double>& times_s, double time_s) {
  std::size_t after = times_s.size();  // the first used key after time_s
  double least_s = std::numeric_limits<double>::infinity();
  for (std::size_t i = times_s.size(); i-- > 0;) {
    if (times_s[i] > least_s) continue;
    least_s = times_s[i];
    if (least_s > time_s) {
      after = i;
      continue;
    }
    if (after == times_s.size()) return {i, i, 0.0, 0.0};
    const double interval_s = times_s[after] - least_s;
    return {i, after, interval_s, (time_s - least_s) / interval_s};
  }
  return {after, after, 0.0, 0.0};
}

Result<GltfKeyframes::Sampler> GltfKeyframes::sampler_of(std::size_t channel) const {
  const Json& json = asset_.json["animations"][animation_];
  const auto samplers = json.find("samplers");
  if (samplers == json.end() || !samplers->is_array()) {
    return gltf_invalid(gltf_element("animations", animation_, "samplers"),
                        "is missing, or not an array");
  }
  const auto id =
      required_id(json["channels"][channel], element_in(animation_, "channels", channel), "sampler",
                  gltf_element("animations", animation_, "samplers").c_str(), samplers->size());
  if (!id) return id.error();
  const Json& object = (*samplers)[*id];
  Sampler sampler{*id, element_in(animation_, "samplers", *id)};
  if (!object.is_object()) return gltf_expected(sampler.element, object, "an object");
  const std::size_t accessors = asset_.model.accessors.size();
  const auto input = required_id(object, sampler.element, "input", "/accessors", accessors);
  if (!input) return input.error();
  const auto output = required_id(object, sampler.element, "output", "/accessors", accessors);
  if (!output) return output.error();
  sampler.input = *input;
  sampler.output = *output;
  const Json interpolation = object.value("interpolation", Json("LINEAR"));
  sampler.is_step = interpolation == "STEP";
  sampler.is_cubic = interpolation == "CUBICSPLINE";
  if (!sampler.is_step && !sampler.is_cubic && interpolation != "LINEAR") {
    return gltf_expected(sampler.element + "/interpolation", interpolation,
                         "LINEAR, STEP or CUBICSPLINE");
  }
  return sampler;
}

Result<std::shared_ptr<const std::vector<double>>> GltfKeyframes::value(std::size_t channel,
                                                                        GltfPath path,
                                                                        std::size_t weights) {
  const auto sampler = sampler_of(channel);
  if (!sampler) return sampler.error();
  const std::size_t width = path == GltfPath::kWeights ? weights : 1;
  const auto [known, is_new] = values_.try_emplace({sampler->id, path, width});
  if (is_new) {
    auto sampled = sample(*sampler, path, width);
    if (!sampled) return sampled.error();
    known->second = std::make_shared<const std::vector<double>>(std::move(*sampled));
  }
  return known->second;
}

// width: elements of the output in a value.
Result<std::vector<double>> GltfKeyframes::sample(const Sampler& sampler, GltfPath path,
                                                  std::size_t width) {
  const std::size_t per_key = sampler.is_cubic ? 3 * width : width;
  const std::size_t keys_in = asset_.model.accessors[sampler.input].count;
  const std::size_t elements = asset_.model.accessors[sampler.output].count;
  if (elements % per_key != 0 || elements / per_key != keys_in) {
    return gltf_invalid(sampler.element + "/output", "accessor " + std::to_string(sampler.output) +
                                                         " has " + std::to_string(elements) +
                                                         " elements; expected " +
                                                         std::to_string(per_key) + " for each of " +
                                                         std::to_string(keys_in) + " keyframes");
  }
  const auto interval = interval_of(sampler);
  if (!interval) return interval.error();
  const auto numbers = read_all(sampler.output, format_of(path), sampler.element + "/output");
  if (!numbers) return numbers;
  const bool is_rotation = path == GltfPath::kRotation;
  const Keys keys(*numbers, width * (numbers->size() / elements), sampler.is_cubic);
  for (std::size_t i = 0; is_rotation && i < keys.count(); ++i) {
    const Vector4d q(keys.value(i).data());
    if (auto error = check_rotation(q, sampler.element + "/output")) {
      error->problem = "key " + std::to_string(i) + " " + error->problem;
      return *error;
    }
  }
  if (interval->share == 0.0 || sampler.is_step) {
    const auto key = keys.value(interval->before);
    return std::vector<double>(key.begin(), key.end());
  }
  if (!sampler.is_cubic && is_rotation) {
    const Vector4d q = slerp(Vector4d(keys.value(interval->before).data()),
                             Vector4d(keys.value(interval->after).data()), interval->share);
    return std::vector<double>(q.data(), q.data() + 4);
  }
  if (!sampler.is_cubic) return linear(keys, *interval);
  auto value = cubic(keys, *interval);
  if (!is_rotation) return value;
  const Vector4d q = Vector4d(value.data()).stableNormalized();
  if (!(q.norm() > 0.5)) {
    return gltf_invalid(
        sampler.element + "/output",
        "its spline passes through a zero quaternion at " + std::to_string(time_s_) + " s");
  }
  return std::vector<double>(q.data(), q.data() + 4);
}

Result<GltfKeyInterval> GltfKeyframes::interval_of(const Sampler& sampler) {
  if (const auto known = intervals_.find(sampler.input); known != intervals_.end()) {
    return known->second;
  }
  const auto times_s = read_all(sampler.input, kTimes, sampler.element + "/input");
  if (!times_s) return times_s.error();
  const double least_s = *std::min_element(times_s->begin(), times_s->end());
  if (least_s < 0.0) {
    return gltf_invalid(sampler.element + "/input", "accessor " + std::to_string(sampler.input) +
                                                        " has a key at " + std::to_string(least_s) +
                                                        " s; expected 0 or later");
  }
  warn_of_order(sampler, *times_s);
  return intervals_.emplace(sampler.input, find_key_interval(*times_s, time_s_)).first->second;
}

void GltfKeyframes::warn_of_order(const Sampler& sampler, const std::vector<double>& times_s) {
  std::optional<std::size_t> falls;
  std::optional<std::size_t> stays;
  for (std::size_t i = 1; i < times_s.size(); ++i) {
    if (!falls && times_s[i] < times_s[i - 1]) falls = i;
    if (!stays && times_s[i] == times_s[i - 1]) stays = i;
  }
  const auto warn = [&](std::size_t key, const char* is, const char* reading) {
    warnings_.push_back(sampler.element + "/input: key " + std::to_string(key) + " at " +
                        std::to_string(times_s[key]) + " s " + is +
                        " the previous key; expected increasing times. " + reading);
  };
  if (falls) {
    warn(*falls, "is earlier than", "Keys are ignored if a key with an earlier time follows");
  }
  if (stays) {
    warn(*stays, "has the time of", "The last of several keys at one time is used from then on");
  }
}

// Reads all elements, after checking that they are present, before memory is allocated.
Result<std::vector<double>> GltfKeyframes::read_all(std::size_t accessor_id,
                                                    const GltfNumberFormat& format,
                                                    const std::string& element) {
  if (const auto none = read_numbers(asset_, accessor_id, format, 0); !none) return none;
  const tinygltf::Accessor& accessor = asset_.model.accessors[accessor_id];
  const bool is_stored = accessor.bufferView >= 0;
  const auto components = static_cast<std::size_t>(
      tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor.type)));
  if (accessor.count > pose_work_ / components ||
      (!is_stored && !asset_.buffers.take_unstored(accessor.count))) {
    return gltf_error(ErrorCode::kLimitExceeded, element,
                      is_stored
                          ? "raises the data to read for the pose to more than " +
                                std::to_string(kMaxGltfPoseWork) + " numbers"
                          : "raises the number of elements without a bufferView to more than " +
                                std::to_string(kMaxGltfUnstored) + ", the limit");
  }
  pose_work_ -= accessor.count * components;
  return read_numbers(asset_, accessor_id, format, accessor.count);
}

std::optional<double> largest_key_time_s(const GltfAsset& asset, std::size_t accessor_id,
                                         std::size_t& budget) {
  const tinygltf::Accessor& accessor = asset.model.accessors[accessor_id];
  if (!read_numbers(asset, accessor_id, kTimes, 0)) return std::nullopt;
  const bool is_stored = accessor.bufferView >= 0;
  const bool is_too_long =
      accessor.count > budget || (!is_stored && accessor.count > kMaxGltfUnstored);
  if (is_too_long) return std::nullopt;
  budget -= accessor.count;
  const auto times_s = read_numbers(asset, accessor_id, kTimes, accessor.count);
  if (!times_s) return std::nullopt;
  return *std::max_element(times_s->begin(), times_s->end());
}

}  // namespace palpate
