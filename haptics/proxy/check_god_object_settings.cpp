#include "haptics/proxy/check_god_object_settings.h"

#include <algorithm>
#include <string>

#include "haptics/proxy/god_object.h"
#include "haptics/proxy/setting_errors.h"

namespace palpate {
namespace {

// Tests that the sphere is large enough to differ from a point and small enough for the indices.
// radius_m: finite, > 0.
std::optional<Error> check_sphere(const ContactWorld& world, double radius_m) {
  const double stand_off_m = SolverScale::of(world.size_m, radius_m).stand_off_m;
  if (radius_m < stand_off_m) {
    return invalid_argument("radius_m", "is " + digits_of(radius_m) +
                                            " m; expected 0 for a point, or at least " +
                                            digits_of(stand_off_m) + " m, the solver's stand-off");
  }
  const double sweep_m = radius_m + stand_off_m;
  double built_for_m = SurfaceIndex::kLargestSweep_m;
  if (world.tree) built_for_m = std::min(built_for_m, world.tree->sweep_radius_m());
  for (const ContactBody& body : world.bodies) {
    const double units_per_metre = body.reach_index(1.0, Vec3::Zero());
    built_for_m = std::min(built_for_m, body.index->sweep_radius_m() / units_per_metre);
  }
  if (sweep_m <= built_for_m) return std::nullopt;
  return invalid_argument("radius_m",
                          "is " + digits_of(radius_m) + " m, or " + digits_of(sweep_m) +
                              " m with the stand-off; expected at most " + digits_of(built_for_m) +
                              " m with the stand-off, the limit of the scene's indices",
                          "load the scene with this radius");
}

}  // namespace

std::optional<Error> check_settings(const ContactWorld& world, const GodObjectSettings& settings) {
  if (auto error = check_number("radius_m", settings.radius_m, true)) return error;
  if (settings.radius_m > 0.0) {
    if (auto error = check_sphere(world, settings.radius_m)) return error;
  }
  const Accuracy& accuracy = settings.accuracy;
  if (accuracy.iterations < 1 || accuracy.iterations > Accuracy::kMostIterations) {
    return invalid_argument("accuracy.iterations", "is " + std::to_string(accuracy.iterations) +
                                                       "; expected 1 to " +
                                                       std::to_string(Accuracy::kMostIterations));
  }
  if (accuracy.work_budget < 1) {
    return invalid_argument("accuracy.work_budget",
                            "is " + std::to_string(accuracy.work_budget) + "; expected at least 1");
  }
  return check_number("accuracy.tolerance", accuracy.tolerance, false);
}

}  // namespace palpate
