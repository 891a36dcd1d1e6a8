#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <meshoptimizer.h>
#include <utility>

#include "engine/accuracy/built_scene.h"
#include "engine/accuracy/proxy_reference.h"
#include "engine/accuracy/scene_accuracy.h"
#include "engine/accuracy/session_pass.h"
#include "engine/rig/replay.h"
#include "engine/rig/rig.h"
#include "engine/simulation/exploration.h"
#include "haptics/record_vectors.h"

namespace palpate {
namespace {

constexpr int kHalvings = 6;
constexpr std::size_t kLeastTriangles = 64;  // fewer triangles do not show the shape

// All triangles of the scene. The simplifier works in single precision, which has the most digits
// near the origin, so it receives corners relative to the middle of the scene.
struct Merged {
  TriangleMesh mesh;
  Vec3 middle_m;
};

Merged merged(const Scene& scene) {
  Merged all;
  scene.append_triangles_scene(all.mesh.positions_m, all.mesh.triangles);
  Eigen::AlignedBox3d box;
  for (const Vec3& p : all.mesh.positions_m) box.extend(p);
  all.middle_m = box.center();
  return all;
}

// The surface simplified to about this many triangles, with the smallest error that the simplifier
// finds. Corners without a triangle are removed.
TriangleMesh simplified(const Merged& all, std::size_t triangles) {
  std::vector<std::array<float, 3>> corners;
  corners.reserve(all.mesh.positions_m.size());
  for (const Vec3& p : all.mesh.positions_m) {
    const Eigen::Vector3f c = (p - all.middle_m).cast<float>();
    corners.push_back({c.x(), c.y(), c.z()});
  }
  std::vector<std::uint32_t> indices;
  for (const Triangle& t : all.mesh.triangles) indices.insert(indices.end(), t.begin(), t.end());
  std::vector<std::uint32_t> kept(indices.size());
  constexpr float kAnyError = 1.0f;  // relative to the extent: the number of triangles decides
  kept.resize(meshopt_simplify(kept.data(), indices.data(), indices.size(), corners.front().data(),
                               corners.size(), sizeof corners.front(), 3 * triangles, kAnyError));
  TriangleMesh mesh;
  constexpr std::uint32_t kNone = ~std::uint32_t{0};
  std::vector<std::uint32_t> place(corners.size(), kNone);
  for (std::uint32_t& corner : kept) {
    if (place[corner] == kNone) {
      place[corner] = static_cast<std::uint32_t>(mesh.positions_m.size());
      mesh.positions_m.push_back(all.mesh.positions_m[corner]);
    }
    corner = place[corner];
  }
  for (std::size_t i = 0; i + 2 < kept.size(); i += 3) {
    mesh.triangles.push_back({kept[i], kept[i + 1], kept[i + 2]});
  }
  return mesh;
}

// Compares a simplified mesh with the whole mesh: time and distance of the proxies in the ticks in
// which the hand touches the whole mesh. Where the simplified surface has receded from the hand,
// its proxy is at the goal.
class Comparison final : public TickObserver {
 public:
  explicit Comparison(const std::vector<TickRecord>& whole) : whole_(whole) {
    offs_m_.reserve(whole.size());
  }

  void on_tick(const TickRecord& record) noexcept override {
    const TickRecord& whole = whole_[record.tick];
    faults_ |= record.faults;
    if (!whole.contact) return;
    offs_m_.push_back((vec3(record.proxy_scene_m) - vec3(whole.proxy_scene_m)).norm());
    time_ns_ += static_cast<double>(record.step_ns);
    iterations_ += record.iterations;
  }
  Sample finish() {
    Sample sample;
    sample.ticks = offs_m_.size();
    sample.failure = failure_of(faults_);
    if (offs_m_.empty()) return sample;
    const auto ticks = static_cast<double>(offs_m_.size());
    sample.time = std::max(0.0, time_ns_ / ticks - clock_overhead_ns());
    sample.iterations = iterations_ / ticks;
    std::sort(offs_m_.begin(), offs_m_.end());
    sample.error = offs_m_[(offs_m_.size() - 1) * 95 / 100];
    return sample;
  }

 private:
  const std::vector<TickRecord>& whole_;
  std::vector<double> offs_m_;
  double time_ns_ = 0.0;
  double iterations_ = 0.0;
  std::uint32_t faults_ = kFaultNone;
};

// The paths of the hands, and their records on the whole mesh.
class Hands {
 public:
  Hands(std::shared_ptr<const Scene> whole, const RunSetup& setup, double seconds,
        std::uint64_t first_seed)
      : whole_(std::move(whole)), setup_(setup), seconds_(seconds), first_seed_(first_seed) {
    setup_.moves.clear();
  }

  Sample run(const Scene& scene, std::uint64_t seed, const Accuracy& accuracy) {
    const std::uint64_t hand = (seed - first_seed_) % kHands;
    const std::vector<Vec3>& path_m = paths_.get(hand, [&] { return path_of(first_seed_ + hand); });
    Comparison comparison(records_of_whole(hand, path_m));
    RunSetup setup = setup_;
    setup.haptics.god_object.accuracy = accuracy;
    PathDevice device(path_m);
    const auto rig = Rig::create(scene, setup, device, {.observers = {&comparison}});
    if (!rig) return {.failure = rig.error().to_string()};
    HapticSession& session = (*rig)->session();
    session.start();
    for (std::size_t n = 0; n < path_m.size(); ++n) session.tick(setup_.dt_s);
    return comparison.finish();
  }

