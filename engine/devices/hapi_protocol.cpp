#include "engine/devices/hapi_protocol.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace palpate {
namespace {

constexpr std::uint8_t kPortsOneAndTwo = 3;  // port p is bit p - 1
constexpr std::uint8_t kForwards = 0;        // direction of a motor or an encoder

std::array<std::uint8_t, 4> little_endian(float number) {
  const auto bits = std::bit_cast<std::uint32_t>(number);
  return {static_cast<std::uint8_t>(bits), static_cast<std::uint8_t>(bits >> 8),
          static_cast<std::uint8_t>(bits >> 16), static_cast<std::uint8_t>(bits >> 24)};
}

float number_of(const std::uint8_t* bytes) {
  std::uint32_t bits = 0;
  for (int k = 3; k >= 0; --k) bits = bits << 8 | bytes[k];
  return std::bit_cast<float>(bits);
}

}  // namespace

std::array<std::uint8_t, 2> hapi_reset() {
  return {HapiCommand::kReset, 0};
}

std::vector<std::uint8_t> hapi_set_up(const HapiWiring& wiring, const HapiNumbers& present_deg) {
  constexpr std::uint8_t kNone = 0;
  std::vector<std::uint8_t> bytes = {HapiCommand::kSetUp, wiring.device};
  bytes.reserve(64);
  for (const std::uint8_t byte : {kPortsOneAndTwo, kForwards, kForwards,  // motors
                                  kPortsOneAndTwo, kForwards, kForwards,  // encoders
                                  kNone, kNone}) {                        // analog inputs, PWM pins
    bytes.push_back(byte);
  }
  for (const float angle_deg : present_deg) {
    for (const float number : {angle_deg, wiring.counts_per_turn}) {
      const auto part = little_endian(number);
      bytes.insert(bytes.end(), part.begin(), part.end());
    }
  }
  return bytes;
}

HapiMotors hapi_motors(const HapiWiring& wiring) {
  return {wiring.device, kPortsOneAndTwo, {kForwards, kForwards}, {}};
}

HapiTick hapi_tick(std::uint8_t device, const HapiNumbers& torques) {
  HapiTick message = {HapiCommand::kTick, device};
  for (std::size_t joint = 0; joint < kHapiJoints; ++joint) {
    const auto part = little_endian(torques[joint]);
    std::copy(part.begin(), part.end(), message.begin() + 2 + 4 * joint);
  }
  return message;
}

std::vector<std::uint8_t> hapi_stop_bytes(const HapiWiring& wiring) {
  const std::size_t longest = hapi_set_up(wiring, wiring.rest_deg).size();
  std::vector<std::uint8_t> bytes(longest, HapiCommand::kNone);
  const HapiTick zero = hapi_tick(wiring.device, {});
  bytes.insert(bytes.end(), zero.begin(), zero.end());
  return bytes;
}

HapiAnswerParser::State HapiAnswerParser::add(std::uint8_t byte) noexcept {
  bytes_[size_++] = byte;
  if (bytes_[0] != device_) {
    clear();
    return State::kMalformed;
  }
  if (size_ < bytes_.size()) return State::kIncomplete;
  clear();
  HapiNumbers angles_deg;
  for (std::size_t joint = 0; joint < kHapiJoints; ++joint) {
    angles_deg[joint] = number_of(bytes_.data() + 1 + 4 * joint);
    // Also false for an angle that is not a number.
    if (!(std::abs(angles_deg[joint] - angles_deg_[joint]) <= kJump_deg)) return State::kMalformed;
  }
  angles_deg_ = angles_deg;
  return State::kComplete;
}

}  // namespace palpate
