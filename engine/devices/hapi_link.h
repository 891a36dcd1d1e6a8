#pragma once

// The conversation with a hAPI board: what to send and when, and what the answers mean. It does no
// I/O and reads no clock.

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "engine/devices/hapi_delay.h"
#include "engine/devices/hapi_flights.h"
#include "engine/devices/hapi_protocol.h"
#include "engine/devices/hapi_settings.h"
#include "engine/devices/hapi_torques.h"
#include "engine/devices/round_trips.h"
#include "engine/devices/write_guard.h"

namespace palpate {

// Why the driver has asked for a trip.
enum class HapiProblem : std::uint8_t {
  kNone,
  kNoAnswers,
  kBadAnswers,
  kHungUp,
  kGuardTripped,  // the guard has stopped the motors
  kGuardGone,     // nobody would stop the motors
  kGuardFrozen,   // the same, though the process exists
  kSuspended      // the machine was suspended; the guard has stopped the motors
};

// The force that a tick commands.
struct HapiForce {
  std::array<double, 2> force_N = {};
  std::int64_t tick_ns = 0;    // time of the tick; 0: there was none
  std::int64_t period_ns = 0;  // of the ticks; at most that of the messages counts as that one
  std::int64_t sample_ns = 0;  // HapiSample::time_ns of the sample that it answers; 0: unknown
};

// What the driver knows of the device.
struct HapiSample {
  std::array<double, 2> tip_m = {};
  std::array<double, 4> jacobian = {};  // row by row, m/rad
  double fade = 0.0;                    // HapiPose::fade
  std::uint64_t sequence = 0;           // number of the answer; the driver counts it
  std::int64_t time_ns = 0;  // when its message was sent: the device was sampled no earlier
  // The motors obey: since the last trip the board was set up again and has answered.
  bool is_working = false;
  std::uint64_t trips = 0;
  HapiProblem problem = HapiProblem::kNone;  // of the last trip
};

struct HapiCounts {
  std::uint64_t messages = 0;   // ticks
  std::uint64_t answers = 0;    // accepted
  std::uint64_t missed = 0;     // messages without an answer for kAnswer_ns
  std::uint64_t late = 0;       // answers later than that
  std::uint64_t malformed = 0;  // answers that were refused or cut
  std::uint64_t set_ups = 0;
  std::int64_t round_trip_median_ns = 0;
  std::int64_t round_trip_longest_ns = 0;
  // From the message of a sample to the message with the force that answers it; 0 without a force.
  std::int64_t delay_median_ns = 0;
  std::int64_t delay_longest_ns = 0;
  std::uint64_t forces = 0;          // messages with a force whose sample is known
  std::uint64_t delayed_forces = 0;  // of these, those later than HapiLink::set_longest_delay()
  // From the first message to the last one.
  std::int64_t messages_ns = 0;
  // The fewest messages in a second; 0 before the first second ends.
  std::uint64_t fewest_in_second = 0;
};

// The conversation. Rules:
// - At most one message is in flight. If its answer does not come within kAnswer_ns, it is counted
//   and the next message goes out. If then only one answer comes, nobody knows to which message it
//   belongs: the link takes the older one, and waits until kForget_ns for another answer.
// - An answer is malformed if the parser refuses it, if it is cut, if the links cannot have its
//   angles, or if a joint would have turned faster than kFastestJoint_deg_per_s. A fault that
//   changes an angle by less cannot be found. After a malformed answer, the link sends zero,
//   discards bytes until the line was quiet for kForget_ns, asks once for the present angles,
//   resets the board, and sets it up with these angles; without a good answer, with the last good
//   ones.
// - After kMostBad messages in a row with a bad outcome of either kind, the same happens, and the
//   link asks for a trip.
// - Before each message it looks at the guard. If the guard has stopped the motors, the same
// happens
//   when the guard is quiet again; if the guard is gone, the link commands zero from then on. Every
//   message that was written is a beat for the guard.
// - After a trip it commands zero until a later tick has commanded zero.
// - It commands zero if the newest tick is older than 10 ms or 5 periods of the slower of ticks and
//   messages, whichever is longer.
// - A message that is cut is continued, never begun again. A message that waits is made anew.
//
// Times are on one monotonic clock and never decrease. One thread owns an object.
class HapiLink {
 public:
  static constexpr std::int64_t kAnswer_ns = 5'000'000;
  static constexpr std::int64_t kForget_ns = 2 * kAnswer_ns;
  static constexpr std::int64_t kLongestClearing_ns = 100'000'000;  // on a line that is never quiet
  static constexpr int kMostBad = 3;
  static constexpr double kFastestJoint_deg_per_s = 12'000.0;  // a tip of the example at 10 m/s

