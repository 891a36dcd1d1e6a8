#pragma once

// Validation of a god-object's settings.

#include <optional>

#include "geometry/base/result.h"

namespace palpate {

struct ContactWorld;
struct GodObjectSettings;

// Returns an Error for the first setting that is out of range, or nullopt. Error::element is the
// name of the field, such as "accuracy.tolerance". The valid ranges are:
//
//   radius_m               finite; 0 for a point, or at least one stand-off (SolverScale), since
//                          rounding would hide a smaller sphere. radius_m plus a stand-off must
//                          exceed neither SurfaceIndex::kLargestSweep_m nor the sweep radius of the
//                          world's tree or of any of its indices
//   accuracy.iterations    1 to Accuracy::kMostIterations
//   accuracy.work_budget   >= 1
//   accuracy.tolerance     finite, > 0
//
// GodObject::create() returns this Error. Not for the haptic thread: allocates. Thread-safe.
std::optional<Error> check_settings(const ContactWorld& world, const GodObjectSettings& settings);

}  // namespace palpate
