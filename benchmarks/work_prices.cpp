// Measures what a unit of work takes, by kind of work, and whether the ticks of the slowest known
// inputs keep what the price promises.
//
// usage: work_prices [--repeats=N] [--filter=TEXT] [--small] [--csv=FILE --cpu=NAME]
//
// A unit: time and counted work of the ticks of an input whose ticks spend most of their work on
// one kind of operation. A tick: the proxy, the moving bodies and, in the rows with effects, the
// effects of every body. Each time is the shortest of all passes: the budget bounds the work of a
// tick, not interruptions by the machine. The state before a tick is the same in every pass.
//
// --small: inputs of the size of the tests. The exit code does not depend on a time.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "benchmarks/worst_effects.h"
#include "benchmarks/worst_inputs.h"
#include "haptics/proxy/live_world.h"

namespace palpate::bench {
namespace {

// Ticks with less work than this say little about the price of a unit.
constexpr double kLeastPart = 0.25;

struct Options {
  int repeats = 9;
  bool is_small = false;
  std::string filter;
  std::string csv;
  std::string cpu;  // its name, for the file
};

// One tick: its shortest time and its work, which is the same in every pass.
struct Tick {
  double time_ns = std::numeric_limits<double>::infinity();
  WorkUnits units = 0;
  bool is_capped = false;
};

struct Row {
  std::string input;
  std::string effects;
  std::size_t size = 0;
  std::size_t capped = 0;
  double longest_us = 0.0;
  double unit_ns = 0.0;          // median over the ticks with much work
  double dearest_unit_ns = 0.0;  // over the capped ticks
};

Row row_of(const std::vector<Tick>& ticks, WorkUnits budget) {
  Row row;
  std::vector<double> prices_ns;
  for (const Tick& tick : ticks) {
    row.longest_us = std::max(row.longest_us, 1e-3 * tick.time_ns);
    row.capped += tick.is_capped;
    const double units = static_cast<double>(tick.units);
    const double price_ns = tick.time_ns / units;
    if (tick.is_capped) row.dearest_unit_ns = std::max(row.dearest_unit_ns, price_ns);
    if (units >= kLeastPart * static_cast<double>(budget)) prices_ns.push_back(price_ns);
  }
  if (prices_ns.empty()) return row;
  const auto middle = prices_ns.begin() + static_cast<std::ptrdiff_t>(prices_ns.size() / 2);
  std::nth_element(prices_ns.begin(), middle, prices_ns.end());
  row.unit_ns = *middle;
  return row;
}

Row measure(const WorstInput& input, EffectKind kind, int repeats) {
  std::vector<Tick> ticks(input.goals_m.size());
  const GodObjectSettings settings{.radius_m = input.proxy_radius_m};
  for (int repeat = 0; repeat < repeats; ++repeat) {
    WorstEffects effects(input, kind, settings);
    GodObject god_object = std::move(*GodObject::create(input.world, settings));
    god_object.place(input.goals_m.front());
    for (std::size_t n = 0; n < ticks.size(); ++n) {
      const auto start = std::chrono::steady_clock::now();
      if (!input.motions.empty()) god_object.move_bodies(input.motions[n]);
      const ProxyState state = god_object.move_to(input.goals_m[n]);
      const WorkUnits work_of_effects = effects.run(god_object.world(), state);
      const std::chrono::duration<double, std::nano> time =
          std::chrono::steady_clock::now() - start;
      ticks[n].time_ns = std::min(ticks[n].time_ns, time.count());
      ticks[n].units = state.work + work_of_effects;
      ticks[n].is_capped = state.work >= settings.accuracy.work_budget || effects.is_capped();
    }
  }
  return row_of(ticks, settings.accuracy.work_budget);
}

void write(const Options& options, const std::vector<Row>& rows) {
  std::ofstream file(options.csv);
  file << "# " << options.cpu << "\ninput,effects,size,capped,longest_us,unit_ns,dearest_unit_ns\n";
  for (const Row& row : rows) {
    char line[256];
    std::snprintf(line, sizeof line, "%s,%s,%zu,%zu,%.1f,%.2f,%.2f\n", row.input.c_str(),
                  row.effects.c_str(), row.size, row.capped, row.longest_us, row.unit_ns,
                  row.dearest_unit_ns);
    file << line;
  }
}

int run(const Options& options) {
  std::vector<Row> rows;
  std::printf("%-40s %-8s %9s %7s %11s %9s %13s\n", "input", "effects", "size", "capped",
              "longest, us", "unit, ns", "dearest, ns");
  for (const WorstKind& kind : worst_kinds()) {
    if (std::string(kind.name).find(options.filter) == std::string::npos) continue;
    const std::size_t size = options.is_small ? kind.least : kind.most;
    const WorstInput input = kind.make(size);
    for (const EffectKind effects : {EffectKind::kNone, EffectKind::kMagnets, EffectKind::kMedia}) {
      Row row = measure(input, effects, options.repeats);
      row.input = kind.name;
      row.effects = name_of(effects);
      row.size = size;
      std::printf("%-40s %-8s %9zu %7zu %11.1f %9.2f %13.2f\n", row.input.c_str(),
                  row.effects.c_str(), row.size, row.capped, row.longest_us, row.unit_ns,
                  row.dearest_unit_ns);
      std::fflush(stdout);
      rows.push_back(std::move(row));
    }
  }
  if (!options.csv.empty()) write(options, rows);
  return 0;
}

bool read(const std::string& argument, const char* name, std::string& value) {
  const std::string prefix = std::string("--") + name + "=";
  if (argument.compare(0, prefix.size(), prefix) != 0) return false;
  value = argument.substr(prefix.size());
  return true;
}

}  // namespace
}  // namespace palpate::bench

int main(int argc, char** argv) {
  palpate::bench::Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    std::string repeats;
    if (argument == "--small") {
      options.is_small = true;
    } else if (palpate::bench::read(argument, "repeats", repeats)) {
      options.repeats = std::max(1, std::atoi(repeats.c_str()));
    } else if (!palpate::bench::read(argument, "filter", options.filter) &&
               !palpate::bench::read(argument, "csv", options.csv) &&
               !palpate::bench::read(argument, "cpu", options.cpu)) {
      std::fprintf(stderr, "work_prices: unknown argument %s\n", argv[i]);
      return 2;
    }
  }
  return palpate::bench::run(options);
}
