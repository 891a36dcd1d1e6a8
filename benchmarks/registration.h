#pragma once

#include <cstddef>

namespace palpate::bench {

// Names are workload/triangles; Google Benchmark appends the iterations.
void register_index_benchmarks(int subdivisions, std::size_t sample_count);
void register_tick_benchmarks(int subdivisions, std::size_t sample_count);

}  // namespace palpate::bench
