// What each effect adds to a tick: the sliding proxy on a sphere that has it, beside the same
// sphere without.

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

#include "benchmarks/percentiles.h"
#include "benchmarks/registration.h"
#include "benchmarks/sphere.h"
#include "benchmarks/trajectories.h"
#include "haptics/haptic_loop.h"
#include "models/primitives.h"

namespace palpate::bench {
namespace {

// Larger ones tell nothing new: an effect's time does not go by the size of the mesh.
constexpr int kMostSubdivisions = 8;

constexpr double kTextureTile_m = 2e-3;
constexpr std::uint32_t kTexels = 64;

// Passes over the path with and without the effect, in turn: the shortest of each count.
constexpr int kPairs = 8;

struct EffectCase {
  const char* effect;  // as reports call it; "all", or "elsewhere": all, on what is not touched
  std::vector<std::pair<const char*, double>> parameters;
};

const std::vector<EffectCase>& effect_cases() {
  static const std::vector<EffectCase> cases = [] {
    std::vector<EffectCase> list = {
        {"stiffness", {{"stiffness", 800.0}}},
        {"damping", {{"damping", 1.5}}},
        {"friction", {{"staticFriction", 0.5}, {"dynamicFriction", 0.4}}},
        {"texture", {{"textureHeight", 1e-4}}},
        {"shading", {{"creaseAngle", 60.0}}},
        {"vibration", {{"vibrationFrequency", 150.0}, {"vibrationAmplitude", 0.3}}},
        {"restitution", {{"restitution", 0.5}}},
        {"magnet", {{"magnetForce", 1.0}, {"magnetRange", 5e-3}}},
        {"viscosity", {{"viscosity", 2.0}}},
        {"gravity", {}},
    };
    EffectCase all{"all", {}};
    for (const EffectCase& one : list) {
      all.parameters.insert(all.parameters.end(), one.parameters.begin(), one.parameters.end());
    }
    list.push_back(all);
    all.effect = "elsewhere";
    list.push_back(all);
    return list;
  }();
  return cases;
}

bool has(const EffectCase& effect_case, const char* key) {
  return std::any_of(effect_case.parameters.begin(), effect_case.parameters.end(),
                     [&](const auto& parameter) { return std::string(parameter.first) == key; });
}

bool is(const EffectCase& effect_case, const char* effect) {
  return std::string(effect_case.effect) == effect;
}

MaterialParameter parameter(const char* key, MaterialValue value) {
  return {key, std::move(value), std::string("/materials/0/extras/palpate/") + key};
}

ImageDescription waves() {
  ImageDescription image{kTexels, kTexels, {}};
  for (std::uint32_t row = 0; row < kTexels; ++row) {
    for (std::uint32_t column = 0; column < kTexels; ++column) {
      const double phase = 2.0 * std::numbers::pi * (column + 0.5) / kTexels;
      const auto grey = static_cast<std::uint16_t>(32767.5 * (1.0 + std::sin(phase)));
      image.rgb.insert(image.rgb.end(), 3, grey);
    }
  }
  return image;
}

MeshDescription sphere_mesh(int subdivisions, double radius_m) {
  TriangleMesh sphere = icosphere(subdivisions, radius_m);
  return {"sphere", std::move(sphere.positions_m), std::move(sphere.triangles), {}, {}};
}

void add_node(SceneDescription& scene, const std::string& name, const Vec3& place_m) {
  NodeDescription node;
  node.name = name;
  node.mesh = static_cast<std::uint32_t>(scene.meshes.size() - 1);
  node.translation_m = place_m;
  node.tree_node = static_cast<std::uint32_t>(scene.tree.size());
  scene.nodes.push_back(node);
  scene.tree.push_back({name, node.tree_node, {}, true, place_m});
}

// A medium to be in and a field, for the effects that are not of a surface.
void add_surroundings(SceneDescription& scene, const EffectCase& effect_case) {
  if (has(effect_case, "viscosity")) {
    RegionDescription region;
    region.name = "medium";
    region.element = "/nodes/0/extras/palpate";
    region.parameters = {parameter("medium", std::string("sphere")),
                         parameter("radius", 2.0 * kSphereRadius_m), parameter("viscosity", 2.0)};
    region.linear_scene_node = Mat3::Identity();
    region.translation_m = Vec3::Zero();
    scene.regions.push_back(region);
  }
  if (is(effect_case, "gravity") || is(effect_case, "all")) {
    scene.scene_parameters.parameters = {parameter("gravity", std::vector<double>{0.0, 0.0, -9.81}),
                                         parameter("toolMass", 0.05)};
  }
}

// The sphere, and in the case "elsewhere" a small one beside it that has the effects.
std::optional<Scene> compile(int subdivisions, const EffectCase& effect_case, bool with_effects) {
  const bool elsewhere = is(effect_case, "elsewhere");
  SceneDescription scene;
  scene.meshes.push_back(sphere_mesh(subdivisions, kSphereRadius_m));
  add_node(scene, "sphere", Vec3::Zero());
  if (elsewhere) {
    scene.meshes.push_back(sphere_mesh(3, 0.1 * kSphereRadius_m));
    add_node(scene, "other", Vec3(3.0 * kSphereRadius_m, 0.0, 0.0));
  }
  if (with_effects) {
    MeshDescription& mesh = scene.meshes.back();
    MaterialDescription material;
    material.name = "material";
    material.element = "/materials/0";
    for (const auto& [key, value] : effect_case.parameters) {
      const bool is_surface = std::string(key) != "viscosity" || elsewhere;
      if (is_surface) material.parameters.push_back(parameter(key, value));
    }
    mesh.material_runs = {{0, 0}};
    if (has(effect_case, "textureHeight")) {
      scene.images.push_back(waves());
      HapticMap map;
      map.property = "vibrotactileTexture";
      map.texture.image = 0;
      map.texture.pixels = 0;
      scene.haptic_materials.push_back({"waves", {map}});
      mesh.haptic_material = 0;
      for (const Vec3& p : mesh.positions) {
        mesh.texture_uv.push_back({p.x() / kTextureTile_m, p.y() / kTextureTile_m});
      }
    }
    scene.materials.push_back(std::move(material));
    if (!elsewhere) add_surroundings(scene, effect_case);
  }
  Result<Scene> compiled = Scene::compile(std::move(scene), {});
  if (!compiled) return std::nullopt;
  return std::move(*compiled);
}

// The same hand, again and again.
class Slider {
 public:
  Slider(const Scene& scene, const DevicePath& path)
      : world_(scene.world()), path_(path), actuation_(*ActuationModel::from_counts(3, 3)) {
    settings_.a4.enabled = false;
  }

