// The messages to a hAPI board, byte by byte, and the parser of its answers. The simulated firmware
// reads the same bytes from the other side.

#include "engine/devices/hapi_protocol.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "engine/simulation/hapi_firmware.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::Random;
using Bytes = std::vector<std::uint8_t>;
using State = HapiAnswerParser::State;
using Event = HapiFirmware::Event;

template <typename Message>
Bytes bytes_of(const Message& message) {
  return {message.begin(), message.end()};
}

Bytes answer_of(std::uint8_t device, float first_deg, float second_deg) {
  Bytes bytes = {device};
  for (const float angle : {first_deg, second_deg}) {
    const auto* const part = reinterpret_cast<const std::uint8_t*>(&angle);  // little-endian host
    for (int k = 0; k < 4; ++k) bytes.push_back(part[k]);
  }
  return bytes;
}

// The states after each byte.
std::vector<State> states_of(HapiAnswerParser& parser, const Bytes& bytes) {
  std::vector<State> states;
  for (const std::uint8_t byte : bytes) states.push_back(parser.add(byte));
  return states;
}

State last_state(HapiAnswerParser& parser, const Bytes& bytes) {
  return states_of(parser, bytes).back();
}

constexpr HapiFirmware::Joints kRest_deg = {180.0, 0.0, 0.0, 0.0};

Event send(HapiFirmware& firmware, const Bytes& bytes,
           const HapiFirmware::Joints& joints_deg = kRest_deg) {
  Event event = Event::kNone;
  for (const std::uint8_t byte : bytes) event = firmware.receive(byte, joints_deg);
  return event;
}

// Sets up a firmware and lets it push.
HapiFirmware pushing_firmware(const HapiWiring& wiring) {
  HapiFirmware firmware;
  send(firmware, hapi_set_up(wiring, wiring.rest_deg));
  send(firmware, bytes_of(hapi_tick(wiring.device, {0.1f, -0.1f})));
  EXPECT_EQ(firmware.torques()[0], 0.1f);
  EXPECT_EQ(firmware.torques()[1], -0.1f);
  return firmware;
}

// Below one step of the board's output, whatever its scale: zero on the motor.
constexpr float kZero = 0x1p-119f;

bool is_zero(const HapiFirmware& firmware) {
  for (const float torque : firmware.torques()) {
    if (!(std::abs(torque) < kZero)) return false;
  }
  return true;
}

TEST(HapiProtocol, WritesTheBytesOfTheMakersMessages) {
  EXPECT_EQ(bytes_of(hapi_reset()), (Bytes{0, 0}));
  // 1.0 is 0x3f800000, -2.0 is 0xc0000000.
  EXPECT_EQ(bytes_of(hapi_tick(7, {1.0f, -2.0f})), (Bytes{2, 7, 0, 0, 0x80, 0x3f, 0, 0, 0, 0xc0}));
  // 180 is 0x43340000, 13824 is 0x46580000.
  EXPECT_EQ(hapi_set_up({.device = 5}, {180.0f, 0.0f}),
            (Bytes{1,    5, 3, 0,    0,    3, 0, 0, 0, 0, 0, 0,    0x34,
                   0x43, 0, 0, 0x58, 0x46, 0, 0, 0, 0, 0, 0, 0x58, 0x46}));
}

TEST(HapiProtocol, BoardObeysTheMessagesAndAnswersWithItsAngles) {
  const HapiWiring wiring;
  HapiFirmware firmware;
  EXPECT_EQ(send(firmware, bytes_of(hapi_reset())), Event::kReset);
  EXPECT_EQ(send(firmware, hapi_set_up(wiring, wiring.rest_deg)), Event::kSetUp);
  EXPECT_EQ(send(firmware, bytes_of(hapi_tick(wiring.device, {0.25f, -0.5f}))), Event::kTick);
  EXPECT_EQ(firmware.torques()[0], 0.25f);
  EXPECT_EQ(firmware.torques()[1], -0.5f);
  HapiAnswerParser parser(wiring.device, wiring.rest_deg);
  EXPECT_EQ(last_state(parser, firmware.answer(kRest_deg)), State::kComplete);
  EXPECT_EQ(parser.angles_deg(), wiring.rest_deg);
  // 7 and -11 steps of the encoders.
  const double step_deg = 360.0 / 13824.0;
  const auto answer = firmware.answer({180.0 + 7.2 * step_deg, -11.3 * step_deg, 0.0, 0.0});
  EXPECT_EQ(last_state(parser, answer), State::kComplete);
  EXPECT_EQ(parser.angles_deg()[0], static_cast<float>(180.0 + 7.0 * step_deg));
  EXPECT_EQ(parser.angles_deg()[1], static_cast<float>(-11.0 * step_deg));
}

