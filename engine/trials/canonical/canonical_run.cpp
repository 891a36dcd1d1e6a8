#include "engine/trials/canonical/canonical_run.h"

#include <utility>

#include "engine/trials/canonical/canonical_rows.h"
#include "engine/trials/canonical/canonical_trial.h"
#include "engine/trials/canonical/canonical_wall.h"
#include "engine/trials/deal/run_identity.h"
#include "engine/trials/key_hash.h"
#include "engine/trials/plan_device.h"
#include "engine/trials/trial.h"

namespace palpate {
namespace {

std::uint64_t canonical_noise_seed(std::uint64_t seed, int participant, const CanonicalCell& cell) {
  return KeyHash()
      .add("canonical noise")
      .add(seed)
      .add(static_cast<std::uint64_t>(participant))
      .add(cell.angle_deg)
      .add(kCanonicalMotionNames[static_cast<std::size_t>(cell.motion)])
      .add(kRotationNames[cell.rotates ? 1 : 0])
      .value();
}

Error device_error(const Error& error, const CanonicalPlan& plan) {
  Error of_plan = as_plan_error(error, "/device");
  of_plan.path = plan.path;
  return of_plan;
}

// The errors of run_canonical_trial(), which depend on the person and on nothing else of a trial.
std::optional<Error> check_trials(const CanonicalPlan& plan, const Scene& wall,
                                  const RunSetup& device) {
  for (const CanonicalCell& cell : plan.cells()) {
    const RunSetup setup = canonical_setup(device, cell.angle_deg, cell.rotates);
    if (auto error = check_setup(wall, setup)) return device_error(*error, plan);
  }
  for (int participant = 1; participant <= plan.participants; ++participant) {
    const OperatorParameters person = draw_person(plan.person, plan.seed, participant);
    if (auto error = check_plant(plant_of(device, person, 0), device.dt_s)) {
      return device_error(*error, plan);
    }
  }
  return std::nullopt;
}

Result<std::optional<UnitRun>> run_canonical_participant(const CanonicalPlan& plan,
                                                         const Scene& wall, const RunSetup& device,
                                                         int participant, UnitTrials& trials) {
  const OperatorParameters person = draw_person(plan.person, plan.seed, participant);
  CsvLines lines("");
  UnitRun run;
  for (const CanonicalCell& cell : plan.cells()) {
    if (const std::string* const finished = trials.next()) {
      run.rows += *finished;
      continue;
    }
    const auto outcome =
        run_canonical_trial(wall, device, plan.display_Hz, person,
                            {cell, canonical_noise_seed(plan.seed, participant, cell)});
    if (!outcome) return outcome.error();
    lines.clear();
    add_canonical_row(lines,
                      {participant, cell, outcome->along_over_into, outcome->share_within_30deg});
    run.rows += lines.text();
    run.ticks += outcome->ticks;
    run.loop_ns += outcome->loop_ns;
    const auto goes_on = trials.add(lines.text());
    if (!goes_on) return goes_on.error();
    if (!*goes_on) return std::optional<UnitRun>();
  }
  return std::optional<UnitRun>(std::move(run));
}

// All arguments must outlive the result.
DealtRun dealt_canonical(const CanonicalPlan& plan, const Scene& wall, const RunSetup& device) {
  const RunIdentity identity = identity_of_persons(RunKind::kCanonical, plan);
  DealtRun run;
  run.units = identity.dealt_units(canonical_columns());
  run.identity_json = identity.json();
  run.result_names = result_names(identity.kind);
  run.trials = [&plan](int) { return std::uint64_t{plan.cells().size()}; };
  run.compute = [&](int participant, UnitTrials& trials) {
    return run_canonical_participant(plan, wall, device, participant, trials);
  };
  return run;
}

}  // namespace

Result<DealtOutcome> run_canonical(const CanonicalPlan& plan, const DealtSettings& settings,
                                   const std::function<void(const RunProgress&)>& progress,
                                   const StopFlag* stop) {
  const auto device = make_setup(plan.device);
  if (!device) return device_error(device.error(), plan);
  const auto wall = canonical_wall(plan.device.haptics.god_object.radius_m);
  if (!wall) return device_error(wall.error(), plan);
  if (auto error = check_trials(plan, *wall, *device)) return *error;
  return run_dealt(dealt_canonical(plan, *wall, *device), settings, progress, stop);
}

}  // namespace palpate
