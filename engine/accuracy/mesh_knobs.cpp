#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "engine/accuracy/built_scene.h"
#include "engine/accuracy/error_measures.h"
#include "engine/accuracy/knobs.h"
#include "engine/accuracy/pressed_path.h"
#include "engine/accuracy/session_pass.h"
#include "geometry/base/degrees.h"
#include "haptics/record_vectors.h"

namespace palpate {
namespace {

constexpr double kMeshedRadius_m = 0.1;
constexpr double kTube_m = 0.04;

// A smooth surface and one of its meshes.
struct Meshed {
  SmoothSurface smooth;
  double extent_m;
  double edge_m;
  std::size_t triangles;
  LazyScene scene;  // for proxies with a radius of at most most_radius_m
};

Meshed meshed_sphere(int subdivisions, double most_radius_m = 0.0) {
  // From 6 subdivisions on, each further one halves the mean edge to within 0.1 %.
  const TriangleMesh coarse = icosphere(std::min(subdivisions, 6), kMeshedRadius_m);
  return {smooth_sphere(kMeshedRadius_m), 2.0 * kMeshedRadius_m,
          mean_edge_m(coarse) / std::exp2(std::max(0, subdivisions - 6)),
          std::size_t{20} << (2 * subdivisions), LazyScene([=] {
            return mesh_scene(icosphere(subdivisions, kMeshedRadius_m), most_radius_m);
          })};
}

Meshed meshed_torus(int subdivisions) {
  const TriangleMesh coarse = torus(kMeshedRadius_m, kTube_m, std::min(subdivisions, 5));
  return {smooth_torus(kMeshedRadius_m, kTube_m), 2.0 * (kMeshedRadius_m + kTube_m),
          mean_edge_m(coarse) / std::exp2(std::max(0, subdivisions - 5)),
          std::size_t{64} << (2 * subdivisions),
          LazyScene([=] { return mesh_scene(torus(kMeshedRadius_m, kTube_m, subdivisions)); })};
}

// Errors of the faceted surface against the smooth one.
struct FacetErrors {
  RootMeanSquare depth_m;
  RootMeanSquare angle_deg;
  PassCost cost;
};

FacetErrors run_hand(const Meshed& meshed, std::uint64_t seed, std::size_t ticks,
                     const GodObjectSettings& god_object) {
  SeededRandom random(seed);
  PressSettings press;
  press.proxy_radius_m = god_object.radius_m;
  press.ticks = ticks;
  const PressedPath path = pressed_path(meshed.smooth, meshed.extent_m, press, random);
  FacetErrors errors;
  const auto visit = [&](const TickRecord& record) {
    const SmoothPoint smooth = meshed.smooth(vec3(record.goal_scene_m));
    const double depth_m =
        smooth.normal.dot(smooth.point_m - vec3(record.goal_scene_m)) + god_object.radius_m;
    errors.depth_m.add((vec3(record.proxy_scene_m) - vec3(record.goal_scene_m)).norm() - depth_m);
    const Vec3& n = vec3(record.normal_scene);
    errors.angle_deg.add(kDegreesPerRad *
                         std::atan2(n.cross(smooth.normal).norm(), n.dot(smooth.normal)));
  };
  errors.cost =
      run_path(meshed.scene.world(), PassSetup::fully_actuated(kAccuracyCoupling, god_object),
               path.device_m, kAccuracyPeriod_s, path.lead_in, visit);
  return errors;
}

enum class Measure { kDepth, kAngle };

Sample sample_of(const FacetErrors& errors, Measure measure) {
  return {measure == Measure::kDepth ? errors.depth_m.value() : errors.angle_deg.value(),
          errors.cost.tick_ns, errors.cost.iterations, errors.cost.ticks,
          failure_of(errors.cost.faults)};
}

constexpr const char* kHand =
    "A hand at 0.1 m/s, pressed 1 to 3 mm into the mesh; K = 1000 N/m, B = 2 N s/m, 1 kHz.";
constexpr const char* kFloat = "the rounding of a file's coordinates to single precision";

// One method per surface, one level per mesh of the surface.
Knob resolution_knob(const MeasurementEffort& effort, Measure measure) {
  const bool is_depth = measure == Measure::kDepth;
  Knob knob;
  knob.name = is_depth ? "mesh_depth" : "mesh_angle";
  knob.title = is_depth ? "Mesh resolution: depth" : "Mesh resolution: direction of the force";
  knob.level = {"mean edge", "m"};
  knob.error = is_depth ? Quantity{"error of the depth (rms)", "m"}
                        : Quantity{"error of the contact normal (rms)", "deg"};
  knob.time = {"time of a tick", "ns"};
  knob.methods_are_given = true;
  knob.workload = kHand;
  knob.reference = "the smooth surface, in closed form: a sphere of 0.2 m, a torus of 0.28 m";
  knob.floor_is = kFloat;
  knob.enough = is_depth ? kEnoughDepth_m : 3.0;
  knob.enough_because = is_depth
                            ? kEnoughDepthBecause
                            : "a tenth of the 30 degrees by which a hand distinguishes directions";
  if (!is_depth) knob.decided_by = "mesh_depth";
  knob.default_because = "the user's file determines the mesh";
  const std::size_t ticks = effort.quick ? 1000 : 2000;
  constexpr int kUsual = 5;            // 20 thousand triangles
  std::optional<Meshed> default_mesh;  // presets use the same mesh: a copy has caches of its own
  const auto add = [&](const char* name, Meshed (*make)(int), int first, int last) {
    Method method{name, {}, is_depth ? 2.0 : 1.0, is_depth ? float_floor_m(kMeshedRadius_m) : 0.0};
    for (int s = first; s <= last; ++s) {
      const Meshed meshed = make(s);
      if (knob.methods.empty() && s == kUsual) {
        default_mesh = meshed;
        knob.default_level = method.levels.size();
      }
      method.levels.push_back(
          {meshed.edge_m, triangles_label(meshed.triangles), [=](std::uint64_t seed) {
             return sample_of(run_hand(meshed, seed, ticks, {}), measure);
           }});
    }
    knob.methods.push_back(std::move(method));
  };
  const int coarser = effort.quick ? 1 : 0;
  const auto sphere = [](int s) { return meshed_sphere(s); };
  add("sphere", sphere, 3, 8 - coarser);
  add("torus", meshed_torus, 2, 7 - coarser);
  knob.default_method = 0;
  knob.run_preset = [=, usual = *default_mesh](std::uint64_t seed, const Accuracy& preset) {
    return sample_of(run_hand(usual, seed, ticks, {0.0, preset}), measure);
  };
  return knob;
}

Knob radius_knob(const MeasurementEffort& effort) {
  Knob knob;
  knob.name = "proxy_radius";
  knob.title = "Sphere against point proxy";
  knob.level = {"mean edge", "m"};
  knob.error = {"error of the contact normal (rms)", "deg"};
  knob.time = {"time of a tick", "ns"};
  knob.workload = kHand;
  knob.reference = "The smooth sphere of 0.2 m, in closed form.";
  knob.levels_are_given = true;
  knob.enough = 3.0;
  knob.enough_because = "a tenth of the 30 degrees by which a hand distinguishes directions";
  knob.default_because =
      "a point renders every crack and edge as modelled; a sphere stands for the tip of a tool";
  const std::size_t ticks = effort.quick ? 500 : 1000;
  struct Proxy {
    const char* name;
    double radius_m;
  };
  constexpr double kMostRadius_m = 5e-3;
  std::vector<Meshed> meshes;
  for (int s = 3; s <= (effort.quick ? 6 : 7); ++s) {
    meshes.push_back(meshed_sphere(s, kMostRadius_m));
  }
  for (const Proxy& proxy : {Proxy{"point", 0.0}, Proxy{"sphere, 0.5 mm", 5e-4},
                             Proxy{"sphere, 2 mm", 2e-3}, Proxy{"sphere, 5 mm", kMostRadius_m}}) {
    Method method{proxy.name, {}, {}, 0.0};
    for (const Meshed& meshed : meshes) {
      method.levels.push_back(
          {meshed.edge_m, triangles_label(meshed.triangles),
           [=, radius_m = proxy.radius_m](std::uint64_t seed) {
             return sample_of(run_hand(meshed, seed, ticks, {radius_m, {}}), Measure::kAngle);
           }});
    }
    knob.methods.push_back(std::move(method));
  }
  knob.default_level = 2;
  knob.run_preset = [=, usual = meshes[2]](std::uint64_t seed, const Accuracy& preset) {
    return sample_of(run_hand(usual, seed, ticks, {0.0, preset}), Measure::kAngle);
  };
  return knob;
}

}  // namespace

std::vector<Knob> mesh_knobs(const MeasurementEffort& effort) {
  return {resolution_knob(effort, Measure::kDepth), resolution_knob(effort, Measure::kAngle),
          radius_knob(effort)};
}

}  // namespace palpate
