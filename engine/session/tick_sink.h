#pragma once

// What a recording of a session consists of, and the interface through which a session hands it
// over.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>

#include "engine/session/tick_times.h"
#include "haptics/safety_governor.h"
#include "palpate/device.h"
#include "palpate/record.h"

namespace palpate {

// The kinds of inputs: everything but the sample and the times of a tick that changes what a tick
// computes. The numbers are part of the format of recordings: add new kinds at the end.
enum class InputKind : std::uint16_t {
  kBodyPose,          // a new pose of a body of the world
  kBadBodyPose,       // a pose that was refused before it reached the loop
  kActuation,         // the actuated axes
  kEffectParameters,  // parameters of one call of the world's effect program
  kA4,                // A4 on or off; only in recordings of before kSetting
  kForce,             // the part of the force that is commanded; likewise
  kCoupling,          // stiffness and damping of surfaces that declare none; likewise
  kMotors,            // the motors of a device whose motors turn
  kRearm,             // the end of a trip
  kTrip,              // the device asks the governor to trip: a fault of the driver or of the guard
  kPause,             // ticks in which the session was paused, before this tick
  kFreeHand,          // the hand is free of surfaces and force, or no longer
  kSetting            // a setting of kLiveSettings (live_setting.h)
};

struct InputKindFacts {
  InputKind kind;
  std::string_view name;
  std::size_t least_bytes;  // of the input's bytes
  std::size_t most_bytes;
  std::string_view handle;  // what the handle of an input means
  std::string_view bytes;   // what its bytes are
};

// One line for each kind, in the order of their numbers. loop_changes.cpp does not compile if a
// kind is missing.
inline constexpr std::array kInputKinds = {
    InputKindFacts{InputKind::kBodyPose, "body_pose", 56, 56, "body",
                   "T_scene_body: quaternion w x y z, then origin x y z in m, as doubles"},
    InputKindFacts{InputKind::kBadBodyPose, "bad_body_pose", 0, 0, "0", "none"},
    InputKindFacts{InputKind::kActuation, "actuation", 72, 72, "sensors + 256 actuators",
                   "three orthonormal axes, device frame, as doubles"},
    InputKindFacts{InputKind::kEffectParameters, "effect_parameters", 8, 120,
                   "call of the effect program",
                   "the numbers of the effect's keys, in the order of their list, as doubles"},
    InputKindFacts{InputKind::kA4, "a4", 0, 0, "1: on, 0: off", "none"},
    InputKindFacts{InputKind::kForce, "force", 0, 0, "0: none, 1: actuated, 2: full", "none"},
    InputKindFacts{InputKind::kCoupling, "coupling", 16, 16, "0", "N/m and N s/m, as doubles"},
    InputKindFacts{InputKind::kMotors, "motors", 0, 120, "number of motors",
                   "direction x y z, peak and continuous force in N of each motor, as doubles"},
    InputKindFacts{InputKind::kRearm, "rearm", 0, 0, "0", "none"},
    InputKindFacts{InputKind::kTrip, "trip", 0, 0, "0", "none"},
    InputKindFacts{InputKind::kPause, "pause", 8, 8, "0",
                   "the number of paused ticks, unsigned, 8 bytes"},
    InputKindFacts{InputKind::kFreeHand, "free_hand", 0, 0, "1: free, also again; 0: not", "none"},
    InputKindFacts{InputKind::kSetting, "setting", 8, 8, "number of the setting",
                   "0 or 1 for a flag, the place of the choice, or the number, as a double"},
};
inline constexpr std::size_t kMostInputBytes = 120;

// One input of a tick.
struct TickInput {
  InputKind kind;
  std::uint32_t handle = 0;
  std::span<const std::byte> bytes = {};
};

// What a tick reads from outside, besides its inputs, and what the governor derives from it.
struct TickReading {
  double sample_m[3] = {};          // as the device gave it, device frame
  std::uint64_t sequence = 0;       // of the sample
  std::int64_t sample_ns = 0;       // DeviceSample::time_ns
  double dt_s = 0.0;                // nominal time since the last tick
  std::int64_t due_ns = 0;          // when the tick was due: its start minus late_ns
  std::int64_t measured_dt_ns = 0;  // between the starts of the ticks; computed by the governor
  std::int64_t sample_age_ns = 0;   // computed by the governor
  std::uint64_t session_tick = 0;   // counts the ticks of the session, paused ones included
  std::uint32_t buttons = 0;        // of the sample
  std::uint32_t is_valid = 0;       // of the sample
};
static_assert(std::is_trivially_copyable_v<TickReading> && sizeof(TickReading) == 88);

// What is fixed from the start of a session to its end, beside the settings of its loop.
struct SessionFacts {
  const DeviceDescription& device;
  std::optional<double> max_force_N;
  bool takes_motors = true;
  GovernorSettings governor = {};
};

// Receives all that is needed to compute a session again. The session calls on_start() on the
// owner's thread and the other functions on the haptic thread, where they must not block, allocate
// or throw.
class TickSink {
 public:
  virtual ~TickSink() = default;
  // The device has started; the first tick follows.
  virtual void on_start(const SessionFacts& facts) noexcept = 0;
  // An input of the tick that is running. It is called at the place where the input acts, before
  // it acts.
  virtual void on_input(const TickInput& input) noexcept = 0;
  // Ends a tick, after the force was commanded.
  virtual void on_tick(const TickRecord& record, const TickReading& reading) noexcept = 0;
  // The governor has cut the force in the tick that on_tick() has ended.
  virtual void on_trip(const GovernorTrip& trip) noexcept = 0;
  // The tick that on_tick() ended last ended after the next one was due.
  virtual void on_late(LateCause cause, const TickCost& cost) noexcept = 0;
};

}  // namespace palpate
