#pragma once

// The medians measured so far in this process. With these medians, a benchmark can report the ratio
// of its median to the median of a peer.

#include <string>

#include <benchmark/benchmark.h>

namespace palpate::bench {

// Stores the counter p50_ns under the name of the row.
void remember_p50(const std::string& row, const benchmark::State& state);

// Sets the counter to p50_ns of the row divided by p50_ns of the peer's row. Does not set the
// counter if the peer has not been measured before, for example because a filter excludes the peer.
void report_ratio(benchmark::State& state, const std::string& counter, const std::string& peer_row);

}  // namespace palpate::bench
