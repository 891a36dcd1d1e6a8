#include "engine/devices/hapi_zero.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/engine/devices/fake_firmware.h"

namespace palpate {
namespace {

using Stage = FakeFirmware::Stage;

constexpr std::array<ResetKind, 4> kResetKinds = {
    ResetKind::kGivesMotorsToDevice0, ResetKind::kZeroesTorques, ResetKind::kKeepsEverything,
    ResetKind::kLosesMotors};
// Not 0, to which all ports belong after a reset. Also those that are commands, and those that
// would be a large torque as its last byte.
constexpr std::array<std::uint8_t, 7> kDevices = {1, 2, 3, 5, 0x41, 0x7F, 0xFF};

// The last byte of a torque, its most significant one, is at most 3 in the zero bytes. The exponent
// of such a float is at most 7, which is 2^(7 - 127), and its fraction is less than 2.
const float kAlmostZero = std::ldexp(1.0f, -119);

std::uint8_t ports(int motors) {
  return static_cast<std::uint8_t>((1 << motors) - 1);
}

// The bytes for a board that HostMessages has set up.
std::vector<std::uint8_t> zero_bytes(std::uint8_t device, int motors, int pwms = 0) {
  HapiMotors set_up;
  set_up.device = device;
  set_up.ports = ports(motors);
  for (int i = 0; i < motors; ++i) set_up.directions.push_back(static_cast<std::uint8_t>(i % 2));
  for (int i = 0; i < pwms; ++i) set_up.pwm_pins.push_back(static_cast<std::uint8_t>(2 + i));
  return hapi_zero_bytes(set_up);
}

// The largest number that each torque may have, port by port: what it has now or will have after
// the torques that the host has written completely.
std::array<float, 4> commanded(const FakeFirmware& board, const std::vector<float>& torques) {
  std::array<float, 4> largest = {};
  for (std::size_t port = 0; port < 4; ++port) {
    largest[port] = std::fabs(board.torque[port]);
    if (port < torques.size()) largest[port] = std::max(largest[port], std::fabs(torques[port]));
  }
  return largest;
}

// Passes the zero bytes to the board. Expects that no torque exceeds `largest`, that all end as
// zero, and that the board expects a command afterwards. Returns false at a failure.
bool stops(FakeFirmware board, const std::vector<std::uint8_t>& zero,
           const std::array<float, 4>& largest) {
  for (const std::uint8_t byte : zero) {
    if (!board.take(byte)) continue;
    for (std::size_t port = 0; port < 4; ++port) {
      const float torque = std::fabs(board.torque[port]);
      if (!(torque <= largest[port] || torque < kAlmostZero)) return false;
    }
  }
  return board.is_zero() && board.stage == Stage::kCommand;
}

// A board that was set up by a host and commands torques.
FakeFirmware running_board(ResetKind kind, std::uint8_t device, int joints, int analogs, int pwms,
                           const std::vector<float>& torques) {
  FakeFirmware board(kind);
  for (const auto& message :
       {HostMessages::reset(), HostMessages::set_up(device, joints, joints, analogs, pwms),
        HostMessages::tick(device, pwms, torques)}) {
    for (const std::uint8_t byte : message) board.take(byte);
  }
  return board;
}

TEST(HapiZero, StopsABoardWhoseLastMessageWasCutAfterAnyByte) {
  int cases = 0;
  for (const ResetKind kind : kResetKinds) {
    for (const std::uint8_t device : kDevices) {
      for (int joints = 1; joints <= 4; ++joints) {
        for (const int extras : {0, 3}) {  // analog pins and PWM pins
          const std::vector<float> before(static_cast<std::size_t>(joints), 0.5f);
          // A torque with the largest low bytes, and one whose bytes are all different.
          const std::vector<float> all = {-0.99999994f, 1.2345678f, -3.0e-7f, 2.0f};
          const std::vector<float> after(all.begin(), all.begin() + joints);
          const auto board = running_board(kind, device, joints, extras, extras, before);
          ASSERT_FALSE(board.is_zero());
          const auto zero = zero_bytes(device, joints, extras);
          for (const auto& message :
               {HostMessages::reset(), HostMessages::set_up(device, joints, joints, extras, extras),
                HostMessages::tick(device, extras, after)}) {
            for (std::size_t cut = 0; cut <= message.size(); ++cut) {
              FakeFirmware stopped = board;
              for (std::size_t i = 0; i < cut; ++i) stopped.take(message[i]);
              const auto largest = commanded(board, after);
              FakeFirmware impatient = stopped;
              impatient.starve();
              ASSERT_TRUE(stops(stopped, zero, largest) && stops(impatient, zero, largest))
                  << "reset kind " << static_cast<int>(kind) << ", device " << int{device} << ", "
                  << joints << " joints, " << extras << " pins, command " << int{message[0]}
                  << " cut after " << cut << " bytes";
              ++cases;
            }
          }
        }
      }
    }
  }
  EXPECT_GT(cases, 5000);
}

// All states of the parser, except that pins and data which were read differ in no way that matters
// to the parser: the stage, the bytes left, the numbers of motors and encoders to come.
std::vector<FakeFirmware> all_states(const FakeFirmware& board, std::uint8_t device) {
  std::vector<FakeFirmware> states;
  const auto add = [&](Stage stage, int left, int motors, int encoders, int owner) {
    FakeFirmware state = board;
    state.stage = stage;
    state.left = left;
    state.device = owner;
    state.motor_mask = ports(motors);
    state.encoder_count = encoders;
    state.torque_data.fill(0xFF);
    states.push_back(state);
  };
  for (const int owner : {int{device}, 0, 200}) {
    for (const Stage stage : {Stage::kCommand, Stage::kResetDevice, Stage::kSetUpDevice,
                              Stage::kMotorMask, Stage::kTickDevice}) {
      add(stage, 0, 0, 0, owner);
    }
    for (int motors = 0; motors <= 4; ++motors) {
      for (int left = 1; left <= motors; ++left) {
        add(Stage::kMotorDirections, left, motors, 0, owner);
      }
      add(Stage::kEncoderMask, 0, motors, 0, owner);
      for (int encoders = 0; encoders <= 4; ++encoders) {
        for (int left = 1; left <= encoders; ++left) {
          add(Stage::kEncoderDirections, left, motors, encoders, owner);
        }
        add(Stage::kAnalogCount, 0, motors, encoders, owner);
        add(Stage::kPwmCount, 0, motors, encoders, owner);
        for (int left = 1; left <= 255; ++left) {
          add(Stage::kAnalogPins, left, motors, encoders, owner);
          add(Stage::kPwmPins, left, motors, encoders, owner);
        }
        for (int left = 1; left <= 8 * encoders; ++left) {
          add(Stage::kParameters, left, motors, encoders, owner);
        }
      }
    }
  }
  return states;
}

// The states in a tick message, for the device that the board has.
void add_tick_states(std::vector<FakeFirmware>& states, const FakeFirmware& board,
                     std::uint8_t device, int joints, int pwms) {
  FakeFirmware state = board;
  for (const std::uint8_t byte : HostMessages::tick(device, pwms, {0.5f, 0.5f, 0.5f, 0.5f})) {
    state.take(byte);
    if (state.stage == Stage::kCommand) break;
    states.push_back(state);
    // The low bytes of the torque that is being read are the largest possible.
    const int in_torque = state.torque_bytes % 4;
    for (int i = 1; i <= in_torque; ++i) {
      states.back().torque_data[static_cast<std::size_t>(state.torque_bytes - i)] = 0xFF;
    }
  }
  ASSERT_EQ(state.ticks, board.ticks + 1) << joints;
}

TEST(HapiZero, StopsABoardInEveryStateOfItsParser) {
  std::size_t cases = 0;
  for (const ResetKind kind : kResetKinds) {
    for (const std::uint8_t device : {kDevices[0], kDevices[1], kDevices[4]}) {
      for (const int joints : {1, 4}) {
        for (const int pwms : {0, 3}) {
          const std::vector<float> torques(static_cast<std::size_t>(joints), 0.5f);
          const auto board = running_board(kind, device, joints, 0, pwms, torques);
          const auto zero = zero_bytes(device, joints, pwms);
          auto states = all_states(board, device);
          add_tick_states(states, board, device, joints, pwms);
          for (const FakeFirmware& state : states) {
            ASSERT_TRUE(stops(state, zero, commanded(board, torques)))
                << "reset kind " << static_cast<int>(kind) << ", device " << int{device} << ", "
                << joints << " joints, " << pwms << " PWM pins, stage "
                << static_cast<int>(state.stage) << ", " << state.left << " left, encoders "
                << state.encoder_count << ", mask " << state.motor_mask << ", owner "
                << state.device;
            ++cases;
          }
        }
      }
    }
  }
  EXPECT_GT(cases, 400'000u);
}

// A board whose set-up was misread: some motors belong to another device than the host's.
TEST(HapiZero, StopsMotorsOfAnotherDevice) {
  for (const ResetKind kind : kResetKinds) {
    for (const std::uint8_t device : kDevices) {
      FakeFirmware board = running_board(kind, device, 2, 0, 0, {0.5f, -0.5f});
      board.motor_device[1] = 200;
      EXPECT_TRUE(stops(board, zero_bytes(device, 2), {0.5f, 0.5f, 0.0f, 0.0f}))
          << static_cast<int>(kind) << " " << int{device};
    }
  }
}

// The end of the bytes relies on a byte that is no command, which a firmware may treat in another
// way. The rest does not.
TEST(HapiZero, NeedsNoUnknownCommandIfMotorsCanBeReached) {
  for (const ResetKind kind :
       {ResetKind::kGivesMotorsToDevice0, ResetKind::kZeroesTorques, ResetKind::kKeepsEverything}) {
    auto zero = zero_bytes(1, 2);
    zero.erase(std::find(zero.begin(), zero.end(), 3), zero.end());
    const auto board = running_board(kind, 1, 2, 0, 0, {0.5f, 0.5f});
    for (FakeFirmware& state : all_states(board, 1)) {
      for (const std::uint8_t byte : zero) state.take(byte);
      ASSERT_TRUE(state.is_zero()) << static_cast<int>(kind) << ", stage "
                                   << static_cast<int>(state.stage) << ", " << state.left;
    }
  }
}

TEST(HapiZero, StopsABoardInTimeWithItsFirstPacketsUnlessASetUpWasCut) {
  const auto zero = zero_bytes(1, 2);
  const std::vector<std::uint8_t> first(zero.begin(), zero.begin() + 2 * 64);
  const auto message = HostMessages::tick(1, 0, {0.25f, -0.25f});
  for (std::size_t cut = 0; cut <= message.size(); ++cut) {
    FakeFirmware board = running_board(ResetKind::kGivesMotorsToDevice0, 1, 2, 0, 0, {0.5f, 0.5f});
    for (std::size_t i = 0; i < cut; ++i) board.take(message[i]);
    for (const std::uint8_t byte : first) board.take(byte);
    EXPECT_TRUE(board.is_zero()) << "cut after " << cut;
  }
}

// The firmware takes a byte of a tick's beginning that has not arrived for 255.
TEST(HapiZero, NoTickMessageExtendsOverTwoPackets) {
  for (const int joints : {1, 4}) {
    const auto zero = zero_bytes(1, joints);
    FakeFirmware board = running_board(ResetKind::kGivesMotorsToDevice0, 1, joints, 0, 0,
                                       std::vector<float>(static_cast<std::size_t>(joints), 1.0f));
    for (std::size_t i = 0; i < zero.size(); ++i) {
      board.take(zero[i]);
      if ((i + 1) % 64 == 0) {
        EXPECT_NE(board.stage, Stage::kTickDevice) << i;
        EXPECT_NE(board.stage, Stage::kPwmValues) << i;
        EXPECT_NE(board.stage, Stage::kTorques) << i;
      }
    }
  }
}

// A host that has not yet seen that it was stopped may write one more command.
TEST(HapiZero, TheBoardReadsALateCommandOfTheHostAsItIsMeant) {
  const std::vector<float> torques = {1.0e-3f, -2.7f, 3.1e-20f, 0.1f};
  for (const ResetKind kind : kResetKinds) {
    for (const std::uint8_t device : kDevices) {
      for (int joints = 1; joints <= 4; ++joints) {
        for (const int pwms : {0, 3, 12}) {
          const std::vector<float> late(torques.begin(), torques.begin() + joints);
          FakeFirmware board = running_board(kind, device, joints, 0, pwms, late);
          for (const std::uint8_t byte : zero_bytes(device, joints, pwms)) board.take(byte);
          ASSERT_TRUE(board.is_zero());
          for (const std::uint8_t byte : HostMessages::tick(device, pwms, late)) board.take(byte);
          for (std::size_t i = 0; i < late.size(); ++i) ASSERT_EQ(board.torque[i], late[i]);
          EXPECT_EQ(board.stage, Stage::kCommand);
        }
      }
    }
  }
}

TEST(HapiZero, SetsUpTheMotorsAsTheHostDid) {
  HapiMotors motors;
  motors.device = 9;
  motors.ports = 0b1010;
  motors.directions = {1, 0};
  motors.pwm_pins = {5, 11};
  const auto bytes = hapi_zero_bytes(motors);
  const std::vector<std::uint8_t> end = {3,                                      // no command
                                         1, 9, 10, 1, 0, 0, 0, 2, 5, 11,         // set up
                                         2, 9, 0,  0, 0, 0, 0, 0, 0, 0,  0, 0};  // tick
  ASSERT_GE(bytes.size(), end.size());
  EXPECT_EQ(
      std::vector<std::uint8_t>(bytes.end() - static_cast<std::ptrdiff_t>(end.size()), bytes.end()),
      end);
}

TEST(HapiZero, ABoardCanBeSetUpAtOnceAfterwards) {
  FakeFirmware board = running_board(ResetKind::kGivesMotorsToDevice0, 1, 2, 0, 0, {0.5f, 0.5f});
  board.take(0);  // a reset, cut after its first byte
  for (const std::uint8_t byte : zero_bytes(1, 2)) board.take(byte);
  for (const std::uint8_t byte : HostMessages::set_up(1, 2, 2, 0, 0)) board.take(byte);
  for (const std::uint8_t byte : HostMessages::tick(1, 0, {0.125f, 0.25f})) board.take(byte);
  EXPECT_EQ(board.torque, (std::array<float, 4>{0.125f, 0.25f, 0.0f, 0.0f}));
  EXPECT_EQ(board.answer().size(), 9u);
}

}  // namespace
}  // namespace palpate
