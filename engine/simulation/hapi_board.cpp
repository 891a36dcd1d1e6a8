#include "engine/simulation/hapi_board.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "geometry/base/degrees.h"

namespace palpate {
namespace {

using FaultKind = BoardFault::Kind;

constexpr std::int64_t kPlantStep_ns = 200'000;  // short beside the periods of hand and wall

bool acts_at(const BoardFault& fault, std::int64_t now_ns) {
  return fault.from_ns <= now_ns && now_ns < fault.until_ns;
}

Vec2 rest_tip(const BoardSettings& settings) {
  const FiveBar bar(settings.plant.links);
  return bar.forward(kRadPerDegree * settings.rest_deg).value_or(Vec2::Zero());
}

}  // namespace

HapiBoard::HapiBoard(const BoardSettings& settings)
    : settings_(settings), plant_(settings.plant, rest_tip(settings)) {}

void HapiBoard::advance(std::int64_t now_ns) {
  while (!to_firmware_.empty() && to_firmware_.front().due_ns <= now_ns) {
    const DueByte next = to_firmware_.front();
    to_firmware_.pop_front();
    move_to(next.due_ns);
    take_byte(next.byte, next.due_ns);
  }
  move_to(now_ns);
}

// Moves device and hand on, while the motors have the torques of the firmware.
void HapiBoard::move_to(std::int64_t now_ns) {
  if (!has_time_) time_ns_ = now_ns;
  has_time_ = true;
  const double limit = settings_.largest_torque;
  Vec2 torques_Nm;
  for (int k = 0; k < 2; ++k) {
    const double torque = static_cast<double>(firmware_.torques()[static_cast<std::size_t>(k)]);
    torques_Nm[k] = std::clamp(torque, -limit, limit) / settings_.torque_per_Nm;
    if (!std::isfinite(torques_Nm[k])) torques_Nm[k] = 0.0;
  }
  while (time_ns_ < now_ns) {
    const std::int64_t step_ns = std::min(kPlantStep_ns, now_ns - time_ns_);
    plant_.advance(torques_Nm, 1e-9 * static_cast<double>(step_ns));
    time_ns_ += step_ns;
  }
}

HapiFirmware::Joints HapiBoard::joints_deg() const {
  const Vec2 degrees = plant_.joints_rad() / kRadPerDegree;
  return {degrees[0], degrees[1], 0.0, 0.0};
}

void HapiBoard::receive(std::span<const std::uint8_t> bytes, std::int64_t now_ns) {
  advance(now_ns);
  if (has_hung_up(now_ns)) return;
  for (const std::uint8_t byte : bytes) {
    if (settings_.line_ns > 0) {
      to_firmware_.push_back({now_ns + settings_.line_ns, byte});
    } else {
      take_byte(byte, now_ns);
    }
  }
}

void HapiBoard::take_byte(std::uint8_t byte, std::int64_t now_ns) {
  const HapiFirmware::Event event = firmware_.receive(byte, joints_deg());
  if (event == HapiFirmware::Event::kSetUp) ++set_ups_;
  if (event != HapiFirmware::Event::kTick) return;
  plant_.begin_probes();
  answer(now_ns);
}

void HapiBoard::log_command(std::span<const std::uint8_t> answer, std::int64_t now_ns) {
  BoardCommand command;
  command.time_ns = now_ns;
  std::copy_n(firmware_.torques().begin(), kHapiJoints, command.torques.begin());
  command.tip_m = plant_.tip_m();
  command.joints_rad = plant_.joints_rad();
  if (answer.size() == kHapiAnswerSize) {
    std::memcpy(command.answered_deg.data(), answer.data() + 1, kHapiAnswerSize - 1);
  }
  const auto kept = static_cast<std::ptrdiff_t>(settings_.kept_commands);
  if (kept > 0 && std::ssize(log_) >= 2 * kept) log_.erase(log_.begin(), log_.end() - kept);
  log_.push_back(command);
  ++commands_;
}

// Logs a tick message and queues its answer.
void HapiBoard::answer(std::int64_t now_ns) {
  std::vector<std::uint8_t> bytes = firmware_.answer(joints_deg());
  log_command(bytes, now_ns);
  std::vector<std::int64_t> due_ns(bytes.size(), now_ns + settings_.answer_ns + settings_.line_ns);
  for (const BoardFault& fault : faults_) {
    if (!acts_at(fault, now_ns)) continue;
    const bool has_byte = fault.byte < bytes.size();
    const auto at = static_cast<std::ptrdiff_t>(fault.byte);
    switch (fault.kind) {
      case FaultKind::kSilence:
        return;
      case FaultKind::kDelay:
        for (std::int64_t& due : due_ns) due += fault.delay_ns;
        break;
      case FaultKind::kSplit:
        for (std::size_t k = fault.byte; k < due_ns.size(); ++k) due_ns[k] += fault.delay_ns;
        break;
      case FaultKind::kSwallow:
        if (!has_byte) break;
        bytes.erase(bytes.begin() + at);
        due_ns.erase(due_ns.begin() + at);
        break;
      case FaultKind::kCorrupt:
        if (has_byte) bytes[fault.byte] ^= fault.mask;
        break;
      case FaultKind::kHangUp:
        break;
    }
  }
  for (std::size_t k = 0; k < bytes.size(); ++k) {
    // A serial line keeps the order of its bytes.
    if (!to_host_.empty()) due_ns[k] = std::max(due_ns[k], to_host_.back().due_ns);
    to_host_.push_back({due_ns[k], bytes[k]});
  }
}

std::size_t HapiBoard::take_answer(std::span<std::uint8_t> bytes, std::int64_t now_ns) {
  advance(now_ns);
  std::size_t count = 0;
  if (has_hung_up(now_ns)) return count;
  while (count < bytes.size() && !to_host_.empty() && to_host_.front().due_ns <= now_ns) {
    bytes[count++] = to_host_.front().byte;
    to_host_.pop_front();
  }
  return count;
}

std::optional<std::int64_t> HapiBoard::next_due_ns() const {
  std::optional<std::int64_t> next_ns;
  for (const auto* bytes : {&to_host_, &to_firmware_}) {
    if (!bytes->empty())
      next_ns = std::min(next_ns.value_or(bytes->front().due_ns), bytes->front().due_ns);
  }
  return next_ns;
}

bool HapiBoard::has_hung_up(std::int64_t now_ns) const {
  return std::any_of(faults_.begin(), faults_.end(), [now_ns](const BoardFault& fault) {
    return fault.kind == FaultKind::kHangUp && fault.from_ns <= now_ns;
  });
}

}  // namespace palpate
