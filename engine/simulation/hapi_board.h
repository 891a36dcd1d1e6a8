#pragma once

// A simulated hAPI board: firmware, motors, a pantograph and a hand, and a serial line that can
// have faults.

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "engine/devices/hapi_protocol.h"
#include "engine/simulation/hapi_firmware.h"
#include "engine/simulation/pantograph_plant.h"

namespace palpate {

struct BoardSettings {
  PantographSettings plant;
  Vec2 rest_deg = {180.0, 0.0};      // the angles of the joints at the beginning
  double torque_per_Nm = 1.0;        // what the board's numbers mean
  double largest_torque = 0.123;     // the firmware limits numbers to this, in its own unit
  std::int64_t answer_ns = 300'000;  // from the end of a message to its answer
  std::int64_t line_ns = 0;          // each way: what the line delays messages and answers by
  // The log keeps at least this many of the newest commands. 0: all.
  std::size_t kept_commands = 0;
};

// A fault of the line or of the board, while from_ns <= time < until_ns.
struct BoardFault {
  enum class Kind : std::uint8_t {
    kSilence,  // obeys, but does not answer
    kDelay,    // answers delay_ns later
    kSplit,    // the bytes of an answer from number `byte` on come delay_ns later
    kSwallow,  // byte number `byte` of an answer is lost
    kCorrupt,  // byte number `byte` of an answer is changed: exclusive or with `mask`
    kHangUp    // the line is dead from from_ns on, for ever
  };
  Kind kind = Kind::kSilence;
  std::int64_t from_ns = 0;
  std::int64_t until_ns = 0;
  std::int64_t delay_ns = 0;
  std::size_t byte = 0;
  std::uint8_t mask = 0xff;
};

// What the board did with one tick message.
struct BoardCommand {
  std::int64_t time_ns = 0;  // when its last byte came
  HapiNumbers torques{};     // as commanded, in the board's unit
  Vec2 tip_m = Vec2::Zero();
  Vec2 joints_rad = Vec2::Zero();  // the true ones
  HapiNumbers answered_deg{};      // the angles of the answer, before any fault
};

// Works in any time, virtual or real: each call says how late it is. Times must not decrease. One
// thread owns an object.
class HapiBoard {
 public:
  explicit HapiBoard(const BoardSettings& settings);

  void add_fault(const BoardFault& fault) { faults_.push_back(fault); }
  void set_hand(const Vec2& hand_m) { plant_.set_hand(hand_m); }

  // Moves device and hand on.
  void advance(std::int64_t now_ns);
  // Bytes from the host; they reach the firmware after BoardSettings::line_ns.
  void receive(std::span<const std::uint8_t> bytes, std::int64_t now_ns);
  // Moves bytes that are due to the host into `bytes`; returns their number.
  std::size_t take_answer(std::span<std::uint8_t> bytes, std::int64_t now_ns);
  // When the next byte to the host, or to the firmware, is due; no value if there is none.
  std::optional<std::int64_t> next_due_ns() const;
  bool has_hung_up(std::int64_t now_ns) const;

  // The tick messages, oldest first (BoardSettings::kept_commands), and their number since the
  // beginning.
  const std::vector<BoardCommand>& log() const { return log_; }
  std::uint64_t commands() const { return commands_; }
  std::uint64_t set_ups() const { return set_ups_; }
  const HapiFirmware& firmware() const { return firmware_; }
  const PantographPlant& plant() const { return plant_; }

 private:
  struct DueByte {
    std::int64_t due_ns = 0;
    std::uint8_t byte = 0;
  };
  void move_to(std::int64_t now_ns);
  void take_byte(std::uint8_t byte, std::int64_t now_ns);
  HapiFirmware::Joints joints_deg() const;
  void answer(std::int64_t now_ns);
  void log_command(std::span<const std::uint8_t> answer, std::int64_t now_ns);

  BoardSettings settings_;
  PantographPlant plant_;
  HapiFirmware firmware_;
  std::vector<BoardFault> faults_;
  std::deque<DueByte> to_host_;
  std::deque<DueByte> to_firmware_;  // of a line with a delay
  std::vector<BoardCommand> log_;
  std::uint64_t commands_ = 0;
  std::uint64_t set_ups_ = 0;
  std::int64_t time_ns_ = 0;
  bool has_time_ = false;
};

}  // namespace palpate
