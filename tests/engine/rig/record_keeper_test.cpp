// The keeper of the records of a run.

#include "engine/rig/record_keeper.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "haptics/haptic_loop.h"
#include "tests/helpers/made.h"
#include "tests/helpers/random.h"
#include "tests/helpers/ticks.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::kTick_s;
using test::Random;

TickRecord record_of(std::uint64_t tick, std::int64_t step_ns, double x_m) {
  TickRecord record{};
  record.tick = tick;
  record.step_ns = step_ns;
  record.device_m[0] = x_m;
  return record;
}

HapticLoop any_loop(const ContactWorld& world) {
  return test::made(HapticLoop::create(world, *ActuationModel::from_counts(3, 3), {}));
}

TEST(RecordKeeper, KeepsTheFirstPassWithTheShortestTimeOfEachTick) {
  Random random(11);
  const test::OwnedWorld box(test::box_soup({0.1, 0.1, 0.1}));
  const HapticLoop loop = any_loop(box.world());
  constexpr std::size_t kTicks = 50;
  RecordKeeper keeper(kTicks);
  std::vector<double> first_m(kTicks);
  std::vector<std::int64_t> shortest_ns(kTicks, std::numeric_limits<std::int64_t>::max());
  for (int pass = 0; pass < 4; ++pass) {
    for (std::size_t n = 0; n < kTicks; ++n) {
      const auto step_ns = static_cast<std::int64_t>(random.index(1'000'000));
      const double x_m = random.uniform(-1.0, 1.0);
      if (pass == 0) first_m[n] = x_m;
      shortest_ns[n] = std::min(shortest_ns[n], step_ns);
      keeper.on_tick(record_of(n, step_ns, x_m));
    }
    keeper.end_pass(loop);
  }
  const RunRecords run = keeper.finish();
  ASSERT_EQ(run.records.size(), kTicks);
  EXPECT_EQ(run.summary.ticks, kTicks);
  for (std::size_t n = 0; n < kTicks; ++n) {
    EXPECT_EQ(run.records[n].device_m[0], first_m[n]);
    EXPECT_EQ(run.records[n].step_ns, shortest_ns[n]);
  }
  EXPECT_EQ(run.summary.step_ns.max_ns, *std::max_element(shortest_ns.begin(), shortest_ns.end()));
}

TEST(RecordKeeper, EndsWhereAnInterruptedRunEnded) {
  const test::OwnedWorld box(test::box_soup({0.1, 0.1, 0.1}));
  RecordKeeper keeper(10);
  for (std::uint64_t n = 0; n < 4; ++n) keeper.on_tick(record_of(n, 5, 0.0));
  keeper.end_pass(any_loop(box.world()));
  const RunRecords run = keeper.finish();
  EXPECT_EQ(run.records.size(), 4u);
  EXPECT_EQ(run.summary.ticks, 4u);
}

TEST(RecordKeeper, CountsTicksBeyondItsMemoryInTheSummaryOnly) {
  const test::OwnedWorld box(test::box_soup({0.1, 0.1, 0.1}));
  RecordKeeper keeper(3);
  for (std::uint64_t n = 0; n < 5; ++n) keeper.on_tick(record_of(n, 5, 0.0));
  keeper.end_pass(any_loop(box.world()));
  for (std::uint64_t n = 0; n < 5; ++n) keeper.on_tick(record_of(n, 1, 0.0));
  const RunRecords run = keeper.finish();
  ASSERT_EQ(run.records.size(), 3u);
  EXPECT_EQ(run.summary.ticks, 5u);
  EXPECT_EQ(run.records[2].step_ns, 1);
}

TEST(RecordKeeper, CountsATripOnce) {
  const test::OwnedWorld box(test::box_soup({0.1, 0.1, 0.1}));
  const HapticLoop loop = any_loop(box.world());
  RecordKeeper keeper(1);
  GovernorTrip trip;
  trip.tick = 7;
  for (int pass = 0; pass < 2; ++pass) {
    keeper.on_trip(trip);
    keeper.on_tick(record_of(0, 5, 0.0));
    keeper.end_pass(loop);
  }
  const RunSummary summary = keeper.finish().summary;
  EXPECT_EQ(summary.trips, 1u);
}

TEST(KeptTicks, AreOneToFourMillion) {
  EXPECT_EQ(*kept_ticks(1.0, kTick_s), 1000u);
  EXPECT_EQ(*kept_ticks(kTick_s, kTick_s), 1u);
  EXPECT_EQ(*kept_ticks(4e6, 1.0), 4'000'000u);
  const double beyond = std::nextafter(4e6, 5e6);
  for (const double ticks :
       {0.0, std::nextafter(1.0, 0.0), -1.0, beyond, std::numeric_limits<double>::infinity(),
        std::numeric_limits<double>::quiet_NaN()}) {
    const auto kept = kept_ticks(ticks, 1.0);
    ASSERT_FALSE(kept.ok()) << ticks;
    EXPECT_EQ(kept.error().element, "seconds");
  }
}

TEST(RunMemory, IsThatOfTheCallerAndOfTheTicks) {
  constexpr std::uint64_t kTaken = 1'000'000;
  constexpr std::uint64_t kTicks = 1000;
  constexpr std::uint64_t kAll = kTaken + kTicks * kBytesPerTick;
  MemoryLedger ledger;
  EXPECT_FALSE(take_run_memory(kAll, kTaken, "advice", kTicks, ledger));
  EXPECT_EQ(ledger.taken(), kAll);

  const auto of_ticks = take_run_memory(kAll - 1, kTaken, "advice", kTicks, ledger);
  ASSERT_TRUE(of_ticks);
  EXPECT_EQ(of_ticks->code, ErrorCode::kLimitExceeded);
  EXPECT_EQ(of_ticks->element, "seconds");
  EXPECT_NE(of_ticks->hint.find("choose a shorter run"), std::string::npos) << of_ticks->hint;

  const auto of_caller = take_run_memory(kTaken - 1, kTaken, "load less", kTicks, ledger);
  ASSERT_TRUE(of_caller);
  EXPECT_EQ(of_caller->code, ErrorCode::kLimitExceeded);
  EXPECT_NE(of_caller->hint.find("load less"), std::string::npos) << of_caller->hint;
}

}  // namespace
}  // namespace palpate