TEST(HapiProtocol, SetUpTellsTheBoardItsPresentAngles) {
  HapiFirmware firmware;
  send(firmware, hapi_set_up({}, {90.0f, 45.0f}), {10.0, 20.0, 0.0, 0.0});
  send(firmware, bytes_of(hapi_tick(5, {})));
  HapiAnswerParser parser(5, {});
  EXPECT_EQ(last_state(parser, firmware.answer({10.0, 20.0, 0.0, 0.0})), State::kComplete);
  EXPECT_EQ(parser.angles_deg(), (HapiNumbers{90.0f, 45.0f}));
}

TEST(HapiProtocol, TorquesStayOverResetAndSetUp) {
  HapiFirmware firmware = pushing_firmware({});
  send(firmware, bytes_of(hapi_reset()));
  EXPECT_EQ(firmware.torques()[0], 0.1f);
  // Without a set-up, no motor obeys.
  send(firmware, bytes_of(hapi_tick(5, {})));
  EXPECT_EQ(firmware.torques()[0], 0.1f);
  send(firmware, Bytes(8, 0));
  send(firmware, hapi_set_up({}, {180.0f, 0.0f}));
  EXPECT_EQ(firmware.torques()[0], 0.1f);
}

TEST(HapiProtocol, ZeroBytesEndAnyCutTickMessage) {
  for (const std::uint8_t device : Bytes{1, 2, 3, 5, 127}) {
    const HapiWiring wiring{.device = device};
    const Bytes tick = bytes_of(hapi_tick(device, {0.123f, -0.07f}));
    for (std::size_t cut = 0; cut <= tick.size(); ++cut) {
      HapiFirmware firmware = pushing_firmware(wiring);
      send(firmware, Bytes(tick.begin(), tick.begin() + static_cast<std::ptrdiff_t>(cut)));
      Event event = Event::kNone;
      for (const std::uint8_t byte : hapi_stop_bytes(wiring)) {
        event = send(firmware, {byte});
        // On the way, each torque is one that the driver has commanded, or zero.
        for (const float torque : firmware.torques()) {
          ASSERT_TRUE(std::abs(torque) < kZero || std::abs(torque) == 0.1f || torque == 0.123f ||
                      torque == -0.07f)
              << torque << ", cut after " << cut;
        }
      }
      EXPECT_EQ(event, Event::kTick);
      EXPECT_TRUE(is_zero(firmware)) << "device " << int{device} << ", cut after " << cut;
      EXPECT_TRUE(firmware.is_between_messages());
      // The set-up and the angles are as before.
      HapiAnswerParser parser(device, wiring.rest_deg);
      EXPECT_EQ(last_state(parser, firmware.answer(kRest_deg)), State::kComplete);
      EXPECT_EQ(parser.angles_deg(), wiring.rest_deg);
    }
  }
}

// The driver sends the zero bytes before a reset and a set-up, so that every cut leaves a board
// whose torque is zero already or that the zero bytes reach.
TEST(HapiProtocol, ZeroBytesEndACutSetUpThatFollowsZeroBytes) {
  for (const std::uint8_t device : Bytes{1, 2, 3, 5, 127}) {
    const HapiWiring wiring{.device = device};
    Bytes sequence = hapi_stop_bytes(wiring);
    for (const Bytes& part : {bytes_of(hapi_reset()), hapi_set_up(wiring, wiring.rest_deg)}) {
      sequence.insert(sequence.end(), part.begin(), part.end());
    }
    for (std::size_t cut = 0; cut <= sequence.size(); ++cut) {
      HapiFirmware firmware = pushing_firmware(wiring);
      send(firmware, Bytes(sequence.begin(), sequence.begin() + static_cast<std::ptrdiff_t>(cut)));
      for (int again = 0; again < 3; ++again) {
        for (const std::uint8_t byte : hapi_stop_bytes(wiring)) {
          send(firmware, {byte});
          // Never a torque on the way, either.
          if (cut >= hapi_stop_bytes(wiring).size()) {
            ASSERT_TRUE(is_zero(firmware)) << "cut after " << cut;
          }
        }
        EXPECT_TRUE(is_zero(firmware)) << "device " << int{device} << ", cut after " << cut;
      }
    }
  }
}

TEST(HapiParser, AcceptsAnAnswerByteByByte) {
  HapiAnswerParser parser(5, {});
  const Bytes answer = answer_of(5, 12.5f, -300.0f);
  std::vector<State> expected(answer.size(), State::kIncomplete);
  expected.back() = State::kComplete;
  for (int again = 0; again < 3; ++again) {
    EXPECT_EQ(states_of(parser, answer), expected);
    EXPECT_EQ(parser.angles_deg(), (HapiNumbers{12.5f, -300.0f}));
    EXPECT_FALSE(parser.has_part());
  }
}

