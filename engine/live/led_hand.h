#pragma once

// A pointer of a page that leads a simulated hand: what a person sees of a force, and does not
// feel.

#include "engine/live/pointed_device.h"
#include "engine/session/run_setup.h"
#include "engine/simulation/simulated_device.h"

namespace palpate {

// The hand of `view` without noise, with the grip that a plan states.
inline PlantSettings led_plant(const RunSetup& setup, const HandImpedance& grip) {
  PlantSettings plant;
  plant.device = setup.device;
  plant.hand = grip;
  plant.intention_noise_m = 0.0;
  return plant;
}

// The simulated device in a hand that the grip, a spring and a damper, draws to the place of the
// pointer, at rest there. The force of the engine acts on it, so that it yields. The grip never
// lets go: where a pen is lifted, the hand is drawn to the pointer's last place.
// Thread-safety: that of PointedDevice; device() and target() are for the haptic thread.
class LedHand final : public HandPlan {
 public:
  // The pointer must outlive this object. start_m: where the hand rests at first, device frame.
  // setup and grip must have passed check_plant().
  LedHand(PointedDevice& pointer, const RunSetup& setup, const HandImpedance& grip,
          const Vec3& start_m)
      : pointer_(pointer), device_(device_in_hand(led_plant(setup, grip), setup, *this, start_m)) {}
  LedHand(const LedHand&) = delete;
  LedHand& operator=(const LedHand&) = delete;

  SimulatedDevice& device() noexcept { return device_; }

  HandTarget target(double /*time_s*/, const ScenePose& /*T_device_scene*/,
                    const TickRecord& /*last*/) noexcept override {
    pointer_.read(0.0);
    return {pointer_.target_m(), Vec3::Zero()};
  }

 private:
  PointedDevice& pointer_;
  SimulatedDevice device_;
};

}  // namespace palpate
