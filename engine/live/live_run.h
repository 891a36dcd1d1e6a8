#pragma once

// Leads one participant through an experiment: `palpate experiment live`.

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "engine/devices/guardable_device.h"
#include "engine/live/course.h"
#include "engine/live/kept_device.h"
#include "engine/live/live_folder.h"
#include "engine/live/live_pages.h"
#include "engine/live/live_row.h"
#include "engine/recording/recorder.h"
#include "engine/session/stop_flag.h"
#include "engine/trials/experiment_scene.h"
#include "engine/trials/plan.h"

namespace palpate {

struct LiveRunSettings {
  int participant = 1;
  std::string folder = "experiment";
  bool is_pilot = false;
  std::optional<int> cpu = {};       // see HapticThreadSettings
  GuardableDevice* board = nullptr;  // null: a pointer of the page; it must outlive the run
  bool has_guard = true;             // of the board: see GuardedRunSettings
  bool without_realtime = false;     // as well
  // Gets one line for each privilege that the system refuses to a trial, once; may be empty.
  std::function<void(const std::string&)> warn = {};
  // Called with the scenes before anything is written; may be empty.
  std::function<std::optional<Error>(const std::vector<ExperimentScene>&)> check_scenes = {};
};

// What a plan takes of a participant and of the disk.
struct LiveEstimate {
  std::size_t trials = 0;
  double usual_s = 0.0;    // with kUsualTrial_s a trial, and the breaks
  double longest_s = 0.0;  // if every trial takes its time limit
  double usual_bytes = 0.0;
  // The paper's mean total times lie between 13 and 15 s; a trial begins by itself after a few.
  static constexpr double kUsualTrial_s = 20.0;
};
LiveEstimate estimate_live(const ExperimentPlan& plan);

// An error if the plan has no `live`, or not this participant.
std::optional<Error> check_live(const ExperimentPlan& plan, int participant);
// The scenes of a plan with a `live`, which has one orientation: their setups are turned to it.
Result<std::vector<ExperimentScene>> load_live_scenes(const ExperimentPlan& plan,
                                                      const TrialFunctions& functions);
// The first entry of a journal. script: the name of the simulated person; empty: a person.
JournalEntry journal_head(const ExperimentPlan& plan, int participant, bool is_pilot,
                          const std::string& script);

// The plan as a person takes part in it: with one following, which a person has of their own.
ExperimentPlan plan_for_person(ExperimentPlan plan);
CourseSettings course_settings(const ExperimentPlan& plan);

// The course, what the participant does, and the files. One thread, which may wait, owns an object
// and calls its functions.
class LiveRun {
 public:
  // Reads the scenes and opens the folder and the journal. plan: with a `live`, and from
  // plan_for_person(). Errors: those of load_experiment_scenes(), start_place_m(),
  // LiveFolder::open() and Journal::open(); the plan has no `live`, or not this participant; the
  // journal ends the course already.
  static Result<std::unique_ptr<LiveRun>> open(ExperimentPlan plan,
                                               const LiveRunSettings& settings);

  LivePages& pages() { return pages_; }
  const Course& course() const { return course_; }
  const std::vector<ExperimentScene>& scenes() const { return scenes_; }
  // An earlier run of this participant has left entries.
  bool is_resumed() const { return is_resumed_; }

  // What this participant did is kept: they have neither refused nor asked to delete it.
  bool keeps_data() const { return !forgets_ && course_.step() != CourseStep::kRefused; }

  // Leads the participant to the end of the course, or until `stop` is requested, which ends a
  // trial that runs. Errors: the journal or a recording cannot be written; a device does not start.
  // What was finished is then on the disk.
  std::optional<Error> run(const StopFlag& stop);

 private:
  using Clock = std::chrono::steady_clock;
  using Json = nlohmann::ordered_json;
  struct Trial;  // one that runs

  static constexpr auto kLookEvery = std::chrono::milliseconds(50);  // for requests, between trials

  LiveRun(ExperimentPlan plan, const LiveRunSettings& settings, std::vector<ExperimentScene> scenes,
          std::vector<Vec3> starts_m, std::vector<Box> regions_m, LiveFolder folder,
          Journal journal, Course course);

