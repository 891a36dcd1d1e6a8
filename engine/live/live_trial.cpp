// The trials of LiveRun.

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <fcntl.h>
#include <filesystem>
#include <system_error>
#include <unistd.h>
#include <utility>

#include "engine/live/live_run.h"
#include "engine/recording/recording_settings.h"
#include "engine/report/write_error.h"
#include "engine/scene/felt_glb.h"
#include "engine/simulation/hand_path.h"
#include "haptics/record_vectors.h"

namespace palpate {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

constexpr auto kLookInTrialEvery = std::chrono::milliseconds(2);
// A page that draws reports its pictures four times a second. Without a report for this time more
// than the longest time between two pictures, it draws none.
constexpr double kReportPatience_s = 1.0;
constexpr auto kLastReport = std::chrono::milliseconds(300);  // after trial_end
// A computer that is too slow for the plan would repeat its trials for ever.
constexpr int kMostLateInRow = 3;
constexpr double kMostBytesPerTick = 400.0;  // more than a recording takes at rest or in contact

double seconds_since(std::chrono::steady_clock::time_point time) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - time).count();
}

// Whether the disk has this much space: the file is made and removed.
std::optional<Error> check_space(const std::string& path, double bytes) {
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (descriptor < 0) return write_error(path, errno);
  const int reason = ::posix_fallocate(descriptor, 0, static_cast<off_t>(bytes));
  ::close(descriptor);
  ::unlink(path.c_str());
  if (reason != 0 && reason != EOPNOTSUPP && reason != EINVAL) return write_error(path, reason);
  return std::nullopt;
}

// What the experimenter may ask for while a trial, or the way to it, goes on.
bool leaves_trial_alone(const LiveRequest& request) {
  return request.type == "note" || request.type == "repeat";
}

// Why the participant's page has left a trial; other reasons are not its own to state.
CutReason reason_of(const std::string& why) {
  for (const CutReason reason :
       {CutReason::kFocus, CutReason::kFullScreen, CutReason::kPointerLock}) {
    if (why == kCutReasonNames[static_cast<std::size_t>(reason)]) return reason;
  }
  return CutReason::kHidden;
}

Json vector_json(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

}  // namespace

struct LiveRun::Trial {
  CourseTrial place;
  const PlannedTrial* planned = nullptr;
  std::size_t scene = 0;
  std::string recording;  // its name
  std::string path;       // until it is complete
  std::unique_ptr<Recorder> recorder;
  std::shared_ptr<PersonTrial> person;
  DrawnPictures pictures;
  std::optional<CutReason> cut;
  bool is_skipped = false;
  std::optional<LiveRequest> cut_by;
  std::vector<LiveRequest> deferred;  // came too late for the trial, and wait for its end
  bool shows_ring = false;
  Clock::time_point last_report;
};

PersonTrialSettings LiveRun::trial_settings(const PlannedTrial& planned) const {
  PersonTrialSettings settings;
  settings.force = force_of(kHapticLevels[planned.condition.haptic].value);
  settings.a4 = kRotationLevels[planned.condition.rotation].value;
  settings.trial = plan_.trial;
  settings.longest_lateness_s = plan_.live->longest_lateness_s;
  settings.grip = plan_.live->grip;
  settings.permits_clutch = plan_.live->permits_clutch;
  settings.cpu = settings_.cpu;
  settings.has_guard = settings_.has_guard;
  settings.without_realtime = settings_.without_realtime;
  return settings;
}

