#pragma once

// A session on the haptic thread: with a device that a person holds, or without motors.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/session/guarded_run.h"

namespace palpate {

// One thread owns an object and calls its functions. The session, and the device, must outlive it.
class SessionThread {
 public:
  // device: its session starts and ends in the order of GuardedRun; null: no motors move, and only
  // settings.thread counts.
  SessionThread(HapticSession& session, GuardableDevice* device,
                const GuardedRunSettings& settings);
  ~SessionThread();  // calls stop()

  // Starts the thread. An Error names what the device or its guard lacks.
  std::optional<Error> start();
  // Ends the thread after zero force.
  void stop();

  const HapticThread& thread() const;
  // One line each, after start(): privileges that the system refused.
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  HapticSession& session_;
  std::unique_ptr<HapticThread> alone_;  // without a device
  std::unique_ptr<GuardedRun> guarded_;  // with one
  std::vector<std::string> warnings_;
};

}  // namespace palpate