  // The device must be in its rest pose at the first set-up.
  explicit HapiLink(const HapiSettings& settings);
  HapiLink(const HapiLink&) = delete;
  HapiLink& operator=(const HapiLink&) = delete;

  // Stops motors that may still push, and sets up the board.
  void start(std::int64_t now_ns);
  // guard: must outlive the link; null: there is none. Its earlier trips are ignored.
  void set_guard(WriteGuard* guard);
  void set_force(const HapiForce& force);
  // Later forces count as delayed.
  void set_longest_delay(std::int64_t delay_ns) { longest_delay_ns_ = delay_ns; }
  // From now on, the link commands zero.
  void release() { is_released_ = true; }
  // A zero force was sent after release(), or nothing can be sent.
  bool has_released() const { return has_sent_zero_ || phase_ == Phase::kOff; }

  // Bytes from the board.
  void receive(std::span<const std::uint8_t> bytes, std::int64_t now_ns);
  // The line is dead: nothing can be sent from now on.
  void hang_up(std::int64_t now_ns);
  // Does what is due. Call it after receive(), and at wake_ns().
  void step(std::int64_t now_ns);
  // Bytes to the board, valid until the next call. Call it directly after step().
  std::span<const std::uint8_t> to_send() const { return std::span(outgoing_).subspan(sent_); }
  // The first `count` bytes of to_send() were written.
  void sent(std::size_t count, std::int64_t now_ns);
  // When the next step is due.
  std::int64_t wake_ns() const;
  // Before start() and after hang_up(): there is nothing to do.
  bool is_off() const { return phase_ == Phase::kOff; }

  const HapiSample& sample() const { return sample_; }
  HapiCounts counts() const;
  // The exchanges since the first answer.
  const HapiDelay& exchanges() const { return exchanges_; }

 private:
  enum class Phase : std::uint8_t { kOff, kClearing, kAsking, kRunning };

  void watch_guard(std::int64_t now_ns);
  void watch_answers(std::int64_t now_ns);
  void take_answer(std::int64_t now_ns);
  void refuse_answer(std::int64_t now_ns);
  void count_bad(HapiProblem problem, std::int64_t now_ns);
  void trip(HapiProblem problem, std::int64_t now_ns);
  void begin_clearing(std::int64_t now_ns);
  void watch_clearing(std::int64_t now_ns);
  void ask_for_angles(std::int64_t now_ns);
  void take_angles(std::int64_t now_ns);
  void set_up(std::int64_t now_ns);
  bool may_send() const;
  void make_tick(std::int64_t now_ns);
  bool commands_force(std::int64_t now_ns) const;
  void count_message(std::int64_t now_ns);
  void count_delay(std::int64_t now_ns);
  template <typename Message>
  void put(const Message& message);

  HapiSettings settings_;
  FiveBar bar_;
  HapiTorques torques_;
  HapiNumbers angles_deg_;  // of the last answer that was accepted
  HapiAnswerParser parser_;
  WriteGuard* guard_ = nullptr;
  std::uint64_t guard_epoch_ = 0;  // the last one that was seen
  bool owes_acknowledgement_ = false;
  bool is_guard_gone_ = false;

  Phase phase_ = Phase::kOff;
  std::int64_t quiet_since_ns_ = 0;
  std::int64_t clearing_since_ns_ = 0;
  std::optional<HapiNumbers> first_asked_deg_;  // before a set-up
  std::int64_t first_asked_ns_ = 0;
  HapiFlights flights_;
  int bad_in_a_row_ = 0;
  std::int64_t period_ns_;
  std::int64_t next_tick_ns_ = 0;
  std::int64_t last_tick_ns_ = 0;

  std::vector<std::uint8_t> outgoing_;
  std::size_t sent_ = 0;
  bool is_tick_ = false;                 // outgoing_ is a tick message
  bool is_zero_ = false;                 // outgoing_ ends with zero torques
  std::int64_t answered_sample_ns_ = 0;  // of the force in outgoing_; 0: none, or unknown

  HapiForce force_;
  bool awaits_zero_ = false;  // since trip_ns_
  std::int64_t trip_ns_ = 0;
  bool is_released_ = false;
  bool has_sent_zero_ = false;

  std::optional<HapiPose> pose_;
  HapiSample sample_;
  HapiCounts counts_;
  RoundTrips round_trips_;
  RoundTrips delays_;
  std::int64_t longest_delay_ns_ = std::numeric_limits<std::int64_t>::max();
  HapiDelay exchanges_;
  std::int64_t first_message_ns_ = 0;
  std::int64_t second_since_ns_ = 0;
  std::uint64_t messages_before_second_ = 0;
};

}  // namespace palpate