TEST(HapiParser, RefusesAWrongDeviceByteAtOnce) {
  HapiAnswerParser parser(5, {});
  for (int byte = 0; byte < 256; ++byte) {
    if (byte == 5) continue;
    EXPECT_EQ(parser.add(static_cast<std::uint8_t>(byte)), State::kMalformed);
    EXPECT_FALSE(parser.has_part());
  }
  EXPECT_EQ(parser.add(5), State::kIncomplete);
  EXPECT_TRUE(parser.has_part());
}

TEST(HapiParser, RefusesAnglesThatAreNotFiniteOrThatJump) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  const float beyond = std::nextafter(360.0f, 400.0f);
  for (const float bad : {kNaN, kInfinity, -kInfinity, beyond, -beyond, 1e38f}) {
    for (const bool is_first : {true, false}) {
      HapiAnswerParser parser(5, {});
      const Bytes answer = is_first ? answer_of(5, bad, 1.0f) : answer_of(5, 1.0f, bad);
      EXPECT_EQ(last_state(parser, answer), State::kMalformed) << bad;
      EXPECT_EQ(parser.angles_deg(), HapiNumbers{}) << "a refused answer has no effect";
      EXPECT_EQ(last_state(parser, answer_of(5, 2.0f, 3.0f)), State::kComplete);
    }
  }
  // The limit is relative to the last answer.
  HapiAnswerParser parser(5, {});
  EXPECT_EQ(last_state(parser, answer_of(5, 360.0f, 0.0f)), State::kComplete);
  EXPECT_EQ(last_state(parser, answer_of(5, 720.0f, 0.0f)), State::kComplete);
  EXPECT_EQ(last_state(parser, answer_of(5, 359.0f, 0.0f)), State::kMalformed);
}

TEST(HapiParser, ForgetsAnIncompleteAnswer) {
  HapiAnswerParser parser(5, {});
  states_of(parser, {5, 0, 0});
  EXPECT_TRUE(parser.has_part());
  parser.clear();
  EXPECT_FALSE(parser.has_part());
  EXPECT_EQ(last_state(parser, answer_of(5, 2.0f, 3.0f)), State::kComplete);
}

// The oracle reads the last nine bytes since the parser was empty.
TEST(HapiParser, AcceptsOnlyWhatTheDefinitionAcceptsInRandomBytes) {
  Random random(1);
  HapiAnswerParser parser(5, {});
  Bytes part;
  HapiNumbers last{};
  int accepted = 0;
  int refused = 0;
  for (int n = 0; n < 200'000; ++n) {
    // Mostly plausible bytes, so that many answers are complete.
    std::uint8_t byte = static_cast<std::uint8_t>(random.index(256));
    if (part.empty() && random.index(4) != 0) byte = 5;
    if ((part.size() == 4 || part.size() == 8) && random.index(4) != 0) byte = 0x42;
    part.push_back(byte);
    State expected = State::kIncomplete;
    if (part.front() != 5) expected = State::kMalformed;
    if (part.size() == 9) {
      HapiNumbers angles;
      std::memcpy(angles.data(), part.data() + 1, 8);
      bool is_good = true;
      for (std::size_t k = 0; k < 2; ++k) {
        is_good = is_good && std::isfinite(angles[k]) && std::abs(angles[k] - last[k]) <= 360.0f;
      }
      expected = is_good ? State::kComplete : State::kMalformed;
      if (is_good) last = angles;
    }
    ASSERT_EQ(parser.add(byte), expected) << "byte " << n;
    if (expected != State::kIncomplete) part.clear();
    accepted += expected == State::kComplete;
    refused += expected == State::kMalformed;
    ASSERT_EQ(parser.angles_deg(), last);
  }
  EXPECT_GT(accepted, 1000);
  EXPECT_GT(refused, 1000);
}

// Any bytes: the firmware may do anything but fail, and it ends every message.
TEST(HapiFirmware, ReadsRandomBytesWithoutAFault) {
  Random random(2);
  HapiFirmware firmware;
  std::size_t ends = 0;
  for (int n = 0; n < 300'000; ++n) {
    const auto byte = static_cast<std::uint8_t>(random.index(random.index(2) == 0 ? 4 : 256));
    firmware.receive(byte, kRest_deg);
    if (n % 64 == 0) firmware.answer(kRest_deg);
    ends += firmware.is_between_messages();
  }
  EXPECT_GT(ends, 1000u);
}

}  // namespace
}  // namespace palpate
