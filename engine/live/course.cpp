#include "engine/live/course.h"

#include <array>
#include <utility>

#include "engine/trials/levels.h"

namespace palpate {
namespace {

constexpr std::array<std::string_view, 13> kStepNames = {
    "information",   "consent", "check",      "instructions", "about",   "learning", "trials",
    "questionnaire", "break",   "debriefing", "done",         "refused", "stopped"};

std::string text_in(const JournalEntry& entry, const char* key) {
  const auto found = entry.find(key);
  return found != entry.end() && found->is_string() ? found->get<std::string>() : std::string();
}

std::optional<std::size_t> number_in(const JournalEntry& entry, const char* key) {
  const auto found = entry.find(key);
  if (found == entry.end() || !found->is_number_integer()) return std::nullopt;
  const auto number = found->get<std::int64_t>();  // one of this program may be signed
  if (number < 0) return std::nullopt;
  return static_cast<std::size_t>(number);
}

bool are_of_one_group(const PlannedTrial& a, const PlannedTrial& b) {
  return a.block == b.block && a.following == b.following && a.variant.view == b.variant.view &&
         a.variant.start == b.variant.start && a.variant.scale == b.variant.scale;
}

bool are_of_one_condition(const PlannedTrial& a, const PlannedTrial& b) {
  return a.condition.haptic == b.condition.haptic && a.condition.rotation == b.condition.rotation;
}

}  // namespace

std::string_view name_of(CourseStep step) {
  return kStepNames[static_cast<std::size_t>(step)];
}

Course::Course(std::vector<PlannedTrial> trials, const CourseSettings& settings)
    : trials_(std::move(trials)),
      settings_(settings),
      has_asked_(trials_.size(), false),
      has_started_(trials_.size(), false),
      attempts_(trials_.size(), 0) {
  for (std::size_t i = 0; i < trials_.size(); ++i) {
    if (i == 0 || !are_of_one_group(trials_[i - 1], trials_[i])) groups_.push_back({i, i});
    groups_.back().end = i + 1;
  }
  begin_group();
}

void Course::begin_group() {
  queue_.clear();
  for (std::size_t i = groups_[group_].first; i < groups_[group_].end; ++i) queue_.push_back(i);
}

CourseTrial Course::next() const {
  if (running_) return *running_;
  const std::size_t planned = refresher_       ? *refresher_
                              : queue_.empty() ? groups_[group_].end - 1
                                               : queue_.front();
  return {planned, attempts_[planned] + 1};
}

int Course::block() const {
  return trials_[step_ == CourseStep::kQuestionnaire ? rated_ : next().planned].block;
}

std::size_t Course::trials_left() const {
  std::size_t left = queue_.size();
  for (std::size_t g = group_ + 1; g < groups_.size(); ++g) {
    left += groups_[g].end - groups_[g].first;
  }
  return left;
}

std::optional<std::string> Course::take(const JournalEntry& entry) {
  const std::string kind = text_in(entry, "kind");
  const std::string at = std::string(name_of(step_));
  bool fits = true;
  if (kind == "next") {
    fits = take_next(entry);
  } else if (kind == "consent") {
    fits = step_ == CourseStep::kConsent && entry.contains("value") && entry["value"].is_boolean();
    if (fits) step_ = entry["value"].get<bool>() ? CourseStep::kCheck : CourseStep::kRefused;
  } else if (kind == "checked") {
    // A page that is loaded again is checked again.
    fits = step_ >= CourseStep::kCheck && !has_ended();
    if (step_ == CourseStep::kCheck) step_ = CourseStep::kInstructions;
  } else if (kind == "about") {
    fits = step_ == CourseStep::kAbout;
    if (fits) go_to_trials();
  } else if (kind == "learned") {
    fits = step_ == CourseStep::kLearning;
    if (fits && ++learned_ == settings_.learning_conditions) step_ = CourseStep::kTrials;
  } else if (kind == "start") {
    fits = take_start(entry);
  } else if (kind == "end") {
    fits = take_end(entry);
  } else if (kind == "skip") {
    fits = take_skip(entry);
  } else if (kind == "repeat") {
    fits = take_repeat(entry);
  } else if (kind == "rated") {
    fits = take_rated(entry);
  } else if (kind == "refresh") {
    fits = take_refresh();
  } else if (kind == "stop") {
    fits = !has_ended();
    if (fits) step_ = step_ <= CourseStep::kConsent ? CourseStep::kRefused : CourseStep::kStopped;
  }
  if (fits) return std::nullopt;
  return "does not follow in the step " + at;
}

// From the last step before the trials.
void Course::go_to_trials() {
  step_ = settings_.learning_conditions > learned_ ? CourseStep::kLearning : CourseStep::kTrials;
}

bool Course::take_next(const JournalEntry& entry) {
  if (text_in(entry, "step") != name_of(step_)) return false;
  switch (step_) {
    case CourseStep::kInformation:
      step_ = CourseStep::kConsent;
      return true;
    case CourseStep::kInstructions:
      if (step_after_refresh_) {
        step_ = *std::exchange(step_after_refresh_, std::nullopt);
      } else if (settings_.asks_about) {
        step_ = CourseStep::kAbout;
      } else {
        go_to_trials();
      }
      return true;
    case CourseStep::kBreak:
      step_ = CourseStep::kTrials;
      return true;
    case CourseStep::kDebriefing:
      step_ = CourseStep::kDone;
      return true;
    default:
      return false;
  }
}

bool Course::is_next(const JournalEntry& entry) const {
  const auto trial = number_in(entry, "trial");
  return step_ == CourseStep::kTrials && trial && *trial == next().planned;
}

bool Course::take_start(const JournalEntry& entry) {
  const CourseTrial trial = step_ == CourseStep::kTrials ? next() : CourseTrial{};
  const auto attempt = number_in(entry, "attempt");
  if (running_ || !is_next(entry) || !attempt ||
      *attempt != static_cast<std::size_t>(trial.attempt))
    return false;
  running_ = trial;
  ++attempts_[trial.planned];
  has_started_[trial.planned] = true;
  return true;
}

bool Course::take_end(const JournalEntry& entry) {
  const auto attempt = number_in(entry, "attempt");
  if (!running_ || !is_next(entry) || !attempt ||
      *attempt != static_cast<std::size_t>(running_->attempt)) {
    return false;
  }
  running_.reset();
  leave_trial(text_in(entry, "status") == "aborted");
  return true;
}

bool Course::take_skip(const JournalEntry& entry) {
  if (running_ || !is_next(entry)) return false;
  ++attempts_[next().planned];
  leave_trial(false);
  return true;
}

void Course::leave_trial(bool repeats) {
  if (refresher_) {
    if (!repeats) refresher_.reset();
    return;
  }
  const std::size_t planned = queue_.front();
  queue_.pop_front();
  if (repeats) queue_.push_back(planned);
  if (wants_rating(planned)) {
    has_asked_[planned] = true;
    rated_ = planned;
    step_ = CourseStep::kQuestionnaire;
    return;
  }
  end_group_if_empty();
}

// Whether the condition of this trial, which has just been left, is rated now.
bool Course::wants_rating(std::size_t planned) const {
  const Group& group = groups_[group_];
  const bool is_last =
      planned + 1 == group.end || !are_of_one_condition(trials_[planned], trials_[planned + 1]);
  if (!settings_.has_questionnaire || trials_[planned].block == 0 || !is_last ||
      has_asked_[planned]) {
    return false;
  }
  for (std::size_t i = planned + 1; i-- > group.first;) {
    if (!are_of_one_condition(trials_[planned], trials_[i])) return false;
    if (has_started_[i]) return true;
  }
  return false;
}

bool Course::take_rated(const JournalEntry& entry) {
  const auto trial = number_in(entry, "trial");
  if (step_ != CourseStep::kQuestionnaire || !trial || *trial != rated_) return false;
  step_ = CourseStep::kTrials;
  end_group_if_empty();
  return true;
}

void Course::end_group_if_empty() {
  if (!queue_.empty()) return;
  if (group_ + 1 == groups_.size()) {
    step_ = CourseStep::kDebriefing;
    return;
  }
  ++group_;
  begin_group();
  step_ = CourseStep::kBreak;
}

bool Course::take_repeat(const JournalEntry& entry) {
  const auto trial = number_in(entry, "trial");
  const Group& group = groups_[group_];
  const bool is_in_block = step_ == CourseStep::kTrials || step_ == CourseStep::kQuestionnaire;
  if (!is_in_block || !trial || *trial < group.first || *trial >= group.end) return false;
  queue_.push_back(*trial);
  return true;
}

bool Course::take_refresh() {
  const bool is_among_trials = step_ >= CourseStep::kTrials && step_ <= CourseStep::kBreak;
  if (running_ || !is_among_trials) return false;
  step_after_refresh_ = step_;
  step_ = CourseStep::kInstructions;
  if (trials_.front().block == 0) refresher_ = 0;
  return true;
}

}  // namespace palpate