// Shows the scene of the next trial, or of the next condition to touch, to the pages.
std::optional<Error> LiveRun::show_scene(std::size_t scene, const char* step, std::size_t number) {
  if (step_name() != announced_) announce();
  const int place = course_.trials()[course_.next().planned].trial;  // in its block
  if (!glbs_[scene]) {
    auto felt = encode_felt_scene(scenes_[scene].scene, kMostShownTriangles);
    if (!felt) return felt.error();
    glbs_[scene] = std::make_shared<const std::string>(std::move(felt->bytes));
  }
  pages_.set_scene(glbs_[scene]);
  const TrialWay& way = scenes_[scene].way;
  const Vec3 start_m = scenes_[scene].setup.haptics.initial_pose.point(starts_m_[scene]);
  shown_trial_ = {{"type", "trial"},
                  {"number", number},
                  {"place", place},
                  {"of", plan_.conditions().size()},
                  {"scene", scene},
                  {"green_m", vector_json(way.green_m)},
                  {"red_m", vector_json(way.red_m)},
                  {"radius_m", plan_.trial.sphere_radius_m},
                  {"start_device_m", vector_json(start_m)},
                  {"step", step}};
  send_to_all(shown_trial_);
  return std::nullopt;
}

// Shows a scene, and waits until the participant's page has it. False: something else came first.
Result<bool> LiveRun::wait_until_ready(std::size_t scene, const char* step, std::size_t number,
                                       const StopFlag& stop) {
  if (auto error = show_scene(scene, step, number)) return *error;
  while (!stop.requested()) {
    const auto request = pages_.wait(kLookEvery);
    tell_status_when_due();
    if (!request) continue;
    if (request->type == "ready") {
      const bool is_this = request->body["trial"] == number;
      pages_.answer(*request,
                    is_this ? std::nullopt : std::optional<std::string>("ready: is another trial"));
      if (is_this) return true;
      continue;
    }
    // A page that was loaded again does not know the trial.
    const bool asks_again =
        request->type == "next" && request->body["step"].get<std::string>() == step_name();
    if (asks_again) {
      pages_.answer(*request, std::nullopt);
      if (auto error = show_scene(scene, step, number)) return *error;
      continue;
    }
    if (auto error = handle(*request)) return *error;
    const bool is_of_old_trial = request->type == "frames" || request->type == "left";
    if (!is_of_old_trial && !leaves_trial_alone(*request)) return false;
  }
  return false;
}

// The page was told twice of the trial that runs, and is ready twice.
bool LiveRun::answer_again(const LiveRequest& request) {
  if (request.type != "ready") return false;
  const bool is_this =
      request.body["trial"].get<std::uint64_t>() == shown_trial_["number"].get<std::uint64_t>();
  pages_.answer(request,
                is_this ? std::nullopt : std::optional<std::string>("ready: is another trial"));
  return true;
}

void LiveRun::tell_warnings(const PersonTrial& person) {
  for (const std::string& warning : person.warnings()) {
    if (told_warnings_.insert(warning).second && settings_.warn) settings_.warn(warning);
  }
}

// The participant touches a condition without a clock, until they go on.
std::optional<Error> LiveRun::touch_condition(const StopFlag& stop) {
  const std::size_t number = ++trial_number_;
  const std::size_t level = course_.learned();
  PlannedTrial planned = course_.trials().front();
  planned.condition = plan_.conditions()[level * plan_.objects.size()];
  const std::size_t scene = scene_index(plan_, planned.variant, planned.condition.object);
  const auto is_ready = wait_until_ready(scene, "learning", number, stop);
  if (!is_ready) return is_ready.error();
  if (!*is_ready) return std::nullopt;
  PersonTrialSettings settings = trial_settings(planned);
  settings.has_clock = false;
  const auto is_placed = lead_to_start(scene, settings, stop);
  if (!is_placed) return is_placed.error();
  if (!*is_placed) return std::nullopt;
  auto person = PersonTrial::create(scenes_[scene], starts_m_[scene], settings, board_.get());
  if (!person) return person.error();
  if (auto error = (*person)->start()) return error;
  const std::shared_ptr<PersonTrial> shared(std::move(*person));
  pages_.set_trial(shared);
  const auto begin = Clock::now();
  DrawnPictures pictures;
  bool is_over = false;
  while (!is_over && !stop.requested() && !shared->watch().is_over()) {
    const auto request = pages_.wait(kLookInTrialEvery);
    tell_status_when_due();
    if (!request) continue;
    if (request->type == "frames") {
      pictures.add(request->body["times_ms"].get<std::vector<double>>());
      picture_rate_Hz_ = pictures.rate_Hz();
      continue;
    }
    if (answer_again(*request)) continue;
    if (leaves_trial_alone(*request)) {
      if (auto error = handle(*request)) return error;
      continue;
    }
    is_over = true;
    shared->stop();
    if (request->type != "next") {
      if (auto error = handle(*request)) return error;
      continue;
    }
    const bool is_here = request->body["step"] == "learning";
    pages_.answer(*request, is_here ? std::nullopt
                                    : std::optional<std::string>("the course is at another step"));
    if (!is_here) continue;
    if (auto error = note({{"kind", "learned"},
                           {"condition", plan_.level_name(planned.condition)},
                           {"length_s", seconds_since(begin)}})) {
      return error;
    }
  }
  shared->stop();
  pages_.set_trial(nullptr);
  send_to_all({{"type", "trial_end"}, {"number", number}});
  if (shared->watch().cut() == TrialCut::kTrip) return hold_after_trip(*shared);
  if (course_.step() != CourseStep::kLearning) announce();
  return std::nullopt;
}

