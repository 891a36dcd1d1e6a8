#pragma once

#include <algorithm>
#include <cstddef>
#include <string>

#include "benchmarks/caches.h"
#include "benchmarks/sphere.h"
#include "engine/accuracy/knob.h"

namespace palpate::bench {

// Lengths of the paths, in samples of 1 ms.
struct SampleCounts {
  std::size_t warm;

  // The smaller number of samples that is used for evicted caches and for inputs that are designed
  // to be slow. (Evicting the caches takes a hundred times as long as the timed sample.) The path
  // includes at least one tap.
  std::size_t fewer() const { return std::min(warm, std::max<std::size_t>(warm / 4, 250)); }
  std::size_t for_caches(Caches caches) const { return caches == Caches::kWarm ? warm : fewer(); }
};

// The name of a row, to which Google Benchmark appends the number of iterations.
inline std::string row_name(const std::string& workload, int subdivisions) {
  return workload + "/" + std::to_string(sphere_triangles(subdivisions));
}

// Call these two functions in this order for each size, because the tick benchmarks compare their
// times with the times of Palpate's peers, which the index benchmarks measure.
void register_index_benchmarks(int subdivisions, const SampleCounts& counts);
void register_tick_benchmarks(int subdivisions, const SampleCounts& counts);
// scan_<proxy>/<approximate triangles>, for sizes that have a scan.
void register_scan_benchmarks(int subdivisions, const SampleCounts& counts);
// Once for all sizes: worst_<input>/<triangles or bodies>.
void register_worst_benchmarks(bool is_large);
// tick_sliding_with_<effect>/<triangles>.
void register_effect_benchmarks(int subdivisions, const SampleCounts& counts);

// Once for all sizes: governor/<device>, governor/heartbeat and governor/attribution.
void register_governor_benchmarks();

// Once for all sizes: accuracy_<knob>/<method>/<level>, every level of every knob. Adds the
// conditions of the measurement to the context of the results.
void register_accuracy_benchmarks(const MeasurementEffort& effort);

// Once for all sizes: load_instances/<count>x, instances_sliding/<count>x and
// instances_sliding_searched/<count>x.
void register_instance_benchmarks(const SampleCounts& counts);
// Call this function before those that register the other benchmarks of the size, because these
// benchmarks keep their scenes in memory.
void register_load_benchmarks(int subdivisions);

// Once for all sizes: side_test_<method>/<class of inputs>. Registers nothing if the program was
// built without CGAL, because CGAL provides one of the compared methods.
void register_side_test_benchmarks();

}  // namespace palpate::bench
