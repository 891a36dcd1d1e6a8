#pragma once

// The accuracy settings of the god-object: all caps, tolerances and shortcuts in one place.

#include <cstdint>
#include <optional>
#include <string_view>

#include "haptics/proxy/work.h"

namespace palpate {

// The arithmetic that decides where a point proxy meets a triangle. A sphere proxy always uses
// double precision.
enum class NarrowPhase : std::uint8_t {
  kFloat,  // single precision relative to the pack's centre; requires a larger stand-off
  kDouble  // double precision, with exact signs where double rounding leaves them uncertain
};

// Plain numbers; check_settings() (check_god_object_settings.h) reports values out of range.
struct Accuracy {
  // Largest number of solver steps per tick, 1 to kMostIterations. Attempts to leave a vertex or an
  // edge are not counted. A capped proxy is feasible and no farther from the goal than before, but
  // more steps could have moved it nearer; the tick reports kFaultSolverCapped.
  int iterations = 64;
  // A solver step shorter than this has converged. In stand-offs (SolverScale), finite, > 0.
  double tolerance = 0.01;
  NarrowPhase narrow_phase = NarrowPhase::kDouble;
  // If true, candidate triangles are kept from tick to tick while the proxy stays in their safe
  // zone. The results with and without this reuse are the same bit for bit.
  bool reuse_candidates = true;
  // If true, the committed part of a stopped step is traced again, up to its end point. The proxy
  // then ends each step at least SolverScale::clearance_m from every triangle. Without this check,
  // a proxy can end a step so close to a second face that rounding hides on which side of it the
  // proxy is.
  bool certify = true;

  // Largest work of the proxy and the bodies in one tick, in the units of work.h, >= 1. A tick that
  // exceeds it is capped, and the next tick continues the interrupted search.
  WorkUnits work_budget = 20000;
  // How the work is counted. Under kFirst, effects have no budget.
  CountingRule counting = CountingRule::kSecond;

  // The budget of the effects of a tick, which is separate from that of the proxy.
  WorkUnits effects_budget() const { return work_budget / kEffectsPart + 1; }
  static constexpr WorkUnits kEffectsPart = 8;

  // Limit of `iterations`. The path of a tick is allocated in advance: 28 MB at this limit.
  static constexpr int kMostIterations = 1 << 16;

  // fast() uses double precision, too: in measurements, the larger stand-off of kFloat caused
  // additional steps, and these took more time than single-precision arithmetic saved.
  static constexpr Accuracy fast() { return {8, 1.0, NarrowPhase::kDouble, true, false, 5000}; }
  static constexpr Accuracy balanced() { return {}; }
  static constexpr Accuracy exact() {
    return {512, 1e-4, NarrowPhase::kDouble, true, true, 160000};
  }
};

// The preset named "fast", "balanced" or "exact"; nullopt for any other name.
constexpr std::optional<Accuracy> accuracy_preset(std::string_view name) {
  if (name == "fast") return Accuracy::fast();
  if (name == "balanced") return Accuracy::balanced();
  if (name == "exact") return Accuracy::exact();
  return std::nullopt;
}

}  // namespace palpate
