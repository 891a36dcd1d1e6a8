#include "engine/live/stroke.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "engine/trials/deal/participant_run.h"
#include "haptics/record_vectors.h"

namespace palpate {
namespace {

constexpr int kPlane = 2;  // a trial has two sensed axes

// The largest share of the workspace that one axis of the stroke takes.
double largest_share(const Box& stroke, const DeviceDescription& device) {
  double share = 0.0;
  for (int k = 0; k < kPlane; ++k) {
    const auto axis = static_cast<std::size_t>(k);
    const double room_m = device.workspace_high_m[axis] - device.workspace_low_m[axis];
    share = std::max(share, (stroke.high[k] - stroke.low[k]) / room_m);
  }
  return share;
}

}  // namespace

Result<Box> find_stroke(const ExperimentPlan& plan, const ExperimentScene& scene, int participant) {
  const OperatorParameters person = draw_person(plan.person, plan.seed, participant);
  Box stroke = Box::empty();
  for (const std::size_t rotation : plan.rotation) {
    TrialConditions conditions;
    conditions.force = ForceMode::kNone;
    conditions.a4 = kRotationLevels[rotation].value;
    conditions.noise_seed = plan.seed;
    std::optional<Vec3> start_m;
    const auto outcome = run_trial(scene.scene, scene.way, scene.setup, plan.trial, person,
                                   conditions, [&](const TickRecord& record) {
                                     const Vec3 device_m = vec3(record.device_m);
                                     if (!start_m) start_m = device_m;
                                     const Vec3 away_m = device_m - *start_m;
                                     stroke = stroke.united({away_m, away_m});
                                   });
    if (!outcome) return outcome.error();
  }
  return stroke;
}

std::optional<Box> start_region(const Box& stroke, const DeviceDescription& device) {
  Box region;
  for (int k = 0; k < kPlane; ++k) {
    const auto axis = static_cast<std::size_t>(k);
    region.low[k] = device.workspace_low_m[axis] - stroke.low[k];
    region.high[k] = device.workspace_high_m[axis] - stroke.high[k];
    if (region.low[k] > region.high[k]) return std::nullopt;
  }
  region.low[kPlane] = region.high[kPlane] = 0.0;
  return region;
}

std::optional<Error> check_stroke(const Box& stroke, const DeviceDescription& device,
                                  const ExperimentPlan& plan, const std::string& object,
                                  double scale) {
  const double share = largest_share(stroke, device);
  if (share <= 1.0) return std::nullopt;
  constexpr double kSteps = 100.0;  // the factor in the text has two decimals, rounded down
  const double fitting = std::floor(kSteps * scale / share) / kSteps;
  std::ostringstream problem;
  problem << "is " << scale << ", with which a simulated hand moves the device "
          << stroke.high.x() - stroke.low.x() << " m along A1 and "
          << stroke.high.y() - stroke.low.y() << " m along A2 to follow object " << object
          << "; expected about " << fitting << ", which the workspace of "
          << device.workspace_high_m[0] - device.workspace_low_m[0] << " by "
          << device.workspace_high_m[1] - device.workspace_low_m[1] << " m permits";
  return Error{ErrorCode::kInvalidContent, plan.path, "/scale", problem.str(),
               "state one scale for all conditions, or leave the object out"};
}

}  // namespace palpate