std::optional<Error> LiveRun::run_trial(const StopFlag& stop) {
  const std::size_t number = ++trial_number_;
  Trial trial;
  trial.place = course_.next();
  trial.planned = &course_.trials()[trial.place.planned];
  trial.scene = scene_index(plan_, trial.planned->variant, trial.planned->condition.object);
  const char* const step = trial.planned->block == 0 ? "practice" : "block";
  const auto is_ready = wait_until_ready(trial.scene, step, number, stop);
  if (!is_ready) return is_ready.error();
  if (!*is_ready) return std::nullopt;

  PersonTrialSettings settings = trial_settings(*trial.planned);
  const auto is_placed = lead_to_start(trial.scene, settings, stop);
  if (!is_placed) return is_placed.error();
  if (!*is_placed) return std::nullopt;
  std::string name = fs::path(trace_name(plan_, settings_.participant, *trial.planned)).stem();
  trial.recording = name + "-attempt-" + std::to_string(trial.place.attempt) + ".palpate";
  trial.path = folder_.recording_path(settings_.participant, trial.recording + ".part");
  const double bytes = plan_.trial.limit_s * plan_.device.rate_Hz * kMostBytesPerTick;
  if (auto error = check_space(trial.path, bytes)) return error;
  if (auto error = note({{"kind", "start"},
                         {"trial", trial.place.planned},
                         {"attempt", trial.place.attempt},
                         {"recording", trial.recording}})) {
    return error;
  }
  auto recorder = make_recorder(*trial.planned, settings, trial.path);
  if (!recorder) return recorder.error();
  trial.recorder = std::move(*recorder);
  settings.sink = trial.recorder.get();
  auto person =
      PersonTrial::create(scenes_[trial.scene], starts_m_[trial.scene], settings, board_.get());
  if (!person) return person.error();
  trial.person = std::move(*person);
  auto failed = trial.person->start();
  if (!failed) tell_warnings(*trial.person);
  if (!failed) failed = follow(trial, stop);
  trial.person->stop();
  pages_.set_trial(nullptr);
  if (failed) return failed;
  send_to_all({{"type", "trial_end"}, {"number", number}});
  take_last_pictures(trial);
  if (auto error = finish(trial)) return error;
  if (trial.cut_by) {
    if (auto error = carry_out_after_trial(*trial.cut_by)) return error;
  }
  for (const LiveRequest& request : trial.deferred) {
    if (auto error = handle(request)) return error;
  }
  if (trial.cut == CutReason::kTrip) return hold_after_trip(*trial.person);
  if (auto error = pause_if_always_late(trial)) return error;
  if (course_.step() != CourseStep::kTrials) announce();
  return std::nullopt;
}

