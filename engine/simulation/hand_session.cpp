#include "engine/simulation/hand_session.h"

#include <utility>

namespace palpate {
namespace {

std::vector<TickObserver*> with_last(std::vector<TickObserver*> observers, TickObserver& last) {
  observers.push_back(&last);
  return observers;
}

// Under ForceMode::kFull, the simulated device has a motor on every sensed axis, as if it were
// fully actuated.
PlantSettings with_motors(PlantSettings plant, const RunSetup& setup) {
  if (setup.haptics.force != ForceMode::kFull) return plant;
  give_all_motors(plant.device, setup.actuation.sensors());
  return plant;
}

}  // namespace

HandSession::HandSession(const Scene& scene, const RunSetup& setup, const PlantSettings& plant,
                         HandPlan& plan, const Vec3& start_scene_m,
                         std::vector<TickObserver*> observers, TickSink* sink, SteadyMotions mover)
    : dt_s_(setup.dt_s),
      mover_(std::move(mover)),
      device_(with_motors(plant, setup), plan, setup.haptics.initial_pose.point(start_scene_m),
              setup.haptics.initial_pose, setup.actuation.is_planar()),
      loop_(scene.world(), setup.actuation, setup.haptics),
      session_(loop_, device_,
               {.changes = {&mover_},
                .observers = with_last(std::move(observers), device_),
                .max_force_N = setup.max_force_N,
                .sink = sink}) {}

Result<std::unique_ptr<HandSession>> HandSession::create(const Scene& scene, const RunSetup& setup,
                                                         const PlantSettings& plant, HandPlan& plan,
                                                         const Vec3& start_scene_m,
                                                         std::vector<TickObserver*> observers,
                                                         TickSink* sink) {
  auto mover = SteadyMotions::create(scene, setup.moves);
  if (!mover) return mover.error();
  return std::unique_ptr<HandSession>(new HandSession(
      scene, setup, plant, plan, start_scene_m, std::move(observers), sink, std::move(*mover)));
}

}  // namespace palpate
