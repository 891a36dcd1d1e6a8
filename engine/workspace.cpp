#include "engine/workspace.h"

#include <cmath>
#include <sstream>

namespace palpate {
namespace {

constexpr double kPartToFill = 0.5;

double widest_m(const Workspace& workspace, const Box& bounds_device) {
  return (bounds_device.high - bounds_device.low).head(workspace.sensors).maxCoeff();
}

// As it is typed: 0.0666 and not 0.066666667.
double rounded_down(double x) {
  constexpr int kDigits = 3;
  const double unit = std::pow(10.0, std::floor(std::log10(x)) + 1 - kDigits);
  const double rounded = std::floor(x / unit) * unit;
  return std::isfinite(rounded) && rounded > 0.0 ? rounded : x;
}

}  // namespace

std::optional<double> fitting_size_m(const Workspace& workspace, const Box& bounds_device,
                                     double largest_extent_m) {
  const double size_m =
      kPartToFill * workspace.extent_m * (largest_extent_m / widest_m(workspace, bounds_device));
  if (!std::isfinite(size_m) || size_m <= 0.0) return std::nullopt;
  return rounded_down(size_m);
}

std::optional<Error> check_fits(const Workspace& workspace, const Box& bounds_device,
                                double largest_extent_m) {
  const double widest = widest_m(workspace, bounds_device);
  const double most_m = workspace.extent_m - 2 * workspace.room_m;
  if (widest >= workspace.least_m && widest <= most_m) return std::nullopt;
  if (most_m < workspace.least_m) {
    std::ostringstream problem;
    problem << workspace.extent_m << " m given, expected "
            << 2 * workspace.room_m + workspace.least_m
            << " m at least: room for the hand on each side of what it presses on";
    return Error{ErrorCode::kInvalidArgument, "", "--workspace", problem.str(), ""};
  }
  const Vec3 extent_m = bounds_device.high - bounds_device.low;
  std::ostringstream problem;
  problem << "spans ";
  for (int axis = 0; axis < workspace.sensors; ++axis) {
    problem << (axis > 0 ? " x " : "") << extent_m[axis];
  }
  problem << " m along the sensed axes, expected ";
  if (widest > most_m) {
    problem << most_m << " m at most: the workspace of " << workspace.extent_m << " m less "
            << workspace.room_m << " m on each side for the hand";
  } else {
    problem << workspace.least_m << " m at least: the hand presses so deep";
  }
  std::ostringstream hint;
  if (const auto size_m = fitting_size_m(workspace, bounds_device, largest_extent_m)) {
    hint << "scale it with --fit " << *size_m << ", which --fit auto does";
  } else {
    hint << "turn it with --place so that it has an extent along the sensed axes";
  }
  return Error{ErrorCode::kInvalidArgument, "", "scene", problem.str(), hint.str()};
}

}  // namespace palpate
