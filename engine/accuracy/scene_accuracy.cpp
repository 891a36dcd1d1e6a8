#include "engine/accuracy/scene_accuracy.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <thread>
#include <utility>

#include "engine/accuracy/built_scene.h"
#include "engine/accuracy/error_measures.h"
#include "engine/accuracy/session_pass.h"
#include "engine/devices/vector_device.h"
#include "engine/rig/replay.h"
#include "engine/rig/rig.h"
#include "engine/session/haptic_thread.h"
#include "engine/session/start_inside.h"
#include "engine/simulation/exploration.h"
#include "haptics/record_vectors.h"

namespace palpate {
namespace {

constexpr int kHands = 3;
constexpr std::array kRates_Hz = {1000.0, 2000.0, 4000.0, 8000.0, 16000.0, 32000.0};
constexpr std::array kSlowRates_Hz = {500.0, 250.0};  // if 1 kHz is not kept
constexpr int kTrials = 3;                            // per rate; most of them must keep it

// Limits of the loop's rate. Every tick of every hand is kept in memory.
constexpr double kSlowest_Hz = 20.0;
constexpr double kFastest_Hz = 20000.0;

std::optional<Error> check_rate(const RunSetup& setup) {
  const double rate_Hz = 1.0 / setup.dt_s;
  if (rate_Hz >= kSlowest_Hz && rate_Hz <= kFastest_Hz) return std::nullopt;
  return Error{ErrorCode::kInvalidArgument, "", "rate_Hz",
               "is " + std::to_string(rate_Hz) + " Hz; expected 20 to 20000 Hz",
               "1000 Hz is usual; the report states the highest rate that this machine keeps"};
}

RunSetup with(RunSetup setup, const Accuracy& accuracy) {
  setup.haptics.god_object.accuracy = accuracy;
  return setup;
}

// The path of a hand, and its records under the preset exact.
struct Hand {
  std::vector<Vec3> path_m;
  std::vector<TickRecord> exact;
};

Result<Hand> record_hand(const Scene& scene, const RunSetup& setup, double seconds,
                         std::uint64_t seed) {
  ExplorationSettings exploration;
  exploration.seconds = seconds;
  exploration.virtual_time = true;
  exploration.seed = seed;
  const RunSetup exact = with(setup, Accuracy::exact());
  Result<ExplorationRun> run = explore(scene, exact, exploration, [](double) {});
  if (!run) return run.error();
  Hand hand;
  for (const TickRecord& record : run->records) hand.path_m.push_back(vec3(record.device_m));
  // Recorded again as a replay, like the presets, so that only the presets differ.
  Result<RunRecords> again = replay(scene, exact, hand.path_m, 1);
  if (!again) return again.error();
  hand.exact = std::move(again->records);
  return hand;
}

// Sums up the results of a preset over the hands.
class PresetTally {
 public:
  void add(const RunRecords& run, const Hand& hand) {
    std::vector<std::int64_t> contact_ns;
    for (std::size_t n = 0; n < run.records.size(); ++n) {
      const TickRecord& record = run.records[n];
      const std::int64_t step_ns = std::max<std::int64_t>(0, record.step_ns - clock_ns_);
      all_ns_.push_back(step_ns);
      add_errors(record, hand.exact[n]);
      if (!record.contact) continue;
      contact_ns.push_back(step_ns);
      contact_ns_.push_back(step_ns);
      iterations_ += record.iterations;
      capped_ += (record.faults & kFaultSolverCapped) != 0;
      ++ticks_;
    }
    if (contact_ns.empty()) return;
    const StepTimes times = StepTimes::of(std::move(contact_ns));
    p50_ns_.push_back(static_cast<double>(times.p50_ns));
    p99_ns_.push_back(static_cast<double>(times.p99_ns));
    worst_ns_.push_back(static_cast<double>(times.max_ns));
  }

