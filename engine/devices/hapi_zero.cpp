#include "engine/devices/hapi_zero.h"

#include <algorithm>
#include <bit>
#include <cstddef>

#include "engine/devices/hapi_protocol.h"

// How the bytes were found. A zero byte is safe everywhere: it completes a torque to a number near
// zero, it is the count "none", and two of them are the command "reset". After enough zeros, any
// message has ended. "Enough" is 288: a set-up of 255 analog pins, the count of PWM pins and the
// parameters of four encoders (1 + 255 + 32). The board then is in one of two states: it expects a
// command, or the device number of a reset. A tick message in the first state sets the torques to
// zero; in the second state its first byte is the device number. A second tick message, after an
// even number of zeros, arrives in the first state if the first one did not.
//
// A reset keeps the torques of the firmware that was read and gives its motors to device 0. The
// tick messages are therefore for device 0, whose 14 PWM values and 4 torques are zeros.
//
// A byte that is no command leads from both states to "expects a command". After it, the motors are
// set up anew and zeroed by their own number, for a board that knows no device 0. They stay set up:
// a host that has not yet seen that it was stopped may write one more tick message. Without a
// set-up the board would read the torques in it as commands, and in rare cases as other torques. No
// encoder is set up, because the firmware that was read takes new memory for it each time.
//
// USB carries the bytes in packets of 64. The firmware takes a byte that has not arrived for 255,
// if the byte is no torque; therefore no message extends over two packets. Most boards read the
// first pair of tick messages in time; the second pair is for those in a set-up with wrong counts.
namespace palpate {
namespace {

constexpr std::size_t kPacket = 64;
constexpr std::size_t kFirstPair = 0;   // in which packet
constexpr std::size_t kSecondPair = 5;  // begins at byte 351, after the 288
constexpr std::size_t kSetUpPacket = 7;
constexpr std::size_t kPwmPins = 14;
// The length of a tick message for device 0: the command, the device, 14 PWM values, 4 torques.
constexpr std::size_t kTickZero = 2 + kPwmPins + 4 * 4;

// The zeros between two tick messages of a pair must be an even number: the first message ends its
// packet, and the second begins the next one.
void put_pair(std::vector<std::uint8_t>& bytes, std::size_t packet) {
  bytes[(packet + 1) * kPacket - kTickZero - 1] = HapiCommand::kTick;
  bytes[(packet + 1) * kPacket] = HapiCommand::kTick;
}

}  // namespace

std::vector<std::uint8_t> hapi_zero_bytes(const HapiMotors& motors) {
  std::vector<std::uint8_t> bytes(kSetUpPacket * kPacket, 0);
  put_pair(bytes, kFirstPair);
  put_pair(bytes, kSecondPair);
  bytes.back() = HapiCommand::kNone;

  const auto put = [&bytes](const std::vector<std::uint8_t>& more) {
    bytes.insert(bytes.end(), more.begin(), more.end());
  };
  const std::uint8_t ports = motors.ports & 0x0F;
  std::vector<std::uint8_t> directions = motors.directions;
  directions.resize(static_cast<std::size_t>(std::popcount(ports)), 0);
  std::vector<std::uint8_t> pins = motors.pwm_pins;
  pins.resize(std::min(pins.size(), kPwmPins));
  put({HapiCommand::kSetUp, motors.device, ports});
  put(directions);
  put({0, 0, static_cast<std::uint8_t>(pins.size())});  // no encoder, no analog pin
  put(pins);
  put({HapiCommand::kTick, motors.device});
  put(std::vector<std::uint8_t>(pins.size() + 4 * directions.size(), 0));
  return bytes;
}

}  // namespace palpate
