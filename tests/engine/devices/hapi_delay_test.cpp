// The delay that a start measures, against the true one: the board's log says when it sampled, and
// when it obeyed the force that answers the sample.

#include "engine/devices/hapi_delay.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "tests/engine/devices/hapi_rig.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::kMillisecond_ns;
using test::pushing_settings;
using test::Random;

constexpr std::int64_t kStep_ns = 20'000;

// The ways of one line. Each message takes up_ns and at most jitter_ns more; answers likewise.
struct Ways {
  double rate_Hz = 1000.0;     // of ticks and messages
  std::int64_t up_ns = 0;      // to the board
  std::int64_t answer_ns = 0;  // back
  std::int64_t jitter_ns = 0;
  double phase = 0.0;        // of the ticks, in periods
  std::int64_t tick_ns = 0;  // the computation of a tick
};

HapiSettings settings_at(double rate_Hz) {
  HapiSettings settings = pushing_settings();
  settings.rate_Hz = rate_Hz;
  return settings;
}

BoardSettings board_with(std::int64_t answer_ns) {
  BoardSettings settings;
  settings.answer_ns = answer_ns;
  return settings;
}

// The link, a line with ways in both directions, a board, and ticks that answer samples.
class Line {
 public:
  Line(const Ways& ways, Random& random)
      : ways_(ways),
        random_(random),
        link(settings_at(ways.rate_Hz)),
        board(board_with(ways.answer_ns)) {
    link.set_guard(&guard_);
    link.start(now_ns_);
  }

  void measure() {
    while (!link.exchanges().is_full()) step();
  }
  void push(std::int64_t time_ns) {
    const auto period_ns = std::llround(1e9 / ways_.rate_Hz);
    std::int64_t next_ns = now_ns_ + std::llround(ways_.phase * static_cast<double>(period_ns));
    for (const std::int64_t end_ns = now_ns_ + time_ns; now_ns_ < end_ns;) {
      if (now_ns_ >= next_ns) {
        ticks_.push_back({now_ns_ + ways_.tick_ns, force_for(link.sample())});
        next_ns += period_ns;
      }
      if (!ticks_.empty() && now_ns_ >= ticks_.front().at_ns) {
        link.set_force(ticks_.front().force);
        ticks_.pop_front();
      }
      step();
    }
  }
  // From each sample to the moment at which the board obeys the force that answers it.
  std::vector<std::int64_t> true_delays_ns() const {
    std::vector<std::int64_t> delays_ns;
    const auto& log = board.log();
    for (std::size_t k = 1; k < log.size(); ++k) {
      // The link computes torques in the pose of the newest answer.
      for (std::size_t n = 1; n <= 4 && n <= k; ++n) {
        const auto sent_ns = answered_by(log[k], log[k - n].answered_deg);
        if (!sent_ns) continue;
        // One message is in flight at a time: the first one that came since then.
        const auto sampled = std::find_if(log.begin(), log.end(), [&](const BoardCommand& command) {
          return command.time_ns >= *sent_ns;
        });
        delays_ns.push_back(log[k].time_ns - sampled->time_ns);
        break;
      }
    }
    return delays_ns;
  }

 private:
  struct Bytes {
    std::int64_t at_ns;
    std::vector<std::uint8_t> bytes;
  };
  struct Tick {
    std::int64_t at_ns;
    HapiForce force;
  };
  struct Answer {
    std::int64_t sent_ns;  // the message of the sample
    Vec2 force_N;
  };

