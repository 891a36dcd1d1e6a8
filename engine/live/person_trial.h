#pragma once

// One trial, or the touch of one condition, with a person's hand, on the haptic thread.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/devices/guardable_device.h"
#include "engine/live/led_hand.h"
#include "engine/live/pointed_device.h"
#include "engine/live/trial_watch.h"
#include "engine/rig/rig.h"
#include "engine/session/session_thread.h"
#include "engine/trials/experiment_scene.h"
#include "engine/trials/trial_clock.h"
#include "engine/viewer/state_publisher.h"

namespace palpate {

struct PersonTrialSettings {
  ForceMode force = ForceMode::kNone;
  bool a4 = false;
  TrialSettings trial;
  bool has_clock = true;            // false: the person touches the scene as long as they like
  double longest_lateness_s = 0.1;  // see TrialWatch
  bool permits_clutch = false;      // of a pointer
  // Where the hand on a board is, device frame: the scene is moved in the plane so that the trial
  // begins there. No value: the scene stays, and the pointer begins at its start.
  std::optional<Vec3> hand_m = {};
  // Of a pointer: it leads a simulated hand (LedHand). No value: it moves the device point itself.
  std::optional<HandImpedance> grip = {};
  std::optional<int> cpu = {};    // see HapticThreadSettings
  bool has_guard = true;          // of a board: see GuardedRunSettings
  bool without_realtime = false;  // as well
  TickSink* sink = nullptr;       // records the session; null: nothing does
};

// Owns the device of a pointer, the loop, the clock and the haptic thread. One thread creates,
// starts, stops and destroys it; another one may call point(), newest(), take_ticks() and watch()
// between create() and the destructor.
class PersonTrial {
 public:
  // scene: must outlive this object. start_scene_m: where the device point of a pointer is at
  // first. board: the device that the person holds, which must outlive this object; null: a
  // pointer. Errors: those of check_setup(), of check_plant() with a grip, and of Rig::create().
  static Result<std::unique_ptr<PersonTrial>> create(const ExperimentScene& scene,
                                                     const Vec3& start_scene_m,
                                                     const PersonTrialSettings& settings,
                                                     GuardableDevice* board);

  // The setup of a session with these settings.
  static RunSetup setup_of(const ExperimentScene& scene, const Vec3& start_scene_m,
                           const PersonTrialSettings& settings);

  // Starts the haptic thread. An Error names what the device or its guard lacks.
  std::optional<Error> start() { return thread_->start(); }
  // Ends the thread after zero force.
  void stop() { thread_->stop(); }

  const TrialWatch& watch() const { return watch_; }
  // Requires has_clock and stop().
  const TrialClock& clock() const { return *clock_; }
  std::uint64_t missed_deadlines() const { return thread_->thread().missed_deadlines(); }
  // One line each, after start(): privileges that the system refused.
  const std::vector<std::string>& warnings() const { return thread_->warnings(); }

  void point(const PointerMessage& message) { pointer_.point(message); }
  bool newest(ViewState& state, std::vector<BodyPose>& bodies) const {
    return publisher_->newest(rig_->session(), state, bodies);
  }
  std::uint64_t take_ticks(std::vector<TickSummary>& rows) { return publisher_->take_ticks(rows); }
  // How often the hand was set back.
  std::uint32_t clutches() const noexcept { return pointer_.clutch().uses(); }
  // The hand began inside an object, is free there, and has not left yet (StartInside).
  bool waits_inside() const;
  // Why the governor cut the force; no value: it did not.
  std::optional<TripReason> trip() const;

 private:
  PersonTrial(const ExperimentScene& scene, const RunSetup& setup, const Vec3& start_device_m,
              const PersonTrialSettings& settings);
  std::optional<Error> make_rig(const Scene& scene, const RunSetup& setup,
                                const PersonTrialSettings& settings, GuardableDevice* board);

  bool is_on_board_ = false;
  PointedDevice pointer_;
  std::optional<LedHand> led_;
  std::unique_ptr<TrialClock> clock_;
  TrialWatch watch_;
  std::unique_ptr<Rig> rig_;
  std::optional<StatePublisher> publisher_;
  std::optional<SessionThread> thread_;
};

}  // namespace palpate
