#include "engine/live/live_run.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/live/start_place.h"
#include "engine/live/stroke.h"
#include "engine/recording/recording_settings.h"
#include "engine/recording/sha256.h"
#include "engine/scene/felt_glb.h"
#include "engine/trials/questionnaire_file.h"
#include "engine/viewer/live_words.h"

namespace palpate {
namespace {

using Json = nlohmann::ordered_json;

// Of screens: from a projector to a magnified one.
constexpr NumberRange kPixelRange_per_mm{0.01, 1000.0};
constexpr auto kPatienceAtEnd = std::chrono::milliseconds(500);
// After a longer absence a participant reads the instructions again.
constexpr double kLongAbsence_s = 30.0 * 60.0;
constexpr double kUsualBytesPerTick = 123.0;  // FORMAT.md of recordings: a hand in contact

std::optional<double> seconds_of(const JournalEntry& entry) {
  const auto at = entry.find("at_s");
  if (at == entry.end() || !at->is_number()) return std::nullopt;
  return at->get<double>();
}

double now_s() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

// What a person did, rather than the program or the experimenter.
bool is_of_participant(const JournalEntry& entry) {
  const std::string kind = entry["kind"].get<std::string>();
  const bool is_of_program = kind == "opened" || kind == "refresh" || kind == "note" ||
                             (kind == "end" && entry.value("reason", "") == "server");
  return !is_of_program;
}

std::string hash_of(const std::string& text) {
  return sha256_hex({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

Result<std::vector<Vec3>> find_starts(const ExperimentPlan& plan,
                                      const std::vector<ExperimentScene>& scenes) {
  std::vector<Vec3> starts_m;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const auto start_m = start_place_m(scenes[i].scene, scenes[i].way, plan.trial.sphere_radius_m);
    if (!start_m) {
      Error error = start_m.error();
      error.path = plan.objects[i].path;
      return error;
    }
    starts_m.push_back(*start_m);
  }
  return starts_m;
}

// Why these are not the answers to the questionnaire; no value: they are.
std::optional<std::string> problem_of_ratings(const nlohmann::json& answers) {
  for (const auto& item : answers.items()) {
    const auto& names = kQuestionnaireItemNames;
    if (std::find(names.begin(), names.end(), item.key()) == names.end()) {
      return "answers: has the unknown item \"" + item.key() + "\"";
    }
  }
  for (const auto& level : kQuestionnaireItemLevels) {
    const std::string name(level.name);
    if (!answers.contains(name)) return "answers: lacks " + name;
    const auto value = answers[name].get<std::uint64_t>();
    const QuestionnaireScale scale = scale_of(level.value);
    if (value > 100 || !scale.contains(static_cast<int>(value))) {
      return name + ": is not on its scale";
    }
  }
  return std::nullopt;
}

// UaH on a device that pushes along every axis that it senses would be H.
std::optional<Error> check_masked(const ExperimentPlan& plan) {
  const auto setup = make_setup(plan.device);
  if (!setup) return setup.error();
  const ActuationModel& actuation = setup->actuation;
  if (actuation.actuators() < actuation.sensors()) return std::nullopt;
  for (std::size_t i = 0; i < plan.haptic.size(); ++i) {
    if (force_of(kHapticLevels[plan.haptic[i]].value) != ForceMode::kActuated) continue;
    const std::string name(kHapticNames[plan.haptic[i]]);
    return Error{ErrorCode::kInvalidContent, plan.path, "/haptic/" + std::to_string(i),
                 "is " + name + ", but /device/actuators has every sensed axis, as the full force",
                 "state the axis that UaH leaves: 1 actuator, also for a board with two motors"};
  }
  return std::nullopt;
}

// A misspelt key would leave a word in English.
std::optional<Error> check_words(const ExperimentPlan& plan) {
  const Json known = Json::parse(live_words_json());
  for (const auto& [key, word] : plan.live->words) {
    if (known.contains(key)) continue;
    return Error{ErrorCode::kInvalidContent, plan.path, "/live/words/" + key,
                 "is no word of the participant's page",
                 "engine/viewer/page/live_words.json lists them with their English texts"};
  }
  return std::nullopt;
}

// Empty for a pointer, which reaches everywhere.
Result<std::vector<Box>> find_regions(const ExperimentPlan& plan, const LiveRunSettings& settings,
                                      const std::vector<ExperimentScene>& scenes) {
  std::vector<Box> regions_m;
  for (std::size_t i = 0; settings.board && i < scenes.size(); ++i) {
    const DeviceDescription& device = settings.board->description();
    const auto stroke = find_stroke(plan, scenes[i], settings.participant);
    if (!stroke) return stroke.error();
    const auto misfit =
        check_stroke(*stroke, device, plan, plan.objects[i].name, plan.scale.front());
    if (misfit) return *misfit;
    regions_m.push_back(*start_region(*stroke, device));
  }
  return regions_m;
}

}  // namespace

JournalEntry journal_head(const ExperimentPlan& plan, int participant, bool is_pilot,
                          const std::string& script) {
  return {{"kind", "journal"}, {"format", 1},       {"participant", participant},
          {"plan", plan.name}, {"pilot", is_pilot}, {"script", script}};
}

std::optional<Error> check_live(const ExperimentPlan& plan, int participant) {
  if (!plan.live) {
    return Error{ErrorCode::kInvalidContent, plan.path, "/live",
                 "is missing; expected the texts that a participant reads",
                 "begin with `experiment plan paper-live-mouse`"};
  }
  if (auto error = check_words(plan)) return error;
  if (auto error = check_masked(plan)) return error;
  if (participant >= 1 && participant <= plan.participants) return std::nullopt;
  return invalid_argument("--participant",
                          "is " + std::to_string(participant) + "; expected 1 to " +
                              std::to_string(plan.participants) + ", the participants of the plan");
}

Result<std::vector<ExperimentScene>> load_live_scenes(const ExperimentPlan& plan,
                                                      const TrialFunctions& functions) {
  auto scenes = load_experiment_scenes(plan, functions);
  if (!scenes) return scenes;
  for (ExperimentScene& scene : *scenes) {
    scene.setup = turned_setup(std::move(scene.setup), plan.start_orientation_deg.front());
  }
  return scenes;
}

LiveEstimate estimate_live(const ExperimentPlan& plan) {
  LiveEstimate estimate;
  const double breaks = static_cast<double>(plan.block_numbers().size() - 1) * plan.live->break_s;
  estimate.trials = plan.conditions().size() * plan.block_numbers().size();
  const auto trials = static_cast<double>(estimate.trials);
  estimate.usual_s = trials * LiveEstimate::kUsualTrial_s + breaks;
  estimate.longest_s = trials * plan.trial.limit_s + breaks;
  estimate.usual_bytes =
      trials * LiveEstimate::kUsualTrial_s * plan.device.rate_Hz * kUsualBytesPerTick;
  return estimate;
}

ExperimentPlan plan_for_person(ExperimentPlan plan) {
  if (!plan.followings.empty()) plan.followings.resize(1);
  return plan;
}

CourseSettings course_settings(const ExperimentPlan& plan) {
  return {!plan.live->about.empty(), plan.level_count(), plan.live->has_questionnaire};
}

Result<std::unique_ptr<LiveRun>> LiveRun::open(ExperimentPlan plan,
                                               const LiveRunSettings& settings) {
  if (auto error = check_live(plan, settings.participant)) return *error;
  auto scenes = load_live_scenes(plan, {find_trial_way, palpate::run_trial});
  if (!scenes) return scenes.error();
  auto starts_m = find_starts(plan, *scenes);
  if (!starts_m) return starts_m.error();
  auto regions_m = find_regions(plan, settings, *scenes);
  if (!regions_m) return regions_m.error();
  if (settings.check_scenes) {
    if (auto error = settings.check_scenes(*scenes)) return *error;
  }
  auto folder = LiveFolder::open(settings.folder, plan);
  if (!folder) return folder.error();
  if (auto error = folder->add_participant(settings.participant)) return *error;
  auto journal = Journal::open(folder->journal_path(settings.participant),
                               journal_head(plan, settings.participant, settings.is_pilot, {}));
  if (!journal) return journal.error();
  Course course(planned_trials(plan, settings.participant), course_settings(plan));
  std::unique_ptr<LiveRun> run(new LiveRun(
      std::move(plan), settings, std::move(*scenes), std::move(*starts_m), std::move(*regions_m),
      std::move(*folder), std::move(*journal), std::move(course)));
  if (auto error = run->begin()) return *error;
  run->announce();  // a page may come before run()
  return run;
}

LiveRun::LiveRun(ExperimentPlan plan, const LiveRunSettings& settings,
                 std::vector<ExperimentScene> scenes, std::vector<Vec3> starts_m,
                 std::vector<Box> regions_m, LiveFolder folder, Journal journal, Course course)
    : plan_(std::move(plan)),
      settings_(settings),
      scenes_(std::move(scenes)),
      starts_m_(std::move(starts_m)),
      regions_m_(std::move(regions_m)),
      folder_(std::move(folder)),
      journal_(std::move(journal)),
      course_(std::move(course)),
      pages_(plan_.device.rate_Hz, plan_.live->is_blind),
      board_(settings.board ? std::make_unique<KeptDevice>(*settings.board) : nullptr),
      glbs_(scenes_.size()),
      step_since_(Clock::now()) {}

// Adds an entry to the journal, and takes it.
std::optional<Error> LiveRun::note(JournalEntry entry) {
  if (const auto problem = course_.take(entry)) {
    return Error{ErrorCode::kInvalidContent, journal_.path(), entry["kind"].get<std::string>(),
                 *problem, "restore the journal from a backup"};
  }
  count_attempt(entry);
  entry["at"] = utc_now();
  entry["at_s"] = now_s();
  auto error = journal_.add(std::move(entry));
  tell_status();
  return error;
}

// Takes what earlier runs have left.
std::optional<Error> LiveRun::begin() {
  std::optional<double> last_s;
  for (std::size_t i = 0; i < journal_.entries().size(); ++i) {
    const JournalEntry& entry = journal_.entries()[i];
    if (const auto problem = course_.take(entry)) {
      constexpr std::size_t kFirstLine = 2;  // behind the head
      return Error{ErrorCode::kInvalidContent, journal_.path(),
                   "line " + std::to_string(i + kFirstLine), *problem,
                   "restore the journal from a backup"};
    }
    count_attempt(entry);
    if (entry["kind"] == "checked") checked_ = entry;
    take_trip(entry);
    if (is_of_participant(entry)) last_s = seconds_of(entry);
  }
  is_resumed_ = !journal_.entries().empty();
  if (course_.has_ended()) return end_of_course();
  if (auto error = note({{"kind", "opened"}, {"input", settings_.board ? "board" : "pointer"}})) {
    return error;
  }
  is_paused_ = trip_.has_value();
  if (auto error = end_cut_trial()) return error;
  // A clock that was set back says nothing about the absence.
  const double absence_s = last_s ? now_s() - *last_s : 0.0;
  const bool is_among_trials =
      course_.step() >= CourseStep::kTrials && course_.step() <= CourseStep::kBreak;
  if (!is_among_trials || (absence_s >= 0.0 && absence_s < kLongAbsence_s)) return std::nullopt;
  return note({{"kind", "refresh"}, {"absence_s", absence_s}});
}

// A force that was cut in an earlier run waits for the experimenter, too.
void LiveRun::take_trip(const JournalEntry& entry) {
  if (entry["kind"] == "rearm") trip_.reset();
  if (entry["kind"] != "tripped") return;
  const auto name = std::find(kTripReasonNames.begin(), kTripReasonNames.end(),
                              entry.value("reason", std::string()));
  trip_ = name == kTripReasonNames.end() ? TripReason::kNone
                                         : static_cast<TripReason>(name - kTripReasonNames.begin());
}

// Does what was asked for when the course ended, unless it was done then.
Error LiveRun::end_of_course() {
  const std::string name(name_of(course_.step()));
  const auto& entries = journal_.entries();
  const auto stop = std::find_if(entries.rbegin(), entries.rend(),
                                 [](const JournalEntry& entry) { return entry["kind"] == "stop"; });
  if (stop != entries.rend()) forgets_ = !stop->value("keep", true);
  const bool removes = !keeps_data();
  const std::string path = journal_.path();
  if (auto error = put_away()) return *error;
  return {ErrorCode::kInvalidArgument, path, "",
          "has the whole course of this participant: " + name +
              (removes ? "; what was recorded is deleted now, as the participant wanted" : ""),
          "choose another participant"};
}

// At the end: the rows, or nothing if the participant wants it so.
std::optional<Error> LiveRun::put_away() {
  if (course_.step() == CourseStep::kRefused) {
    return folder_.remove_participant(settings_.participant);
  }
  if (!forgets_) return folder_.write_rows(settings_.participant, journal_.entries());
  { const Journal closed = std::move(journal_); }
  return folder_.forget_participant(settings_.participant);
}

// The program was killed in a trial.
std::optional<Error> LiveRun::end_cut_trial() {
  if (!course_.running()) return folder_.write_rows(settings_.participant, journal_.entries());
  const CourseTrial trial = *course_.running();
  LiveColumns live = live_columns();
  live.reason = CutReason::kServer;
  TrialOutcome outcome;
  outcome.status = TrialStatus::kAborted;
  auto error =
      note({{"kind", "end"},
            {"trial", trial.planned},
            {"attempt", trial.attempt},
            {"status", "aborted"},
            {"reason", "server"},
            {"row", live_row_text(plan_, settings_.participant, course_.trials()[trial.planned],
                                  trial.attempt, outcome, live)}});
  if (error) return error;
  return folder_.write_rows(settings_.participant, journal_.entries());
}

std::optional<Error> LiveRun::run(const StopFlag& stop) {
  auto error = lead(stop);
  pages_.set_trial(nullptr);
  pages_.drain(kPatienceAtEnd);
  const auto problem = put_away();
  return error ? error : problem;
}

std::optional<Error> LiveRun::lead(const StopFlag& stop) {
  announce();
  while (!stop.requested() && !course_.has_ended()) {
    const CourseStep before = course_.step();
    std::optional<Error> error;
    if (!is_paused_ && before == CourseStep::kTrials) {
      error = run_trial(stop);
    } else if (!is_paused_ && before == CourseStep::kLearning) {
      error = touch_condition(stop);
    } else if (const auto request = pages_.wait(kLookEvery)) {
      error = handle(*request);
    }
    if (error) return error;
    if (may_go_on() != told_may_go_on_) announce();  // the break is over
    tell_status_when_due();
  }
  return std::nullopt;
}

// The rest of a break; 0 in other steps.
double LiveRun::break_left_s() const {
  if (course_.step() != CourseStep::kBreak) return 0.0;
  const double passed_s = std::chrono::duration<double>(Clock::now() - step_since_).count();
  return std::max(0.0, std::ceil(plan_.live->break_s - passed_s));
}

// As the pages name the step.
std::string LiveRun::step_name() const {
  if (is_paused_) return "paused";
  if (course_.step() != CourseStep::kTrials) return std::string(name_of(course_.step()));
  return course_.trials()[course_.next().planned].block == 0 ? "practice" : "block";
}

// What the participant's page shows of the step.
Json LiveRun::step_json() const {
  const CourseStep step = course_.step();
  const LivePlan& live = *plan_.live;
  Json json = {{"type", "step"}, {"step", step_name()}};
  json["text"] = step == CourseStep::kInformation    ? live.text(LiveText::kInformation)
                 : step == CourseStep::kConsent      ? live.text(LiveText::kConsent)
                 : step == CourseStep::kInstructions ? live.text(LiveText::kInstructions)
                 : step == CourseStep::kDebriefing   ? live.text(LiveText::kDebriefing)
                                                     : std::string();
  json["number"] = course_.block();
  json["of"] = plan_.blocks;
  json["remaining_s"] = nullptr;
  if (step == CourseStep::kBreak) json["remaining_s"] = break_left_s();
  json["may_go_on"] = may_go_on();
  if (step == CourseStep::kAbout) json["about"] = live.about;
  return json;
}

Json LiveRun::display_json() const {
  return {{"Hz", plan_.trial.display_Hz},
          {"scale", plan_.live->scale},
          {"sphere_radius_m", plan_.trial.sphere_radius_m},
          {"proxy_radius_m", plan_.device.haptics.god_object.radius_m}};
}

// Tells the pages where the course is.
void LiveRun::announce() {
  if (course_.step() != step_of_since_) {
    step_of_since_ = course_.step();
    step_since_ = Clock::now();
  }
  announced_ = step_name();
  told_may_go_on_ = may_go_on();
  const LivePlan& live = *plan_.live;
  const Json step = step_json();
  Json hello = {{"type", "hello"},
                {"role", "participant"},
                {"version", kViewVersion},
                {"engine", engine_version()},
                {"is_script", false},
                {"language", live.language},
                {"direction", live.is_right_to_left ? "rtl" : "ltr"},
                {"words", live.words},
                {"display", display_json()},
                {"inputs", settings_.board ? Json{"board"} : Json{"mouse", "pen", "touch"}},
                {"rate_Hz", plan_.device.rate_Hz},
                {"clutch", live.permits_clutch},
                {"checked", checked_},
                {"step", step}};
  pages_.set_hello(kParticipantPage, hello);
  pages_.send(kParticipantPage, step);
  tell_status();
}

// A message of a page while no trial runs.
std::optional<Error> LiveRun::handle(const LiveRequest& request) {
  const std::string& type = request.type;
  if (course_.has_ended()) {  // such as a second click on Stop
    pages_.answer(request, "the course has ended");
    return std::nullopt;
  }
  if (type == "next") return go_on_from(request);
  if (type == "consent") return take_consent(request);
  if (type == "about") return take_about(request);
  if (type == "rated") return take_rating(request);
  if (type == "checked") return take_check(request);
  if (type == "stop") return take_stop(request);
  if (type == "skip") return skip_next(request);
  if (type == "repeat") return repeat_last(request);
  if (type == "note") return answered(request, {{"kind", "note"}, {"text", request.body["text"]}});
  if (type == "pause" || type == "go_on") return pause_or_go_on(request);
  if (type == "rearm") return rearm(request);
  const bool is_late = type == "left" || type == "frames";  // of a trial that has ended
  pages_.answer(request, is_late ? std::nullopt : std::optional<std::string>("no trial runs"));
  return std::nullopt;
}

std::optional<Error> LiveRun::pause_or_go_on(const LiveRequest& request) {
  const bool pauses = request.type == "pause";
  if (!pauses && trip_) {
    pages_.answer(request, "the force was cut, and the experimenter has to rearm first");
    return std::nullopt;
  }
  if (is_paused_ == pauses) return pages_.answer(request, std::nullopt), std::nullopt;
  is_paused_ = pauses;
  const bool is_participant = request.role == kParticipantPage;
  return answered(
      request, {{"kind", request.type}, {"by", is_participant ? "participant" : "experimenter"}});
}

// After a trip nobody is pushed again before the experimenter has looked.
std::optional<Error> LiveRun::hold_after_trip(const PersonTrial& person) {
  if (course_.has_ended()) return std::nullopt;
  trip_ = person.trip().value_or(TripReason::kNone);
  is_paused_ = true;
  const auto reason = kTripReasonNames[static_cast<std::size_t>(*trip_)];
  auto error = note({{"kind", "tripped"}, {"reason", reason}});
  announce();
  return error;
}

std::optional<Error> LiveRun::rearm(const LiveRequest& request) {
  if (!trip_) {
    pages_.answer(request, "rearm: the force was not cut");
    return std::nullopt;
  }
  trip_.reset();
  return answered(request, {{"kind", "rearm"}});
}

// Takes an entry that a page asked for, and answers the page.
std::optional<Error> LiveRun::answered(const LiveRequest& request, JournalEntry entry) {
  if (auto error = note(std::move(entry))) {
    pages_.answer(request, error->problem);
    return error;
  }
  pages_.answer(request, std::nullopt);
  // A step that is told again would end the trial that the page shows.
  if (step_name() != announced_) announce();
  return std::nullopt;
}

std::optional<Error> LiveRun::go_on_from(const LiveRequest& request) {
  const JournalEntry entry = {{"kind", "next"}, {"step", request.body["step"]}};
  const Json step = step_json();
  const bool is_here = request.body["step"] == std::string(name_of(course_.step()));
  Course tried = course_;
  if (is_paused_ || !is_here || !step["may_go_on"].get<bool>() || tried.take(entry)) {
    pages_.answer(request, "the course is at another step, or the break is not over");
    return std::nullopt;
  }
  return answered(request, entry);
}

std::optional<Error> LiveRun::take_consent(const LiveRequest& request) {
  if (course_.step() != CourseStep::kConsent) {
    pages_.answer(request, "the course is at another step");
    return std::nullopt;
  }
  return answered(request,
                  {{"kind", "consent"},
                   {"value", request.body["value"]},
                   {"information_sha256", hash_of(plan_.live->text(LiveText::kInformation))},
                   {"consent_sha256", hash_of(plan_.live->text(LiveText::kConsent))}});
}

// What a participant says about themselves is in a file of its own.
std::optional<Error> LiveRun::take_about(const LiveRequest& request) {
  const auto& asked = plan_.live->about;
  Json answers = Json::object();
  bool is_asked = course_.step() == CourseStep::kAbout;
  for (const auto& item : request.body["answers"].items()) {
    is_asked = is_asked && std::find(asked.begin(), asked.end(), item.key()) != asked.end();
    answers[item.key()] = item.value();
  }
  if (!is_asked) {
    pages_.answer(request, "the plan does not ask this here");
    return std::nullopt;
  }
  if (auto error = write_synced(folder_.about_path(settings_.participant), answers.dump() + "\n")) {
    return error;
  }
  return answered(request, {{"kind", "about"}});
}

std::optional<Error> LiveRun::take_rating(const LiveRequest& request) {
  const auto& answers = request.body["answers"];
  auto problem = problem_of_ratings(answers);
  if (is_paused_ || course_.step() != CourseStep::kQuestionnaire) {
    problem = "the course is at another step";
  }
  if (problem) return pages_.answer(request, problem), std::nullopt;
  const PlanCondition& condition = course_.trials()[course_.rated()].condition;
  JournalEntry entry = {{"kind", "rated"},
                        {"trial", course_.rated()},
                        {"block", course_.block()},
                        {"condition", plan_.level_name(condition)},
                        {"haptic", kHapticNames[condition.haptic]},
                        {"rotation", kRotationNames[condition.rotation]},
                        {"pilot", settings_.is_pilot},
                        {"answers", Json(answers)}};
  if (auto error = answered(request, std::move(entry))) return error;
  return folder_.write_rows(settings_.participant, journal_.entries());
}

// Whether the page was offered this input.
bool LiveRun::is_offered(const std::string& input) const {
  return (input == kLiveInputNames[static_cast<std::size_t>(LiveInput::kBoard)]) ==
         (settings_.board != nullptr);
}

std::optional<Error> LiveRun::take_check(const LiveRequest& request) {
  const auto& body = request.body;
  const auto is_one_of = [](const auto& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  const bool is_known = is_one_of(kLiveInputNames, body["input"].get<std::string>()) &&
                        body["input"] != "script" &&
                        is_one_of(kPointerMotionNames, body["motion"].get<std::string>()) &&
                        is_offered(body["input"].get<std::string>()) &&
                        kPixelRange_per_mm.contains(body["css_px_per_mm"].get<double>());
  if (!is_known || course_.step() < CourseStep::kCheck) {
    pages_.answer(request, "checked: is not what the input check finds, or comes too early");
    return std::nullopt;
  }
  JournalEntry entry = {{"kind", "checked"}};
  for (const auto& item : body.items()) {
    if (item.key() != "type" && item.key() != "id") entry[item.key()] = item.value();
  }
  checked_ = entry;
  return answered(request, std::move(entry));
}

// The person ends the participation, and says whether the data are kept.
std::optional<Error> LiveRun::take_stop(const LiveRequest& request) {
  const bool is_kept = request.body["keep"].get<bool>();
  if (auto error = answered(request, {{"kind", "stop"}, {"keep", is_kept}})) return error;
  forgets_ = !is_kept;
  return std::nullopt;
}

// Whether the trial that a request names is the one that runs, or is next.
bool LiveRun::names_next(const LiveRequest& request) const {
  if (course_.step() != CourseStep::kTrials) return false;
  const CourseTrial next = course_.next();
  const PlannedTrial& planned = course_.trials()[next.planned];
  return request.body["block"] == planned.block && request.body["place"] == planned.trial &&
         request.body["attempt"] == next.attempt;
}

std::optional<Error> LiveRun::skip_next(const LiveRequest& request) {
  if (!names_next(request)) {
    pages_.answer(request, "another trial is next now, or none");
    return std::nullopt;
  }
  const CourseTrial next = course_.next();
  LiveColumns live = live_columns();
  live.reason = CutReason::kExperimenter;
  TrialOutcome outcome;
  outcome.status = TrialStatus::kSkipped;
  JournalEntry entry = {
      {"kind", "skip"},
      {"trial", next.planned},
      {"row", live_row_text(plan_, settings_.participant, course_.trials()[next.planned],
                            next.attempt, outcome, live)}};
  if (auto error = answered(request, std::move(entry))) return error;
  return folder_.write_rows(settings_.participant, journal_.entries());
}

// The trial that runs, or has ended last, comes again at the end of its block.
std::optional<Error> LiveRun::repeat_last(const LiveRequest& request) {
  std::optional<std::size_t> planned = last_trial_;
  if (course_.running()) planned = course_.running()->planned;
  const JournalEntry entry = {{"kind", "repeat"}, {"trial", planned.value_or(0)}};
  Course tried = course_;
  if (!planned || tried.take(entry)) {
    pages_.answer(request, "repeat: no trial of this block has ended");
    return std::nullopt;
  }
  return answered(request, entry);
}

LiveColumns LiveRun::live_columns() const {
  LiveColumns live;
  live.pilot = settings_.is_pilot ? 1 : 0;
  if (settings_.board) live.input = LiveInput::kBoard;
  if (!checked_.is_object()) return live;
  const auto place_of = [](const auto& names, const std::string& name) {
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  };
  if (!settings_.board) {
    live.input = static_cast<LiveInput>(
        place_of(kLiveInputNames, checked_.value("input", std::string(kLiveInputNames[0]))));
    live.motion = static_cast<PointerMotion>(place_of(
        kPointerMotionNames, checked_.value("motion", std::string(kPointerMotionNames[2]))));
  }
  live.css_px_per_mm = checked_.value("css_px_per_mm", 0.0);
  return live;
}

}  // namespace palpate
