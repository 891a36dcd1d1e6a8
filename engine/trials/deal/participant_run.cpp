#include "engine/trials/deal/participant_run.h"

#include <cmath>
#include <filesystem>
#include <system_error>
#include <utility>

#include "engine/report/csv.h"
#include "engine/report/write_error.h"
#include "engine/session/trace_csv.h"
#include "engine/trials/as_printed.h"
#include "engine/trials/trial_order.h"
#include "engine/trials/trials_file.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

std::string following_name(Following following) {
  return std::string(kFollowingNames[static_cast<std::size_t>(following)]);
}

Result<TraceWriter> create_trace(const std::string& path) {
  std::error_code failed;
  fs::create_directories(fs::path(path).parent_path(), failed);
  if (failed) return write_error(path, failed.value());
  return TraceWriter::create(path);
}

Result<TrialOutcome> run_planned(const ExperimentPlan& plan, const ExperimentScene& scene,
                                 const RunSetup& setup, const TrialFunctions& functions,
                                 const OperatorParameters& person,
                                 const TrialConditions& conditions, const std::string& trace_path) {
  if (trace_path.empty()) {
    return functions.run(scene.scene, scene.way, setup, plan.trial, person, conditions, {});
  }
  auto writer = create_trace(trace_path);
  if (!writer) return writer.error();
  auto outcome = functions.run(scene.scene, scene.way, setup, plan.trial, person, conditions,
                               [&](const TickRecord& record) { writer->add(record); });
  if (!outcome) return outcome;
  const auto written = writer->finish();
  if (!written) return written.error();
  return outcome;
}

// The conditions of a block in the order of the square: participant i has row i + block, counted
// from 1 to the number of rows and then from 1 again.
std::vector<PlanCondition> in_williams_order(const ExperimentPlan& plan, int participant,
                                             int block) {
  const std::vector<PlanCondition> conditions = plan.conditions();
  const std::size_t objects = plan.objects.size();
  const std::size_t levels = plan.level_count();
  const std::size_t row = static_cast<std::size_t>(participant - 1 + block) % levels;
  std::vector<PlanCondition> ordered;
  for (const std::size_t level : williams_row(levels, row)) {
    const PlanCondition& first = conditions[level * objects];
    const std::uint64_t seed = objects_seed(plan.seed, participant, block, plan.level_name(first));
    for (const std::size_t object : trial_order(objects, seed)) {
      ordered.push_back(conditions[level * objects + object]);
    }
  }
  return ordered;
}

std::vector<PlanCondition> ordered_conditions(const ExperimentPlan& plan, int participant,
                                              int block) {
  if (plan.order == ConditionOrder::kWilliams) return in_williams_order(plan, participant, block);
  const std::vector<PlanCondition> conditions = plan.conditions();
  std::vector<PlanCondition> ordered;
  const std::uint64_t seed = order_seed(plan.seed, participant, block);
  for (const std::size_t place : trial_order(conditions.size(), seed)) {
    ordered.push_back(conditions[place]);
  }
  return ordered;
}

// "-still-45deg-x2", or nothing if the plan has one variant.
std::string variant_suffix(const ExperimentPlan& plan, const PlanVariant& variant) {
  if (plan.variants().size() == 1) return {};
  return "-" + std::string(kViewNames[static_cast<std::size_t>(variant.view)]) + "-" +
         as_printed(plan.start_orientation_deg[variant.start]) + "deg-x" +
         as_printed(plan.scale[variant.scale]);
}

}  // namespace

TrialConditions conditions_of(const ExperimentPlan& plan, int participant,
                              const PlannedTrial& trial) {
  const PlanCondition& c = trial.condition;
  const std::string& object = plan.objects[c.object].name;
  TrialConditions conditions;
  conditions.following = trial.following;
  if (c.strategy) {
    conditions.strategy = plan.strategies[*c.strategy];
    // All strategies meet the same noise.
    conditions.noise_seed = noise_seed(plan.seed, participant, trial.block, "", "", object);
    return conditions;
  }
  conditions.force = force_of(kHapticLevels[c.haptic].value);
  conditions.a4 = kRotationLevels[c.rotation].value;
  conditions.noise_seed =
      noise_seed(plan.seed, participant, trial.block, std::string(kHapticNames[c.haptic]),
                 std::string(kRotationNames[c.rotation]), object);
  return conditions;
}

