#pragma once

// The bytes that stop the motors of a hAPI board, whatever the board has read before.

#include <cstdint>
#include <vector>

namespace palpate {

// The motors and PWM pins that a host has set up on a board, with the same numbers as in its set-up
// message.
struct HapiMotors {
  std::uint8_t device = 1;               // not 0, to which all ports belong before a set-up
  std::uint8_t ports = 0;                // bit p is port p + 1, for p from 0 to 3
  std::vector<std::uint8_t> directions;  // of each motor
  std::vector<std::uint8_t> pwm_pins;    // at most 14
};

// The host may have been stopped in the middle of a message, and the board reads on without looking
// for the begin of a message. After these bytes, written at once, the torques of all motors are
// zero, for every state of the board's parser: any message cut after any byte, set-up included,
// with any lengths. A torque of which the host had written some bytes becomes less than 2^-119, and
// no other torque but zero arises.
//
// The board then expects a command. Its motors and PWM pins are set up, so that it reads a command
// that the host writes late as the host means it. Its encoders are not set up: the host must set up
// the board again, which on the firmware that was read also sets the encoders to their offsets.
//
// No board was tried. The bytes are right for the firmware that was read and for the ways in which
// others may differ: a reset keeps or clears the torques; the motors are set up, or belong to
// device 0, or to no device after it (hapi_zero_test.cpp has them all).
//
// If directions or pwm_pins have a wrong length, the motors still stop, but late commands of the
// host may be misread.
std::vector<std::uint8_t> hapi_zero_bytes(const HapiMotors& motors);

}  // namespace palpate