  PresetOnScene finish(const char* name) {
    PresetOnScene preset;
    preset.name = name;
    preset.p50_ns = Spread::of(p50_ns_);
    preset.p99_ns = Spread::of(p99_ns_);
    preset.worst_ns = Spread::of(worst_ns_);
    preset.ticks = ticks_;
    preset.capped_ticks = capped_;
    preset.worst_force_error_N = worst_force_N_;
    if (ticks_ > 0) preset.iterations = iterations_ / static_cast<double>(ticks_);
    if (errors_m_.empty()) return preset;
    RootMeanSquare rms_m;
    for (const double error_m : errors_m_) rms_m.add(error_m);
    preset.rms_error_m = rms_m.value();
    std::sort(errors_m_.begin(), errors_m_.end());
    preset.p99_error_m = errors_m_[(errors_m_.size() - 1) * 99 / 100];
    preset.worst_error_m = errors_m_.back();
    return preset;
  }
  // The time that one tick in a thousand exceeds, over all ticks or those in contact, whichever is
  // longer.
  double p999_ns() const {
    return static_cast<double>(
        std::max(StepTimes::of(all_ns_).p999_ns, StepTimes::of(contact_ns_).p999_ns));
  }

 private:
  // Counts ticks in which either of the two is in contact: losing a surface that exact still
  // touches is an error.
  void add_errors(const TickRecord& record, const TickRecord& exact) {
    if (!record.contact && !exact.contact) return;
    errors_m_.push_back((vec3(record.proxy_scene_m) - vec3(exact.proxy_scene_m)).norm());
    const Vec3 off_N = vec3(record.full_force_device_N) - vec3(exact.full_force_device_N);
    worst_force_N_ = std::max(worst_force_N_, off_N.norm());
  }

  std::vector<double> p50_ns_, p99_ns_, worst_ns_, errors_m_;
  std::vector<std::int64_t> all_ns_, contact_ns_;
  std::int64_t clock_ns_ = std::llround(clock_overhead_ns());
  double iterations_ = 0.0;
  double worst_force_N_ = 0.0;
  std::uint64_t ticks_ = 0;
  std::uint64_t capped_ = 0;
};

// Follows a recorded path in the same time at any rate.
class ResampledPath final : public VectorDevice {
 public:
  ResampledPath(const std::vector<Vec3>& path_m, double period_s)
      : path_m_(path_m), period_s_(period_s) {}
  Vec3 read_position_m(double dt_s) noexcept override {
    const double place = std::min(time_s_ / period_s_, static_cast<double>(path_m_.size() - 1));
    const auto n = std::min(static_cast<std::size_t>(place), path_m_.size() - 2);
    time_s_ += dt_s;
    return path_m_[n] + (place - static_cast<double>(n)) * (path_m_[n + 1] - path_m_[n]);
  }
  void command_force_N(const Vec3&) noexcept override {}

