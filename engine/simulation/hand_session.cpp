#include "engine/simulation/hand_session.h"

#include <utility>

namespace palpate {

HandSession::HandSession(const RunSetup& setup, const PlantSettings& plant, HandPlan& plan,
                         const Vec3& start_scene_m)
    : dt_s_(setup.dt_s),
      device_(device_in_hand(plant, setup, plan, setup.haptics.initial_pose.point(start_scene_m))) {
}

Result<std::unique_ptr<HandSession>> HandSession::create(const Scene& scene, const RunSetup& setup,
                                                         const PlantSettings& plant, HandPlan& plan,
                                                         const Vec3& start_scene_m,
                                                         RigParts parts) {
  std::unique_ptr<HandSession> hand(new HandSession(setup, plant, plan, start_scene_m));
  auto rig = Rig::create(scene, setup, hand->device_, std::move(parts));
  if (!rig) return rig.error();
  hand->rig_ = std::move(*rig);
  hand->session().observe(hand->device_);
  return hand;
}

}  // namespace palpate
