#pragma once

// The messages of a hAPI board with two motors and two encoders on ports 1 and 2 (Haply 2DIY). The
// protocol has neither a checksum nor a sequence number.

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/devices/hapi_zero.h"

namespace palpate {

inline constexpr std::size_t kHapiJoints = 2;
inline constexpr std::size_t kHapiTickSize = 2 + 4 * kHapiJoints;
inline constexpr std::size_t kHapiAnswerSize = 1 + 4 * kHapiJoints;

// The first byte of a message.
struct HapiCommand {
  static constexpr std::uint8_t kReset = 0;
  static constexpr std::uint8_t kSetUp = 1;
  static constexpr std::uint8_t kTick = 2;
  static constexpr std::uint8_t kNone = 3;  // no command: the board skips it
};

// One number per joint.
using HapiNumbers = std::array<float, kHapiJoints>;
using HapiTick = std::array<std::uint8_t, kHapiTickSize>;

// What the set-up message tells the board.
struct HapiWiring {
  std::uint8_t device = 5;        // a label for these motors and encoders, 1 to 127
  float counts_per_turn = 13824;  // of an encoder, > 0
  // The angles of the joints in the rest pose, degrees. The board counts steps of its encoders, and
  // a set-up message tells it the present angles: the device must be in its rest pose at that time.
  HapiNumbers rest_deg = {180.0f, 0.0f};
};

// Makes the board forget its set-up. Its motors hold their torque.
std::array<std::uint8_t, 2> hapi_reset();

// Sets up motors and encoders. present_deg: the present angles. The motors hold their torque.
std::vector<std::uint8_t> hapi_set_up(const HapiWiring& wiring, const HapiNumbers& present_deg);

// The motors as the set-up message states them, for the process that guards them.
HapiMotors hapi_motors(const HapiWiring& wiring);

// Sets the torques, in the board's own unit, and asks for an answer.
HapiTick hapi_tick(std::uint8_t device, const HapiNumbers& torques);

// Bytes that end any message which was cut, and then set both torques to zero, for the driver
// itself (the guard, which does not know whether the board is set up, uses hapi_zero.h). The board
// must be set up; it keeps its set-up and its angles. The bytes begin with a padding that is
// skipped as a command and that is a torque below 2^-119 as the end of a message.
std::vector<std::uint8_t> hapi_stop_bytes(const HapiWiring& wiring);

// Reads answers byte by byte: the device byte, then an angle in degrees per encoder.
//
// One thread owns an object. No function allocates or throws.
class HapiAnswerParser {
 public:
  enum class State : std::uint8_t {
    kIncomplete,
    kComplete,  // angles_deg() has a new value
    // A wrong device byte, or an angle that is not finite or further than kJump_deg from the last
    // one. The parser is as after clear(): bytes may be missing, so the caller should discard bytes
    // until the line is quiet.
    kMalformed
  };
  static constexpr float kJump_deg = 360.0f;

  // last_deg: what the first answer is compared with.
  HapiAnswerParser(std::uint8_t device, const HapiNumbers& last_deg) noexcept
      : device_(device), angles_deg_(last_deg) {}

  State add(std::uint8_t byte) noexcept;
  // Forgets an incomplete answer.
  void clear() noexcept { size_ = 0; }
  bool has_part() const noexcept { return size_ > 0; }
  // The angles of the last complete answer.
  const HapiNumbers& angles_deg() const noexcept { return angles_deg_; }

 private:
  std::uint8_t device_;
  HapiNumbers angles_deg_;
  std::array<std::uint8_t, kHapiAnswerSize> bytes_{};
  std::size_t size_ = 0;
};

}  // namespace palpate
