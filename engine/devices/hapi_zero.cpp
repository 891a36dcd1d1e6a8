#include "engine/devices/hapi_zero.h"

#include <bit>
#include <cstddef>

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
// set up anew and zeroed by their own number, for a board that knows no device 0.
//
// USB carries the bytes in packets of 64. The firmware takes a byte that has not arrived for 255,
// if the byte is no torque; therefore no message extends over two packets. Most boards read the
// first pair of tick messages in time; the second pair is for those in a set-up with wrong counts.
namespace palpate {
namespace {

constexpr std::size_t kPacket = 64;
constexpr std::size_t kPackets = 8;
constexpr std::size_t kFirstPair = 0;   // in which packet
constexpr std::size_t kSecondPair = 5;  // begins at byte 351, after the 288
constexpr std::size_t kSetUp = 7;
// The length of a tick message for device 0: the command, the device, 14 PWM values, 4 torques.
constexpr std::size_t kTickZero = 2 + 14 + 4 * 4;
constexpr std::uint8_t kSetUpCommand = 1;
constexpr std::uint8_t kTickCommand = 2;
constexpr std::uint8_t kNoCommand = 3;

// The zeros between two tick messages of a pair must be an even number: the first message ends its
// packet, and the second begins the next one.
void put_pair(std::vector<std::uint8_t>& bytes, std::size_t packet) {
  bytes[(packet + 1) * kPacket - kTickZero - 1] = kTickCommand;
  bytes[(packet + 1) * kPacket] = kTickCommand;
}

}  // namespace

std::vector<std::uint8_t> hapi_zero_bytes(std::uint8_t device, std::uint8_t motor_ports) {
  std::vector<std::uint8_t> bytes(kPackets * kPacket, 0);
  put_pair(bytes, kFirstPair);
  put_pair(bytes, kSecondPair);

  std::size_t place = kSetUp * kPacket;
  bytes[place - 1] = kNoCommand;
  bytes[place] = kSetUpCommand;
  bytes[place + 1] = device;
  bytes[place + 2] = motor_ports & 0x0F;
  // The directions of the motors, no encoder, no analog pin, no PWM pin.
  place += 3 + static_cast<std::size_t>(std::popcount(bytes[place + 2])) + 3;
  bytes[place] = kTickCommand;
  bytes[place + 1] = device;
  bytes.back() = kNoCommand;
  return bytes;
}

}  // namespace palpate
