// The plant behind a simulated board: a line with a delay, and a hand that probes.

#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include <gtest/gtest.h>

#include "engine/devices/hapi_protocol.h"
#include "engine/simulation/hapi_board.h"
#include "engine/simulation/port_loop.h"
#include "engine/simulation/probing_hand.h"

namespace palpate {
namespace {

constexpr std::int64_t kMicrosecond_ns = 1'000;

// A board that has been set up, and gets a message with these torques at time 0.
void begin(HapiBoard& board, const HapiNumbers& torques) {
  const HapiWiring wiring;
  board.receive(hapi_set_up(wiring, wiring.rest_deg), 0);
  board.receive(hapi_tick(wiring.device, torques), 0);
}

TEST(BoardPlant, ALineDelaysMessagesAndAnswers) {
  BoardSettings settings;
  settings.line_ns = 700 * kMicrosecond_ns;
  settings.answer_ns = 200 * kMicrosecond_ns;
  HapiBoard board(settings);
  begin(board, {0.01f, 0.0f});
  std::array<std::uint8_t, 64> bytes;
  EXPECT_EQ(board.take_answer(bytes, 699 * kMicrosecond_ns), 0u);
  EXPECT_EQ(board.commands(), 0u);
  EXPECT_EQ(board.next_due_ns(), 700 * kMicrosecond_ns);
  board.advance(700 * kMicrosecond_ns);
  EXPECT_EQ(board.commands(), 1u);
  EXPECT_EQ(board.firmware().torques()[0], 0.01f);
  EXPECT_EQ(board.log().front().time_ns, 700 * kMicrosecond_ns);
  EXPECT_EQ(board.next_due_ns(), 1600 * kMicrosecond_ns);
  EXPECT_EQ(board.take_answer(bytes, 1599 * kMicrosecond_ns), 0u);
  EXPECT_EQ(board.take_answer(bytes, 1600 * kMicrosecond_ns), std::size_t{kHapiAnswerSize});
}

TEST(BoardPlant, AHandProbesFourDirectionsAndItsTipIsJudgedAtTheEndOfEachHold) {
  BoardSettings settings;
  settings.plant.hand = kLightGrip;
  settings.plant.hand_probes = true;
  HapiBoard board(settings);
  const Vec2 rest_m = board.plant().tip_m();
  board.advance(5'000'000'000);
  EXPECT_EQ((board.plant().tip_m() - rest_m).norm(), 0.0) << "it begins with the first message";
  const HapiWiring wiring;
  std::int64_t now_ns = 5'000'000'000;
  board.receive(hapi_set_up(wiring, wiring.rest_deg), now_ns);
  board.receive(hapi_tick(wiring.device, {}), now_ns);
  const double cycle_s = 2.0 * ProbingHand::kMove_s + ProbingHand::kHold_s;
  const Vec2 expected[] = {{0, 1}, {1, 0}, {-1, 0}, {0.6, 0.8}, {0, 1}};
  for (int n = 0; n < 5; ++n) {
    const double held_s =
        ProbingHand::kWait_s + n * cycle_s + ProbingHand::kMove_s + ProbingHand::kHold_s - 0.01;
    board.advance(now_ns + std::llround(1e9 * held_s));
    // The grip's own swing has decayed by e^(-4.5 * 3) after 3 s.
    EXPECT_LE((board.plant().tip_m() - rest_m - ProbingHand::kReach_m * expected[n]).norm(),
              1e-5 * ProbingHand::kReach_m)
        << n;
    EXPECT_EQ(board.plant().probes().judged, static_cast<std::uint64_t>(n));
  }
  EXPECT_LE(board.plant().probes().largest_amplitude_m, 1e-4 * ProbingHand::kReach_m);
  const PortAccount& account = board.plant().tip().account();
  EXPECT_EQ(account.motors_J, 0.0);
  EXPECT_GT(account.hand_J, 0.0);
  EXPECT_GT(account.largest_speed_m_per_s, ProbingHand::kReach_m / ProbingHand::kMove_s);
}

TEST(BoardPlant, ABareTipIsThrown) {
  BoardSettings settings;
  settings.plant.hand = kNoHand;
  settings.plant.hand_probes = true;
  HapiBoard board(settings);
  const Vec2 rest_m = board.plant().tip_m();
  begin(board, {});
  board.advance(std::llround(1e9 * (ProbingHand::kWait_s + ProbingHand::kMove_s)));
  const double way_m = ProbingHand::kThrow_m_per_s * settings.plant.mass_kg /
                       settings.plant.damping_Ns_per_m * -std::expm1(-5.0);
  EXPECT_NEAR((board.plant().tip_m() - rest_m).y(), way_m, 1e-2 * way_m);  // a plant's step
}

}  // namespace
}  // namespace palpate
