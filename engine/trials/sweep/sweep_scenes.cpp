#include "engine/trials/sweep/sweep_scenes.h"

#include <algorithm>
#include <utility>

#include "engine/trials/plan_device.h"

namespace palpate {
namespace {

constexpr const char* kDeviceElement = "/device";

// The scenes of one scale, checked in every orientation in which a point of this scale has them.
Result<std::vector<ExperimentScene>> load_scale(const Sweep& sweep, double scale,
                                                const std::vector<SweepPoint>& points,
                                                const TrialFunctions& functions) {
  ExperimentPlan plan = sweep.plan;
  plan.scale = {scale};
  for (const SweepPoint& point : points) {
    const double start_deg = *point.values[kStartOrientation];
    auto& all_deg = plan.start_orientation_deg;
    if (*point.values[kScale] != scale) continue;
    if (std::find(all_deg.begin(), all_deg.end(), start_deg) == all_deg.end()) {
      all_deg.push_back(start_deg);
    }
  }
  return load_experiment_scenes(plan, functions);
}

// The device of a plan, in the place of another setup.
RunSetup in_place_of(RunSetup device, const RunSetup& placed) {
  device.haptics.plane_height_m = placed.haptics.plane_height_m;
  device.haptics.initial_pose = placed.haptics.initial_pose;
  return device;
}

std::optional<Error> check_point(const ExperimentPlan& plan,
                                 const std::vector<ExperimentScene>& scenes) {
  const auto device = make_setup(plan.device);
  if (!device) return as_plan_error(device.error(), kDeviceElement);
  for (const ExperimentScene& scene : scenes) {
    const RunSetup setup =
        in_place_of(*device, turned_setup(scene.setup, plan.start_orientation_deg.front()));
    if (auto error = check_setup(scene.scene, setup)) {
      return as_plan_error(*error, kDeviceElement);
    }
  }
  return check_persons(plan, *device);
}

}  // namespace

Result<SweepScenes> load_sweep_scenes(const Sweep& sweep, const std::vector<SweepPoint>& points,
                                      const TrialFunctions& functions) {
  SweepScenes scenes;
  for (const SweepPoint& point : points) {
    const double scale = *point.values[kScale];
    if (!scenes.contains(scale)) {
      auto loaded = load_scale(sweep, scale, points, functions);
      if (!loaded) return at_point(loaded.error(), sweep, point);
      scenes.emplace(scale, std::move(*loaded));
    }
    if (auto error = check_point(plan_at(sweep, point), scenes.at(scale))) {
      return at_point(*error, sweep, point);
    }
  }
  return scenes;
}

TrialFunctions with_device_of(const ExperimentPlan& plan, const TrialFunctions& functions) {
  TrialFunctions with_device = functions;
  with_device.run = [device = make_setup(plan.device), run = functions.run](
                        const Scene& scene, const TrialWay& way, const RunSetup& placed,
                        const TrialSettings& settings, const OperatorParameters& person,
                        const TrialConditions& conditions,
                        const TrialSink& sink) -> Result<TrialOutcome> {
    if (!device) return device.error();
    return run(scene, way, in_place_of(*device, placed), settings, person, conditions, sink);
  };
  return with_device;
}

}  // namespace palpate
