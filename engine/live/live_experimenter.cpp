// What LiveRun tells the pages while the course is at a step, above all the experimenter's.

#include <algorithm>
#include <utility>

#include "engine/live/live_run.h"
#include "engine/recording/recording_settings.h"

namespace palpate {
namespace {

using Json = nlohmann::ordered_json;

// The rules of the governor that acted.
Json rule_names_json(std::uint32_t rules) {
  Json names = Json::array();
  for (std::size_t i = 0; i < kGovernorRuleNames.size(); ++i) {
    if ((rules >> i & 1u) != 0) names.push_back(kGovernorRuleNames[i]);
  }
  return names;
}

}  // namespace

// Counts an entry that ends an attempt.
void LiveRun::count_attempt(const JournalEntry& entry) {
  const bool is_skip = entry.value("kind", "") == "skip";
  if (!is_skip && entry.value("kind", "") != "end") return;
  const std::string status = is_skip ? "skipped" : entry.value("status", "");
  const auto name = std::find(kTrialStatusNames.begin(), kTrialStatusNames.end(), status);
  const auto planned = entry.value("trial", std::size_t{0});
  if (name == kTrialStatusNames.end() || planned >= course_.trials().size()) return;
  ++attempts_by_status_[static_cast<std::size_t>(name - kTrialStatusNames.begin())];
  const PlannedTrial& trial = course_.trials()[planned];
  last_attempt_ = {{"block", trial.block},
                   {"place", trial.trial},
                   {"attempt", course_.attempts(planned)},
                   {"status", status},
                   {"reason", entry.value("reason", "")}};
}

// To the pages of both roles, if the experimenter may see what tells the condition.
void LiveRun::send_to_all(const Json& json) {
  pages_.send(kParticipantPage, json);
  if (!plan_.live->is_blind) pages_.send(kExperimenterPage, json);
}

// The trial, or the condition to touch, that runs or is next.
void LiveRun::add_next_trial(Json& status) const {
  const CourseTrial next = course_.next();
  PlannedTrial planned = course_.trials()[next.planned];
  const bool is_learning = course_.step() == CourseStep::kLearning;
  const auto is_of_block = [&](const PlannedTrial& t) { return t.block == planned.block; };
  if (is_learning) {
    planned.condition = plan_.conditions()[course_.learned() * plan_.objects.size()];
    status["place"] = course_.learned() + 1;
    status["places"] = plan_.level_count();
  } else {
    status["place"] = planned.trial;
    status["places"] = std::count_if(course_.trials().begin(), course_.trials().end(), is_of_block);
    status["attempt"] = next.attempt;
    status["runs"] = course_.running().has_value();
  }
  if (plan_.live->is_blind) return;
  status["condition"] = plan_.level_name(planned.condition);
  status["object"] = plan_.objects[planned.condition.object].name;
}

Json LiveRun::experimenter_status() {
  const LivePages::SeenTicks ticks = pages_.seen_ticks();
  Json attempts = Json::object();
  for (std::size_t i = 0; i < kTrialStatusNames.size(); ++i) {
    attempts[std::string(kTrialStatusNames[i])] = attempts_by_status_[i];
  }
  Json status = {{"type", "status"},
                 {"participant", settings_.participant},
                 {"step", step_name()},
                 {"paused", is_paused_},
                 {"trip", nullptr},
                 {"block", course_.block()},
                 {"blocks", plan_.blocks},
                 {"trials_left", course_.trials_left()},
                 {"attempts", attempts},
                 {"last", last_attempt_},
                 {"newest_late_us", ticks.newest_late_us},
                 {"worst_late_us", ticks.worst_late_us},
                 {"missed_deadlines", ticks.missed_deadlines},
                 {"pictures_Hz", nullptr}};
  if (trip_) status["trip"] = kTripReasonNames[static_cast<std::size_t>(*trip_)];
  if (picture_rate_Hz_) status["pictures_Hz"] = *picture_rate_Hz_;
  if (!plan_.live->is_blind) status["rules"] = rule_names_json(ticks.rules);
  const bool has_trial =
      course_.step() == CourseStep::kLearning || course_.step() == CourseStep::kTrials;
  if (has_trial) add_next_trial(status);
  return status;
}

// Not more often than the server asks.
void LiveRun::tell_status_when_due() {
  constexpr auto kTellEvery = std::chrono::milliseconds(250);
  if (Clock::now() - told_ >= kTellEvery) tell_status();
}

void LiveRun::tell_status() {
  told_ = Clock::now();
  pages_.set_status(
      kParticipantPage,
      {{"type", "status"}, {"paused", is_paused_}, {"remaining_s", step_json()["remaining_s"]}});
  const Json status = experimenter_status();
  pages_.set_status(kExperimenterPage, status);
  const LivePlan& live = *plan_.live;
  pages_.set_hello(kExperimenterPage,
                   {{"type", "hello"},
                    {"role", "experimenter"},
                    {"version", kViewVersion},
                    {"engine", engine_version()},
                    {"plan", plan_.name},
                    {"participant", settings_.participant},
                    {"pilot", settings_.is_pilot},
                    {"blind", live.is_blind},
                    {"has_force", settings_.board != nullptr || plan_.live->grip},
                    {"display", display_json()},
                    {"rate_Hz", plan_.device.rate_Hz},
                    {"trial", live.is_blind ? Json() : shown_trial_},
                    {"status", status}});
}

}  // namespace palpate