  // A force of its own for each sample.
  HapiForce force_for(const HapiSample& sample) {
    const Vec2 force_N(0.1 + 1e-4 * static_cast<double>(sample.sequence % 1000), 0.05);
    answers_.push_back({sample.time_ns, force_N});
    return {{force_N.x(), force_N.y()}, now_ns_, 0, sample.time_ns};
  }
  std::optional<std::int64_t> answered_by(const BoardCommand& command,
                                          const HapiNumbers& angles_deg) const {
    const auto pose = hapi_pose(FiveBar(FiveBarLinks{}), angles_deg);
    if (!pose) return std::nullopt;
    for (const Answer& answer : answers_) {
      const Vec2 torques = pose->jacobian.transpose() * answer.force_N;
      const HapiNumbers numbers{static_cast<float>(torques[0]), static_cast<float>(torques[1])};
      if (numbers == command.torques) return answer.sent_ns;
    }
    return std::nullopt;
  }
  std::int64_t jitter_ns() {
    return std::llround(random_.uniform(0.0, 1.0) * static_cast<double>(ways_.jitter_ns));
  }
  static void queue(std::deque<Bytes>& way, std::int64_t at_ns, std::span<const std::uint8_t> b) {
    if (!way.empty()) at_ns = std::max(at_ns, way.back().at_ns);  // a line keeps the order
    way.push_back({at_ns, {b.begin(), b.end()}});
  }
  void step() {
    std::array<std::uint8_t, 64> bytes;
    if (const std::size_t count = board.take_answer(bytes, now_ns_)) {
      queue(down_, now_ns_ + jitter_ns(), std::span(bytes).first(count));
    }
    while (!up_.empty() && up_.front().at_ns <= now_ns_) {
      board.receive(up_.front().bytes, now_ns_);
      up_.pop_front();
    }
    while (!down_.empty() && down_.front().at_ns <= now_ns_) {
      link.receive(down_.front().bytes, now_ns_);
      down_.pop_front();
    }
    link.step(now_ns_);
    if (const auto out = link.to_send(); !out.empty()) {
      queue(up_, now_ns_ + ways_.up_ns + jitter_ns(), out);
      link.sent(out.size(), now_ns_);
    }
    now_ns_ += kStep_ns;
  }

  Ways ways_;
  Random& random_;
  std::int64_t now_ns_ = 1'000 * kMillisecond_ns;
  test::FakeGuard guard_;
  std::deque<Bytes> up_, down_;
  std::deque<Tick> ticks_;
  std::vector<Answer> answers_;

 public:
  HapiLink link;
  HapiBoard board;
};

// The true delays in seconds, sorted; `line` gets what the start has measured.
std::vector<double> delays_of(const Ways& ways, Random& random, HapiLine& line) {
  Line rig(ways, random);
  rig.measure();
  line = rig.link.exchanges().line();
  rig.push(150 * kMillisecond_ns);
  std::vector<double> delays_s;
  for (const std::int64_t delay_ns : rig.true_delays_ns()) {
    delays_s.push_back(1e-9 * static_cast<double>(delay_ns));
  }
  std::sort(delays_s.begin(), delays_s.end());
  return delays_s;
}

std::string text_of(const Ways& ways, const HapiLine& line, const std::vector<double>& delays_s) {
  std::ostringstream text;
  text << ways.rate_Hz << " Hz, up " << ways.up_ns << " ns, answer " << ways.answer_ns
       << " ns, jitter " << ways.jitter_ns << " ns, phase " << ways.phase << ", tick "
       << ways.tick_ns << " ns; measured " << 1e3 * line.delay.least_s << " to "
       << 1e3 * line.delay.most_s << " ms; true " << 1e3 * delays_s.front() << " to "
       << 1e3 * delays_s.back() << " ms";
  return text.str();
}

