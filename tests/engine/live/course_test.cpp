// The course of a participant as a function of the journal.

#include "engine/live/course.h"

#include <algorithm>
#include <map>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace palpate::test {
namespace {

// Blocks 0 to 2 with three trials each.
std::vector<PlannedTrial> three_blocks() {
  std::vector<PlannedTrial> trials;
  for (int block = 0; block < 3; ++block) {
    for (int trial = 1; trial <= 3; ++trial) {
      trials.push_back({{}, Following::kDelayed, block, trial, {}});
    }
  }
  return trials;
}

void take(Course& course, const JournalEntry& entry) {
  const auto problem = course.take(entry);
  ASSERT_FALSE(problem) << entry.dump() << " " << *problem;
}

// Up to the first trial.
Course at_first_trial(const CourseSettings& settings = {true, 2}) {
  Course course(three_blocks(), settings);
  take(course, {{"kind", "next"}, {"step", "information"}});
  take(course, {{"kind", "consent"}, {"value", true}});
  take(course, {{"kind", "checked"}});
  take(course, {{"kind", "next"}, {"step", "instructions"}});
  if (settings.asks_about) take(course, {{"kind", "about"}});
  for (std::size_t i = 0; i < settings.learning_conditions; ++i) {
    take(course, {{"kind", "learned"}});
  }
  return course;
}

void start(Course& course) {
  const CourseTrial next = course.next();
  take(course, {{"kind", "start"}, {"trial", next.planned}, {"attempt", next.attempt}});
}

void end(Course& course, const std::string& status) {
  const CourseTrial next = course.next();
  take(course,
       {{"kind", "end"}, {"trial", next.planned}, {"attempt", next.attempt}, {"status", status}});
}

TEST(Course, TakesTheStepsInOrder) {
  Course course(three_blocks(), {true, 2});
  std::vector<std::string> steps;
  const auto see = [&] { steps.emplace_back(name_of(course.step())); };
  see();
  take(course, {{"kind", "next"}, {"step", "information"}});
  see();
  take(course, {{"kind", "consent"}, {"value", true}});
  see();
  take(course, {{"kind", "checked"}});
  see();
  take(course, {{"kind", "next"}, {"step", "instructions"}});
  see();
  take(course, {{"kind", "about"}});
  see();
  take(course, {{"kind", "learned"}});
  take(course, {{"kind", "learned"}});
  see();
  EXPECT_EQ(steps, (std::vector<std::string>{"information", "consent", "check", "instructions",
                                             "about", "learning", "trials"}));
}

TEST(Course, LeavesOutWhatThePlanDoesNotAsk) {
  Course course(three_blocks(), {false, 0});
  take(course, {{"kind", "next"}, {"step", "information"}});
  take(course, {{"kind", "consent"}, {"value", true}});
  take(course, {{"kind", "checked"}});
  take(course, {{"kind", "next"}, {"step", "instructions"}});
  EXPECT_EQ(course.step(), CourseStep::kTrials);
}

TEST(Course, EndsWithoutConsent) {
  Course course(three_blocks(), {});
  take(course, {{"kind", "next"}, {"step", "information"}});
  take(course, {{"kind", "consent"}, {"value", false}});
  EXPECT_EQ(course.step(), CourseStep::kRefused);
  EXPECT_TRUE(course.has_ended());
}

TEST(Course, RunsEveryTrialOnceWithABreakBetweenBlocks) {
  Course course = at_first_trial();
  std::vector<std::size_t> order;
  int breaks = 0;
  while (course.step() != CourseStep::kDebriefing) {
    if (course.step() == CourseStep::kBreak) {
      ++breaks;
      take(course, {{"kind", "next"}, {"step", "break"}});
      continue;
    }
    order.push_back(course.next().planned);
    start(course);
    end(course, "done");
  }
  EXPECT_EQ(order, (std::vector<std::size_t>{0, 1, 2, 3, 4, 5, 6, 7, 8}));
  EXPECT_EQ(breaks, 2);
  take(course, {{"kind", "next"}, {"step", "debriefing"}});
  EXPECT_EQ(course.step(), CourseStep::kDone);
}

TEST(Course, RepeatsAnAbortedTrialAtTheEndOfItsBlock) {
  Course course = at_first_trial();
  start(course);
  end(course, "aborted");
  EXPECT_EQ(course.next().planned, 1u);
  for (int i = 0; i < 2; ++i) {
    start(course);
    end(course, i == 0 ? "timeout" : "fault");  // these are not repeated
  }
  EXPECT_EQ(course.next().planned, 0u);
  EXPECT_EQ(course.next().attempt, 2);
  start(course);
  end(course, "aborted");
  EXPECT_EQ(course.next().planned, 0u);
  EXPECT_EQ(course.next().attempt, 3);
  start(course);
  end(course, "done");
  EXPECT_EQ(course.step(), CourseStep::kBreak);
}

TEST(Course, SkipsATrialAndRepeatsOne) {
  Course course = at_first_trial();
  start(course);
  end(course, "done");
  take(course, {{"kind", "skip"}, {"trial", 1}});
  take(course, {{"kind", "repeat"}, {"trial", 0}});
  EXPECT_EQ(course.next().planned, 2u);
  start(course);
  end(course, "done");
  EXPECT_EQ(course.next().planned, 0u);
  EXPECT_EQ(course.next().attempt, 2);
}

TEST(Course, RefreshesAfterALongAbsence) {
  Course course = at_first_trial();
  for (int i = 0; i < 3; ++i) {
    start(course);
    end(course, "done");
  }
  take(course, {{"kind", "next"}, {"step", "break"}});
  start(course);
  end(course, "done");
  take(course, {{"kind", "refresh"}});
  EXPECT_EQ(course.step(), CourseStep::kInstructions);
  take(course, {{"kind", "next"}, {"step", "instructions"}});
  EXPECT_EQ(course.next().planned, 0u) << "a practice trial";
  EXPECT_EQ(course.next().attempt, 2);
  start(course);
  end(course, "aborted");
  EXPECT_EQ(course.next().planned, 0u);
  start(course);
  end(course, "done");
  EXPECT_EQ(course.next().planned, 4u);
}

TEST(Course, RefusesWhatDoesNotFollow) {
  Course course = at_first_trial();
  const std::vector<JournalEntry> wrong = {
      {{"kind", "next"}, {"step", "information"}},
      {{"kind", "consent"}, {"value", true}},
      {{"kind", "about"}},
      {{"kind", "learned"}},
      {{"kind", "start"}, {"trial", 1}, {"attempt", 1}},
      {{"kind", "start"}, {"trial", 0}, {"attempt", 2}},
      {{"kind", "start"}, {"trial", -1}, {"attempt", 1}},
      {{"kind", "start"}, {"trial", "0"}, {"attempt", 1}},
      {{"kind", "start"}},
      {{"kind", "end"}, {"trial", 0}, {"attempt", 1}, {"status", "done"}},
      {{"kind", "repeat"}, {"trial", 3}},
      {{"kind", "skip"}, {"trial", 2}}};
  for (const JournalEntry& entry : wrong) {
    EXPECT_TRUE(course.take(entry)) << entry.dump();
    EXPECT_EQ(course.next().planned, 0u) << entry.dump();
    EXPECT_EQ(course.next().attempt, 1) << entry.dump();
  }
  start(course);
  EXPECT_TRUE(course.take({{"kind", "start"}, {"trial", 0}, {"attempt", 1}}));
  EXPECT_TRUE(course.take({{"kind", "skip"}, {"trial", 0}})) << "a trial runs";
}

// Two conditions with two objects each, in practice and in two blocks.
Course with_questionnaire() {
  std::vector<PlannedTrial> trials;
  for (int block = 0; block < 3; ++block) {
    for (int trial = 0; trial < 4; ++trial) {
      PlanCondition condition;
      condition.rotation = static_cast<std::size_t>(trial / 2);
      condition.object = static_cast<std::size_t>(trial % 2);
      trials.push_back({{}, Following::kDelayed, block, trial + 1, condition});
    }
  }
  Course course(trials, {false, 0, true});
  take(course, {{"kind", "next"}, {"step", "information"}});
  take(course, {{"kind", "consent"}, {"value", true}});
  take(course, {{"kind", "checked"}});
  take(course, {{"kind", "next"}, {"step", "instructions"}});
  return course;
}

// The steps from here to the end: places of trials that end as done, "rated 5" and "break".
std::vector<std::string> rest_of(Course& course) {
  std::vector<std::string> seen;
  while (course.step() != CourseStep::kDebriefing) {
    if (course.step() == CourseStep::kBreak) {
      seen.emplace_back("break");
      take(course, {{"kind", "next"}, {"step", "break"}});
    } else if (course.step() == CourseStep::kQuestionnaire) {
      seen.push_back("rated " + std::to_string(course.rated()));
      EXPECT_EQ(course.block(), course.trials()[course.rated()].block);
      take(course, {{"kind", "rated"}, {"trial", course.rated()}});
    } else {
      seen.push_back(std::to_string(course.next().planned));
      start(course);
      end(course, "done");
    }
  }
  return seen;
}

TEST(Course, AsksAfterTheLastTrialOfEachConditionInABlock) {
  Course course = with_questionnaire();
  const std::vector<std::string> expected = {"0",       "1",  "2",  "3",       "break", "4", "5",
                                             "rated 5", "6",  "7",  "rated 7", "break", "8", "9",
                                             "rated 9", "10", "11", "rated 11"};
  EXPECT_EQ(rest_of(course), expected);
}

TEST(Course, RepeatsAnAbortedTrialAfterTheQuestionnaireOfItsCondition) {
  Course course = with_questionnaire();
  for (int i = 0; i < 4; ++i) take(course, {{"kind", "skip"}, {"trial", i}});
  take(course, {{"kind", "next"}, {"step", "break"}});
  start(course);
  end(course, "done");
  start(course);
  end(course, "aborted");
  ASSERT_EQ(course.step(), CourseStep::kQuestionnaire);
  for (const JournalEntry& wrong :
       std::vector<JournalEntry>{{{"kind", "rated"}},
                                 {{"kind", "rated"}, {"trial", 4}},
                                 {{"kind", "skip"}, {"trial", 6}},
                                 {{"kind", "start"}, {"trial", 6}, {"attempt", 1}},
                                 {{"kind", "next"}, {"step", "questionnaire"}}}) {
    EXPECT_TRUE(course.take(wrong)) << wrong.dump();
  }
  take(course, {{"kind", "repeat"}, {"trial", 4}});
  const std::vector<std::string> expected = {"rated 5", "6",     "7",       "rated 7", "5",
                                             "4",       "break", "8",       "9",       "rated 9",
                                             "10",      "11",    "rated 11"};
  EXPECT_EQ(rest_of(course), expected);
}

TEST(Course, AsksNothingAboutAConditionOfWhichAllTrialsWereSkipped) {
  Course course = with_questionnaire();
  for (int i = 0; i < 4; ++i) take(course, {{"kind", "skip"}, {"trial", i}});
  take(course, {{"kind", "next"}, {"step", "break"}});
  for (int i = 4; i < 6; ++i) take(course, {{"kind", "skip"}, {"trial", i}});
  EXPECT_EQ(course.step(), CourseStep::kTrials);
  start(course);
  end(course, "done");
  take(course, {{"kind", "skip"}, {"trial", 7}});
  EXPECT_EQ(course.step(), CourseStep::kQuestionnaire) << "one of its trials was made";
  take(course, {{"kind", "refresh"}});
  take(course, {{"kind", "next"}, {"step", "instructions"}});
  EXPECT_EQ(course.step(), CourseStep::kQuestionnaire);
  EXPECT_EQ(course.block(), 1);
  take(course, {{"kind", "rated"}, {"trial", 7}});
  EXPECT_EQ(course.step(), CourseStep::kBreak);
  take(course, {{"kind", "next"}, {"step", "break"}});
  EXPECT_EQ(course.next().planned, 0u) << "the practice trial of the refresher";
}

// The definition: whatever is aborted, repeated and skipped, every trial of a block has ended
// without an abort, or was skipped, before the next block begins, and no attempt comes twice.
TEST(Course, LeavesNoTrialOutHoweverOftenOneIsCut) {
  const unsigned seed = std::random_device()();
  std::mt19937 random(seed);
  for (int run = 0; run < 200; ++run) {
    Course course = at_first_trial({});
    std::map<std::size_t, int> finished, attempts;
    int last_block = 0;
    while (course.step() != CourseStep::kDebriefing) {
      if (course.step() == CourseStep::kBreak) {
        take(course, {{"kind", "next"}, {"step", "break"}});
        continue;
      }
      const CourseTrial next = course.next();
      const int block = course.trials()[next.planned].block;
      ASSERT_GE(block, last_block) << "seed " << seed;
      for (std::size_t i = 0; block > last_block && i < course.trials().size(); ++i) {
        if (course.trials()[i].block < block) {
          ASSERT_GE(finished[i], 1) << "seed " << seed;
        }
      }
      last_block = block;
      ASSERT_EQ(next.attempt, ++attempts[next.planned]) << "seed " << seed;
      const auto what = random() % 10;
      if (what == 0) {
        take(course, {{"kind", "skip"}, {"trial", next.planned}});
        ++finished[next.planned];
        continue;
      }
      start(course);
      if (what == 1) take(course, {{"kind", "repeat"}, {"trial", next.planned}});
      end(course, what < 5 ? "aborted" : "done");
      if (what >= 5) ++finished[next.planned];
    }
    for (std::size_t i = 0; i < course.trials().size(); ++i) ASSERT_GE(finished[i], 1);
  }
}

}  // namespace
}  // namespace palpate::test
