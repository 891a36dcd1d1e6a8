#include "engine/devices/five_bar_workspace.h"

#include <algorithm>
#include <vector>

namespace palpate {
namespace {

bool has_full_force(const FiveBar& bar, const Vec2& p_m) {
  const auto joints_rad = bar.inverse(p_m);
  if (!joints_rad) return false;
  const auto jacobian = bar.jacobian(*joints_rad);
  return jacobian && condition_number(*jacobian) <= kFullForceCondition;
}

// The number of steps to both sides of the middle that have full force; -1 if the middle has none.
int steps_beside_middle(const FiveBar& bar, double y_m, double step_m) {
  const double middle_m = 0.5 * bar.links().base_m;
  int steps = 0;
  while (steps <= kGridSteps && has_full_force(bar, {middle_m + steps * step_m, y_m}) &&
         has_full_force(bar, {middle_m - steps * step_m, y_m})) {
    ++steps;
  }
  return steps - 1;
}

}  // namespace

std::optional<PlaneBox> full_force_workspace(const FiveBar& bar) {
  const double step_m = (bar.links().proximal_m + bar.links().distal_m) / kGridSteps;
  std::vector<int> widths;
  for (int row = 1; row <= kGridSteps; ++row) {
    widths.push_back(steps_beside_middle(bar, row * step_m, step_m));
  }
  int most = 0;
  PlaneBox box;
  for (int low = 1; low <= kGridSteps; ++low) {
    int width = kGridSteps;
    for (int high = low; high <= kGridSteps; ++high) {
      width = std::min(width, widths[static_cast<std::size_t>(high - 1)]);
      const int area = 2 * width * (high - low);
      if (area <= most) continue;
      most = area;
      const double middle_m = 0.5 * bar.links().base_m;
      box.low_m = {middle_m - width * step_m, low * step_m};
      box.high_m = {middle_m + width * step_m, high * step_m};
    }
  }
  if (most == 0) return std::nullopt;
  return box;
}

}  // namespace palpate
