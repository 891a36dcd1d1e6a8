#pragma once

// The times of the ticks of a thread, as JSON and as text.

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "engine/session/run_setup.h"
#include "engine/session/tick_times.h"

namespace palpate {

nlohmann::ordered_json tick_times_json(const TickTimes& times);
// The timing reached and the stiffness of walls at that timing; null for fewer than two ticks.
nlohmann::ordered_json reached_timing_json(const RunSetup& setup, const TickTimes& times);

// " (3 woken_late, 1 preempted)"; empty if no tick was late.
std::string late_causes_text(const TickTimes& times);
// One line about the stiffness of walls at the timing reached; empty for fewer than two ticks.
std::string reached_timing_text(const RunSetup& setup, const TickTimes& times);

}  // namespace palpate
