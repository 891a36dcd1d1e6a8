#include "benchmarks/medians.h"

#include <map>

namespace palpate::bench {
namespace {

std::map<std::string, double>& medians_ns() {
  static std::map<std::string, double> medians;
  return medians;
}

double p50_ns(const benchmark::State& state) {
  const auto counter = state.counters.find("p50_ns");
  return counter == state.counters.end() ? 0.0 : counter->second.value;
}

}  // namespace

void remember_p50(const std::string& row, const benchmark::State& state) {
  medians_ns()[row] = p50_ns(state);
}

void report_ratio(benchmark::State& state, const std::string& counter,
                  const std::string& peer_row) {
  const auto peer = medians_ns().find(peer_row);
  if (peer == medians_ns().end() || !(peer->second > 0.0)) return;
  state.counters[counter] = p50_ns(state) / peer->second;
}

}  // namespace palpate::bench
