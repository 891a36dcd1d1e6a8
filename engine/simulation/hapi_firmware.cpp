#include "engine/simulation/hapi_firmware.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace palpate {
namespace {

constexpr std::uint8_t kResetByte = 0;
constexpr std::uint8_t kSetUpByte = 1;
constexpr std::uint8_t kTickByte = 2;

std::size_t ports_in(std::uint8_t mask) {
  return static_cast<std::size_t>(std::popcount(static_cast<unsigned>(mask & 0xf)));
}

template <std::size_t n>
std::size_t count_of(const std::array<std::uint8_t, n>& addresses, std::uint8_t device) {
  return static_cast<std::size_t>(std::count(addresses.begin(), addresses.end(), device));
}

float float_at(const std::vector<std::uint8_t>& bytes, std::size_t at) {
  std::uint32_t bits = 0;
  for (std::size_t k = 4; k-- > 0;) bits = bits << 8 | bytes[at + k];
  return std::bit_cast<float>(bits);
}

void append_number(std::vector<std::uint8_t>& bytes, float number) {
  const auto bits = std::bit_cast<std::uint32_t>(number);
  for (int k = 0; k < 4; ++k) bytes.push_back(static_cast<std::uint8_t>(bits >> (8 * k)));
}

}  // namespace

HapiFirmware::Event HapiFirmware::receive(std::uint8_t byte, const Joints& joints_deg) {
  message_.push_back(byte);
  if (message_.size() < length()) return Event::kNone;
  Event event = Event::kNone;
  switch (message_.front()) {
    case kResetByte:
      forget_set_up();
      event = Event::kReset;
      break;
    case kSetUpByte:
      set_up(joints_deg);
      event = Event::kSetUp;
      break;
    case kTickByte:
      set_torques();
      event = Event::kTick;
      break;
    default:
      break;
  }
  message_.clear();
  return event;
}

// The length of the message as far as its first bytes tell it: more than they are while it is open.
std::size_t HapiFirmware::length() const {
  switch (message_.front()) {
    case kResetByte:
      return 2;
    case kSetUpByte:
      return set_up_length();
    case kTickByte:
      if (message_.size() < 2) return 2;
      return 2 + count_of(pwm_address_, message_[1]) + 4 * count_of(motor_address_, message_[1]);
    default:
      return 1;
  }
}

std::size_t HapiFirmware::set_up_length() const {
  std::size_t at = 2;  // of the next byte that has a length
  std::size_t encoders = 0;
  for (int part = 0; part < 4; ++part) {
    if (message_.size() <= at) return at + 1;
    const bool is_mask = part < 2;
    const std::size_t count = is_mask ? ports_in(message_[at]) : message_[at];
    if (part == 1) encoders = count;
    at += 1 + count;
  }
  return at + 8 * encoders;
}

void HapiFirmware::forget_set_up() {
  motor_address_.fill(0);
  encoder_address_.fill(0);
  analog_address_.fill(0);
  pwm_address_.fill(0);
  is_set_up_ = false;
}

void HapiFirmware::set_up(const Joints& joints_deg) {
  forget_set_up();
  is_set_up_ = true;
  const std::uint8_t device = message_[1];
  std::size_t at = 2;
  const std::uint8_t motors = message_[at];
  at += 1 + ports_in(motors);
  const std::uint8_t encoders = message_[at];
  at += 1 + ports_in(encoders);
  for (std::size_t n = message_[at++]; n > 0; --n) {
    const std::size_t pin = message_[at++];
    if (pin - kFirstAnalogPin < kAnalogPins) analog_address_[pin - kFirstAnalogPin] = device;
  }
  for (std::size_t n = message_[at++]; n > 0; --n) {
    const std::size_t pin = message_[at++];
    if (pin < kPwmPins) pwm_address_[pin] = device;
  }
  for (std::size_t port = 0; port < kPorts; ++port) {
    if ((motors >> port & 1) != 0) motor_address_[port] = device;
    if ((encoders >> port & 1) == 0) continue;
    encoder_address_[port] = device;
    const double present_deg = static_cast<double>(float_at(message_, at));
    Encoder& encoder = encoders_[port];
    encoder.counts_per_turn = float_at(message_, at + 4);
    const double per_degree = static_cast<double>(encoder.counts_per_turn) / 360.0;
    encoder.zero_counts =
        std::trunc(present_deg * per_degree) - std::round(joints_deg[port] * per_degree);
    at += 8;
  }
}

void HapiFirmware::set_torques() {
  asked_device_ = message_[1];
  std::size_t at = 2 + count_of(pwm_address_, asked_device_);
  for (std::size_t port = 0; port < kPorts; ++port) {
    if (motor_address_[port] != asked_device_) continue;
    torques_[port] = float_at(message_, at);
    at += 4;
  }
}

float HapiFirmware::angle_deg(const Encoder& encoder, double joint_deg) const {
  const double per_turn = static_cast<double>(encoder.counts_per_turn);
  const double counts = encoder.zero_counts + std::round(joint_deg * per_turn / 360.0);
  return static_cast<float>(360.0 * counts / per_turn);
}

std::vector<std::uint8_t> HapiFirmware::answer(const Joints& joints_deg) const {
  std::vector<std::uint8_t> bytes = {asked_device_};
  for (std::size_t n = count_of(analog_address_, asked_device_); n > 0; --n)
    append_number(bytes, 0.0f);
  for (std::size_t port = 0; port < kPorts; ++port) {
    if (encoder_address_[port] == asked_device_) {
      append_number(bytes, angle_deg(encoders_[port], joints_deg[port]));
    }
  }
  return bytes;
}

}  // namespace palpate
