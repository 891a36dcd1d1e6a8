#pragma once

// The reading of a hAPI board's firmware, byte by byte, without any resynchronising.

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

namespace palpate {

// What a reset does, which may differ between firmwares. A set-up replaces the one before.
enum class ResetKind {
  kGivesMotorsToDevice0,  // the firmware that was read: torques stay
  kZeroesTorques,         // and gives the motors to device 0
  kKeepsEverything,       // and the device number is ignored
  kLosesMotors            // torques stay, and only a new set-up reaches the motors
};

struct FakeFirmware {
  static constexpr int kPorts = 4;
  static constexpr int kPwmPins = 14;
  static constexpr int kNobody = -1;

  enum class Stage : std::uint8_t {
    kCommand,
    kResetDevice,
    kSetUpDevice,
    kMotorMask,
    kMotorDirections,
    kEncoderMask,
    kEncoderDirections,
    kAnalogCount,
    kAnalogPins,
    kPwmCount,
    kPwmPins,
    kParameters,
    kTickDevice,
    kPwmValues,
    kTorques
  };

  ResetKind reset_kind;
  Stage stage = Stage::kCommand;
  int left = 0;  // bytes of this stage, > 0 if the stage has several
  int device = 0;
  int motor_mask = 0;
  int encoder_count = 0;
  int analog_count = 0;
  int torque_bytes = 0;  // read
  std::array<std::uint8_t, 4 * kPorts> torque_data = {};

  // The device to which each port and each pin belongs.
  std::array<int, kPorts> motor_device = {};
  std::array<int, kPwmPins> pwm_device = {};
  int encoders = 0;  // set up
  int analogs = 0;
  std::array<float, kPorts> torque = {};
  std::uint64_t ticks = 0;  // completed tick messages

  explicit FakeFirmware(ResetKind kind = ResetKind::kGivesMotorsToDevice0) : reset_kind(kind) {
    forget_set_up();
  }

  // Returns whether this byte has completed a tick message.
  bool take(std::uint8_t byte) {
    const std::uint64_t before = ticks;
    switch (stage) {
      case Stage::kCommand:
        begin(byte);
        break;
      case Stage::kResetDevice:
        reset();
        stage = Stage::kCommand;
        break;
      case Stage::kSetUpDevice:
        device = byte;
        stage = Stage::kMotorMask;
        break;
      case Stage::kMotorMask:
        motor_mask = byte & 0x0F;
        go_on(Stage::kMotorDirections, std::popcount(static_cast<unsigned>(motor_mask)));
        break;
      case Stage::kEncoderMask:
        encoder_count = std::popcount(static_cast<unsigned>(byte & 0x0F));
        go_on(Stage::kEncoderDirections, encoder_count);
        break;
      case Stage::kAnalogCount:
        analog_count = byte;
        go_on(Stage::kAnalogPins, byte);
        break;
      case Stage::kPwmCount:
        go_on(Stage::kPwmPins, byte);
        break;
      case Stage::kPwmPins:
        if (byte < kPwmPins) pwm_device[byte] = device;
        end_byte();
        break;
      case Stage::kTickDevice:
        device = byte;
        torque_bytes = 0;
        go_on(Stage::kPwmValues, count(pwm_device));
        break;
      case Stage::kTorques:
        torque_data[static_cast<std::size_t>(torque_bytes++)] = byte;
        end_byte();
        break;
      default:
        end_byte();
    }
    return ticks != before;
  }

  // The host sends nothing for a while. The firmware that was read takes a missing byte for 255,
  // unless the byte belongs to a torque or to the parameters of an encoder.
  void starve() {
    while (stage != Stage::kCommand && stage != Stage::kTorques && stage != Stage::kParameters) {
      take(255);
    }
  }

  // The answer to a tick message.
  std::vector<std::uint8_t> answer() const {
    std::vector<std::uint8_t> bytes(
        1 + 4 * static_cast<std::size_t>(is_set_up() ? encoders + analogs : 0), 0);
    bytes[0] = static_cast<std::uint8_t>(device);
    return bytes;
  }

  bool is_zero() const { return torque == std::array<float, kPorts>{}; }

  // Enters a stage of some bytes, or the first stage after it that has any.
  void go_on(Stage next, int bytes) {
    stage = next;
    left = bytes;
    if (bytes == 0) leave();
  }

