// Compares arithmetics that decide on which side of an edge a line passes if double is undecided.

#include <algorithm>
#include <chrono>
#include <limits>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "benchmarks/registration.h"
#include "benchmarks/side_test_inputs.h"

namespace palpate::bench {
namespace {

constexpr std::size_t kInputs = 1024;
constexpr std::size_t kPasses = 32;

struct InputClass {
  const char* name;
  std::vector<SideInput> (*make)(std::size_t count);
};
constexpr InputClass kClasses[] = {{"easy", easy_side_inputs},
                                   {"near", near_side_inputs},
                                   {"exact", exact_side_inputs},
                                   {"hidden", hidden_side_inputs}};

struct Problem {
  std::vector<SideInput> inputs;
  std::vector<int> true_sides;
  double filter_share = 0.0;  // of inputs decided by the filter of the first two methods

  explicit Problem(const InputClass& input_class) : inputs(input_class.make(kInputs)) {
    for (const SideInput& input : inputs) {
      true_sides.push_back(true_side(input));
      filter_share += filter_decides(input) ? 1.0 / kInputs : 0.0;
    }
  }
};

const Problem& problem(const InputClass& input_class) {
  static const std::vector<Problem> problems(std::begin(kClasses), std::end(kClasses));
  return problems[static_cast<std::size_t>(&input_class - kClasses)];
}

// An iteration is one pass over the inputs; the fastest pass counts.
template <typename Side>
void time_sides(benchmark::State& state, const Problem& task, Side side) {
  std::vector<int> sides(task.inputs.size());
  double shortest_s = std::numeric_limits<double>::infinity();
  for ([[maybe_unused]] auto iteration : state) {
    const auto start = std::chrono::steady_clock::now();
    for (std::size_t n = 0; n < sides.size(); ++n) sides[n] = side(n);
    const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
    benchmark::DoNotOptimize(sides.data());
    state.SetIterationTime(time.count());
    shortest_s = std::min(shortest_s, time.count());
  }
  double wrong = 0.0;
  double undecided = 0.0;
  for (std::size_t n = 0; n < sides.size(); ++n) {
    if (sides[n] == task.true_sides[n]) continue;
    (sides[n] == 0 ? undecided : wrong) += 1.0;
  }
  state.counters["call_ns"] = 1e9 * shortest_s / static_cast<double>(sides.size());
  state.counters["filter_share"] = task.filter_share;
  state.counters["wrong_signs"] = wrong;
  state.counters["undecided"] = undecided;  // returned as zero, a touch, although not zero
  if (wrong > 0.0) state.SkipWithError("a sign was wrong");
}

void run_float128(benchmark::State& state, const Problem& task) {
  time_sides(state, task, [&](std::size_t n) { return side_float128(task.inputs[n]); });
}

void run_adaptive(benchmark::State& state, const Problem& task) {
  time_sides(state, task, [&](std::size_t n) { return side_adaptive(task.inputs[n]); });
}

void run_cgal(benchmark::State& state, const Problem& task) {
  const CgalSideTest test(task.inputs);
  time_sides(state, task, [&](std::size_t n) { return test.side(n); });
}

struct SideMethod {
  const char* name;
  void (*run)(benchmark::State&, const Problem&);
};
constexpr SideMethod kMethods[] = {{"side_test_float128", run_float128},
                                   {"side_test_adaptive", run_adaptive},
                                   {"side_test_cgal", run_cgal}};

}  // namespace

void register_side_test_benchmarks() {
  for (const InputClass& input_class : kClasses) {
    for (const SideMethod& method : kMethods) {
      benchmark::RegisterBenchmark(
          (std::string(method.name) + "/" + input_class.name).c_str(),
          [&](benchmark::State& state) { method.run(state, problem(input_class)); })
          ->UseManualTime()
          ->Iterations(kPasses);
    }
  }
}

}  // namespace palpate::bench
