#include "engine/rig/workspace.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "engine/rig/placed_bounds.h"

namespace palpate {
namespace {

constexpr double kPartToFill = 0.5;

double widest_m(const Workspace& workspace, const Box& bounds_device) {
  return (bounds_device.high - bounds_device.low).head(workspace.sensors).maxCoeff();
}

double unit_of(double x) {
  constexpr int kDigits = 3;
  return std::pow(10.0, std::floor(std::log10(x)) + 1 - kDigits);
}

// Rounded down to three digits, so that it is easy to type: 0.0666 instead of 0.066666667.
double rounded_down(double x) {
  const double unit = unit_of(x);
  const double rounded = std::floor(x / unit) * unit;
  return std::isfinite(rounded) && rounded > 0.0 ? rounded : x;
}

// A lower bound on rounded_down(x) / x: the digits after the third are worth less than 1 % of x.
constexpr double kLeftOfRounded = 0.99;

double most_m(const Workspace& workspace) {
  return workspace.extent_m - 2 * workspace.room_m;
}

// The wanted largest extent along the sensed axes. It is below most_m() by at least as much as the
// rounding to three digits can change it, so that rounding does not make the scaled scene exceed
// the workspace.
double wanted_m(const Workspace& workspace) {
  return std::min(kPartToFill * workspace.extent_m, kLeftOfRounded * most_m(workspace));
}

// The value of --fit that scales an extent of widest_m along the sensed axes to wanted_m.
std::optional<double> size_for(double wanted_m, double widest_m, double largest_extent_m) {
  const double size_m = wanted_m * (largest_extent_m / widest_m);
  if (!std::isfinite(size_m) || size_m <= 0.0) return std::nullopt;
  return rounded_down(size_m);
}

// The smallest workspace that some size of three digits fits, for every scene.
double least_workspace_m(const Workspace& workspace) {
  const double least_m =
      2 * workspace.room_m + workspace.least_m / (kLeftOfRounded * kLeftOfRounded);
  const double unit = unit_of(least_m);
  return std::ceil(least_m / unit) * unit;
}

Error too_small(const Workspace& workspace) {
  std::ostringstream problem;
  problem << "is " << workspace.extent_m << " m; expected at least " << least_workspace_m(workspace)
          << " m, to leave clearance for the hand on each side of the scene";
  return {ErrorCode::kInvalidArgument, "", "device.workspace", problem.str(),
          "enlarge the workspace; no `SceneSettings::fit_size_m` makes a scene fit a smaller one"};
}

}  // namespace

Workspace hand_workspace(int sensors, double extent_m) {
  return {sensors, extent_m, 2 * kHandPressDepth_m, kHandPressDepth_m};
}

Workspace hand_workspace(const RunSetup& setup) {
  return hand_workspace(setup.actuation.sensors(), workspace_extent_m(setup.device));
}

std::optional<double> fitting_size_m(const Workspace& workspace, const Box& bounds_device,
                                     double largest_extent_m) {
  return size_for(wanted_m(workspace), widest_m(workspace, bounds_device), largest_extent_m);
}

std::optional<double> largest_size_m(const Workspace& workspace, const Box& bounds_device,
                                     double largest_extent_m) {
  return size_for(kLeftOfRounded * most_m(workspace), widest_m(workspace, bounds_device),
                  largest_extent_m);
}

std::optional<Error> check_fits(const Workspace& workspace, const Box& bounds_device,
                                double largest_extent_m) {
  const double widest = widest_m(workspace, bounds_device);
  const double most = most_m(workspace);
  if (widest >= workspace.least_m && widest <= most) return std::nullopt;
  if (workspace.extent_m < least_workspace_m(workspace)) return too_small(workspace);
  const Vec3 extent_m = bounds_device.high - bounds_device.low;
  std::ostringstream problem;
  problem << "spans ";
  for (int axis = 0; axis < workspace.sensors; ++axis) {
    problem << (axis > 0 ? " x " : "") << extent_m[axis];
  }
  problem << " m along the sensed axes; expected ";
  if (widest > most) {
    problem << "at most " << most << " m, the workspace of " << workspace.extent_m << " m minus "
            << workspace.room_m << " m of clearance for the hand on each side";
  } else {
    problem << "at least " << workspace.least_m << " m, the depth to which the hand presses";
  }
  std::ostringstream hint;
  if (const auto size_m = fitting_size_m(workspace, bounds_device, largest_extent_m)) {
    hint << "scale the scene with `SceneSettings::fit_size_m` " << *size_m
         << ", the value of `fitting_size_m()`";
  } else {
    hint << "rotate the scene with `HapticSettings::initial_pose`, to give it an extent along the "
            "sensed axes";
  }
  return Error{ErrorCode::kInvalidArgument, "", "scene", problem.str(), hint.str()};
}

std::optional<Error> check_fits(const Scene& scene, const RunSetup& setup) {
  if (scene.objects().empty()) return std::nullopt;
  return check_fits(hand_workspace(setup), bounds_in_device(scene, setup.haptics.initial_pose),
                    scene.statistics().extent_m.maxCoeff());
}

std::optional<double> fitting_size_m(const Scene& scene, const RunSetup& setup) {
  return fitting_size_m(hand_workspace(setup), bounds_in_device(scene, setup.haptics.initial_pose),
                        scene.statistics().extent_m.maxCoeff());
}

}  // namespace palpate
