#pragma once

// Which settings a god-object accepts, told before it is made.

#include <optional>

#include "geometry/base/result.h"

namespace palpate {

struct ContactWorld;
struct GodObjectSettings;

// The first setting that is out of range, or nothing. Error::element is the name of the field, such
// as "accuracy.tolerance". In range are:
//
//   radius_m              finite; 0, a point, or at least a stand-off (SolverScale): a smaller
//                         sphere has no digits. No larger than what each index of the world and its
//                         tree were built for: SurfaceIndex::sweep_radius_m() >= radius_m + a
//                         stand-off, kLargestSweep_m at most
//   accuracy.iterations   1 to Accuracy::kMostIterations
//   accuracy.tolerance    finite, > 0
//
// A god-object that is made in spite of an error moves nothing (ProxyState::is_refused).
// Not for the haptic thread: it allocates. Thread-safe.
std::optional<Error> check_settings(const ContactWorld& world, const GodObjectSettings& settings);

}  // namespace palpate
