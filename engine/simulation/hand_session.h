#pragma once

// A haptic session whose device is simulated: a hand, the device that it holds, and a haptic loop.
// `run` and the experiment both use it.

#include <cstdint>
#include <memory>
#include <vector>

#include "engine/session/haptic_session.h"
#include "engine/session/run_setup.h"
#include "engine/simulation/simulated_device.h"
#include "geometry/base/result.h"

namespace palpate {

// One thread owns a session; the haptic thread of the session may be another thread (HapticThread).
class HandSession {
 public:
  // The caller must have checked setup and plant (check_setup, check_plant). start_scene_m: the
  // point where the hand and the device rest at time 0, scene frame. observers: called in every
  // tick, before the hand sees the record of the tick. sink: records the session; null: nothing
  // does. All references must outlive the session. Returns an error if a node that setup.moves
  // names does not exist.
  static Result<std::unique_ptr<HandSession>> create(const Scene& scene, const RunSetup& setup,
                                                     const PlantSettings& plant, HandPlan& plan,
                                                     const Vec3& start_scene_m,
                                                     std::vector<TickObserver*> observers,
                                                     TickSink* sink = nullptr);

  // Runs ticks in simulated time, as fast as possible, then commands zero force. Ends after `most`
  // ticks, or when is_over(n) returns true. is_over(n) is called before tick n (n = 0, 1, ...).
  // Returns the number of ticks.
  template <typename IsOver>
  std::uint64_t run_simulated(std::uint64_t most, const IsOver& is_over) {
    session_.start();  // a simulated device always starts
    std::uint64_t n = 0;
    for (; n < most && !is_over(n); ++n) session_.tick(dt_s_);
    session_.stop();
    return n;
  }

  HapticSession& session() { return session_; }
  const HapticLoop& loop() const { return loop_; }

 private:
  HandSession(const Scene& scene, const RunSetup& setup, const PlantSettings& plant, HandPlan& plan,
              const Vec3& start_scene_m, std::vector<TickObserver*> observers, TickSink* sink,
              SteadyMotions mover);

  double dt_s_;
  SteadyMotions mover_;
  SimulatedDevice device_;
  HapticLoop loop_;
  HapticSession session_;
};

}  // namespace palpate
