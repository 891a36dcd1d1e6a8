// The clutch of a pointer: what moves the device point, what does not, and what is counted.

#include "engine/live/clutch.h"

#include <limits>

#include <gtest/gtest.h>

#include "engine/live/pointed_device.h"
#include "tests/helpers/random.h"

namespace palpate::test {
namespace {

const Vec3 kStart_m(0.01, -0.02, 0.0);

// A pointer of a page, and the tick that follows its messages.
class Pointer {
 public:
  explicit Pointer(bool permits_clutch) : device_(describe(), kStart_m, permits_clutch) {}

  static DeviceDescription describe() {
    DeviceDescription description;
    description.sensed_axes = 2;
    return description;
  }
  // The pointer moves by this, with the clutch pressed or not.
  void move(double right_m, bool is_clutched, bool holds = true) {
    sum_m_ += right_m;
    device_.point({holds, ++sequence_, {kStart_m.x() + sum_m_, kStart_m.y(), 0.0}, is_clutched});
  }
  void press() { move(0.0, true); }
  void release() { move(0.0, false); }
  void lift() { move(0.0, true, false); }
  // Where the device point is in this tick, from its start.
  double tick(bool is_in_contact = false) {
    const DeviceSample sample = device_.read(1e-3);
    TickRecord record;
    record.contact = is_in_contact ? 1 : 0;
    device_.on_tick(record);
    return sample.position_m[0] - kStart_m.x();
  }
  std::uint32_t uses() const { return device_.clutch().uses(); }
  std::uint64_t refused_lifts() const { return device_.clutch().refused_lifts(); }

 private:
  PointedDevice device_;
  double sum_m_ = 0.0;
  std::uint64_t sequence_ = 0;
};

// Of a sum of this many numbers of this size in any order.
double rounding_m(double most_m, int additions) {
  return most_m * additions * std::numeric_limits<double>::epsilon();
}

TEST(Clutch, TheDevicePointStandsStillWhileTheHandIsSetBackAndGoesOnFromThere) {
  Pointer hand(true);
  const double near_m = rounding_m(0.1, 10);
  hand.move(0.03, false);
  EXPECT_NEAR(hand.tick(), 0.03, near_m);
  hand.press();
  EXPECT_NEAR(hand.tick(), 0.03, near_m);
  hand.move(-0.05, true);
  EXPECT_NEAR(hand.tick(), 0.03, near_m);
  hand.release();
  EXPECT_NEAR(hand.tick(), 0.03, near_m) << "no jump at the end";
  hand.move(0.02, false);
  EXPECT_NEAR(hand.tick(), 0.05, near_m);
  EXPECT_EQ(hand.uses(), 1u);
}

TEST(Clutch, APressInContactDoesNothingAlsoIfItIsHeldOn) {
  Pointer hand(true);
  const double near_m = rounding_m(0.1, 10);
  hand.move(0.03, false);
  hand.tick(true);
  hand.press();
  hand.tick(true);
  hand.move(-0.01, true);
  EXPECT_NEAR(hand.tick(false), 0.02, near_m);
  hand.move(-0.01, true);
  EXPECT_NEAR(hand.tick(false), 0.01, near_m) << "out of contact";
  EXPECT_EQ(hand.uses(), 0u);
  hand.release();
  hand.tick();
  hand.press();
  hand.move(-0.04, true);
  EXPECT_NEAR(hand.tick(), 0.01, near_m);
  EXPECT_NEAR(hand.tick(), 0.01, near_m);
  EXPECT_EQ(hand.uses(), 1u);
  EXPECT_EQ(hand.refused_lifts(), 0u) << "a mouse was not lifted";
}

// A press is judged where it found the device point, not where the tick before had it.
TEST(Clutch, APressThatComesWithTheMotionIntoContactIsRefused) {
  Pointer hand(true);
  hand.tick();
  hand.move(0.03, false);
  hand.press();
  hand.move(-0.02, true);
  EXPECT_NEAR(hand.tick(true), 0.03, rounding_m(0.1, 10)) << "in contact";
  EXPECT_NEAR(hand.tick(true), 0.01, rounding_m(0.1, 10)) << "the motion of a refused press";
  EXPECT_EQ(hand.uses(), 0u);
}

TEST(Clutch, MessagesThatShareATickLoseNeitherMotionNorPresses) {
  Pointer hand(true);
  hand.move(0.01, false);
  hand.press();
  hand.move(-0.04, true);
  hand.release();
  hand.move(0.02, false);
  hand.press();
  hand.move(-0.03, true);
  hand.release();
  EXPECT_NEAR(hand.tick(), 0.03, rounding_m(0.1, 20));
  EXPECT_NEAR(hand.tick(), 0.03, rounding_m(0.1, 20));
  EXPECT_EQ(hand.uses(), 2u);
}

TEST(Clutch, ALiftIsAUseOutOfContactAndRefusedElsewhere) {
  for (const bool is_permitted : {true, false}) {
    for (const bool is_in_contact : {true, false}) {
      Pointer hand(is_permitted);
      hand.move(0.03, false);
      hand.tick(is_in_contact);
      hand.lift();
      hand.tick(is_in_contact);
      hand.release();  // the pen is down again
      EXPECT_NEAR(hand.tick(is_in_contact), 0.03, rounding_m(0.1, 10));
      const bool is_use = is_permitted && !is_in_contact;
      EXPECT_EQ(hand.uses(), is_use ? 1u : 0u);
      EXPECT_EQ(hand.refused_lifts(), is_use ? 0u : 1u);
    }
  }
}

// Where the plan does not permit it, the device point is where the messages put it, to the bit.
TEST(Clutch, WithoutPermissionEachMotionCounts) {
  Pointer hand(false);
  hand.press();
  hand.move(-0.04, true);
  hand.tick();
  EXPECT_EQ(hand.tick(), (kStart_m.x() - 0.04) - kStart_m.x());
  EXPECT_EQ(hand.uses(), 0u);
}

// Random presses, motions and contacts against the definition, message by message: one message a
// tick.
TEST(Clutch, KeepsTheDefinitionInRandomOrder) {
  Random random(51);
  Pointer hand(true);
  bool is_pressed = false, is_engaged = false, was_in_contact = false;
  double expected_m = 0.0;
  std::uint32_t uses = 0;
  constexpr int kTicks = 20'000;
  for (int i = 0; i < kTicks; ++i) {
    if (random.index(20) == 0) {
      is_pressed = !is_pressed;
      is_pressed ? hand.press() : hand.release();
      hand.tick(was_in_contact);  // it stands still, and so does the contact
      if (is_pressed) is_engaged = !was_in_contact;
      if (is_pressed && is_engaged) ++uses;
      continue;
    }
    const double moved_m = random.uniform(-1e-3, 1e-3);
    hand.move(moved_m, is_pressed);
    if (!(is_pressed && is_engaged)) {
      expected_m += moved_m;
      was_in_contact = random.index(4) == 0;
    }
    ASSERT_NEAR(hand.tick(was_in_contact), expected_m, rounding_m(20.0, 3 * kTicks)) << i;
  }
  hand.tick(was_in_contact);
  EXPECT_EQ(hand.uses(), uses);
  EXPECT_GT(uses, 100u);
}

}  // namespace
}  // namespace palpate::test