 private:
  const std::vector<Vec3>& path_m_;
  double period_s_;
  double time_s_ = 0.0;
};

class WorstStep final : public TickObserver {
 public:
  void on_tick(const TickRecord& record) noexcept override {
    worst_ns = std::max(worst_ns, record.step_ns);
  }
  std::int64_t worst_ns = 0;
};

// Where a hand first touches, so that the trials are about contact.
std::size_t first_contact(const Hand& hand) {
  const auto touches = std::find_if(hand.exact.begin(), hand.exact.end(),
                                    [](const TickRecord& r) { return r.contact; });
  return static_cast<std::size_t>(touches - hand.exact.begin());
}

Result<RateTrial> try_rate(const Scene& scene, const RunSetup& setup, const Hand& hand,
                           double rate_Hz, double seconds, std::string& realtime_note) {
  const std::size_t begin = first_contact(hand) > 50 ? first_contact(hand) - 50 : 0;
  const std::vector<Vec3> path_m(hand.path_m.begin() + static_cast<std::ptrdiff_t>(begin),
                                 hand.path_m.end());
  ResampledPath device(path_m, setup.dt_s);
  WorstStep worst;
  const auto rig = Rig::create(scene, setup, device, {.observers = {&worst}});
  if (!rig) return rig.error();
  RateTrial trial;
  trial.rate_Hz = rate_Hz;
  HapticThread thread((*rig)->session(),
                      {rate_Hz, static_cast<std::uint64_t>(std::ceil(seconds * rate_Hz))});
  realtime_note = thread.start().explanation;
  thread.join();
  trial.ticks = thread.ticks();
  trial.missed = thread.missed_deadlines();
  trial.worst_ns = worst.worst_ns;
  return trial;
}

// The majority of the trials decides, so that a moment of other load, or of no load, does not.
Result<RateTrial> judge_rate(const Scene& scene, const RunSetup& setup, const Hand& hand,
                             double rate_Hz, double seconds, std::string& realtime_note) {
  RateTrial all;
  all.rate_Hz = rate_Hz;
  const auto is_decided = [&] {
    return 2 * all.kept > kTrials || 2 * (all.trials - all.kept) > kTrials;
  };
  while (!is_decided()) {
    const auto trial = try_rate(scene, setup, hand, rate_Hz, seconds, realtime_note);
    if (!trial) return trial.error();
    ++all.trials;
    all.kept += static_cast<double>(trial->missed) <=
                RateTrial::kMostMissed * static_cast<double>(trial->ticks);
    all.ticks += trial->ticks;
    all.missed += trial->missed;
    all.worst_ns = std::max(all.worst_ns, trial->worst_ns);
  }
  return all;
}

// The rates to try upwards from 1 kHz, and those to try downwards from there, each with the loop's
// own rate in its place, because that is the rate asked for.
struct RatesToTry {
  std::vector<double> up_Hz, down_Hz;
};
RatesToTry rates_to_try(double own_Hz) {
  RatesToTry rates{{kRates_Hz.begin(), kRates_Hz.end()},
                   {kSlowRates_Hz.begin(), kSlowRates_Hz.end()}};
  const auto add = [own_Hz](std::vector<double>& to) {
    if (std::find(to.begin(), to.end(), own_Hz) == to.end()) to.push_back(own_Hz);
  };
  add(own_Hz >= kRates_Hz.front() ? rates.up_Hz : rates.down_Hz);
  std::sort(rates.up_Hz.begin(), rates.up_Hz.end());
  std::sort(rates.down_Hz.begin(), rates.down_Hz.end(), std::greater<>());
  return rates;
}

// Tries rates upwards to the first that is not kept; if that is 1 kHz, downwards to one that is
// kept.
std::optional<Error> find_kept_rate(const Scene& scene, const RunSetup& setup, const Hand& hand,
                                    const MeasurementEffort& effort, KeptRate& kept) {
  const auto seconds = [&](double rate_Hz) {
    constexpr double kLeastTicks = 1000.0;  // so that one late tick is not too many
    return std::max(effort.quick ? 0.5 : 2.0, kLeastTicks / rate_Hz);
  };
  const auto keeps = [&](double rate_Hz) -> Result<bool> {
    const auto trial =
        judge_rate(scene, setup, hand, rate_Hz, seconds(rate_Hz), kept.realtime_note);
    if (!trial) return trial.error();
    kept.trials.push_back(*trial);
    if (trial->passed()) kept.by_trial_Hz = rate_Hz;
    return trial->passed();
  };
  const RatesToTry rates = rates_to_try(std::round(1.0 / setup.dt_s));
  for (const double rate_Hz : rates.up_Hz) {
    const auto is_kept = keeps(rate_Hz);
    if (!is_kept) return is_kept.error();
    if (!*is_kept) break;
  }
  for (const double rate_Hz : rates.down_Hz) {
    if (kept.by_trial_Hz > 0.0) break;
    const auto is_kept = keeps(rate_Hz);
    if (!is_kept) return is_kept.error();
  }
  std::sort(kept.trials.begin(), kept.trials.end(),
            [](const RateTrial& a, const RateTrial& b) { return a.rate_Hz < b.rate_Hz; });
  return std::nullopt;
}

std::string start_note(const Scene& scene, const TickRecord& first) {
  const auto object = enclosing_object(scene, vec3(first.goal_scene_m));
  return object ? felt_inside_text(scene, *object) : std::string();
}

// The ticks of a hand in contact.
std::size_t contact_ticks(const Hand& hand) {
  return static_cast<std::size_t>(std::count_if(hand.exact.begin(), hand.exact.end(),
                                                [](const TickRecord& r) { return r.contact; }));
}

// Records the hands, and measures how deep and how long they touch.
Result<std::vector<Hand>> record_hands(const Scene& scene, const RunSetup& setup,
                                       std::uint64_t first_seed, SceneAccuracy& measured) {
  std::vector<Hand> hands;
  std::uint64_t ticks = 0;
  std::vector<double> depths_m;
  for (int h = 0; h < kHands; ++h) {
    Result<Hand> hand =
        record_hand(scene, setup, measured.seconds, first_seed + static_cast<std::uint64_t>(h));
    if (!hand) return hand.error();
    for (const TickRecord& r : hand->exact) {
      if (r.contact) depths_m.push_back((vec3(r.proxy_scene_m) - vec3(r.goal_scene_m)).norm());
    }
    ticks += hand->exact.size();
    if (h == 0 && !hand->exact.empty())
      measured.start_note = start_note(scene, hand->exact.front());
    hands.push_back(std::move(*hand));
  }
  if (depths_m.empty()) {
    return Error{
        ErrorCode::kInvalidArgument, "", "SCENE", "no simulated hand touched the scene",
        "try another `MeasurementEffort::seed`, or `SceneSettings::fit_size_m` to bring the "
        "scene to the size of a hand's reach"};
  }
  std::sort(depths_m.begin(), depths_m.end());
  measured.deepest_m = depths_m[(depths_m.size() - 1) * 99 / 100];
  measured.contact_share = static_cast<double>(depths_m.size()) / static_cast<double>(ticks);
  return hands;
}

// Measures the presets with the hands in turn, and the rate that the preset balanced allows.
std::optional<Error> measure_presets(const Scene& scene, const RunSetup& setup,
                                     const std::vector<Hand>& hands,
                                     const MeasuringProgress& progress, SceneAccuracy& measured) {
  std::array<PresetTally, kAccuracyPresets.size()> tallies;
  measured.repeats = MeasurementEffort::kRepeats;
  for (int repeat = 0; repeat < measured.repeats; ++repeat) {
    const Hand& hand = hands[static_cast<std::size_t>(repeat) % hands.size()];
    for (std::size_t p = 0; p < kAccuracyPresets.size(); ++p) {
      // The first preset differs between repeats, and between repeats with the same hand.
      const auto r = static_cast<std::size_t>(repeat);
      const std::size_t turn = (p + r + r / hands.size()) % kAccuracyPresets.size();
      const auto run = replay(scene, with(setup, kAccuracyPresets[turn]), hand.path_m, 1);
      if (!run) return run.error();
      tallies[turn].add(*run, hand);
    }
    if (progress) progress(0.8 * static_cast<double>(repeat + 1) / measured.repeats);
  }
  for (std::size_t p = 0; p < kAccuracyPresets.size(); ++p) {
    measured.presets[p] = tallies[p].finish(kPresetNames[p]);
  }
  measured.kept_rate.by_computing_Hz = 0.5e9 / tallies[1].p999_ns();
  return std::nullopt;
}

}  // namespace

Result<SceneAccuracy> measure_scene(const Scene& scene, const RunSetup& setup,
                                    const MeasurementEffort& effort,
                                    const MeasuringProgress& progress) {
  SceneAccuracy measured;
  measured.hands = kHands;
  if (auto error = check_rate(setup)) return *error;
  measured.floor_m = file_floor_m(scene);
  measured.seconds = effort.quick ? 3.0 : 12.0;
  const auto hands = record_hands(scene, setup, effort.seed, measured);
  if (!hands) return hands.error();
  if (auto error = measure_presets(scene, setup, *hands, progress, measured)) return *error;
  const Hand& touching = *std::max_element(
      hands->begin(), hands->end(),
      [](const Hand& a, const Hand& b) { return contact_ticks(a) < contact_ticks(b); });
  if (auto error = find_kept_rate(scene, setup, touching, effort, measured.kept_rate)) {
    return *error;
  }
  if (progress) progress(1.0);
  return measured;
}

}  // namespace palpate