  std::optional<Error> note(JournalEntry entry);
  std::optional<Error> begin();
  std::optional<Error> end_cut_trial();
  std::optional<Error> lead(const StopFlag& stop);
  void count_attempt(const JournalEntry& entry);
  void announce();
  std::string step_name() const;
  double break_left_s() const;
  bool may_go_on() const { return break_left_s() == 0.0; }
  Error end_of_course();
  void take_trip(const JournalEntry& entry);
  std::optional<Error> put_away();
  Json step_json() const;
  Json display_json() const;
  void tell_status();
  void tell_status_when_due();
  Json experimenter_status();
  void add_next_trial(Json& status) const;
  void send_to_all(const Json& json);

  std::optional<Error> handle(const LiveRequest& request);
  std::optional<Error> go_on_from(const LiveRequest& request);
  std::optional<Error> take_consent(const LiveRequest& request);
  std::optional<Error> take_about(const LiveRequest& request);
  std::optional<Error> take_rating(const LiveRequest& request);
  std::optional<Error> take_check(const LiveRequest& request);
  bool is_offered(const std::string& input) const;
  std::optional<Error> take_stop(const LiveRequest& request);
  bool names_next(const LiveRequest& request) const;
  std::optional<Error> skip_next(const LiveRequest& request);
  std::optional<Error> repeat_last(const LiveRequest& request);
  std::optional<Error> pause_or_go_on(const LiveRequest& request);
  std::optional<Error> rearm(const LiveRequest& request);
  std::optional<Error> hold_after_trip(const PersonTrial& person);
  std::optional<Error> answered(const LiveRequest& request, JournalEntry entry);

  std::optional<Error> touch_condition(const StopFlag& stop);
  std::optional<Error> run_trial(const StopFlag& stop);
  Result<bool> wait_until_ready(std::size_t scene, const char* step, std::size_t number,
                                const StopFlag& stop);
  Result<bool> lead_to_start(std::size_t scene, PersonTrialSettings& settings,
                             const StopFlag& stop);
  std::optional<Error> show_scene(std::size_t scene, const char* step, std::size_t number);
  PersonTrialSettings trial_settings(const PlannedTrial& planned) const;
  Result<std::unique_ptr<Recorder>> make_recorder(const PlannedTrial& planned,
                                                  const PersonTrialSettings& settings,
                                                  const std::string& path) const;
  std::optional<Error> follow(Trial& trial, const StopFlag& stop);
  void take_pictures(Trial& trial, const LiveRequest& request);
  void take_last_pictures(Trial& trial);
  std::optional<CutReason> reason_to_cut(Trial& trial, const LiveRequest& request);
  void show_ring(Trial& trial);
  std::optional<Error> pause_if_always_late(const Trial& trial);
  void tell_warnings(const PersonTrial& person);
  bool answer_again(const LiveRequest& request);
  std::optional<Error> carry_out_after_trial(const LiveRequest& request);
  std::optional<Error> finish(Trial& trial);
  LiveColumns live_columns() const;

  ExperimentPlan plan_;
  LiveRunSettings settings_;
  std::vector<ExperimentScene> scenes_;
  std::vector<Vec3> starts_m_;  // of each scene, scene frame
  std::vector<Box> regions_m_;  // of each scene: where a trial on a board may begin, device frame
  LiveFolder folder_;
  Journal journal_;
  Course course_;
  LivePages pages_;
  std::unique_ptr<KeptDevice> board_;  // null: a pointer
  bool is_resumed_ = false;
  bool is_paused_ = false;
  std::optional<TripReason> trip_;  // the force was cut, and nobody has rearmed
  bool forgets_ = false;            // the participant wants no data to be kept
  std::vector<std::shared_ptr<const std::string>> glbs_;  // of each scene, once it was shown
  Clock::time_point step_since_;
  Clock::time_point told_;
  CourseStep step_of_since_ = CourseStep::kInformation;
  bool told_may_go_on_ = true;
  std::string announced_;  // the name of the step that the participant's page shows
  std::array<std::size_t, kTrialStatusNames.size()> attempts_by_status_ = {};
  Json last_attempt_;                      // for the experimenter; null: none has ended
  Json shown_trial_;                       // the newest `trial` message; null: none was sent
  std::optional<double> picture_rate_Hz_;  // at the participant's page, in the trial that runs
  std::optional<std::size_t> last_trial_;  // the planned one that this run has ended last
  std::set<std::string> told_warnings_;
  int late_in_row_ = 0;           // attempts that the computer has cut, since one that it has not
  std::size_t trial_number_ = 0;  // of the `trial` messages of this run
  JournalEntry checked_;          // the newest input check; null: none
};

}  // namespace palpate
