#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "engine/accuracy/built_scene.h"
#include "engine/accuracy/error_measures.h"
#include "engine/accuracy/knobs.h"
#include "engine/accuracy/proxy_reference.h"
#include "engine/accuracy/session_pass.h"
#include "geometry/base/random.h"
#include "haptics/record_vectors.h"

namespace palpate {
namespace {

// A flat cone, pressed around its tip: the more triangles meet there, the more of them each tick
// crosses.
constexpr double kConeRadius_m = 0.05;
constexpr double kSlope = 0.5;
constexpr double kAround_m = 2e-3;
constexpr double kSpeed_m_per_s = 0.1;
constexpr std::size_t kPressTicks = 20;
constexpr WorkUnits kUnbounded = WorkUnits{1} << 50;

TriangleMesh cone(int triangles) {
  TriangleMesh mesh;
  mesh.positions_m.push_back(Vec3::Zero());
  for (int i = 0; i < triangles; ++i) {
    const double angle_rad = 2.0 * std::numbers::pi * i / triangles;
    mesh.positions_m.push_back(kConeRadius_m *
                               Vec3(std::cos(angle_rad), std::sin(angle_rad), -kSlope));
    const auto corner = static_cast<std::uint32_t>(i);
    mesh.triangles.push_back(
        {0, corner + 1, (corner + 1) % static_cast<std::uint32_t>(triangles) + 1});
  }
  return mesh;
}

class Cones {
 public:
  Cones(int triangles, std::size_t ticks)
      : scene_([triangles] { return mesh_scene(cone(triangles)); }), ticks_(ticks) {}

  // Errors are against a solver without a budget.
  Sample run(std::uint64_t seed, const Accuracy& accuracy) const {
    const std::vector<Vec3>& unbounded = references_->get(seed, [&] { return proxies(seed); });
    RootMeanSquare off_m;
    std::size_t n = 0;
    const PassCost cost = pass(seed, accuracy, [&](const TickRecord& record) {
      if (n < unbounded.size()) off_m.add((vec3(record.proxy_scene_m) - unbounded[n++]).norm());
    });
    Sample sample{off_m.value(), cost.tick_ns, cost.iterations, cost.ticks,
                  failure_of(cost.faults)};
    if (cost.ticks != unbounded.size()) sample.failure = "lost contact";
    return sample;
  }

 private:
  PassCost pass(std::uint64_t seed, const Accuracy& accuracy, const OnContact& visit) const {
    const PassSetup setup = PassSetup::fully_actuated(kAccuracyCoupling, {0.0, accuracy});
    return run_path(scene_.world(), setup, path_of(seed), kAccuracyPeriod_s, kPressTicks, visit);
  }
  std::vector<Vec3> proxies(std::uint64_t seed) const {
    Accuracy unbounded = Accuracy::balanced();
    unbounded.work_budget = kUnbounded;
    std::vector<Vec3> proxies_m;
    pass(seed, unbounded,
         [&](const TickRecord& record) { proxies_m.push_back(vec3(record.proxy_scene_m)); });
    return proxies_m;
  }

  // From above, then around the tip, in and out, at a depth of 1 to 3 mm.
  std::vector<Vec3> path_of(std::uint64_t seed) const {
    SeededRandom random(seed);
    const double start_rad = random.uniform(0.0, 2.0 * std::numbers::pi);
    const double swing_hz = random.uniform(2.0, 4.0);
    std::vector<Vec3> path_m;
    for (std::size_t n = 0; n < kPressTicks + ticks_; ++n) {
      const double time_s = kAccuracyPeriod_s * static_cast<double>(n);
      const double angle_rad = start_rad + kSpeed_m_per_s / kAround_m * time_s;
      const double away_m =
          kAround_m * (1.0 + 0.9 * std::sin(2.0 * std::numbers::pi * swing_hz * time_s));
      const double share =
          std::min(1.0, static_cast<double>(n) / static_cast<double>(kPressTicks - 1));
      const double depth_m = 2e-3 + 1e-3 * std::cos(2.0 * std::numbers::pi * time_s);
      const double z_m = (1.0 - share) * 5e-3 - kSlope * away_m - share * depth_m;
      path_m.push_back({away_m * std::cos(angle_rad), away_m * std::sin(angle_rad), z_m});
    }
    return path_m;
  }

  LazyScene scene_;
  std::size_t ticks_;
  std::shared_ptr<ProxyReference> references_ = std::make_shared<ProxyReference>();
};

}  // namespace

Knob work_budget_knob(const MeasurementEffort& effort) {
  Knob knob;
  knob.name = "work_budget";
  knob.title = "Work that a tick may do";
  knob.level = {"budget", "units"};
  knob.error = {"distance to the proxy without a budget (rms)", "m"};
  knob.time = {"time of a tick", "ns"};
  knob.workload =
      "A hand at 0.1 m/s, pressed 1 to 3 mm into a flat cone, round its tip; K = 1000 N/m, "
      "B = 2 N s/m, 1 kHz. At the tip of the hard cone 2,000 needles meet, at that of the easy "
      "cone "
      "12 triangles. A tick that exhausts its budget is capped, and the next tick continues the "
      "motion.";
  knob.reference = "the same hand and solver without a budget";
  knob.floor_is = "the rounding of a file's coordinates to single precision";
  knob.methods_are_given = true;
  knob.enough = 1e-6;
  knob.enough_because = "1 µm is 1 mN at 1000 N/m, below the resolution of haptic devices";
  knob.default_because =
      "it bounds the time of a tick on any scene; without a budget, one tick at a tip of 150,000 "
      "needles takes a tenth of a second";
  const std::size_t ticks = effort.quick ? 300 : 1000;
  struct Tip {
    const char* name;
    int triangles;
  };
  for (const Tip& tip : {Tip{"2,000 needles", 2000}, Tip{"12 triangles", 12}}) {
    const Cones cones(tip.triangles, ticks);
    if (knob.methods.empty()) {
      knob.run_preset = [cones](std::uint64_t seed, const Accuracy& preset) {
        return cones.run(seed, preset);
      };
    }
    Method method{tip.name, {}, {}, float_floor_m(kConeRadius_m)};
    for (const WorkUnits budget :
         {200, 500, 1'000, 2'000, 5'000, 10'000, 20'000, 50'000, 200'000}) {
      if (budget == Accuracy::balanced().work_budget) knob.default_level = method.levels.size();
      Accuracy accuracy = Accuracy::balanced();
      accuracy.work_budget = budget;
      method.levels.push_back(
          {static_cast<double>(budget), std::to_string(budget),
           [cones, accuracy](std::uint64_t seed) { return cones.run(seed, accuracy); }});
    }
    knob.methods.push_back(std::move(method));
  }
  return knob;
}

}  // namespace palpate
