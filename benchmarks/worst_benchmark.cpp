// The slowest known inputs, without effects; work_prices.cpp measures them with effects.

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
        god_object = std::move(*GodObject::create(input.world, {.radius_m = input.proxy_radius_m}));
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
  }
}

}  // namespace palpate::bench
