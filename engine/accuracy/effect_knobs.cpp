// The accuracy that the texels of a relief buy, and the cost of each effect.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "engine/accuracy/built_scene.h"
#include "engine/accuracy/effect_cases.h"
#include "engine/accuracy/error_measures.h"
#include "engine/accuracy/knobs.h"
#include "engine/accuracy/session_pass.h"
#include "engine/accuracy/sine_relief.h"
#include "engine/accuracy/sphere_paths.h"
#include "geometry/base/random.h"
#include "haptics/record_vectors.h"
#include "models/haptic_maps.h"

namespace palpate {
namespace {

// ---- texels ------------------------------------------------------------------------------------

constexpr int kTexelsPerWave[] = {4, 8, 16, 32, 64, 128};
constexpr int kModelTexelsPerWave = kMapSide / kMapWaves;  // of the models' own maps

Method sampled(const std::string& name, const SineRelief& relief, ImageDepth depth) {
  // Keys' interpolant is of third order. With few texels per wave its fourth-order error is as
  // large, and with many the rounding of the image is larger: no order fits the ladder.
  Method method{name, {}, {}, image_floor(depth)};
  for (const int texels : kTexelsPerWave) {
    method.levels.push_back(
        {relief.texel_m(texels), std::to_string(texels) + " texels a wave",
         [=](std::uint64_t seed) { return render_sine(relief, texels, depth, Accuracy{}, seed); }});
  }
  return method;
}

Knob texture_knob(const MeasurementEffort& effort) {
  SineRelief relief;
  if (!effort.quick) relief.waves = 3;
  Knob knob;
  knob.name = "texture_sampling";
  knob.title = "Texels of a relief";
  knob.level = {"texel", "m"};
  knob.error = {"error of the normal force (rms) over K H", ""};
  knob.time = {"time of a tick", "ns"};
  knob.workload =
      "A hand slides at 7 mm/s and a depth of 0.9 to 1.5 mm over a relief with waves of 3.9 mm, H "
      "= "
      "0.3 mm from the lowest to the highest point, from an image of n texels per wave; K = 1000 "
      "N/m, B = 0, T = 1 ms.";
  knob.reference =
      "K (d + h) with the sine h in closed form; the interpolant is of third order if a wave has "
      "many texels, and between third and fourth order if it has few";
  knob.floor_is = "half a step of the image's integers, over the height of the relief";
  knob.methods = {sampled("16 bits", relief, ImageDepth::k16Bit),
                  sampled("8 bits", relief, ImageDepth::k8Bit)};
  const auto* usual =
      std::find(std::begin(kTexelsPerWave), std::end(kTexelsPerWave), kModelTexelsPerWave);
  knob.default_level = static_cast<std::size_t>(usual - std::begin(kTexelsPerWave));
  knob.run_preset = [=](std::uint64_t seed, const Accuracy& preset) {
    return render_sine(relief, kModelTexelsPerWave, ImageDepth::k16Bit, preset, seed);
  };
  knob.enough = 0.01;
  knob.enough_because = "far below the 7 % by which people distinguish forces";
  knob.default_because =
      "more texels take no more time but more memory, also in a file, and 16 per wave are enough";
  return knob;
}

// ---- effects -----------------------------------------------------------------------------------

constexpr double kTappedRadius_m = 0.1;
constexpr HeightSwing kTaps{-3e-3, 1e-3, 0.25};

// Pairs of passes with and without the effects. The shortest of each counts, because other work of
// the machine only makes a pass longer.
constexpr int kPairs = 3;

// The resolution of the clock in a mean over the ticks. A difference of two times may be below it,
// even negative, if the effects cost nothing.
double least_time_ns(std::uint64_t ticks) {
  using Step = std::chrono::steady_clock::period;
  return 1e9 * Step::num / Step::den / static_cast<double>(std::max<std::uint64_t>(ticks, 1));
}

// A sphere of one size, compiled for a case on first use.
class EffectScenes {
 public:
  explicit EffectScenes(int subdivisions) : subdivisions_(subdivisions) {}

  const Result<Scene>& get(const EffectCase& effect_case) {
    const std::string key = effect_case.name;
    auto place = scenes_.find(key);
    if (place == scenes_.end()) {
      place = scenes_.emplace(key, effect_scene(subdivisions_, kTappedRadius_m, effect_case)).first;
    }
    return place->second;
  }

 private:
  int subdivisions_;
  std::map<std::string, Result<Scene>> scenes_;
};

// Forces of the ticks in contact, by tick.
using Forces = std::map<std::uint64_t, Vec3>;

double rms_difference_N(const Forces& a, const Forces& b) {
  RootMeanSquare off_N;
  for (const auto& [tick, force_N] : a) {
    const auto other = b.find(tick);
    if (other != b.end()) off_N.add((force_N - other->second).norm());
  }
  return off_N.value();
}

// A hand taps and slides over a sphere of one size.
class TappedSphere {
 public:
  TappedSphere(int subdivisions, std::size_t ticks) : scenes_(subdivisions), ticks_(ticks) {}

