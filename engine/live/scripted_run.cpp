#include "engine/live/scripted_run.h"

#include <utility>
#include <vector>

#include "engine/live/course.h"
#include "engine/live/live_folder.h"
#include "engine/live/live_row.h"
#include "engine/live/live_run.h"

namespace palpate {
namespace {

// A simulated person rates nothing.
CourseSettings settings_of(const ExperimentPlan& plan) {
  CourseSettings settings = course_settings(plan);
  settings.has_questionnaire = false;
  return settings;
}

class ScriptedRun {
 public:
  ScriptedRun(const ExperimentPlan& plan, const ScriptSettings& settings,
              const TrialFunctions& functions, std::vector<ExperimentScene> scenes,
              LiveFolder folder, Journal journal)
      : plan_(plan),
        settings_(settings),
        functions_(functions),
        scenes_(std::move(scenes)),
        folder_(std::move(folder)),
        journal_(std::move(journal)),
        course_(planned_trials(plan, settings.participant), settings_of(plan)),
        person_(draw_person(plan.person, plan.seed, settings.participant)) {}

  // Takes what an earlier run has left. A trial that it was killed in begins again.
  std::optional<Error> begin() {
    for (const JournalEntry& entry : journal_.entries()) {
      if (const auto problem = course_.take(entry)) {
        return Error{ErrorCode::kInvalidContent, journal_.path(), "", *problem,
                     "restore the journal from a backup"};
      }
    }
    return std::nullopt;
  }

  bool is_over() const { return course_.has_ended(); }
  std::size_t trial_count() const { return course_.trials().size(); }
  std::size_t trials_left() const {
    return course_.step() < CourseStep::kDebriefing ? course_.trials_left() : 0;
  }

  // Takes the next step of the course.
  std::optional<Error> advance() {
    switch (course_.step()) {
      case CourseStep::kConsent:
        return note({{"kind", "consent"}, {"value", true}});
      case CourseStep::kCheck:
        return note({{"kind", "checked"}, {"input", "script"}});
      case CourseStep::kAbout:
        return note({{"kind", "about"}});
      case CourseStep::kLearning:
        return note({{"kind", "learned"}, {"condition", course_.learned()}, {"length_s", 0}});
      case CourseStep::kTrials:
        return run_trial();
      default:
        return note({{"kind", "next"}, {"step", name_of(course_.step())}});
    }
  }

  std::optional<Error> write_rows() const {
    return folder_.write_rows(settings_.participant, journal_.entries());
  }

 private:
  std::optional<Error> note(JournalEntry entry) {
    if (const auto problem = course_.take(entry)) {
      return Error{ErrorCode::kInvalidContent, journal_.path(), "", *problem, ""};
    }
    return journal_.add(std::move(entry));
  }

  // Simulated time has no interruption: a trial is in the journal when it has ended.
  std::optional<Error> run_trial() {
    const CourseTrial next = course_.next();
    const PlannedTrial& planned = course_.trials()[next.planned];
    const ExperimentScene& scene =
        scenes_[scene_index(plan_, planned.variant, planned.condition.object)];
    const auto outcome = functions_.run(scene.scene, scene.way, scene.setup, plan_.trial,
                                        person_in_block(person_, plan_, planned.block),
                                        conditions_of(plan_, settings_.participant, planned), {});
    if (!outcome) return outcome.error();
    if (!course_.running()) {
      const JournalEntry start = {
          {"kind", "start"}, {"trial", next.planned}, {"attempt", next.attempt}};
      if (auto error = note(start)) return error;
    }
    LiveColumns live;
    live.pilot = settings_.is_pilot ? 1 : 0;
    live.input = LiveInput::kScript;
    return note({{"kind", "end"},
                 {"trial", next.planned},
                 {"attempt", next.attempt},
                 {"status", kTrialStatusNames[static_cast<std::size_t>(outcome->status)]},
                 {"row", live_row_text(plan_, settings_.participant, planned, next.attempt,
                                       *outcome, live)}});
  }

  const ExperimentPlan& plan_;
  const ScriptSettings& settings_;
  const TrialFunctions& functions_;
  std::vector<ExperimentScene> scenes_;
  LiveFolder folder_;
  Journal journal_;
  Course course_;
  OperatorParameters person_;
};

}  // namespace

Result<bool> run_script(const ExperimentPlan& plan, const ScriptSettings& settings,
                        const TrialFunctions& functions,
                        const std::function<void(std::size_t, std::size_t)>& progress,
                        const StopFlag& stop) {
  if (auto error = check_live(plan, settings.participant)) return *error;
  auto scenes = load_live_scenes(plan, functions);
  if (!scenes) return scenes.error();
  if (auto error = check_persons(plan, scenes->front().setup)) return *error;
  auto folder = LiveFolder::open(settings.folder, plan);
  if (!folder) return folder.error();
  if (auto error = folder->add_participant(settings.participant)) return *error;
  auto journal =
      Journal::open(folder->journal_path(settings.participant),
                    journal_head(plan, settings.participant, settings.is_pilot, plan.person.name));
  if (!journal) return journal.error();
  ScriptedRun run(plan, settings, functions, std::move(*scenes), std::move(*folder),
                  std::move(*journal));
  if (auto error = run.begin()) return *error;
  while (!run.is_over() && !stop.requested()) {
    if (auto error = run.advance()) return *error;
    if (progress) progress(run.trial_count() - run.trials_left(), run.trial_count());
  }
  if (auto error = run.write_rows()) return *error;
  return run.is_over();
}

}  // namespace palpate
