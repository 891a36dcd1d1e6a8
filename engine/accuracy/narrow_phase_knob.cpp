#include <optional>
#include <string>
#include <utility>

#include "engine/accuracy/built_scene.h"
#include "engine/accuracy/error_measures.h"
#include "engine/accuracy/knobs.h"
#include "engine/accuracy/pressed_path.h"
#include "engine/accuracy/session_pass.h"
#include "haptics/record_vectors.h"

namespace palpate {
namespace {

constexpr double kSphereRadius_m = 0.1;
constexpr int kSubdivisions = 5;

// How a file places a mesh.
enum class PlacedBy { kNode, kVertices };

// The sphere at a distance along all three axes, as in a file in single precision.
std::shared_ptr<const Scene> sphere_at(const Vec3& place_m, PlacedBy placed_by) {
  TriangleMesh mesh = icosphere(kSubdivisions, kSphereRadius_m);
  if (placed_by == PlacedBy::kNode) return mesh_scene(std::move(mesh), 0.0, place_m);
  for (Vec3& p : mesh.positions_m) p = (p + place_m).cast<float>().cast<double>();
  return mesh_scene(std::move(mesh));
}

std::vector<Vec3> proxies_of(const ContactWorld& world, std::vector<Vec3> path_m,
                             const Vec3& place_m, std::size_t lead_in, const Accuracy& accuracy,
                             PassCost& cost) {
  for (Vec3& p : path_m) p += place_m;
  std::vector<Vec3> proxies_m;
  cost = run_path(world, PassSetup::fully_actuated(kAccuracyCoupling, {0.0, accuracy}), path_m,
                  kAccuracyPeriod_s, lead_in, [&](const TickRecord& record) {
                    proxies_m.emplace_back(vec3(record.proxy_scene_m) - place_m);
                  });
  return proxies_m;
}

// The same hand on the same sphere, at a distance and at the origin.
class Displaced {
 public:
  Displaced(const MeasurementEffort& effort, double distance_m, PlacedBy placed_by)
      : ticks_(effort.quick ? 500 : 2000),
        place_m_(Vec3::Constant(distance_m)),
        displaced_([place_m = place_m_, placed_by] { return sphere_at(place_m, placed_by); }) {}

  Sample run(std::uint64_t seed, const Accuracy& accuracy) const {
    static const LazyScene here([] { return sphere_at(Vec3::Zero(), PlacedBy::kNode); });
    SeededRandom random(seed);
    PressSettings press;
    press.ticks = ticks_;
    const PressedPath path =
        pressed_path(smooth_sphere(kSphereRadius_m), 2.0 * kSphereRadius_m, press, random);
    PassCost cost;
    const std::vector<Vec3> expected = proxies_of(here.world(), path.device_m, Vec3::Zero(),
                                                  path.lead_in, Accuracy::exact(), cost);
    const std::vector<Vec3> found =
        proxies_of(displaced_.world(), path.device_m, place_m_, path.lead_in, accuracy, cost);
    RootMeanSquare off_m;
    for (std::size_t n = 0; n < found.size() && n < expected.size(); ++n) {
      off_m.add((found[n] - expected[n]).norm());
    }
    Sample sample{off_m.value(), cost.tick_ns, cost.iterations, cost.ticks,
                  failure_of(cost.faults)};
    if (found.size() != expected.size()) sample.failure = "lost contact";
    return sample;
  }

 private:
  std::size_t ticks_;
  Vec3 place_m_;
  LazyScene displaced_;
};

}  // namespace

Knob narrow_phase_knob(const MeasurementEffort& effort) {
  Knob knob;
  knob.name = "narrow_phase";
  knob.title = "Arithmetic of the narrow phase, near the origin and far away";
  knob.level = {"distance from the origin along each axis", "m"};
  knob.error = {"distance to the proxy at the origin (rms)", "m"};
  knob.time = {"time of a tick", "ns"};
  knob.workload =
      "A hand at 0.1 m/s, pressed 1 to 3 mm into a sphere of 0.2 m and 20 thousand triangles. A "
      "file "
      "places the sphere by its node or by its vertices. The narrow phase, which moves the proxy "
      "among the triangles near it, computes in float or double. K = 1000 N/m, B = 2 N s/m, 1 kHz.";
  knob.reference = "the same hand on the same sphere at the origin, preset exact";
  knob.floor_is = "the rounding of a file's coordinates to single precision, at the origin";
  knob.levels_are_given = true;
  knob.enough = 1e-6;
  knob.enough_because = "1 µm is 1 mN at 1000 N/m, below the resolution of haptic devices";
  struct Variant {
    const char* name;
    NarrowPhase arithmetic;
    PlacedBy placed_by;
  };
  struct Rung {
    double distance_m;
    const char* label;
  };
  std::optional<Displaced> near;  // the default's: a copy has caches of its own
  for (const Variant& variant :
       {Variant{"double, by the node", NarrowPhase::kDouble, PlacedBy::kNode},
        Variant{"float, by the node", NarrowPhase::kFloat, PlacedBy::kNode},
        Variant{"double, by the vertices", NarrowPhase::kDouble, PlacedBy::kVertices},
        Variant{"float, by the vertices", NarrowPhase::kFloat, PlacedBy::kVertices}}) {
    Method method{variant.name, {}, {}, float_floor_m(kSphereRadius_m)};
    // The rounding of vertices to single precision grows with their coordinates. The stand-off of
    // the float arithmetic is a constant in addition.
    const bool is_rounding_alone =
        variant.placed_by == PlacedBy::kVertices && variant.arithmetic == NarrowPhase::kDouble;
    if (is_rounding_alone) method.expected_order = 1.0;
    Accuracy accuracy = Accuracy::balanced();
    accuracy.narrow_phase = variant.arithmetic;
    for (const Rung& rung : {Rung{1.0, "1 m"}, Rung{10.0, "10 m"}, Rung{100.0, "100 m"},
                             Rung{1000.0, "1 km"}, Rung{4000.0, "4 km"}}) {
      const Displaced displaced(effort, rung.distance_m, variant.placed_by);
      if (!near) near = displaced;
      method.levels.push_back(
          {rung.distance_m, rung.label,
           [displaced, accuracy](std::uint64_t seed) { return displaced.run(seed, accuracy); }});
    }
    knob.methods.push_back(std::move(method));
  }
  knob.run_preset = [near = *near](std::uint64_t seed, const Accuracy& preset) {
    return near.run(seed, preset);
  };
  return knob;
}

}  // namespace palpate
