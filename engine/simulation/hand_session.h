#pragma once

// A haptic session whose device is simulated: a hand, the device that it holds, and its rig.
// `run` and the experiment both use it.

#include <cstdint>
#include <memory>

#include "engine/rig/rig.h"
#include "engine/session/run_setup.h"
#include "engine/simulation/simulated_device.h"
#include "geometry/base/result.h"

namespace palpate {

// One thread owns a session; the haptic thread of the session may be another thread (HapticThread).
class HandSession {
 public:
  // The caller must have checked the plant (check_plant). start_scene_m: the point where the hand
  // and the device rest at time 0, scene frame. parts: their observers are called before the hand
  // sees the record of a tick. All references must outlive the session. Errors: those of
  // Rig::create().
  static Result<std::unique_ptr<HandSession>> create(const Scene& scene, const RunSetup& setup,
                                                     const PlantSettings& plant, HandPlan& plan,
                                                     const Vec3& start_scene_m,
                                                     RigParts parts = {});

  // Runs ticks in simulated time, as fast as possible, then commands zero force. Ends after `most`
  // ticks, or when is_over(n) returns true. is_over(n) is called before tick n (n = 0, 1, ...).
  // Returns the number of ticks.
  template <typename IsOver>
  std::uint64_t run_simulated(std::uint64_t most, const IsOver& is_over) {
    session().start();  // a simulated device always starts
    std::uint64_t n = 0;
    for (; n < most && !is_over(n); ++n) session().tick(dt_s_);
    session().stop();
    return n;
  }

  Rig& rig() { return *rig_; }
  HapticSession& session() { return rig_->session(); }

 private:
  HandSession(const RunSetup& setup, const PlantSettings& plant, HandPlan& plan,
              const Vec3& start_scene_m);

  double dt_s_;
  SimulatedDevice device_;
  std::unique_ptr<Rig> rig_;
};

}  // namespace palpate
