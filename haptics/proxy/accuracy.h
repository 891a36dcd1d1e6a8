#pragma once

// What accuracy costs: every cap, tolerance and short cut of the god-object in one place.

#include <cstdint>
#include <optional>
#include <string_view>

#include "haptics/proxy/work.h"

namespace palpate {

// The arithmetic that decides where a point proxy meets a triangle; a sphere's is always double.
enum class NarrowPhase : std::uint8_t {
  kFloat,  // coordinates relative to the pack of triangles, rounded to float: a larger stand-off
  kDouble  // and exact signs where double cannot tell
};

struct Accuracy {
  // Steps of the solver a tick, not counting those that look for a way out at a vertex. A capped
  // proxy is feasible and no farther from the goal than before, but could have come nearer; the
  // tick has kFaultSolverCapped. 1 to kMostIterations.
  int iterations = 64;
  // A step shorter than this has converged. In stand-offs (SolverScale), finite, > 0.
  double tolerance = 0.01;
  NarrowPhase narrow_phase = NarrowPhase::kDouble;
  // Candidate triangles of one tick serve the next while the proxy stays in their safe zone. The
  // answer is the same to the bit.
  bool reuse_candidates = true;
  // What is committed of a step that was stopped is traced again to its very end, and a proxy ends
  // a step no closer than the clearance to any triangle. Without it a proxy can be put closer than
  // rounding to a second face, and lose its side there.
  bool certify = true;

  // What a tick may do, counted (work.h): >= 1. A tick that runs out of it is capped; the next one
  // goes on with what it has examined.
  WorkUnits work_budget = 20000;

  // The corners of a tick's way have room from the start, however many steps it takes: 28 MB for so
  // many.
  static constexpr int kMostIterations = 1 << 16;

  // Not in float: measured, its larger stand-off costs more steps than its arithmetic saves.
  static constexpr Accuracy fast() { return {8, 1.0, NarrowPhase::kDouble, true, false, 5000}; }
  static constexpr Accuracy balanced() { return {}; }
  static constexpr Accuracy exact() {
    return {512, 1e-4, NarrowPhase::kDouble, true, true, 160000};
  }
};

// "fast", "balanced" or "exact".
constexpr std::optional<Accuracy> accuracy_preset(std::string_view name) {
  if (name == "fast") return Accuracy::fast();
  if (name == "balanced") return Accuracy::balanced();
  if (name == "exact") return Accuracy::exact();
  return std::nullopt;
}

}  // namespace palpate