// Somebody has to look before the participant tries once more.
std::optional<Error> LiveRun::pause_if_always_late(const Trial& trial) {
  const bool is_late = trial.cut == CutReason::kLateFrames || trial.cut == CutReason::kLateTicks;
  late_in_row_ = is_late ? late_in_row_ + 1 : 0;
  if (late_in_row_ < kMostLateInRow || is_paused_ || course_.has_ended()) return std::nullopt;
  late_in_row_ = 0;
  is_paused_ = true;
  if (settings_.warn) {
    const auto reason = kCutReasonNames[static_cast<std::size_t>(*trial.cut)];
    settings_.warn(std::to_string(kMostLateInRow) + " attempts in a row were aborted (" +
                   std::string(reason) +
                   "), and the course is paused: close other programs, or raise "
                   "/live/longest_picture_s or /live/longest_lateness_s in a new plan");
  }
  auto error = note({{"kind", "pause"}, {"by", "program"}});
  announce();
  return error;
}

Result<std::unique_ptr<Recorder>> LiveRun::make_recorder(const PlannedTrial& planned,
                                                         const PersonTrialSettings& settings,
                                                         const std::string& path) const {
  std::error_code ignored;
  for (const char* const ending : {"", "-wal", "-shm", "-journal"})
    fs::remove(path + ending, ignored);
  const std::size_t index = scene_index(plan_, planned.variant, planned.condition.object);
  const ExperimentScene& scene = scenes_[index];
  const RunSetup setup = PersonTrial::setup_of(scene, starts_m_[index], settings);
  RecordedSetup recorded;
  recorded.scene_path = fs::absolute(plan_.objects[planned.condition.object].path, ignored);
  recorded.scene = scene.settings;
  recorded.scene.scale = scene.scene.statistics().scale;
  recorded.scene.fit_size_m = 0.0;
  recorded.actuation = setup.actuation;
  recorded.haptics = setup.haptics;
  recorded.dt_s = setup.dt_s;
  const auto meta = meta_of(scene.scene, recorded);
  if (!meta) return meta.error();
  RecorderSettings ticks;
  ticks.rate_Hz = plan_.device.rate_Hz;
  return Recorder::create(path, *meta, ticks);
}

// On a board: places the scene at the hand. A hand from which the next stroke would leave the
// workspace is first led back by a ring, without force. False: something else came first.
Result<bool> LiveRun::lead_to_start(std::size_t scene, PersonTrialSettings& settings,
                                    const StopFlag& stop) {
  if (settings_.board == nullptr) return true;
  PersonTrialSettings calm = settings;
  calm.force = ForceMode::kNone;
  calm.a4 = false;
  calm.has_clock = false;
  calm.sink = nullptr;
  auto created = PersonTrial::create(scenes_[scene], starts_m_[scene], calm, board_.get());
  if (!created) return created.error();
  const std::shared_ptr<PersonTrial> person(std::move(*created));
  if (auto error = person->start()) return *error;
  pages_.set_trial(person);
  const Box& region = regions_m_[scene];
  const ScenePose& pose = scenes_[scene].setup.haptics.initial_pose;
  bool shows_ring = false;
  bool goes_on = true;
  ViewState state;
  std::vector<BodyPose> bodies;
  while (goes_on && !settings.hand_m && !stop.requested() && !person->watch().is_over()) {
    tell_status_when_due();
    const bool has_state = person->newest(state, bodies);
    const Vec3 hand_m = vec3(state.record.device_m);
    const bool is_inside = region.contains(Vec3(hand_m.x(), hand_m.y(), 0.0));
    if (has_state && is_inside) {
      settings.hand_m = hand_m;
    } else if (has_state && !shows_ring) {
      shows_ring = true;
      Vec3 middle_m = 0.5 * (region.low + region.high);
      middle_m.z() = hand_m.z();
      send_to_all({{"type", "ring"}, {"p_scene_m", vector_json(pose.inverse_point(middle_m))}});
    }
    if (const auto request = pages_.wait(kLookInTrialEvery)) {
      if (answer_again(*request) || request->type == "frames") continue;
      goes_on = leaves_trial_alone(*request);
      if (!goes_on) person->stop();
      if (request->type == "next") {  // a page that was loaded again: the trial is announced again
        pages_.answer(*request, std::nullopt);
      } else if (auto error = handle(*request)) {
        return *error;
      }
    }
  }
  person->stop();
  pages_.set_trial(nullptr);
  if (shows_ring) send_to_all({{"type", "ring"}, {"p_scene_m", nullptr}});
  return goes_on && settings.hand_m.has_value();
}

