// The cost of accuracy: every level of every knob, measured as in `palpate accuracy`. The time of a
// row is the median of the repeats; its counters hold the rest of the result.

#include <cctype>
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

#include "benchmarks/registration.h"
#include "engine/accuracy/knobs.h"
#include "engine/accuracy/measurement.h"

namespace palpate::bench {
namespace {

// Lower case; each run of other characters than letters and digits becomes "-": "82k-triangles".
std::string slug(const std::string& text) {
  std::string slug;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte)) {
      slug += static_cast<char>(std::tolower(byte));
    } else if (!slug.empty() && slug.back() != '-') {
      slug += '-';
    }
  }
  if (!slug.empty() && slug.back() == '-') slug.pop_back();
  return slug;
}

// All knobs; only the knob in use keeps its scenes in memory.
class Knobs {
 public:
  explicit Knobs(const MeasurementEffort& effort) : effort_(effort) {}

  const MeasurementEffort& effort() const { return effort_; }
  const Knob& get(std::size_t index) {
    if (index_ != index) {
      in_use_.reset();  // first, so that no two knobs are in memory together
      in_use_ = std::move(all_knobs(effort_)[index]);
      index_ = index;
    }
    return *in_use_;
  }

 private:
  MeasurementEffort effort_;
  std::optional<std::size_t> index_;
  std::optional<Knob> in_use_;
};

// The duration of one unit of Knob::time; 0 if the unit is not a time.
double seconds_per(const std::string& unit) {
  return unit == "ns" ? 1e-9 : unit == "us" ? 1e-6 : 0.0;
}

bool is_finite(const Spread& spread) {
  return std::isfinite(spread.low) && std::isfinite(spread.median) && std::isfinite(spread.high);
}

void report(benchmark::State& state, const LevelResult& result) {
  state.counters["error"] = result.error.median;
  state.counters["error_low"] = result.error.low;
  state.counters["error_high"] = result.error.high;
  state.counters["raw_error"] = result.raw_error;
  state.counters["at_floor"] = result.at_floor;
  state.counters["time"] = result.time.median;
  state.counters["time_low"] = result.time.low;
  state.counters["time_high"] = result.time.high;
  state.counters["level"] = result.value;
  // Google Benchmark reserves the name "iterations".
  state.counters["solver_iterations"] = result.iterations;
  state.counters["ticks"] = static_cast<double>(result.ticks);
  state.counters["repeats"] = result.repeats;
  // A failed level is a valid result: some levels are meant to fail. Its errors and times come from
  // the repeats that succeeded, or are 0.
  state.counters["failures"] = result.failures;
}

void run(benchmark::State& state, Knobs& knobs, std::size_t index, const LevelPlace& place) {
  const Knob& knob = knobs.get(index);
  LevelResult result;
  for ([[maybe_unused]] auto _ : state) {
    result = measure_level(knob, place, knobs.effort());
    state.SetIterationTime(result.time.median * seconds_per(knob.time.unit));
  }
  if (!is_finite(result.error) || !is_finite(result.time)) {
    return state.SkipWithError("a result is not finite");
  }
  report(state, result);
  if (place.method == knob.default_method && place.level == knob.default_level) {
    state.counters["is_default"] = 1;
  }
}

}  // namespace

void register_accuracy_benchmarks(const MeasurementEffort& effort) {
  benchmark::AddCustomContext("accuracy", effort.quick ? "quick" : "full");
  benchmark::AddCustomContext("accuracy_seed", std::to_string(effort.seed));
  benchmark::AddCustomContext("accuracy_repeats", std::to_string(MeasurementEffort::kRepeats));
  const auto knobs = std::make_shared<Knobs>(effort);
  const std::vector<Knob> all = all_knobs(effort);
  std::set<std::string> rows;
  for (std::size_t index = 0; index < all.size(); ++index) {
    for (std::size_t m = 0; m < all[index].methods.size(); ++m) {
      const Method& method = all[index].methods[m];
      for (std::size_t l = 0; l < method.levels.size(); ++l) {
        const std::string row = "accuracy_" + all[index].name + "/" + slug(method.name) + "/" +
                                slug(method.levels[l].label);
        const bool is_new = rows.insert(row).second;
        benchmark::RegisterBenchmark(row.c_str(),
                                     [=](benchmark::State& state) {
                                       if (!is_new)
                                         return state.SkipWithError("two rows have the same name");
                                       run(state, *knobs, index, {m, l});
                                     })
            ->UseManualTime()
            ->Iterations(1);
      }
    }
  }
}

}  // namespace palpate::bench
