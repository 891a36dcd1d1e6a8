#include "engine/simulation/exploration.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <sstream>
#include <thread>

#include "engine/rig/rig.h"
#include "engine/session/haptic_thread.h"
#include "engine/simulation/path_coverage.h"
#include "engine/simulation/path_plan.h"
#include "engine/simulation/planned_hand.h"
#include "engine/simulation/scene_cut.h"
#include "engine/simulation/simulated_device.h"
#include "engine/simulation/simulated_run.h"
#include "haptics/record_vectors.h"

namespace palpate {
namespace {

// The first tick of the last fifth of a run.
std::size_t late_tick(const ExplorationRun& run) {
  return run.records.size() - run.records.size() / 5;
}

// Stores the planned path in the run and measures its coverage by the proxy.
void measure_coverage(PlannedHand hand, double largest_extent_m, double proxy_radius_m,
                      ExplorationRun& run) {
  run.proxy_radius_m = proxy_radius_m;
  run.near_m = std::max(kNearWay_m, kNearWayShare * largest_extent_m) + proxy_radius_m;
  if (!hand.contour_m.empty()) {
    run.contour_scene_m = std::move(hand.contour_m);
    run.is_open_contour = hand.is_open_contour;
    CurveCoverage coverage(run.contour_scene_m, run.near_m);
    const std::size_t late = late_tick(run);
    for (std::size_t n = 0; n < late; ++n) coverage.add(vec3(run.records[n].proxy_scene_m));
    const double early_share = coverage.share();
    for (std::size_t n = late; n < run.records.size(); ++n)
      coverage.add(vec3(run.records[n].proxy_scene_m));
    run.way_share = coverage.share();
    run.late_way_share = run.way_share - early_share;
    return;
  }
  run.places_scene_m = std::move(hand.places_m);
  const std::vector<Vec3>& places = run.places_scene_m;
  if (places.empty()) return;
  std::size_t reached = 0;
  std::size_t reached_late = 0;
  for (const Vec3& place : places) {
    const auto at = std::find_if(run.records.begin(), run.records.end(), [&](const TickRecord& r) {
      return (vec3(r.proxy_scene_m) - place).squaredNorm() <= run.near_m * run.near_m;
    });
    if (at == run.records.end()) continue;
    ++reached;
    if (static_cast<std::size_t>(at - run.records.begin()) >= late_tick(run)) ++reached_late;
  }
  const auto count = static_cast<double>(places.size());
  run.way_share = static_cast<double>(reached) / count;
  run.late_way_share = static_cast<double>(reached_late) / count;
}

bool is_stopped(const StopFlag* stop) {
  return stop && stop->requested();
}

void run_realtime(HapticSession& session, const RunSetup& setup, std::size_t ticks,
                  const Progress& progress, const StopFlag* stop, ExplorationRun& run) {
  if (is_stopped(stop)) return;
  HapticThread thread(session, {1.0 / setup.dt_s, ticks});
  run.realtime_note = thread.start().explanation;
  while (thread.running() && !is_stopped(stop)) {
    progress(static_cast<double>(thread.ticks()) / static_cast<double>(ticks));
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  if (is_stopped(stop)) thread.stop();
  thread.join();
  run.missed_deadlines = thread.missed_deadlines();
  run.tick_times = thread.times();
}

}  // namespace

// Comparisons are false for NaN.
std::optional<Error> check_exploration(const ExplorationSettings& settings, double dt_s) {
  if (!(settings.seconds > PathPlanSettings{}.approach_s)) {
    std::ostringstream text;
    text << "is " << settings.seconds << " s; expected more than " << PathPlanSettings{}.approach_s
         << " s, the time of the approach";
    return invalid_argument("seconds", text.str(), "use 25 to 30 s");
  }
  if (const auto ticks = kept_ticks(settings.seconds, dt_s); !ticks) return ticks.error();
  return std::nullopt;
}

namespace {

// Checks the memory of the run: the record of each tick and the section of the surfaces.
std::optional<Error> take_memory(const Scene& scene, const RunSetup& setup,
                                 const ExplorationSettings& settings, std::uint64_t ticks,
                                 MemoryLedger& ledger) {
  if (auto error =
          take_run_memory(settings.max_memory_bytes, settings.taken_memory_bytes,
                          "load a part of the scene with `SceneSettings::node`", ticks, ledger)) {
    return error;
  }
  if (!setup.actuation.is_planar()) return std::nullopt;
  ledger.advise(
      "load a part of the scene with `SceneSettings::node`, or use `RunSettings::sensors` 3, which "
      "needs no contour");
  ledger.begin("cutting the scene for its contour", "scene");
  return ledger.check(scene_cut_bytes(scene));
}

// As the public explore(), but throws std::bad_alloc if memory runs out.
Result<ExplorationRun> explore(const Scene& scene, const RunSetup& setup,
                               const ExplorationSettings& settings, const Progress& progress,
                               const StopFlag* stop, MemoryLedger& ledger) {
  if (const auto error = check_exploration(settings, setup.dt_s)) return *error;
  if (const auto error = check_setup(scene, setup)) return *error;
  const std::uint64_t ticks = *kept_ticks(settings.seconds, setup.dt_s);
  PlantSettings plant;
  plant.device = setup.device;
  plant.seed = settings.seed;
  if (const auto error = check_plant(plant, setup.dt_s)) return *error;
  if (auto error = take_memory(scene, setup, settings, ticks, ledger)) return *error;
  Result<PlannedHand> hand = plan_hand(scene, setup, {settings.seconds, settings.seed});
  if (!hand) return hand.error();
  ExplorationRun run;
  run.a4 = setup.haptics.a4.enabled;
  SimulatedDevice device = device_in_hand(plant, setup, *hand->plan,
                                          setup.haptics.initial_pose.point(hand->start_scene_m));
  const auto rig = Rig::create(scene, setup, device,
                               {.observers = {&device},
                                .keeper = std::make_unique<RecordKeeper>(ticks),
                                .sink = settings.sink});
  if (!rig) return rig.error();
  if (settings.virtual_time) {
    constexpr std::uint64_t kReportEvery = 1000;
    run_simulated((*rig)->session(), setup.dt_s, ticks, [&](std::uint64_t n) {
      if (n % kReportEvery == 0) progress(static_cast<double>(n) / static_cast<double>(ticks));
      return is_stopped(stop);
    });
  } else {
    run_realtime((*rig)->session(), setup, ticks, progress, stop, run);
  }
  RunRecords kept = (*rig)->take_keeper()->finish();
  run.records = std::move(kept.records);
  run.summary = kept.summary;
  run.interrupted = run.records.size() < ticks;
  if (!run.interrupted) progress(1.0);
  measure_coverage(std::move(*hand), scene.statistics().extent_m.maxCoeff(),
                   setup.haptics.god_object.radius_m, run);
  run.exceeds_workspace =
      exceeds_workspace(run.summary.device_travel_m(), workspace_extent_m(setup.device));
  return run;
}

}  // namespace

Result<ExplorationRun> explore(const Scene& scene, const RunSetup& setup,
                               const ExplorationSettings& settings, const Progress& progress,
                               const StopFlag* stop) {
  MemoryLedger ledger;
  return or_out_of_memory(ledger,
                          [&] { return explore(scene, setup, settings, progress, stop, ledger); });
}

}  // namespace palpate
