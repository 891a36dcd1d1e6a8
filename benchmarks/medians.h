#pragma once

// The medians measured so far in this process, so that a row can carry its ratio to a peer's.

#include <string>

#include <benchmark/benchmark.h>

namespace palpate::bench {

// Remembers the row's counter p50_ns under its name.
void remember_p50(const std::string& row, const benchmark::State& state);

// Sets the counter to the row's p50_ns over the peer's. Not if the peer has not been measured
// before, as when a filter left it out.
void report_ratio(benchmark::State& state, const std::string& counter, const std::string& peer_row);

}  // namespace palpate::bench
