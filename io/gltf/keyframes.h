#pragma once

// The samplers of one animation, at one time (glTF 2.0, section 3.11 and appendix C).

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "geometry/base/result.h"
#include "io/gltf/accessor.h"

namespace palpate {

enum class GltfPath { kTranslation, kRotation, kScale, kWeights };

// Where a time falls among keys: at the key `before`, and by `share` of interval_s past it, towards
// the key `after`. Before the first key and behind the last one the share is 0.
struct GltfKeyInterval {
  std::size_t before = 0;
  std::size_t after = 0;
  double interval_s = 0.0;
  double share = 0.0;  // 0 to 1, 1 excluded
};

// times_s: not empty, finite. They should rise. Where they do not, a key counts unless an earlier
// one follows it, and of keys at one time the last counts from that time on.
GltfKeyInterval find_key_interval(const std::vector<double>& times_s, double time_s);

// Not thread-safe; must not outlive the asset, nor the warnings.
class GltfKeyframes {
 public:
  // pose_work: a budget; what is read is taken from it.
  GltfKeyframes(const GltfAsset& asset, std::size_t animation, double time_s,
                std::size_t& pose_work, std::vector<std::string>& warnings)
      : asset_(asset),
        animation_(animation),
        time_s_(time_s),
        pose_work_(pose_work),
        warnings_(warnings) {}

  // The value of the sampler of a channel, for a path: three numbers, four of a unit quaternion x,
  // y, z, w, or `weights` of them. At a key it is that of the key, to the bit. STEP; LINEAR, for
  // rotations along the shorter arc of the sphere; CUBICSPLINE, rotations divided by their length.
  //
  // The whole sampler is checked, whatever the time is. Refused: ids, types and numbers of elements
  // that are not as glTF asks for, numbers that are not finite, a negative time, a key that is no
  // unit quaternion, a spline through no rotation at this time. Times that do not rise are a
  // warning.
  Result<std::shared_ptr<const std::vector<double>>> value(std::size_t channel, GltfPath path,
                                                           std::size_t weights);

 private:
  struct Sampler {
    std::size_t id = 0;
    std::string element;
    std::size_t input = 0;  // accessors
    std::size_t output = 0;
    bool is_step = false;
    bool is_cubic = false;
  };

  Result<Sampler> sampler_of(std::size_t channel) const;
  Result<std::vector<double>> sample(const Sampler& sampler, GltfPath path, std::size_t width);
  Result<GltfKeyInterval> interval_of(const Sampler& sampler);
  void warn_of_order(const Sampler& sampler, const std::vector<double>& times_s);
  Result<std::vector<double>> read_all(std::size_t accessor, const GltfNumberFormat& format,
                                       const std::string& element);

  const GltfAsset& asset_;
  std::size_t animation_;
  double time_s_;
  std::size_t& pose_work_;
  std::vector<std::string>& warnings_;
  std::map<std::size_t, GltfKeyInterval> intervals_;  // by accessor
  // By sampler, path and width: a hostile file may have any number of channels of one sampler.
  std::map<std::tuple<std::size_t, GltfPath, std::size_t>,
           std::shared_ptr<const std::vector<double>>>
      values_;
};

// The largest time of the keys of an accessor of times: nothing if they cannot be read, or are more
// than the budget has left, from which they are taken.
std::optional<double> largest_key_time_s(const GltfAsset& asset, std::size_t accessor,
                                         std::size_t& budget);

}  // namespace palpate