OperatorParameters person_in_block(OperatorParameters person, const ExperimentPlan& plan,
                                   int block) {
  const double times = std::pow(block + 1.0, plan.learning_exponent);
  person.speed_m_per_s *= times;
  person.intention_noise_m /= times;
  return person;
}

TrialRow row_of(const ExperimentPlan& plan, int participant, const PlannedTrial& trial,
                const TrialOutcome& outcome) {
  const PlanCondition& c = trial.condition;
  TrialRow row{.following = following_name(trial.following),
               .participant = std::to_string(participant),
               .block = trial.block,
               .trial = trial.trial,
               .haptic = "",
               .rotation = "",
               .object = plan.objects[c.object].name,
               .attempt = 1,
               .status = outcome.status,
               .measures = outcome.measures};
  if (c.strategy) {
    row.strategy = name_of(plan.strategies[*c.strategy]);
  } else {
    row.haptic = kHapticNames[c.haptic];
    row.rotation = kRotationNames[c.rotation];
  }
  row.view = kViewNames[static_cast<std::size_t>(trial.variant.view)];
  row.align = kAlignmentNames[static_cast<std::size_t>(plan.device.haptics.a4.align)];
  row.start_orientation_deg = plan.start_orientation_deg[trial.variant.start];
  row.scale = plan.scale[trial.variant.scale];
  return row;
}

std::vector<PlannedTrial> planned_trials(const ExperimentPlan& plan, int participant) {
  std::vector<PlannedTrial> trials;
  for (const PlanVariant& variant : plan.variants()) {
    for (const Following following : plan.followings_of(variant.view)) {
      for (const int block : plan.block_numbers()) {
        int place = 0;
        for (const PlanCondition& condition : ordered_conditions(plan, participant, block)) {
          trials.push_back({variant, following, block, ++place, condition});
        }
      }
    }
  }
  return trials;
}

std::string trace_name(const ExperimentPlan& plan, int participant, const PlannedTrial& trial) {
  const std::size_t in_block = plan.conditions().size();
  std::string place = std::to_string(trial.trial);
  place.insert(0, std::to_string(in_block).size() - place.size(), '0');
  const std::string name = "block-" + std::to_string(trial.block) + "-trial-" + place + "-" +
                           plan.level_name(trial.condition) + "-" +
                           plan.objects[trial.condition.object].name +
                           variant_suffix(plan, trial.variant) + ".csv";
  return (fs::path(following_name(trial.following)) /
          ("participant-" + std::to_string(participant)) / name)
      .string();
}

bool is_trace_name(std::string_view file_name) {
  return file_name.starts_with("block-") && file_name.ends_with(".csv");
}

Result<std::optional<UnitRun>> run_participant(const ExperimentPlan& plan,
                                               const std::vector<ExperimentScene>& scenes,
                                               const TrialFunctions& functions, int participant,
                                               const std::string& traces_folder,
                                               UnitTrials& trials) {
  const OperatorParameters person = draw_person(plan.person, plan.seed, participant);
  CsvLines lines("");
  UnitRun run;
  for (const PlannedTrial& trial : planned_trials(plan, participant)) {
    const std::string trace_path =
        traces_folder.empty()
            ? ""
            : (fs::path(traces_folder) / trace_name(plan, participant, trial)).string();
    const std::string* const finished = trials.next();
    if (finished && (trace_path.empty() || fs::exists(trace_path))) {
      run.rows += *finished;
      continue;
    }
    const std::size_t scene = scene_index(plan, trial.variant, trial.condition.object);
    const RunSetup setup =
        turned_setup(scenes[scene].setup, plan.start_orientation_deg[trial.variant.start]);
    const auto outcome = run_planned(plan, scenes[scene], setup, functions,
                                     person_in_block(person, plan, trial.block),
                                     conditions_of(plan, participant, trial), trace_path);
    if (!outcome) return outcome.error();
    lines.clear();
    add_row(lines, row_of(plan, participant, trial, *outcome));
    run.rows += lines.text();
    run.ticks += outcome->ticks;
    run.loop_ns += outcome->loop_ns;
    const auto goes_on = trials.add(lines.text());
    if (!goes_on) return goes_on.error();
    if (!*goes_on) return std::optional<UnitRun>();
  }
  return std::optional<UnitRun>(std::move(run));
}

}  // namespace palpate
