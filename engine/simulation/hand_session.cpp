#include "engine/simulation/hand_session.h"

#include <utility>

namespace palpate {
namespace {

std::vector<TickObserver*> with_last(std::vector<TickObserver*> observers, TickObserver& last) {
  observers.push_back(&last);
  return observers;
}

}  // namespace

HandSession::HandSession(const Scene& scene, const RunSetup& setup, const PlantSettings& plant,
                         HandPlan& plan, const Vec3& start_scene_m,
                         std::vector<TickObserver*> observers, SteadyMotions mover)
    : dt_s_(setup.dt_s),
      mover_(std::move(mover)),
      device_(plant, plan, setup.haptics.initial_pose.point(start_scene_m),
              setup.haptics.initial_pose, setup.actuation.is_planar()),
      loop_(scene.world(), setup.actuation, setup.haptics),
      session_(loop_, device_,
               {.changes = {&mover_},
                .observers = with_last(std::move(observers), device_),
                .max_force_N = setup.max_force_N}) {}

Result<std::unique_ptr<HandSession>> HandSession::create(const Scene& scene, const RunSetup& setup,
                                                         const PlantSettings& plant, HandPlan& plan,
                                                         const Vec3& start_scene_m,
                                                         std::vector<TickObserver*> observers) {
  auto mover = SteadyMotions::create(scene, setup.moves);
  if (!mover) return mover.error();
  return std::unique_ptr<HandSession>(new HandSession(scene, setup, plant, plan, start_scene_m,
                                                      std::move(observers), std::move(*mover)));
}

}  // namespace palpate
