#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <utility>

#include "engine/accuracy/built_scene.h"
#include "engine/accuracy/error_measures.h"
#include "engine/accuracy/knobs.h"
#include "engine/accuracy/session_pass.h"
#include "geometry/base/random.h"
#include "haptics/record_vectors.h"

namespace palpate {
namespace {

constexpr double kLength_m = 0.1;  // along the bottom of the groove
constexpr double kSlope_m = 0.05;  // of each of its walls

// A groove in any pose: its bottom is the x axis, its walls rise on both sides of the z axis.
struct Groove {
  RigidTransform T_scene_groove;
  std::shared_ptr<const Scene> scene;
};

// Corners are random, so that no edges are aligned. Both walls share the corners of the bottom, so
// that there is no crack.
Groove make_groove(double angle_rad, SeededRandom& random) {
  constexpr std::uint32_t kAlong = 12;
  constexpr std::uint32_t kUp = 6;             // triangles up each wall
  constexpr std::uint32_t kRow = 2 * kUp + 1;  // corners from rim to rim
  Groove groove{random.pose(0.2), nullptr};
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i <= kAlong; ++i) {
    for (std::uint32_t j = 0; j < kRow; ++j) {
      const double rise = std::abs(static_cast<double>(j) - kUp);
      const double side = j < kUp ? -1.0 : 1.0;
      const Vec3 up(0.0, side * std::sin(0.5 * angle_rad), std::cos(0.5 * angle_rad));
      const double x = (i + random.uniform(-0.3, 0.3)) / kAlong - 0.5;
      const double z = rise == 0.0 ? 0.0 : (rise + random.uniform(-0.3, 0.3)) / kUp;
      const Vec3 p = x * kLength_m * Vec3::UnitX() + z * kSlope_m * up;
      mesh.positions_m.push_back(groove.T_scene_groove.point(p));
    }
  }
  for (std::uint32_t i = 0; i < kAlong; ++i) {
    for (std::uint32_t j = 0; j + 1 < kRow; ++j) {
      const std::uint32_t a = i * kRow + j;
      const std::uint32_t b = a + kRow;
      mesh.triangles.push_back({a, b, a + 1});
      mesh.triangles.push_back({a + 1, b, b + 1});
    }
  }
  groove.scene = mesh_scene(std::move(mesh));
  return groove;
}

// Grooves by seed, so that every method uses the same grooves.
class Grooves {
 public:
  Grooves(double angle_rad, std::size_t ticks) : angle_rad_(angle_rad), ticks_(ticks) {}

  // The device is pressed below the bottom and moves along it: the exact proxy is on the bottom,
  // beside the device.
  Sample run(std::uint64_t seed, const Accuracy& accuracy) const {
    SeededRandom random(seed);
    Groove& groove = (*kept_)[seed];
    if (!groove.scene) groove = make_groove(angle_rad_, random);
    SeededRandom of_path(~seed);
    const std::size_t lead_in = 20;
    const std::vector<Vec3> path_m = path(groove.T_scene_groove, lead_in, of_path);
    RootMeanSquare off_m;
    bool leaked = false;
    const PassCost cost = run_path(
        groove.scene->world(), PassSetup::fully_actuated(kAccuracyCoupling, {0.0, accuracy}),
        path_m, kAccuracyPeriod_s, lead_in, [&](const TickRecord& record) {
          const Vec3 goal = groove.T_scene_groove.inverse_point(vec3(record.goal_scene_m));
          const Vec3 proxy = groove.T_scene_groove.inverse_point(vec3(record.proxy_scene_m));
          const double off = (proxy - Vec3(goal.x(), 0.0, 0.0)).norm();
          off_m.add(off);
          leaked = leaked || off > 0.5 * least_depth_m();
        });
    Sample sample{off_m.value(), cost.tick_ns, cost.iterations, cost.ticks,
                  failure_of(cost.faults)};
    if (leaked || cost.ticks != ticks_) sample.failure = "leaked: the proxy passed a wall";
    return sample;
  }

