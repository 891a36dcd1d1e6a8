#pragma once

// One trial of the canonical protocol.

#include <cstdint>
#include <optional>

#include "engine/scene/scene.h"
#include "engine/session/run_setup.h"
#include "engine/trials/canonical/canonical_plan.h"
#include "engine/trials/operator_parameters.h"
#include "geometry/base/result.h"

namespace palpate {

struct CanonicalConditions {
  CanonicalCell cell;
  std::uint64_t noise_seed = 0;
};

struct CanonicalOutcome {
  // See CanonicalMeasures. No value also if the trial is spoilt.
  std::optional<double> along_over_into;
  std::optional<double> share_within_30deg;
  bool is_spoilt = false;
  std::uint64_t ticks = 0;
  std::int64_t loop_ns = 0;  // computing time of the haptic loop in these ticks; measured
};

// Runs the trial in simulated time, from rest outside the wall to the end of the person's motion,
// or for as long as the motion takes if the person sees no picture. Requires canonical_duration_s()
// to be finite. The same arguments give the same outcome to the bit, except loop_ns. wall:
// canonical_wall(). device: the setup of the device; canonical_setup() places the wall.
// Thread-safe: any number of threads may run trials on one wall.
//
// Errors: those of check_setup() and check_plant().
Result<CanonicalOutcome> run_canonical_trial(const Scene& wall, const RunSetup& device,
                                             double display_Hz, const OperatorParameters& person,
                                             const CanonicalConditions& conditions);

}  // namespace palpate
