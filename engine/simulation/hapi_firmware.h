#pragma once

// The firmware of a simulated hAPI board: its parser and its registers.

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace palpate {

// Reads messages byte by byte, without a time limit and without finding its way back after a lost
// byte, as the published firmware does. Like the firmware, it skips unknown commands, keeps the
// torques over a reset and over a set-up, and takes the angles of a set-up as the present ones.
//
// Assumptions that no hardware has confirmed: the simulation waits for each byte of a message. The
// firmware takes single bytes that have not arrived yet for 255, and after a second it stops
// waiting for the numbers of a message.
class HapiFirmware {
 public:
  static constexpr std::size_t kPorts = 4;
  using Joints = std::array<double, kPorts>;

  // What a byte has completed.
  enum class Event : std::uint8_t { kNone, kReset, kSetUp, kTick };

  // joints_deg: the true angles at this time.
  Event receive(std::uint8_t byte, const Joints& joints_deg);

  // The answer to the last tick message.
  std::vector<std::uint8_t> answer(const Joints& joints_deg) const;

  // Per port, as commanded: the firmware limits them before they reach the motors.
  const std::array<float, kPorts>& torques() const { return torques_; }
  bool is_between_messages() const { return message_.empty(); }
  bool is_set_up() const { return is_set_up_; }

 private:
  // The firmware's numbers of pins. Pins and ports without a set-up have the address 0.
  static constexpr std::size_t kAnalogPins = 12;
  static constexpr std::size_t kFirstAnalogPin = 54;
  static constexpr std::size_t kPwmPins = 14;
  struct Encoder {
    float counts_per_turn = 0.0f;
    double zero_counts = 0.0;  // what the counter shows at a true angle of 0
  };

  std::size_t length() const;
  std::size_t set_up_length() const;
  void forget_set_up();
  void set_up(const Joints& joints_deg);
  void set_torques();
  float angle_deg(const Encoder& encoder, double joint_deg) const;

  std::vector<std::uint8_t> message_;  // so far
  std::array<std::uint8_t, kPorts> motor_address_{};
  std::array<std::uint8_t, kPorts> encoder_address_{};
  std::array<std::uint8_t, kAnalogPins> analog_address_{};
  std::array<std::uint8_t, kPwmPins> pwm_address_{};
  std::array<Encoder, kPorts> encoders_{};
  std::array<float, kPorts> torques_{};
  std::uint8_t asked_device_ = 0;
  bool is_set_up_ = false;
};

}  // namespace palpate
