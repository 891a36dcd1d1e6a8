// The slowest known inputs. The work budget bounds the update of the proxy; effects that search,
// timed on the same inputs, are not bounded.

#include <algorithm>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

#include "benchmarks/caches.h"
#include "benchmarks/last_built.h"
#include "benchmarks/percentiles.h"
#include "benchmarks/registration.h"
#include "benchmarks/worst_inputs.h"
#include "haptics/effects/magnet.h"
#include "haptics/effects/viscosity.h"

namespace palpate::bench {
namespace {

const WorstInput& input_of(const WorstKind& kind, bool is_large) {
  static LastBuilt<std::pair<std::string, bool>, WorstInput> last;
  return *last.get({std::string(kind.name), is_large},
                   [&] { return std::optional(kind.make(is_large ? kind.most : kind.least)); });
}

// Each tick is the shortest of kRepeats, as in every row: the budget bounds the work of a tick, not
// interruptions by the machine.
void run(benchmark::State& state, const WorstKind& kind, bool is_large, Caches caches) {
  const WorstInput& input = input_of(kind, is_large);
  std::optional<GodObject> god_object;
  ProxyState proxy;
  double capped = 0.0;
  double ticks = 0.0;
  WorkUnits most_work = 0;
  time_path(
      state, {input.goals_m.size(), caches},
      [&] {
        god_object.emplace(input.world, GodObjectSettings{.radius_m = input.proxy_radius_m});
        god_object->place(input.goals_m.front());
      },
      [](std::size_t) {},
      [&](std::size_t n) {
        if (!input.motions.empty()) god_object->move_bodies(input.motions[n]);
        proxy = god_object->move_to(input.goals_m[n]);
      },
      [&](std::size_t) {
        ticks += 1.0;
        capped += proxy.capped;
        most_work = std::max(most_work, proxy.work);
        return SampleError{};
      });
  state.counters["capped_share"] = capped / ticks;
  state.counters["most_work"] = static_cast<double>(most_work);
}

// Each body attracts the hand at any distance.
class Magnets {
 public:
  explicit Magnets(const WorstInput& input) : surfaces_(input.world.bodies.size()) {
    for (std::uint32_t b = 0; b < surfaces_.size(); ++b) {
      surfaces_[b] = {b, 0, input.world.bodies[b].index};
    }
  }
  void apply(EffectTick& tick) {
    MagnetEffect::State state;
    for (const MagneticSurface& surface : surfaces_) {
      MagnetEffect::apply({1.0, 2.0 * tick.world->size_m(), &surface}, state, tick);
    }
  }

 private:
  std::vector<MagneticSurface> surfaces_;
};

// Each body contains a medium and is no obstacle. Closedness is not checked here: the compiler of a
// scene does that.
class Media {
 public:
  explicit Media(const WorstInput& input) : regions_(input.world.bodies.size()) {
    for (std::size_t b = 0; b < regions_.size(); ++b) {
      const ContactBody& body = input.world.bodies[b];
      regions_[b].region.shape = MediumRegion::Shape::kThrough;
      regions_[b].region.index = body.index;
      const Mat3 to_body = body.T_solver_body.rotation.conjugate().toRotationMatrix();
      regions_[b].region.p_region_solver = {to_body, -to_body * body.T_solver_body.translation_m};
    }
  }
  void apply(EffectTick& tick) {
    for (auto& [region, state] : regions_) ViscosityEffect::apply({1.0, &region}, state, tick);
  }

 private:
  struct Region {
    MediumRegion region;
    ViscosityEffect::State state;
  };
  std::vector<Region> regions_;
};

// Times an effect of every body at the proxy's position in each tick.
template <typename Effect>
void run_effect(benchmark::State& state, const WorstKind& kind, bool is_large) {
  const WorstInput& input = input_of(kind, is_large);
  const LiveWorld world(input.world);
  std::optional<GodObject> god_object;
  std::optional<Effect> effect;
  EffectTick tick;
  time_path(
      state, {input.goals_m.size(), Caches::kEvicted},
      [&] {
        god_object.emplace(input.world, GodObjectSettings{.radius_m = input.proxy_radius_m});
        god_object->place(input.goals_m.front());
        effect.emplace(input);
      },
      [&](std::size_t n) {
        tick = EffectTick{};
        tick.proxy_m = god_object->move_to(input.goals_m[n]).proxy;
        tick.radius_m = input.proxy_radius_m;
        tick.world = &world;
      },
      [&](std::size_t) { effect->apply(tick); }, [](std::size_t) { return SampleError{}; });
}

void register_row(const std::string& name, const WorstKind& kind,
                  std::function<void(benchmark::State&)> run) {
  benchmark::RegisterBenchmark(name.c_str(), std::move(run))
      ->UseManualTime()
      ->Iterations(static_cast<benchmark::IterationCount>(kRepeats * kind.ticks));
}

}  // namespace

void register_worst_benchmarks(bool is_large) {
  for (const WorstKind& kind : worst_kinds()) {
    const std::string size = "/" + std::to_string(is_large ? kind.most : kind.least);
    const auto row = [&](const std::string& what, std::function<void(benchmark::State&)> run) {
      register_row("worst_" + std::string(kind.name) + what + size, kind, std::move(run));
    };
    for (const Caches caches : {Caches::kWarm, Caches::kEvicted}) {
      row(caches == Caches::kEvicted ? "_evicted" : "",
          [&kind, is_large, caches](auto& state) { run(state, kind, is_large, caches); });
    }
    row("_magnets", [&kind, is_large](auto& state) { run_effect<Magnets>(state, kind, is_large); });
    row("_media", [&kind, is_large](auto& state) { run_effect<Media>(state, kind, is_large); });
  }
}

}  // namespace palpate::bench