// Until the trial is over or cut.
std::optional<Error> LiveRun::follow(Trial& trial, const StopFlag& stop) {
  pages_.set_trial(trial.person);
  picture_rate_Hz_.reset();
  trial.last_report = Clock::now();
  const TrialWatch& watch = trial.person->watch();
  while (!watch.is_over() && !trial.cut) {
    if (const auto request = pages_.wait(kLookInTrialEvery)) {
      if (answer_again(*request)) continue;
      trial.cut = reason_to_cut(trial, *request);
      if (trial.cut && watch.is_over() && !trial.is_skipped) trial.cut.reset();  // it came too late
      if (trial.cut) {
        trial.person->stop();
        trial.cut_by = *request;
      } else if (request->type != "frames" && watch.is_over()) {
        trial.deferred.push_back(*request);
      } else if (request->type != "frames") {
        if (auto error = handle(*request)) return error;
      }
    }
    if (stop.requested()) trial.cut = CutReason::kServer;
    const double longest_s = plan_.live->longest_picture_s;
    if (trial.pictures.longest_s > longest_s ||
        seconds_since(trial.last_report) > longest_s + kReportPatience_s) {
      trial.cut = CutReason::kLateFrames;
    }
    show_ring(trial);
    tell_status_when_due();
  }
  if (watch.cut() == TrialCut::kLateTick) trial.cut = CutReason::kLateTicks;
  if (watch.cut() == TrialCut::kTrip) trial.cut = CutReason::kTrip;
  if (watch.cut() == TrialCut::kLift) trial.cut = CutReason::kLift;
  return std::nullopt;
}

// A page that has reported pictures reports the last ones when it is told of the end.
void LiveRun::take_last_pictures(Trial& trial) {
  if (trial.pictures.count == 0) return;
  const auto end = Clock::now() + kLastReport;
  for (auto now = Clock::now(); now < end; now = Clock::now()) {
    auto request = pages_.wait(std::chrono::duration_cast<std::chrono::microseconds>(end - now));
    if (!request) continue;
    if (request->type == "frames") {
      take_pictures(trial, *request);
      break;
    }
    trial.deferred.push_back(std::move(*request));
  }
  if (!trial.cut && trial.pictures.longest_s > plan_.live->longest_picture_s) {
    trial.cut = CutReason::kLateFrames;
  }
}

void LiveRun::take_pictures(Trial& trial, const LiveRequest& request) {
  const auto times_ms = request.body["times_ms"].get<std::vector<double>>();
  if (times_ms.empty()) return;  // a page that draws nothing
  trial.pictures.add(times_ms);
  picture_rate_Hz_ = trial.pictures.rate_Hz();
  trial.last_report = Clock::now();
  trial.recorder->add_event("pictures", request.body["times_ms"].dump(), Recorder::EventTime::kNow);
}

// Why a message of a page ends the trial; no value: it does not.
std::optional<CutReason> LiveRun::reason_to_cut(Trial& trial, const LiveRequest& request) {
  const std::string& type = request.type;
  if (type == "frames") {
    take_pictures(trial, request);
    return std::nullopt;
  }
  if (type == "left") return reason_of(request.body["why"].get<std::string>());
  const bool names_trial = type == "abort" || type == "skip";
  if (names_trial && !names_next(request)) return std::nullopt;  // handle() refuses it
  trial.is_skipped = type == "skip";
  const bool ends = names_trial || type == "pause" || type == "stop";
  if (!ends) return std::nullopt;
  return request.role == kParticipantPage ? CutReason::kParticipant : CutReason::kExperimenter;
}

