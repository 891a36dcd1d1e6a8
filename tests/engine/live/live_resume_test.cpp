// What a program finds when it goes on with a participant.

#include <chrono>
#include <string>

#include <gtest/gtest.h>

#include "engine/live/live_run.h"
#include "engine/trials/paper_plan.h"
#include "tests/helpers/gltf_builder.h"

namespace palpate::test {
namespace {

double now_s() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

class Resumed : public ::testing::Test {
 protected:
  Resumed() {
    auto plan =
        parse_plan(shipped_plan_text("paper-live-mouse", ""), "plan.json", PALPATE_MODELS_DIR);
    EXPECT_TRUE(plan.ok()) << plan.error().to_string();
    plan_ = plan_for_person(std::move(*plan));
    settings_.folder = folder_.path("out");
  }
  // A participant who has done the first practice trial, and whose last entry is so old.
  void leave(double ago_s) {
    const auto live = LiveFolder::open(settings_.folder, plan_);
    ASSERT_TRUE(live.ok()) << live.error().to_string();
    ASSERT_FALSE(live->add_participant(1));
    auto journal = Journal::open(live->journal_path(1), journal_head(plan_, 1, false, ""));
    ASSERT_TRUE(journal.ok()) << journal.error().to_string();
    std::vector<JournalEntry> entries = {
        {{"kind", "next"}, {"step", "information"}},
        {{"kind", "consent"}, {"value", true}},
        {{"kind", "checked"}, {"input", "mouse"}},
        {{"kind", "next"}, {"step", "instructions"}},
        {{"kind", "about"}},
        {{"kind", "learned"}},
        {{"kind", "learned"}},
        {{"kind", "start"}, {"trial", 0}, {"attempt", 1}},
        {{"kind", "end"}, {"trial", 0}, {"attempt", 1}, {"status", "done"}}};
    for (JournalEntry& entry : entries) {
      entry["at_s"] = now_s() - ago_s;
      ASSERT_FALSE(journal->add(entry));
    }
  }
  CourseStep step_of_resumed() {
    const auto run = LiveRun::open(plan_, settings_);
    EXPECT_TRUE(run.ok()) << run.error().to_string();
    return run.ok() ? (*run)->course().step() : CourseStep::kStopped;
  }

  TemporaryFolder folder_;
  ExperimentPlan plan_;
  LiveRunSettings settings_;
};

TEST_F(Resumed, GoesOnWithTheNextTrial) {
  leave(60.0);
  EXPECT_EQ(step_of_resumed(), CourseStep::kTrials);
}

TEST_F(Resumed, RepeatsTheInstructionsAfterHalfAnHour) {
  leave(31.0 * 60.0);
  EXPECT_EQ(step_of_resumed(), CourseStep::kInstructions);
}

TEST_F(Resumed, RepeatsThemIfTheClockWasSetBack) {
  leave(-60.0);
  EXPECT_EQ(step_of_resumed(), CourseStep::kInstructions);
}

TEST_F(Resumed, RefusesAParticipantWhoseCourseHasEnded) {
  leave(60.0);
  {
    const auto live = LiveFolder::open(settings_.folder, plan_);
    auto journal = Journal::open(live->journal_path(1), journal_head(plan_, 1, false, ""));
    ASSERT_FALSE(journal->add({{"kind", "stop"}, {"keep", true}}));
  }
  const auto run = LiveRun::open(plan_, settings_);
  ASSERT_FALSE(run.ok());
  EXPECT_NE(run.error().problem.find("stopped"), std::string::npos) << run.error().to_string();
}

}  // namespace
}  // namespace palpate::test