  // error: the force missing without the effects left out; time: that of the effects present.
  Sample run(std::uint64_t seed, const EffectCase& effect_case, const Accuracy& accuracy) {
    const Result<Scene>& with = scenes_.get(effect_case);
    const Result<Scene>& without = scenes_.get(same_without(effect_case));
    const Result<Scene>& all = scenes_.get(all_effects());
    for (const Result<Scene>* scene : {&with, &without, &all}) {
      if (!*scene) return Sample{.failure = scene->error().to_string()};
    }
    const std::vector<Vec3> path_m = path(seed);
    return compare(*with, *without, forces_of(full_, seed, *all, path_m), path_m, accuracy);
  }

  // error: the force that an effect alone adds; time: that of the effect.
  Sample run_alone(std::uint64_t seed, const EffectCase& effect_case, const Accuracy& accuracy) {
    const Result<Scene>& with = scenes_.get(effect_case);
    const Result<Scene>& without = scenes_.get(same_without(effect_case));
    for (const Result<Scene>* scene : {&with, &without}) {
      if (!*scene) return Sample{.failure = scene->error().to_string()};
    }
    const std::vector<Vec3> path_m = path(seed);
    return compare(*with, *without, forces_of(plain_, seed, *without, path_m), path_m, accuracy);
  }

 private:
  // Errors against these forces; times against the scene without effects.
  static Sample compare(const Scene& with, const Scene& without, const Forces& reference,
                        const std::vector<Vec3>& path_m, const Accuracy& accuracy) {
    Forces rendered;
    PassCost cost = pass(with, path_m, accuracy, &rendered);
    double without_ns = pass(without, path_m, accuracy, nullptr).tick_ns;
    for (int i = 1; i < kPairs; ++i) {
      cost.tick_ns = std::min(cost.tick_ns, pass(with, path_m, accuracy, nullptr).tick_ns);
      without_ns = std::min(without_ns, pass(without, path_m, accuracy, nullptr).tick_ns);
    }
    return {rms_difference_N(reference, rendered),
            std::max(cost.tick_ns - without_ns, least_time_ns(cost.ticks)), cost.iterations,
            cost.ticks, failure_of(cost.faults)};
  }
  // One case for all cases with the same geometry, so that they share a scene.
  static EffectCase same_without(const EffectCase& effect_case) {
    EffectCase plain = without_effects(effect_case);
    plain.name = effect_case.is_elsewhere ? "without, beside another" : "without";
    return plain;
  }
  std::vector<Vec3> path(std::uint64_t seed) const {
    const Quat turn = SeededRandom(seed).rotation();
    std::vector<Vec3> path_m = path_over_sphere(kTappedRadius_m, kTaps, ticks_);
    for (Vec3& p_m : path_m) p_m = turn * p_m;
    return path_m;
  }
  static PassCost pass(const Scene& scene, const std::vector<Vec3>& path_m,
                       const Accuracy& accuracy, Forces* forces) {
    const auto keep = [&](const TickRecord& record) {
      if (forces) forces->emplace(record.tick, vec3(record.force_device_N));
    };
    return run_path(scene.world(), PassSetup::fully_actuated(kAccuracyCoupling, {0.0, accuracy}),
                    path_m, kSpherePathPeriod_s, 0, keep);
  }
  static const Forces& forces_of(std::map<std::uint64_t, Forces>& kept, std::uint64_t seed,
                                 const Scene& scene, const std::vector<Vec3>& path_m) {
    const auto [place, is_new] = kept.try_emplace(seed);
    if (is_new) pass(scene, path_m, Accuracy{}, &place->second);
    return place->second;
  }