// What a request that has cut the trial asks for beyond that.
std::optional<Error> LiveRun::carry_out_after_trial(const LiveRequest& request) {
  if (request.type == "pause" || request.type == "stop") return handle(request);
  pages_.answer(request, std::nullopt);  // the end of the trial was what it asked for
  return std::nullopt;
}

// Where the person should return to, or how they get out of an object in which they began.
void LiveRun::show_ring(Trial& trial) {
  const TrialWatch& watch = trial.person->watch();
  const bool waits_inside = trial.person->waits_inside();
  if ((watch.is_lost() || waits_inside) == trial.shows_ring) return;
  trial.shows_ring = !trial.shows_ring;
  Json ring = {{"type", "ring"}, {"p_scene_m", nullptr}};
  if (trial.shows_ring && waits_inside) {
    ring["p_scene_m"] = vector_json(starts_m_[trial.scene]);
  } else if (trial.shows_ring) {
    const HandPath& path = scenes_[trial.scene].way.path;
    ring["p_scene_m"] = vector_json(point_along(path, path.lengths_m(), watch.along_m()));
  }
  trial.recorder->add_event("ring", ring["p_scene_m"].dump(), Recorder::EventTime::kNow);
  send_to_all(ring);
}

// The recording appears, then the entry with the row, then the row in trials.csv.
std::optional<Error> LiveRun::finish(Trial& trial) {
  TrialOutcome outcome;
  const TrialClock& clock = trial.person->clock();
  if (trial.recorder->has_failed() && !trial.is_skipped) trial.cut = CutReason::kServer;
  // A person does the trial again that a bad sample has ended.
  if (!trial.cut && clock.status() == TrialStatus::kFault) trial.cut = CutReason::kFault;
  LiveColumns live = live_columns();
  live.reason = trial.cut;
  live.returns_shown = static_cast<int>(trial.person->watch().times_lost());
  live.clutches = static_cast<int>(trial.person->clutches());
  live.pictures = trial.pictures.count;
  live.longest_picture_s = trial.pictures.longest_s;
  outcome.status = trial.is_skipped ? TrialStatus::kSkipped
                   : trial.cut      ? TrialStatus::kAborted
                                    : clock.status();
  outcome.measures = clock.measures();
  outcome.measures[kMissedDeadlines] = static_cast<double>(trial.person->missed_deadlines());
  const auto status = kTrialStatusNames[static_cast<std::size_t>(outcome.status)];
  const RecordingResult recorded = trial.recorder->finish(std::string(status));
  const std::string path = folder_.recording_path(settings_.participant, trial.recording);
  // A log that stays is a part of the recording.
  if (recorded.has_log &&
      std::rename((trial.path + "-wal").c_str(), (path + "-wal").c_str()) != 0) {
    return write_error(path + "-wal", errno);
  }
  if (std::rename(trial.path.c_str(), path.c_str()) != 0) return write_error(path, errno);
  Json entry = {
      {"kind", "end"},    {"trial", trial.place.planned},     {"attempt", trial.place.attempt},
      {"status", status}, {"recorded_ticks", recorded.ticks}, {"dropped_ticks", recorded.dropped}};
  if (trial.cut) entry["reason"] = kCutReasonNames[static_cast<std::size_t>(*trial.cut)];
  entry["row"] = live_row_text(plan_, settings_.participant, *trial.planned, trial.place.attempt,
                               outcome, live);
  if (recorded.error) entry["recording_problem"] = recorded.error->to_string();
  if (auto error = note(std::move(entry))) return error;
  last_trial_ = trial.place.planned;
  if (auto error = folder_.write_rows(settings_.participant, journal_.entries())) return error;
  return recorded.error;  // the next trial would not be recorded either
}

}  // namespace palpate
