#pragma once

// The numbers of a tick that charts and counters need.

#include <cstdint>

#include "palpate/record.h"

namespace palpate {

struct TickSummary {
  double time_s = 0.0;
  float alpha_rad = 0.0f;
  float depth_m2 = 0.0f;  // squared distance from the goal to the proxy
  float force_N2 = 0.0f;  // squared length of the commanded force
  float full_force_N2 = 0.0f;
  float step_us = 0.0f;
  float late_us = 0.0f;
  std::uint32_t faults = 0;
  std::uint32_t rules = 0;
  std::uint32_t contact = 0;

  // Squares instead of lengths, because this function runs in a tick.
  static TickSummary of(const TickRecord& record) noexcept {
    const auto square = [](const double* v) { return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]; };
    const double depth[3] = {record.proxy_scene_m[0] - record.goal_scene_m[0],
                             record.proxy_scene_m[1] - record.goal_scene_m[1],
                             record.proxy_scene_m[2] - record.goal_scene_m[2]};
    TickSummary row;
    row.time_s = record.time_s;
    row.alpha_rad = static_cast<float>(record.alpha_rad);
    row.depth_m2 = static_cast<float>(square(depth));
    row.force_N2 = static_cast<float>(square(record.force_device_N));
    row.full_force_N2 = static_cast<float>(square(record.full_force_device_N));
    row.step_us = static_cast<float>(record.step_ns) * 1e-3f;
    row.late_us = static_cast<float>(record.late_ns) * 1e-3f;
    row.faults = record.faults;
    row.rules = record.rules;
    row.contact = record.contact;
    return row;
  }
};

}  // namespace palpate
