// The cores that other programs use.

#include "engine/accuracy/machine_load.h"

#include <gtest/gtest.h>

namespace palpate {
namespace {

TEST(MachineLoad, BusySecondsLeaveOutIdlingAndDisks) {
  // user, nice, system, idle, disk, interrupts, soft interrupts, steal; guests are within user.
  const auto busy =
      busy_seconds("cpu  100 10 20 5000 700 1 2 30 90 0\ncpu0 1 1 1 1 1 1 1 1 0 0\n", 100.0);
  ASSERT_TRUE(busy.has_value());
  EXPECT_DOUBLE_EQ(*busy, 1.63);
}

TEST(MachineLoad, AnotherTextHasNoBusySeconds) {
  for (const char* text : {"", "cpu", "cpu 1 2 3", "intr 1 2 3 4 5 6 7 8", "cpu a b c d e f g h"}) {
    EXPECT_FALSE(busy_seconds(text, 100.0).has_value()) << text;
  }
  EXPECT_FALSE(busy_seconds("cpu 1 2 3 4 5 6 7 8", 0.0).has_value());
}

TEST(MachineLoad, OthersUseWhatThisProgramDoesNot) {
  EXPECT_DOUBLE_EQ(cores_of_others({10.0, 100.0, 1.0}, {20.0, 122.0, 8.0}), 1.5);
  EXPECT_DOUBLE_EQ(cores_of_others({10.0, 100.0, 1.0}, {20.0, 107.0, 8.5}), 0.0)
      << "clocks have different steps";
  EXPECT_DOUBLE_EQ(cores_of_others({10.0, 100.0, 1.0}, {10.0, 107.0, 1.0}), 0.0);
}

TEST(MachineLoad, TheSystemStatesItsTimes) {
  const auto before = cpu_times_now();
  ASSERT_TRUE(before.has_value());
  double sum = 0.0;
  for (int i = 0; i < 20'000'000; ++i) sum += 1.0 / (1.0 + i);
  EXPECT_GT(sum, 1.0);
  const auto after = cpu_times_now();
  ASSERT_TRUE(after.has_value());
  EXPECT_GT(after->own_s, before->own_s);
  EXPECT_GE(after->busy_s, before->busy_s);
}

}  // namespace
}  // namespace palpate