 private:
  static double least_depth_m() { return 1e-3; }

  // From the open end to below the bottom, then back and forth along it, trembling. For all goals
  // the bottom is the nearest point in front of both walls.
  std::vector<Vec3> path(const RigidTransform& T_scene_groove, std::size_t lead_in,
                         SeededRandom& random) const {
    std::vector<Vec3> path_m;
    const double steepest = std::tan(0.5 * angle_rad_);
    for (std::size_t n = 0; n < lead_in + ticks_; ++n) {
      const double time_s = kAccuracyPeriod_s * static_cast<double>(n);
      const double x_m = 0.35 * kLength_m * std::sin(2.0 * std::numbers::pi * time_s);
      const double share = std::min(1.0, static_cast<double>(n) / static_cast<double>(lead_in - 1));
      const double depth_m = least_depth_m() * (1.0 + random.uniform(0.0, 2.0));
      const double z_m =
          (1.0 - share) * 0.8 * kSlope_m * std::cos(0.5 * angle_rad_) - share * depth_m;
      // Beside the plane of symmetry, the bottom is nearest while |y| tan(angle/2) <= -z.
      const double most_y_m = 0.9 * std::min(depth_m / std::max(steepest, 1e-3), depth_m);
      const double y_m = share == 1.0 ? random.uniform(-1.0, 1.0) * most_y_m : 0.0;
      path_m.push_back(T_scene_groove.point({x_m, y_m, z_m}));
    }
    return path_m;
  }

  double angle_rad_;
  std::size_t ticks_;
  std::shared_ptr<std::map<std::uint64_t, Groove>> kept_ =
      std::make_shared<std::map<std::uint64_t, Groove>>();
};

}  // namespace

Knob certification_knob(const MeasurementEffort& effort) {
  Knob knob;
  knob.name = "certification";
  knob.title = "Certified path";
  knob.level = {"angle of the groove", "deg"};
  knob.error = {"distance to the exact proxy (rms)", "m"};
  knob.time = {"time of a tick", "ns"};
  knob.workload =
      "A hand trembles below the bottom of a V-shaped groove and moves along it, the hardest place "
      "for a proxy. Certified: each step of the proxy is proven to pass no surface, which does not "
      "reduce the error but excludes leaks. K = 1000 N/m, B = 2 N s/m, 1 kHz.";
  knob.reference = "the point of the bottom beside the device, in closed form";
  knob.floor_is = "the rounding of a file's coordinates to single precision";
  knob.levels_are_given = true;
  knob.enough = 1e-6;
  knob.enough_because = "1 µm is 1 mN at 1000 N/m, below the resolution of haptic devices";
  knob.default_because =
      "it buys not a smaller error but a proof, in every tick, that the proxy is in front of every "
      "triangle";
  const std::size_t ticks = effort.quick ? 500 : 2000;
  for (const bool certifies : {true, false}) {
    Method method{certifies ? "certified" : "not certified", {}, {}, float_floor_m(kLength_m)};
    Accuracy accuracy = Accuracy::balanced();
    accuracy.certify = certifies;
    for (const double angle_deg : {90.0, 60.0, 30.0, 10.0, 3.0, 1.0}) {
      const Grooves grooves(angle_deg * std::numbers::pi / 180.0, ticks);
      method.levels.push_back(
          {angle_deg, std::to_string(static_cast<int>(angle_deg)) + " deg",
           [grooves, accuracy](std::uint64_t seed) { return grooves.run(seed, accuracy); }});
    }
    knob.methods.push_back(std::move(method));
  }
  const Grooves square(0.5 * std::numbers::pi, ticks);
  knob.run_preset = [square](std::uint64_t seed, const Accuracy& preset) {
    return square.run(seed, preset);
  };
  return knob;
}

}  // namespace palpate
