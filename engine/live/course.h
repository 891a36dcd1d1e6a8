#pragma once

// Where a participant is in the course of an experiment: a function of the entries of the journal.

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/live/journal.h"
#include "engine/trials/deal/participant_run.h"

namespace palpate {

// In the order in which a person takes them, apart from the last two, which end the course.
enum class CourseStep : std::uint8_t {
  kInformation,
  kConsent,
  kCheck,
  kInstructions,
  kAbout,
  kLearning,  // each condition, without a clock
  kTrials,
  kQuestionnaire,  // about a condition, after its last trial in a block
  kBreak,
  kDebriefing,
  kDone,
  kRefused,
  kStopped
};
// As the page and the journal name them.
std::string_view name_of(CourseStep step);

struct CourseSettings {
  bool asks_about = false;
  std::size_t learning_conditions = 0;  // how many are touched before the first trial
  bool has_questionnaire = false;       // the trials of a condition then follow each other
};

struct CourseTrial {
  std::size_t planned = 0;  // its place in the planned trials
  int attempt = 1;
};

// The course is computed from the journal alone, so that a program that was killed goes on where it
// was. The entries and what they do:
//   {"kind": "next", "step": S}       goes on from information, instructions, a break or debriefing
//   {"kind": "consent", "value": B}   goes on, or ends the course (kRefused)
//   {"kind": "checked"}, {"kind": "about"}, {"kind": "learned"}   end their step; there are as many
//                                     `learned` as learning conditions
//   {"kind": "start", "trial": I, "attempt": A}
//   {"kind": "end", "trial": I, "attempt": A, "status": S}   ends the trial; an aborted one is
//                                     repeated at the end of its block
//   {"kind": "skip", "trial": I}      leaves out the trial that would be next
//   {"kind": "repeat", "trial": I}    adds a trial of the block that runs to the end of it
//   {"kind": "rated", "trial": I}     ends the questionnaire about the condition of this trial, the
//                                     last one of it in its block. An aborted or repeated trial
//                                     comes after the questionnaire. A condition of which all
//                                     trials were skipped has none, and neither has practice
//   {"kind": "refresh"}               repeats the instructions and one practice trial
//   {"kind": "stop"}                  ends the course; before the consent it refuses it
// Other kinds change nothing.
class Course {
 public:
  // trials: of one participant, in their order; not empty.
  Course(std::vector<PlannedTrial> trials, const CourseSettings& settings);

  // Takes the next entry. An error, in which case nothing has changed, says what was expected.
  std::optional<std::string> take(const JournalEntry& entry);

  CourseStep step() const { return step_; }
  bool has_ended() const { return step_ >= CourseStep::kDone; }
  // In kLearning: how many conditions have been touched.
  std::size_t learned() const { return learned_; }
  // In kQuestionnaire: the last trial of the condition to rate, its place in the planned trials.
  std::size_t rated() const { return rated_; }
  // The number of the block of the next trial, the questionnaire or the break.
  int block() const;
  // The trial that is next, or runs; after the last one of a block, the last one planned in it.
  CourseTrial next() const;
  // The trial that has started and has no end: the program was killed in it.
  const std::optional<CourseTrial>& running() const { return running_; }
  const std::vector<PlannedTrial>& trials() const { return trials_; }
  // How many attempts of the planned trial have begun.
  int attempts(std::size_t planned) const { return attempts_[planned]; }
  std::size_t trials_left() const;

 private:
  void begin_group();
  void go_to_trials();
  bool take_next(const JournalEntry& entry);
  bool take_start(const JournalEntry& entry);
  bool take_end(const JournalEntry& entry);
  bool take_skip(const JournalEntry& entry);
  bool take_repeat(const JournalEntry& entry);
  bool take_rated(const JournalEntry& entry);
  bool take_refresh();
  void leave_trial(bool repeats);
  bool wants_rating(std::size_t planned) const;
  void end_group_if_empty();
  bool is_next(const JournalEntry& entry) const;

  std::vector<PlannedTrial> trials_;
  CourseSettings settings_;
  struct Group {
    std::size_t first, end;  // of the planned trials
  };
  std::vector<Group> groups_;
  CourseStep step_ = CourseStep::kInformation;
  std::optional<CourseStep> step_after_refresh_;
  std::optional<std::size_t> refresher_;  // a practice trial that is repeated before the next one
  std::size_t learned_ = 0;
  std::size_t rated_ = 0;
  std::vector<bool> has_asked_;    // whether there was a questionnaire after the planned trial
  std::vector<bool> has_started_;  // whether an attempt of it has begun
  std::size_t group_ = 0;
  std::deque<std::size_t> queue_;  // of the group
  std::optional<CourseTrial> running_;
  std::vector<int> attempts_;
};

}  // namespace palpate
