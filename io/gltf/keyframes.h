#pragma once

// Evaluates the samplers of one animation at one time (glTF 2.0, section 3.11 and appendix C).

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

// The position of a time among the keys. The time is that of the key `before` plus
// share * interval_s, where interval_s is the time between the keys `before` and `after`. Before
// the first key and after the last key, the share is 0.
struct GltfKeyInterval {
  std::size_t before = 0;
  std::size_t after = 0;
  double interval_s = 0.0;
  double share = 0.0;  // in [0, 1)
};

// times_s: not empty, finite, and increasing in a valid file. In a file whose times do not
// increase, a key is ignored if a key with an earlier time follows it. If several keys have the
// same time, the last of them applies from that time on.
GltfKeyInterval find_key_interval(const std::vector<double>& times_s, double time_s);

// Not thread-safe; must not outlive the asset or the warnings.
class GltfKeyframes {
 public:
  // pose_work: a budget, from which the number of elements read is subtracted.
  GltfKeyframes(const GltfAsset& asset, std::size_t animation, double time_s,
                std::size_t& pose_work, std::vector<std::string>& warnings)
      : asset_(asset),
        animation_(animation),
        time_s_(time_s),
        pose_work_(pose_work),
        warnings_(warnings) {}

  // The value of a channel's sampler for a path. It consists of three numbers, of a unit quaternion
  // (x, y, z, w) or of `weights` numbers. At a key the result is exactly the key's value. The
  // interpolation is STEP, LINEAR or CUBICSPLINE. LINEAR interpolates rotations along the shorter
  // arc on the sphere; after CUBICSPLINE, rotations are normalised.
  //
  // The whole sampler is always checked, not only the keys that the time requires. Errors: ids,
  // types and numbers of elements that violate glTF; non-finite numbers; a negative time; a key
  // that is not a unit quaternion; a spline that passes through a zero quaternion at this time.
  // Times that do not increase cause a warning.
  Result<std::shared_ptr<const std::vector<double>>> value(std::size_t channel, GltfPath path,
                                                           std::size_t weights);

 private:
  struct Sampler {
    std::size_t id = 0;
    std::string element;
    std::size_t input = 0;   // accessor of the key times
    std::size_t output = 0;  // accessor of the key values
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
  std::map<std::size_t, GltfKeyInterval> intervals_;  // one per accessor of key times
  // Stored by sampler, path and width, and not by channel: a hostile file may have any number of
  // channels that use one sampler, and its values are computed and stored only once.
  std::map<std::tuple<std::size_t, GltfPath, std::size_t>,
           std::shared_ptr<const std::vector<double>>>
      values_;
};

// The largest time of an accessor of key times. No value if the times cannot be read, or if their
// number exceeds the budget. The number of times read is subtracted from the budget.
std::optional<double> largest_key_time_s(const GltfAsset& asset, std::size_t accessor,
                                         std::size_t& budget);

}  // namespace palpate