  void begin() {
    loop_.emplace(world_, actuation_, settings_);
    for (const Vec3& p_m : path_.lead_in_m) loop_->tick(p_m, kDt_s);
  }
  const TickRecord& tick(std::size_t n) { return loop_->tick(path_.timed_m[n], kDt_s); }

  // A whole pass, in nanoseconds.
  double pass_ns() {
    begin();
    const auto start = std::chrono::steady_clock::now();
    for (std::size_t n = 0; n < path_.timed_m.size(); ++n) tick(n);
    return static_cast<double>(nanoseconds_since(start));
  }

  // The part of the ticks in which the effect was felt.
  double felt_share(const char* effect) const {
    const EffectCounters* counters = loop_->effect_counters();
    const auto types = compiled_effects();
    for (std::size_t i = 0; counters && i < types.size(); ++i) {
      if (types[i].name != effect) continue;
      return static_cast<double>(counters->ticks[i]) /
             static_cast<double>(path_.lead_in_m.size() + path_.timed_m.size());
    }
    return 0.0;
  }

 private:
  const ContactWorld& world_;
  const DevicePath& path_;
  ActuationModel actuation_;
  HapticSettings settings_;
  std::optional<HapticLoop> loop_;
};

void run(benchmark::State& state, const EffectCase& effect_case, int subdivisions,
         const SampleCounts& counts) {
  const auto with = compile(subdivisions, effect_case, true);
  const auto without = compile(subdivisions, effect_case, false);
  if (!with || !without) return state.SkipWithError("the scene could not be compiled");
  const DevicePath path = entered_path_over_sphere(kSphereRadius_m, kSliding, counts.warm);
  Slider slider(*with, path);
  Slider bare(*without, path);
  const TickRecord* record = nullptr;
  bool had_fault = false;
  time_path(
      state, {path.timed_m.size(), Caches::kWarm}, [&] { slider.begin(); }, [](std::size_t) {},
      [&](std::size_t n) { record = &slider.tick(n); },
      [&](std::size_t) {
        had_fault = had_fault || record->faults != kFaultNone || !record->contact;
        return SampleError{};
      });
  if (had_fault) return state.SkipWithError("a tick had a fault or no contact");
  double with_ns = std::numeric_limits<double>::infinity();
  double bare_ns = with_ns;
  for (int i = 0; i < kPairs; ++i) {
    with_ns = std::min(with_ns, slider.pass_ns());
    bare_ns = std::min(bare_ns, bare.pass_ns());
  }
  const auto ticks = static_cast<double>(path.timed_m.size());
  state.counters["triangles"] = static_cast<double>(sphere_triangles(subdivisions));
  state.counters["tick_ns"] = with_ns / ticks;
  state.counters["marginal_ns"] = (with_ns - bare_ns) / ticks;
  state.counters["vs_bare"] = with_ns / bare_ns;
  const bool is_one = !is(effect_case, "all") && !is(effect_case, "elsewhere");
  if (is_one) {
    const double felt = slider.felt_share(effect_case.effect);
    state.counters["felt_share"] = felt;
    // Taps are rare on this path; whatever else there is, is felt all the time.
    if (felt == 0.0 && !is(effect_case, "restitution")) {
      return state.SkipWithError("the effect was not felt");
    }
  }
}

}  // namespace

void register_effect_benchmarks(int subdivisions, const SampleCounts& counts) {
  if (subdivisions > kMostSubdivisions) return;
  for (const EffectCase& effect_case : effect_cases()) {
    const std::string name = std::string("tick_sliding_with_") + effect_case.effect;
    benchmark::RegisterBenchmark(row_name(name, subdivisions).c_str(),
                                 [=, &effect_case](benchmark::State& state) {
                                   run(state, effect_case, subdivisions, counts);
                                 })
        ->UseManualTime()
        ->Iterations(static_cast<benchmark::IterationCount>(kRepeats * counts.warm));
  }
}

}  // namespace palpate::bench
