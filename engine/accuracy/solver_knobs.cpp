#include <memory>
#include <string>
#include <utility>

#include "engine/accuracy/built_scene.h"
#include "engine/accuracy/error_measures.h"
#include "engine/accuracy/knobs.h"
#include "engine/accuracy/pressed_path.h"
#include "engine/accuracy/proxy_reference.h"
#include "engine/accuracy/session_pass.h"
#include "haptics/record_vectors.h"

namespace palpate {
namespace {

// Valleys in which the proxy touches several faces per tick.
constexpr double kBumpyRadius_m = 0.1;
constexpr double kBump_m = 3e-3;
constexpr int kWaves = 7;

constexpr const char* kCouplingText = "K = 1000 N/m, B = 2 N s/m, 1 kHz";

// One hand on the bumpy sphere, with various accuracies and speeds.
class Bumps {
 public:
  explicit Bumps(const MeasurementEffort& effort)
      : scene_([subdivisions = effort.quick ? 7 : 8] {
          return mesh_scene(bumpy_sphere(subdivisions, kBumpyRadius_m, kBump_m, kWaves));
        }),
        ticks_(effort.quick ? 500 : 2000) {}

  Sample run(std::uint64_t seed, double speed_m_per_s, const Accuracy& accuracy) const {
    const PressedPath path = path_of(seed, speed_m_per_s);
    const std::vector<Vec3>& converged =
        reference(speed_m_per_s)->get(seed, [&] { return proxies(path); });
    RootMeanSquare off_m;
    std::size_t n = 0;
    const PassCost cost = pass(path, accuracy, [&](const TickRecord& record) {
      if (n < converged.size()) off_m.add((vec3(record.proxy_scene_m) - converged[n++]).norm());
    });
    Sample sample{off_m.value(), cost.tick_ns, cost.iterations, cost.ticks,
                  failure_of(cost.faults)};
    if (cost.ticks != converged.size()) sample.failure = "lost contact";
    return sample;
  }

 private:
  PressedPath path_of(std::uint64_t seed, double speed_m_per_s) const {
    SeededRandom random(seed);
    PressSettings press;
    press.speed_m_per_s = speed_m_per_s;
    press.least_depth_m = 1e-3;
    press.most_depth_m = 3e-3;
    press.ticks = ticks_;
    return pressed_path(smooth_bumpy_sphere(kBumpyRadius_m, kBump_m, kWaves), 2.0 * kBumpyRadius_m,
                        press, random);
  }
  PassCost pass(const PressedPath& path, const Accuracy& accuracy, const OnContact& visit) const {
    const PassSetup setup = PassSetup::fully_actuated(kAccuracyCoupling, {0.0, accuracy});
    return run_path(scene_.world(), setup, path.device_m, kAccuracyPeriod_s, path.lead_in, visit);
  }
  std::vector<Vec3> proxies(const PressedPath& path) const {
    std::vector<Vec3> proxies_m;
    pass(path, Accuracy::exact(),
         [&](const TickRecord& record) { proxies_m.push_back(vec3(record.proxy_scene_m)); });
    return proxies_m;
  }
  std::shared_ptr<ProxyReference> reference(double speed_m_per_s) const {
    auto& kept = (*references_)[speed_m_per_s];
    if (!kept) kept = std::make_shared<ProxyReference>();
    return kept;
  }

