#pragma once

#include <algorithm>
#include <cstddef>
#include <string>

#include "benchmarks/caches.h"
#include "benchmarks/sphere.h"
#include "engine/accuracy/knob.h"

namespace palpate::bench {

// How long the paths are, in samples of 1 ms.
struct SampleCounts {
  std::size_t warm;

  // Evicting takes a hundred times as long as what is then timed, and the worst inputs are slow by
  // intention. Still enough to tap once.
  std::size_t fewer() const { return std::min(warm, std::max<std::size_t>(warm / 4, 250)); }
  std::size_t for_caches(Caches caches) const { return caches == Caches::kWarm ? warm : fewer(); }
};

// Google Benchmark appends the iterations.
inline std::string row_name(const std::string& workload, int subdivisions) {
  return workload + "/" + std::to_string(sphere_triangles(subdivisions));
}

// In this order for one size: ticks are compared with peers of the index.
void register_index_benchmarks(int subdivisions, const SampleCounts& counts);
void register_tick_benchmarks(int subdivisions, const SampleCounts& counts);
// scan_<proxy>/<triangles, about>, where a scan goes with the size.
void register_scan_benchmarks(int subdivisions, const SampleCounts& counts);
// Of no size: worst_<input>/<triangles or bodies>.
void register_worst_benchmarks(bool is_large);
// tick_sliding_with_<effect>/<triangles>.
void register_effect_benchmarks(int subdivisions, const SampleCounts& counts);

// Of no size: accuracy_<knob>/<method>/<level>, every level of every knob. Adds to the context how
// they were measured.
void register_accuracy_benchmarks(const StudyEffort& effort);

// Of no size: load_instances/<count>x, instances_sliding/<count>x and the same
// _searched.
void register_instance_benchmarks(const SampleCounts& counts);
// Best before the others of the size, which keep what they have built.
void register_load_benchmarks(int subdivisions);

// Of no size: side_test_<how>/<class of inputs>. Nothing without CGAL, which it compares with.
void register_side_test_benchmarks();

}  // namespace palpate::bench