 private:
  static constexpr std::uint64_t kHands = 7;  // 21 repeats run each hand three times

  // Empty if no hand can touch the scene; then no tick is in contact.
  std::vector<Vec3> path_of(std::uint64_t seed) const {
    ExplorationSettings exploration;
    exploration.seconds = seconds_;
    exploration.virtual_time = true;
    exploration.seed = seed;
    std::vector<Vec3> path_m;
    const auto run = explore(*whole_, setup_, exploration, [](double) {});
    if (run) {
      for (const TickRecord& record : run->records) path_m.push_back(vec3(record.device_m));
    }
    return path_m;
  }
  const std::vector<TickRecord>& records_of_whole(std::uint64_t hand,
                                                  const std::vector<Vec3>& path_m) {
    auto [place, is_new] = whole_records_.try_emplace(hand);
    if (!is_new) return place->second;
    RunSetup exact = setup_;
    exact.haptics.god_object.accuracy = Accuracy::exact();
    if (auto run = replay(*whole_, exact, path_m, 1)) place->second = std::move(run->records);
    return place->second;
  }

  std::shared_ptr<const Scene> whole_;
  RunSetup setup_;
  double seconds_;
  std::uint64_t first_seed_;
  ProxyReference paths_;
  std::map<std::uint64_t, std::vector<TickRecord>> whole_records_;
};

std::size_t triangle_count(const Scene& scene) {
  std::size_t triangles = 0;
  for (const SceneObject& object : scene.objects()) {
    triangles += scene.mesh(object.mesh).face_count();
  }
  return triangles;
}

// The knob without its levels.
Knob described_knob() {
  Knob knob;
  knob.name = "scene_resolution";
  knob.title = "Resolution of the scene's own mesh";
  knob.level = {"mean edge", "m"};
  knob.error = {"distance to the proxy on the whole mesh (95 %)", "m"};
  knob.time = {"time of a tick", "ns"};
  knob.workload =
      "A simulated hand wanders over the scene without its effects, with the device and the "
      "coupling "
      "given.";
  knob.reference = "the same path on all triangles, preset exact";
  knob.floor_is = "the rounding of a file's coordinates to single precision";
  knob.default_because = "the file's own mesh loses no detail";
  knob.enough = kEnoughDepth_m;
  knob.enough_because = kEnoughDepthBecause;
  return knob;
}

// A mesh with some or all of the triangles of the scene.
struct SimplifiedLevel {
  std::shared_ptr<const Scene> scene;
  double edge_m;
  std::size_t triangles;
};

// The mesh with fewer and fewer halvings of its triangles, at last whole. Levels with as many
// triangles as the one before are left out.
std::vector<SimplifiedLevel> simplified_levels(const Merged& all,
                                               const std::shared_ptr<const Scene>& whole,
                                               double radius_m) {
  const std::size_t triangles = all.mesh.triangles.size();
  std::vector<SimplifiedLevel> levels;
  std::size_t last = 0;
  for (int halvings = kHalvings; halvings > 0; --halvings) {
    const std::size_t target = triangles >> halvings;
    if (target < kLeastTriangles) continue;
    TriangleMesh coarse = simplified(all, target);
    // Open edges limit how far a mesh can be simplified.
    if (coarse.triangles.size() <= last || coarse.triangles.size() >= triangles) continue;
    last = coarse.triangles.size();
    const double edge_m = mean_edge_m(coarse);
    // Thin parts may have lost all their area.
    if (const auto level = compile_mesh(std::move(coarse), radius_m)) {
      levels.push_back({*level, edge_m, last});
    }
  }
  levels.push_back({whole, mean_edge_m(all.mesh), triangles});
  return levels;
}

}  // namespace

std::optional<Knob> simplification_knob(const Scene& scene, const RunSetup& setup,
                                        const MeasurementEffort& effort, std::string& why) {
  // Counted before the triangles are gathered: nodes that share a mesh may repeat it any number of
  // times.
  const std::size_t triangles = triangle_count(scene);
  if (triangles > kMostSimplified || triangles < 4 * kLeastTriangles) {
    why = "it has " + std::to_string(triangles) + " triangles; expected " +
          std::to_string(4 * kLeastTriangles) + " to " + std::to_string(kMostSimplified);
    return std::nullopt;
  }
  const Merged all = merged(scene);
  const double radius_m = setup.haptics.god_object.radius_m;
  const auto whole_or_error = compile_mesh(all.mesh, radius_m);
  if (!whole_or_error) {
    why = whole_or_error.error().to_string();
    return std::nullopt;
  }
  const std::shared_ptr<const Scene> whole = *whole_or_error;
  const auto hands = std::make_shared<Hands>(whole, setup, effort.quick ? 2.5 : 5.0, effort.seed);
  Method method{"simplified", {}, {}, file_floor_m(scene)};
  for (const SimplifiedLevel& level : simplified_levels(all, whole, radius_m)) {
    method.levels.push_back({level.edge_m, std::to_string(level.triangles) + " triangles",
                             [hands, scene = level.scene](std::uint64_t seed) {
                               return hands->run(*scene, seed, Accuracy::balanced());
                             }});
  }
  Knob knob = described_knob();
  knob.default_level = method.levels.size() - 1;
  knob.methods.push_back(std::move(method));
  knob.run_preset = [=](std::uint64_t seed, const Accuracy& preset) {
    return hands->run(*whole, seed, preset);
  };
  return knob;
}

}  // namespace palpate
