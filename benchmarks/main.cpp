// palpate_benchmarks [--subdivisions=5,7,8,9] [--ticks=10000] [--accuracy=full] [--seed=1]
//                    [Google Benchmark's options]
//
// subdivisions: sizes of the sphere. 5 has 20,480 triangles, and each further subdivision has four
// times as many (8: 1.3 million, 9: 5.2 million). 5, 7, 8 and 9 add scans of 0.1, 0.5, 1.6 and 6
// million triangles. ticks: length of the paths, in samples of 1 ms; a quarter of it for evicted
// caches and for slow inputs. accuracy: effort of the study of accuracy (full, quick or off), which
// `palpate accuracy` measures from the same seed.

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <string_view>
#include <vector>

#include <benchmark/benchmark.h>

#include "benchmarks/cgal_surface.h"
#include "benchmarks/registration.h"
#include "engine/accuracy/build_facts.h"

namespace {

constexpr int kMostSubdivisions = 10;
constexpr int kMostTicks = 10'000'000;

// A whole number in [1, most].
std::optional<int> parse_number(std::string_view text, int most) {
  int number = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc() || stop != end || number < 1 || number > most) return std::nullopt;
  return number;
}

// Numbers separated by commas; empty if any of them is invalid.
std::vector<int> parse_list(std::string_view text, int most) {
  std::vector<int> numbers;
  for (;;) {
    const std::size_t comma = text.find(',');
    const std::optional<int> number = parse_number(text.substr(0, comma), most);
    if (!number) return {};
    numbers.push_back(*number);
    if (comma == std::string_view::npos) return numbers;
    text.remove_prefix(comma + 1);
  }
}

struct Options {
  std::vector<int> subdivisions{5, 7, 8, 9};
  int ticks = 10000;
  std::optional<palpate::MeasurementEffort> accuracy =
      palpate::MeasurementEffort{};  // nullopt: off
  std::uint64_t seed = palpate::MeasurementEffort{}.seed;
};

// Each function parses the value after the option's name and returns whether it is valid.
bool set_subdivisions(std::string_view value, Options& options) {
  options.subdivisions = parse_list(value, kMostSubdivisions);
  return !options.subdivisions.empty();
}
bool set_ticks(std::string_view value, Options& options) {
  const std::optional<int> ticks = parse_number(value, kMostTicks);
  options.ticks = ticks.value_or(options.ticks);
  return ticks.has_value();
}
bool set_accuracy(std::string_view value, Options& options) {
  options.accuracy.reset();
  if (value == "off") return true;
  options.accuracy = palpate::MeasurementEffort{.quick = value == "quick"};
  return value == "quick" || value == "full";
}
bool set_seed(std::string_view value, Options& options) {
  const char* end = value.data() + value.size();
  const auto [stop, error] = std::from_chars(value.data(), end, options.seed);
  return error == std::errc() && stop == end;
}

struct OptionRule {
  std::string_view prefix;
  bool (*set)(std::string_view value, Options& options);
};
constexpr OptionRule kOptionRules[] = {
    {"--subdivisions=", set_subdivisions},
    {"--ticks=", set_ticks},
    {"--accuracy=", set_accuracy},
    {"--seed=", set_seed},
};

bool parse_option(std::string_view argument, Options& options) {
  for (const OptionRule& rule : kOptionRules) {
    if (!argument.starts_with(rule.prefix)) continue;
    return rule.set(argument.substr(rule.prefix.size()), options);
  }
  return false;
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  Options options;
  for (int i = 1; i < argc; ++i) {
    if (parse_option(argv[i], options)) continue;
    std::fprintf(
        stderr,
        "palpate_benchmarks: invalid argument %s (options: --help, --subdivisions, --ticks, "
        "--accuracy, --seed)\n",
        argv[i]);
    return 2;
  }
  benchmark::AddCustomContext("compiler", palpate::compiler_name());
  benchmark::AddCustomContext("flags", palpate::compiler_flags());
  benchmark::AddCustomContext("cgal", palpate::bench::kHaveCgal ? "yes" : "no");
  const palpate::bench::SampleCounts counts{static_cast<std::size_t>(options.ticks)};
  // Loading runs first, while no other benchmark holds memory: each load then reuses the memory of
  // the previous load instead of pages that the system must provide.
  for (const int subdivisions : options.subdivisions) {
    palpate::bench::register_load_benchmarks(subdivisions);
  }
  for (const int subdivisions : options.subdivisions) {
    palpate::bench::register_index_benchmarks(subdivisions, counts);
    palpate::bench::register_tick_benchmarks(subdivisions, counts);
    palpate::bench::register_effect_benchmarks(subdivisions, counts);
    palpate::bench::register_scan_benchmarks(subdivisions, counts);
  }
  const auto largest = std::max_element(options.subdivisions.begin(), options.subdivisions.end());
  palpate::bench::register_worst_benchmarks(*largest > 5);
  palpate::bench::register_instance_benchmarks(counts);
  palpate::bench::register_side_test_benchmarks();
  palpate::bench::register_governor_benchmarks();
  if (options.accuracy) {
    options.accuracy->seed = options.seed;
    palpate::bench::register_accuracy_benchmarks(*options.accuracy);
  }
  const std::size_t run = benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return run > 0 ? 0 : 2;
}