TEST(HapiDelay, TheTrueDelayIsInTheIntervalAtEveryPhaseOfTheTicks) {
  for (const std::int64_t answer_ns : {100'000, 300'000, 700'000, 1'400'000, 3'000'000}) {
    double least_s = kLongestDelay_s;
    double most_s = 0.0;
    HapiLine line;
    for (int k = 0; k < 10; ++k) {
      Random random(1);
      const Ways ways{1000.0, 0, answer_ns, 0, 0.1 * k, (k % 2) * 500'000};
      const std::vector<double> delays_s = delays_of(ways, random, line);
      ASSERT_GT(delays_s.size(), 20u);
      EXPECT_GE(delays_s.front(), line.delay.least_s) << text_of(ways, line, delays_s);
      EXPECT_LE(delays_s.back(), line.delay.most_s) << text_of(ways, line, delays_s);
      least_s = std::min(least_s, delays_s.front());
      most_s = std::max(most_s, delays_s.back());
    }
    std::cout << "answer after " << 1e-6 * static_cast<double>(answer_ns) << " ms: " << line.rate_Hz
              << " messages per second, measured " << 1e3 * line.delay.least_s << " to "
              << 1e3 * line.delay.most_s << " ms, true " << 1e3 * least_s << " to " << 1e3 * most_s
              << " ms\n";
    // Without jitter the interval is no wider than the phases make it.
    EXPECT_DOUBLE_EQ(line.delay.least_s, least_s);
    EXPECT_DOUBLE_EQ(line.delay.most_s, most_s);
    // A line that is faster than a period carries all messages.
    const double way_s = 1e-9 * static_cast<double>(answer_ns);
    EXPECT_EQ(line.rate_Hz == 1000.0, way_s <= 1e-3);
    EXPECT_NEAR(line.rate_Hz, 1.0 / std::max(1e-3, way_s),
                2e-6 * line.rate_Hz * static_cast<double>(kStep_ns));
  }
}

// Beyond both ends lies at most the share that the measurement leaves out.
TEST(HapiDelay, TheTrueDelayOfARandomLineIsInTheInterval) {
  Random random(2);
  double widest = 0.0;
  for (int n = 0; n < 30; ++n) {
    Ways ways;
    ways.rate_Hz = random.uniform(250.0, 2000.0);
    const double period_ns = 1e9 / ways.rate_Hz;
    const auto whole = [&](double most_ns) { return std::llround(random.uniform(0.0, most_ns)); };
    ways.up_ns = whole(1e6);
    ways.answer_ns = whole(1e6);
    ways.jitter_ns = whole(2e5);
    ways.phase = random.uniform(0.0, 1.0);
    ways.tick_ns = whole(HapiDelay::kShareOfTick * period_ns);
    HapiLine line;
    const std::vector<double> delays_s = delays_of(ways, random, line);
    ASSERT_GT(delays_s.size(), 20u);
    const auto outside = std::count_if(delays_s.begin(), delays_s.end(), [&](double delay_s) {
      return delay_s < line.delay.least_s || delay_s > line.delay.most_s;
    });
    EXPECT_LE(static_cast<double>(outside), HapiDelay::kRare * static_cast<double>(delays_s.size()))
        << text_of(ways, line, delays_s);
    widest = std::max(widest, (line.delay.most_s - line.delay.least_s) * ways.rate_Hz);
  }
  std::cout << "the widest interval has " << widest << " periods\n";
}

TEST(HapiDelay, FewExchangesShowNothing) {
  HapiDelay exchanges(kMillisecond_ns);
  for (std::size_t k = 0; k < HapiDelay::kFewest; ++k) {
    EXPECT_FALSE(exchanges.line().delay.is_known());
    EXPECT_EQ(exchanges.line().rate_Hz, 0.0);
    const auto sent_ns = static_cast<std::int64_t>(k) * kMillisecond_ns;
    exchanges.add(sent_ns, sent_ns + 300'000);
  }
  EXPECT_TRUE(exchanges.line().delay.is_known());
  EXPECT_EQ(exchanges.line().rate_Hz, 1000.0);
}

// One message in a hundred waits for a stalled machine.
TEST(HapiDelay, AStalledMachineIsNotTheLine) {
  HapiDelay exchanges(kMillisecond_ns);
  std::int64_t sent_ns = 0;
  for (std::size_t k = 0; !exchanges.is_full(); ++k) {
    const std::int64_t round_trip_ns = k % 100 == 50 ? 20 * kMillisecond_ns : 300'000;
    exchanges.add(sent_ns, sent_ns + round_trip_ns);
    sent_ns += std::max(kMillisecond_ns, round_trip_ns);
  }
  EXPECT_EQ(exchanges.line().delay, (DelayInterval{1e-3, 2e-3}));
  EXPECT_EQ(exchanges.line().rate_Hz, 1000.0);
}

// The link counts the same delay of the forces that it sends, without the way to the board.
TEST(HapiDelay, TheLinkCountsTheDelayOfItsForces) {
  Random random(3);
  const Ways ways{1000.0, 0, 300'000, 0, 0.5, 0};
  Line line(ways, random);
  line.measure();
  EXPECT_EQ(line.link.counts().forces, 0u);
  line.link.set_longest_delay(kMillisecond_ns);
  line.push(50 * kMillisecond_ns);
  const HapiCounts counts = line.link.counts();
  std::vector<std::int64_t> delays_ns = line.true_delays_ns();
  EXPECT_EQ(counts.forces, delays_ns.size());
  EXPECT_EQ(counts.delay_longest_ns, *std::max_element(delays_ns.begin(), delays_ns.end()));
  EXPECT_EQ(counts.delayed_forces,
            static_cast<std::uint64_t>(std::count_if(
                delays_ns.begin(), delays_ns.end(), [](auto ns) { return ns > kMillisecond_ns; })));
  line.link.set_longest_delay(kMillisecond_ns - 1);
  line.push(10 * kMillisecond_ns);
  EXPECT_GE(line.link.counts().delayed_forces, counts.delayed_forces + 9);
}

}  // namespace
}  // namespace palpate
