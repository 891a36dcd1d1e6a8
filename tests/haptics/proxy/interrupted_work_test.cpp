#include "haptics/proxy/interrupted_work.h"

#include <cstddef>
#include <optional>

#include <gtest/gtest.h>

#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::Random;
using Turn = PushOrder::Turn;

TEST(InterruptedStep, IsRepeatedOnlyByTheSameGoalFromTheSamePosition) {
  Random random(4702);
  for (int i = 0; i < 100; ++i) {
    const Vec3 from = random.in_box(1.0);
    const Vec3 goal = random.in_box(1.0);
    const TraceKey trace{random.in_box(1.0), random.in_box(1.0)};
    InterruptedStep step;
    step.keep(from, trace.p, goal, &trace);
    EXPECT_TRUE(step.is_repeated_by(goal, from));
    EXPECT_FALSE(step.is_repeated_by(goal, trace.p));
    EXPECT_FALSE(step.is_repeated_by(trace.q, from));
    EXPECT_EQ(step.target(), trace.q);
    EXPECT_TRUE(step.is_trace(&trace, trace.p));
    EXPECT_FALSE(step.is_trace(&trace, from));
    EXPECT_FALSE(step.is_trace(nullptr, trace.p));
  }
}

TEST(InterruptedStep, KeepsTheGoalForWhichItsTraceWasBegun) {
  const Vec3 first_goal(0, 0, -1);
  const Vec3 second_goal(0, 0.25, -1);
  const TraceKey trace{Vec3::Zero(), Vec3(0, 0, -0.5)};
  const TraceKey other{Vec3::Zero(), Vec3(0, 0, -0.25)};
  InterruptedStep step;
  step.keep(Vec3::Zero(), trace.p, first_goal, &trace);
  step.keep(Vec3::Zero(), trace.p, second_goal, &trace);
  EXPECT_TRUE(step.is_repeated_by(first_goal, Vec3::Zero()));
  EXPECT_FALSE(step.is_repeated_by(second_goal, Vec3::Zero()));
  step.keep(Vec3::Zero(), trace.p, second_goal, &other);
  EXPECT_TRUE(step.is_repeated_by(second_goal, Vec3::Zero()));
  EXPECT_EQ(step.target(), other.q);
}

// A step that was cut short outside of a trace has no target of its own.
TEST(InterruptedStep, KeepsItsTargetIfNoTraceWasCutShort) {
  const TraceKey trace{Vec3::Zero(), Vec3(0, 0, -0.5)};
  InterruptedStep step;
  step.keep(Vec3::Zero(), trace.p, Vec3(0, 0, -1), &trace);
  step.keep(Vec3(1, 0, 0), Vec3(1, 0, 0), Vec3(0, 0, -2), nullptr);
  EXPECT_TRUE(step.is_repeated_by(Vec3(0, 0, -2), Vec3(1, 0, 0)));
  EXPECT_EQ(step.target(), trace.q);
}

TEST(InterruptedStep, IsWantedWhileTheGoalIsWithinHalfOfItsDistance) {
  const TraceKey trace{Vec3::Zero(), Vec3(0, 0, -1)};
  InterruptedStep step;
  step.keep(Vec3::Zero(), trace.p, Vec3(0, 0, -1), &trace);
  EXPECT_TRUE(step.is_still_wanted(Vec3(0, 0, -1), Vec3::Zero()));
  EXPECT_TRUE(step.is_still_wanted(Vec3(0, 0.5, -1), Vec3::Zero()));
  EXPECT_FALSE(step.is_still_wanted(Vec3(0, 0.5625, -1), Vec3::Zero()));
}

// What the next move and the next pushes ask, answered by a flag each: do pushes belong to its
// tick, and does no body move?
TEST(PushOrder, AnswersAsIndependentFlagsAfterAnySequenceOfCalls) {
  Random random(4703);
  PushOrder order;
  bool are_pushed = false;
  bool move_has_turn = false;
  int reserved = 0;
  for (int i = 0; i < 20000; ++i) {
    if (random.index(2) == 0) {
      ASSERT_EQ(order.begin_pushes(), !move_has_turn) << "call " << i;
      are_pushed = true;
      move_has_turn = false;
    } else {
      ASSERT_EQ(order.begin_move(), are_pushed) << "call " << i;
      are_pushed = false;
      if (random.index(3) == 0) {
        move_has_turn = random.index(2) == 0;
        order.end_cut_short(move_has_turn);
      }
    }
    ASSERT_FALSE(are_pushed && move_has_turn) << "call " << i;
    const Turn expected = are_pushed ? Turn::kPushed : move_has_turn ? Turn::kMove : Turn::kOpen;
    ASSERT_EQ(order.turn(), expected) << "call " << i;
    reserved += order.turn() == Turn::kMove ? 1 : 0;
  }
  EXPECT_GT(reserved, 500);
}

TEST(PushOrder, GivesBackThePushThatWasCutShortOnce) {
  PushOrder order;
  EXPECT_FALSE(order.has_unfinished());
  order.cut_short({3, {Quat::Identity(), Vec3(1, 2, 3)}});
  EXPECT_TRUE(order.has_unfinished());
  const BodyMotion push = order.take_unfinished();
  EXPECT_EQ(push.body, 3U);
  EXPECT_EQ(push.T_solver_body.translation_m, Vec3(1, 2, 3));
  EXPECT_FALSE(order.has_unfinished());
  order.cut_short(push);
  order.forget_unfinished();
  EXPECT_FALSE(order.has_unfinished());
}

}  // namespace
}  // namespace palpate
