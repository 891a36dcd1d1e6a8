#pragma once

// The driver's link and a simulated board in one thread and in virtual time, joined by two buffers.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "engine/devices/hapi_link.h"
#include "engine/simulation/hapi_board.h"

namespace palpate::test {

inline constexpr std::int64_t kMillisecond_ns = 1'000'000;

// A guard that the test commands.
class FakeGuard final : public WriteGuard {
 public:
  void beat(std::int64_t tick_ns, std::int64_t) noexcept override {
    last_beat_ns = tick_ns, ++beats;
  }
  std::uint64_t trip_epoch() const noexcept override { return epoch; }
  void acknowledge(std::uint64_t of_epoch) noexcept override { acknowledged = of_epoch; }
  bool was_suspended() const noexcept override { return suspended; }
  GuardState state(std::int64_t) const noexcept override { return at_present; }

  std::uint64_t epoch = 0;
  std::uint64_t acknowledged = 0;
  std::uint64_t beats = 0;
  std::int64_t last_beat_ns = 0;
  GuardState at_present = GuardState::kAlive;
  bool suspended = false;
};

// A board that pushes: 0.1 N m a number of 0.1, peaks of 0.1 N m.
inline HapiSettings pushing_settings() {
  HapiSettings settings;
  settings.torque_per_Nm = 1.0;
  settings.peak_torque_Nm = 0.1;
  return settings;
}

class HapiRig {
 public:
  static constexpr std::int64_t kStep_ns = 50'000;  // by default
  static constexpr std::int64_t kStart_ns = 1'000 * kMillisecond_ns;

  explicit HapiRig(const HapiSettings& settings = pushing_settings(),
                   const BoardSettings& board_settings = {}, std::int64_t step_of_rig_ns = kStep_ns)
      : step_ns(step_of_rig_ns), link(settings), board(board_settings) {
    link.set_guard(&guard);
    link.start(now_ns);
  }

  // on_tick is called once per period, at the beginning of a step.
  void run(std::int64_t time_ns, const std::function<void()>& on_tick = {}) {
    for (const std::int64_t end_ns = now_ns + time_ns; now_ns < end_ns; now_ns += step_ns) {
      if (on_tick && (now_ns - kStart_ns) % kMillisecond_ns == 0) on_tick();
      step();
    }
  }
  // Runs until the first answer, and on to the next tick.
  void run_until_working() {
    for (int n = 0; n < 100'000 && !link.sample().is_working; ++n, now_ns += step_ns) step();
    for (; (now_ns - kStart_ns) % kMillisecond_ns != 0; now_ns += step_ns) step();
  }
  // Runs while each tick commands a force.
  void push(const Vec2& force_N, std::int64_t time_ns) {
    run(time_ns, [&] { link.set_force({{force_N.x(), force_N.y()}, now_ns}); });
  }

  void step() {
    std::array<std::uint8_t, 64> bytes;
    if (board.has_hung_up(now_ns)) link.hang_up(now_ns);
    link.receive(std::span(bytes).first(board.take_answer(bytes, now_ns)), now_ns);
    link.step(now_ns);
    const auto out = link.to_send();
    const std::size_t count = std::min(out.size(), most_bytes);
    board.receive(out.first(count), now_ns);
    link.sent(count, now_ns);
  }

  std::vector<BoardCommand> commands_since(std::int64_t from_ns) const {
    std::vector<BoardCommand> commands;
    for (const BoardCommand& command : board.log()) {
      if (command.time_ns >= from_ns) commands.push_back(command);
    }
    return commands;
  }
  BoardFault fault(BoardFault::Kind kind, std::int64_t after_ns, std::int64_t time_ns) const {
    BoardFault fault;
    fault.kind = kind;
    fault.from_ns = now_ns + after_ns;
    fault.until_ns = fault.from_ns + time_ns;
    return fault;
  }

  const std::int64_t step_ns;
  std::int64_t now_ns = kStart_ns;
  std::size_t most_bytes = 64;  // that the line takes in a step
  FakeGuard guard;
  HapiLink link;
  HapiBoard board;
};

// Zero on the motor: see hapi_stop_bytes().
inline bool is_zero(const BoardCommand& command) {
  return std::abs(command.torques[0]) < 0x1p-119f && std::abs(command.torques[1]) < 0x1p-119f;
}

// The force of a command in the pose that the driver knew, if it knew the angles angles_deg.
inline Vec2 force_N(const BoardCommand& command, const HapiNumbers& angles_deg,
                    const HapiSettings& settings) {
  const auto pose = hapi_pose(FiveBar(settings.links), angles_deg);
  if (!pose) return Vec2::Zero();
  const Vec2 torques_Nm =
      Vec2(command.torques[0], command.torques[1]) / settings.torque_per_Nm.value_or(1.0);
  return pose->jacobian.transpose().inverse() * torques_Nm;
}

}  // namespace palpate::test
