#pragma once

// The bytes that stop the motors of a hAPI board, whatever the board has read before.

#include <cstdint>
#include <vector>

namespace palpate {

// The host may have been stopped in the middle of a message, and the board reads on without looking
// for the begin of a message. After these bytes, written at once, the torques of all motors are
// zero, for every state of the board's parser: any message cut after any byte, set-up included,
// with any lengths. The board then expects a command and needs a set-up. A torque of which
// the host had written some bytes becomes less than 2^-119, and no other torque but zero arises.
//
// device: the device number of the set-up, not 0, to which all ports belong before a set-up.
// motor_ports: bit p is port p + 1, for p from 0 to 3.
//
// No board was tried. The bytes are right for the firmware that was read and for the ways in which
// others may differ: a reset keeps or clears the torques; the motors are set up, or belong to
// device 0, or to no device after it (hapi_zero_test.cpp has them all).
std::vector<std::uint8_t> hapi_zero_bytes(std::uint8_t device, std::uint8_t motor_ports);

}  // namespace palpate
