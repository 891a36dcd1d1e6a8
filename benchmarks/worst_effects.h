#pragma once

// Magnets and media on the bodies of a slow input.

#include <cstdint>
#include <memory>
#include <string_view>

#include "benchmarks/worst_inputs.h"
#include "haptics/effects/effect_runner.h"

namespace palpate::bench {

enum class EffectKind : std::uint8_t {
  kNone,
  kMagnets,  // each body attracts the hand at any distance
  kMedia     // each body contains a medium and is no obstacle; the benchmark does not check that
             // its surface is closed
};
std::string_view name_of(EffectKind kind);

// The effects of one pass over an input, for the first bodies: a scene may have 256 magnets and 256
// media.
class WorstEffects {
 public:
  WorstEffects(const WorstInput& input, EffectKind kind, const GodObjectSettings& settings);

  // Runs the effects of one tick and returns their work.
  WorkUnits run(const LiveWorld& world, const ProxyState& state);
  bool is_capped() const { return runner_ && runner_->is_capped(); }

 private:
  ContactWorld world_;
  std::unique_ptr<EffectRunner> runner_;  // null without effects
};

}  // namespace palpate::bench
