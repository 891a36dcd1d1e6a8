// A pointer as the target of the simulated hand.

#include "engine/viewer/pointer_plan.h"

#include <gtest/gtest.h>

#include "haptics/record_vectors.h"

namespace palpate::test {
namespace {

constexpr double kTickTime_s = 0x1p-10;  // sums of it are exact

// Calls the plan as the simulated device does.
class Hand {
 public:
  explicit Hand(PointerPlan& plan) : plan_(plan) {}

  Vec3 tick(const Vec3& device_m) {
    TickRecord last;
    view(last.device_m) = device_m;
    const HandTarget target = plan_.target(time_s_, {}, last);
    EXPECT_EQ(target.velocity_m_per_s, Vec3(Vec3::Zero()));
    EXPECT_EQ(target.position_m, plan_.target_m());
    time_s_ += kTickTime_s;
    return target.position_m;
  }

 private:
  PointerPlan& plan_;
  double time_s_ = 0.0;
};

PointerMessage at(std::uint64_t sequence, const Vec3& place_m, bool holds = true) {
  return {holds, sequence, {place_m.x(), place_m.y(), place_m.z()}};
}

const Vec3 kDevice(0.01, 0.02, 0.03);
const Vec3 kPointer(-0.05, 0.0, 0.04);

TEST(PointerPlan, LeavesTheHandWhereTheDeviceIsUntilAPointerComes) {
  PointerPlan plan(Vec3::Zero());
  Hand hand(plan);
  EXPECT_EQ(hand.tick(kDevice), kDevice);
  EXPECT_EQ(hand.tick(2 * kDevice), 2 * kDevice);
  EXPECT_FALSE(plan.has_target());
  EXPECT_EQ(plan.sequence(), 0u);
}

TEST(PointerPlan, FollowsTheNewestPointerAndTellsItsSequence) {
  PointerPlan plan(Vec3::Zero());
  Hand hand(plan);
  plan.point(at(1, kPointer));
  plan.point(at(5, 2 * kPointer));
  EXPECT_EQ(hand.tick(kDevice), 2 * kPointer);
  EXPECT_EQ(plan.sequence(), 5u);
  EXPECT_TRUE(plan.is_held());
  plan.point(at(5, kPointer));
  plan.point(at(4, kPointer));
  EXPECT_EQ(hand.tick(kDevice), 2 * kPointer);
  EXPECT_EQ(plan.sequence(), 5u);
}

TEST(PointerPlan, LetsGoWhenThePointerDoes) {
  PointerPlan plan(Vec3::Zero());
  Hand hand(plan);
  plan.point(at(1, kPointer));
  hand.tick(kDevice);
  plan.point(at(2, kPointer, /* holds = */ false));
  EXPECT_EQ(hand.tick(kDevice), kDevice);
  EXPECT_EQ(plan.sequence(), 2u);
  EXPECT_FALSE(plan.is_held());
  plan.point(at(3, kPointer));
  EXPECT_EQ(hand.tick(kDevice), kPointer);
  plan.let_go();
  EXPECT_EQ(hand.tick(kDevice), kDevice);
  plan.point(at(1, kPointer));  // of the next page
  EXPECT_EQ(hand.tick(kDevice), kPointer);
  EXPECT_EQ(plan.sequence(), 1u);
}

// The patience is 0.3 s, which is 307.2 ticks of 2^-10 s: the first tick later than that is 308
// ticks after the one that took the pointer.
TEST(PointerPlan, LetsGoAfter300MillisecondsWithoutAMessage) {
  PointerPlan plan(Vec3::Zero());
  Hand hand(plan);
  plan.point(at(1, kPointer));
  for (int n = 0; n <= 307; ++n) ASSERT_EQ(hand.tick(kDevice), kPointer) << n;
  EXPECT_EQ(hand.tick(kDevice), kDevice);
  plan.point(at(2, kPointer));
  for (int n = 0; n < 200; ++n) hand.tick(kDevice);
  plan.point(at(3, kPointer));
  for (int n = 0; n <= 307; ++n) ASSERT_EQ(hand.tick(kDevice), kPointer) << n;
  EXPECT_EQ(hand.tick(kDevice), kDevice);
}

TEST(PointerPlan, ReturnsToItsStartInAStraightLine) {
  const Vec3 start(0.05, 0.0, 0.0);
  PointerPlan plan(start);
  Hand hand(plan);
  hand.tick(Vec3::Zero());
  plan.start();
  EXPECT_TRUE(hand.tick(Vec3::Zero()).y() == 0.0);
  Vec3 last = plan.target_m();
  int ticks = 1;
  while (last != start && ticks < 10000) {
    const Vec3 next = hand.tick(last);
    // 0.1 m/s; the last step may be shorter. One rounding of a place of at most 0.05 m.
    ASSERT_LE((next - last).norm(), 0.1 * kTickTime_s + 0x1p-56);
    last = next;
    ++ticks;
  }
  EXPECT_EQ(ticks, 512);  // 0.05 m at 0.1 m/s are 0.5 s
  EXPECT_TRUE(plan.has_target());
  EXPECT_FALSE(plan.is_held());
  EXPECT_EQ(hand.tick(kDevice), start);
  int stays = 1;
  for (; plan.has_target() && stays < 10000; ++stays) hand.tick(kDevice);
  EXPECT_NEAR(stays * kTickTime_s, PointerPlan::kPatience_s, 4 * kTickTime_s);
  EXPECT_EQ(hand.tick(kDevice), kDevice) << "it lets go";
  plan.point(at(1, kPointer));
  EXPECT_EQ(hand.tick(kDevice), kPointer);
}

}  // namespace
}  // namespace palpate::test