 private:
  bool is_set_up() const {
    for (const int owner : motor_device) {
      if (owner == device) return true;
    }
    return false;
  }

  template <std::size_t kCount>
  int count(const std::array<int, kCount>& owners) const {
    int found = 0;
    for (const int owner : owners) found += is_mine(owner) ? 1 : 0;
    return found;
  }
  bool is_mine(int owner) const {
    return reset_kind == ResetKind::kKeepsEverything ? owner != kNobody : owner == device;
  }

  void begin(std::uint8_t command) {
    if (command == 0) stage = Stage::kResetDevice;
    if (command == 1) {
      forget_set_up();
      stage = Stage::kSetUpDevice;
    }
    if (command == 2) stage = Stage::kTickDevice;
  }

  void reset() {
    if (reset_kind != ResetKind::kKeepsEverything) forget_set_up();
    if (reset_kind == ResetKind::kZeroesTorques) torque = {};
  }

  void forget_set_up() {
    const bool gives_to_0 =
        reset_kind == ResetKind::kGivesMotorsToDevice0 || reset_kind == ResetKind::kZeroesTorques;
    motor_device.fill(gives_to_0 ? 0 : kNobody);
    pwm_device.fill(gives_to_0 ? 0 : kNobody);
    encoders = 0;
    analogs = 0;
  }

  void end_byte() {
    if (--left == 0) leave();
  }

  void leave() {
    switch (stage) {
      case Stage::kMotorDirections:
        stage = Stage::kEncoderMask;
        break;
      case Stage::kEncoderDirections:
        stage = Stage::kAnalogCount;
        break;
      case Stage::kAnalogPins:
        stage = Stage::kPwmCount;
        break;
      case Stage::kPwmPins:
        go_on(Stage::kParameters, 8 * encoder_count);
        break;
      case Stage::kParameters:
        set_up();
        break;
      case Stage::kPwmValues:
        go_on(Stage::kTorques, 4 * count(motor_device));
        break;
      default:  // kTorques
        set_torques();
    }
  }

  void set_up() {
    for (int port = 0; port < kPorts; ++port) {
      if ((motor_mask >> port & 1) != 0) motor_device[static_cast<std::size_t>(port)] = device;
    }
    encoders = encoder_count;
    analogs = analog_count;
    stage = Stage::kCommand;
  }

  void set_torques() {
    std::size_t next = 0;
    for (std::size_t port = 0; port < kPorts; ++port) {
      if (!is_mine(motor_device[port])) continue;
      std::memcpy(&torque[port], &torque_data[next], 4);
      next += 4;
    }
    ++ticks;
    stage = Stage::kCommand;
  }
};

// The messages of a host. Ports from 1 on have a motor and an encoder each.
struct HostMessages {
  static std::vector<std::uint8_t> reset() { return {0, 0}; }

  static std::vector<std::uint8_t> set_up(std::uint8_t device, int motors, int encoders,
                                          int analogs, int pwms) {
    std::vector<std::uint8_t> bytes = {1, device};
    for (const int ports : {motors, encoders}) {
      bytes.push_back(static_cast<std::uint8_t>((1 << ports) - 1));
      for (int i = 0; i < ports; ++i) bytes.push_back(static_cast<std::uint8_t>(i % 2));
    }
    bytes.push_back(static_cast<std::uint8_t>(analogs));
    for (int i = 0; i < analogs; ++i) bytes.push_back(static_cast<std::uint8_t>(54 + i));
    bytes.push_back(static_cast<std::uint8_t>(pwms));
    for (int i = 0; i < pwms; ++i) bytes.push_back(static_cast<std::uint8_t>(2 + i));
    for (int i = 0; i < encoders; ++i) {
      put(bytes, 180.0f);
      put(bytes, 13824.0f);
    }
    return bytes;
  }

  static std::vector<std::uint8_t> tick(std::uint8_t device, int pwms,
                                        const std::vector<float>& torques) {
    std::vector<std::uint8_t> bytes = {2, device};
    for (int i = 0; i < pwms; ++i) bytes.push_back(200);
    for (const float torque : torques) put(bytes, torque);
    return bytes;
  }

 private:
  static void put(std::vector<std::uint8_t>& bytes, float number) {
    std::array<std::uint8_t, 4> data;
    std::memcpy(data.data(), &number, 4);
    bytes.insert(bytes.end(), data.begin(), data.end());
  }
};

}  // namespace palpate