  LazyScene scene_;
  std::size_t ticks_;
  std::shared_ptr<std::map<double, std::shared_ptr<ProxyReference>>> references_ =
      std::make_shared<std::map<double, std::shared_ptr<ProxyReference>>>();
};

constexpr double kFast_m_per_s = 1.0;

Knob common(const char* name, const char* title, const Bumps& bumps) {
  Knob knob;
  knob.name = name;
  knob.title = title;
  knob.error = {"distance to the converged proxy (rms)", "m"};
  knob.time = {"time of a tick", "ns"};
  knob.workload = std::string(
                      "A hand at 1 m/s, pressed 1 to 3 mm into a sphere of 0.2 m with "
                      "bumps of 6 mm; ") +
                  kCouplingText + ".";
  knob.reference = "the same hand under the preset exact";
  knob.floor_is = "the rounding of a file's coordinates to single precision";
  knob.run_preset = [bumps](std::uint64_t seed, const Accuracy& preset) {
    return bumps.run(seed, kFast_m_per_s, preset);
  };
  knob.enough = 1e-6;
  knob.enough_because = "1 µm is 1 mN at 1000 N/m, below the resolution of haptic devices";
  return knob;
}

Knob iterations_knob(const Bumps& bumps) {
  Knob knob = common("solver_iterations", "Solver: most steps per tick", bumps);
  knob.level = {"most steps", ""};
  Method capped{"capped", {}, {}, float_floor_m(kBumpyRadius_m)};
  for (const int most : {1, 2, 3, 4, 6, 8, 16, 32, 64, 128}) {
    if (most == Accuracy::balanced().iterations) knob.default_level = capped.levels.size();
    Accuracy accuracy = Accuracy::balanced();
    accuracy.iterations = most;
    capped.levels.push_back(
        {static_cast<double>(most), std::to_string(most), [bumps, accuracy](std::uint64_t seed) {
           return bumps.run(seed, kFast_m_per_s, accuracy);
         }});
  }
  knob.methods.push_back(std::move(capped));
  return knob;
}

Knob tolerance_knob(const Bumps& bumps) {
  Knob knob = common("solver_tolerance", "Solver: tolerance", bumps);
  knob.workload +=
      " A stand-off is the small distance that the proxy keeps from surfaces; the solver stops "
      "when "
      "a step is shorter than this number of stand-offs.";
  knob.level = {"shortest step, in stand-offs", ""};
  Method method{"tolerance", {}, {}, float_floor_m(kBumpyRadius_m)};
  struct Rung {
    double tolerance;
    const char* label;
  };
  for (const Rung& rung :
       {Rung{1e8, "1e8"}, Rung{1e7, "1e7"}, Rung{1e6, "1e6"}, Rung{1e5, "1e5"}, Rung{1e4, "1e4"},
        Rung{1e2, "100"}, Rung{1.0, "1"}, Rung{0.01, "0.01"}, Rung{1e-4, "1e-4"}}) {
    if (rung.tolerance == Accuracy::balanced().tolerance) {
      knob.default_level = method.levels.size();
    }
    Accuracy accuracy = Accuracy::balanced();
    accuracy.tolerance = rung.tolerance;
    method.levels.push_back({rung.tolerance, rung.label, [bumps, accuracy](std::uint64_t seed) {
                               return bumps.run(seed, kFast_m_per_s, accuracy);
                             }});
  }
  knob.methods.push_back(std::move(method));
  return knob;
}

// The proxies are the same to the bit: the knob buys time alone.
Knob candidates_knob(const Bumps& bumps) {
  Knob knob = common("candidate_reuse", "Candidates kept between ticks", bumps);
  knob.level = {"speed of the hand", "m/s"};
  knob.workload =
      std::string(
          "A hand pressed 1 to 3 mm into a sphere of 0.2 m with bumps of "
          "6 mm; ") +
      kCouplingText +
      ". Candidates are the triangles near the proxy: kept while they are valid, or searched in "
      "each tick.";
  knob.levels_are_given = true;
  knob.default_level = 2;
  constexpr double kUsual_m_per_s = 0.1;
  knob.run_preset = [bumps](std::uint64_t seed, const Accuracy& preset) {
    return bumps.run(seed, kUsual_m_per_s, preset);
  };
  struct Rung {
    double speed_m_per_s;
    const char* label;
  };
  for (const bool reuses : {true, false}) {
    Method method{reuses ? "kept" : "sought anew each tick", {}, {}, float_floor_m(kBumpyRadius_m)};
    Accuracy accuracy = Accuracy::balanced();
    accuracy.reuse_candidates = reuses;
    for (const Rung& rung :
         {Rung{0.02, "20 mm/s"}, Rung{0.05, "50 mm/s"}, Rung{kUsual_m_per_s, "100 mm/s"},
          Rung{0.2, "200 mm/s"}, Rung{0.5, "500 mm/s"}}) {
      method.levels.push_back({rung.speed_m_per_s, rung.label,
                               [bumps, accuracy, speed = rung.speed_m_per_s](std::uint64_t seed) {
                                 return bumps.run(seed, speed, accuracy);
                               }});
    }
    knob.methods.push_back(std::move(method));
  }
  return knob;
}

}  // namespace

std::vector<Knob> solver_knobs(const MeasurementEffort& effort) {
  const Bumps bumps(effort);
  return {iterations_knob(bumps), tolerance_knob(bumps), candidates_knob(bumps)};
}

}  // namespace palpate