  EffectScenes scenes_;
  std::size_t ticks_;
  std::map<std::uint64_t, Forces> full_;   // by seed, of the sphere with all effects
  std::map<std::uint64_t, Forces> plain_;  // by seed, of the sphere without effects
};

using Spheres = std::vector<std::pair<int, std::shared_ptr<TappedSphere>>>;

Spheres spheres_of(const MeasurementEffort& effort) {
  Spheres spheres;
  for (int subdivisions = 3; subdivisions <= (effort.quick ? 6 : 7); ++subdivisions) {
    spheres.emplace_back(subdivisions,
                         std::make_shared<TappedSphere>(subdivisions, effort.quick ? 500 : 1000));
  }
  return spheres;
}

constexpr std::size_t triangles_of(int subdivisions) {
  return std::size_t{20} << (2 * subdivisions);
}

constexpr std::size_t kUsualSphere = 2;  // 20 thousand triangles
constexpr const char* kForceFloor =
    "the rounding of a file's coordinates to single precision, times K";
constexpr double force_floor_N() {
  return kAccuracyCoupling.stiffness_N_per_m * 0x1p-24 * kTappedRadius_m;
}

// The choices, from all effects to none.
std::vector<EffectCase> choices() {
  std::vector<EffectCase> choices{all_effects()};
  for (const std::string_view effect : measured_effects()) choices.push_back(all_but(effect));
  choices.push_back(effects_elsewhere());
  choices.back().name = "none touched";
  return choices;
}

Knob effects_knob(const Spheres& spheres) {
  Knob knob;
  knob.name = "effects";
  knob.title = "Effects left out";
  knob.level = {"triangles", ""};
  knob.error = {"force that is missing (rms)", "N"};
  knob.time = {"time that effects add to a tick", "ns"};
  knob.workload =
      "A hand slides at 0.1 m/s and a depth of 3 mm over a sphere of 0.2 m that has all ten "
      "effects, "
      "and taps it four times a second; K = 800 N/m and B = 1.5 N s/m, without these two effects "
      "1000 N/m and 2 N s/m; T = 1 ms. One effect is left out at a time: the difference between "
      "\"all\" and \"all but\" it is the time that the effect adds to a tick, and the error is the "
      "force that it adds. With \"none touched\" the effects belong to another sphere.";
  knob.reference =
      "the same hand on the sphere with all effects; times are against the sphere without effects";
  knob.floor_is = kForceFloor;
  knob.levels_are_given = true;
  for (const EffectCase& choice : choices()) {
    Method method{choice.name, {}, {}, force_floor_N()};
    for (const auto& [subdivisions, sphere] : spheres) {
      method.levels.push_back({static_cast<double>(triangles_of(subdivisions)),
                               triangles_label(triangles_of(subdivisions)),
                               [sphere = sphere, choice](std::uint64_t seed) {
                                 return sphere->run(seed, choice, Accuracy{});
                               }});
    }
    knob.methods.push_back(std::move(method));
  }
  knob.default_level = kUsualSphere;
  knob.run_preset = [sphere = spheres[kUsualSphere].second](std::uint64_t seed,
                                                            const Accuracy& preset) {
    return sphere->run(seed, all_effects(), preset);
  };
  knob.enough = force_floor_N();
  knob.enough_because = "a scene must be rendered as declared";
  knob.default_because = "a scene is rendered as declared";
  return knob;
}

// Neither effect nor mesh is a choice: the knob shows the cost of each effect and the force that it
// changes.
Knob effect_costs_knob(const Spheres& spheres) {
  Knob knob;
  knob.name = "effect_costs";
  knob.title = "Each effect alone";
  knob.level = {"triangles", ""};
  knob.error = {"force that it changes (rms)", "N"};
  knob.time = {"time that it adds to a tick", "ns"};
  knob.workload =
      "A hand slides at 0.1 m/s and a depth of 3 mm over a sphere of 0.2 m that has this effect "
      "alone, and taps it four times a second; K = 1000 N/m and B = 2 N s/m unless the effect sets "
      "them; T = 1 ms. The vertical axis is not an error: up is a stronger effect, to the right a "
      "more expensive one.";
  knob.reference = "the same hand on the sphere without effects, for forces and for times";
  knob.floor_is = kForceFloor;
  knob.levels_are_given = true;
  knob.methods_are_given = true;
  std::vector<EffectCase> cases{all_effects()};
  for (const std::string_view effect : measured_effects()) cases.push_back(only(effect));
  for (const EffectCase& one : cases) {
    Method method{one.name, {}, {}, force_floor_N()};
    for (const auto& [subdivisions, sphere] : spheres) {
      method.levels.push_back({static_cast<double>(triangles_of(subdivisions)),
                               triangles_label(triangles_of(subdivisions)),
                               [sphere = sphere, one](std::uint64_t seed) {
                                 return sphere->run_alone(seed, one, Accuracy{});
                               }});
    }
    knob.methods.push_back(std::move(method));
  }
  knob.default_level = kUsualSphere;
  knob.run_preset = [sphere = spheres[kUsualSphere].second](std::uint64_t seed,
                                                            const Accuracy& preset) {
    return sphere->run_alone(seed, all_effects(), preset);
  };
  knob.enough = std::numeric_limits<double>::infinity();
  knob.enough_because = "the scene declares its effects, so there is no choice";
  knob.default_because = "a scene is rendered as declared";
  return knob;
}

}  // namespace

std::vector<Knob> effect_knobs(const MeasurementEffort& effort) {
  const Spheres spheres = spheres_of(effort);
  return {texture_knob(effort), effect_costs_knob(spheres), effects_knob(spheres)};
}

}  // namespace palpate
