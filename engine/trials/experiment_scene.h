#pragma once

// The objects of a plan, loaded and checked before the first trial.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "engine/scene/scene.h"
#include "engine/session/run_setup.h"
#include "engine/trials/plan.h"
#include "engine/trials/trial.h"
#include "geometry/base/result.h"

namespace palpate {

// find_trial_way() and run_trial() of trial.h. They are passed as arguments, so that tests of the
// code around a trial can replace the trial with a short computation.
struct TrialFunctions {
  std::function<Result<TrialWay>(const Scene&, const RunSetup&, const TrialSettings&)> find_way;
  std::function<Result<TrialOutcome>(const Scene&, const TrialWay&, const RunSetup&,
                                     const TrialSettings&, const OperatorParameters&,
                                     const TrialConditions&, const TrialSink&)>
      run;
};

// An object, ready for trials.
struct ExperimentScene {
  Scene scene;
  SceneSettings settings;  // with which it was loaded
  RunSetup setup;          // with the height of the plane, and before the turn of a variant
  TrialWay way;
  std::uint64_t file_hash;      // of the bytes of the file
  std::uint64_t geometry_hash;  // of the triangles in the scene frame, in metres
};

// The setup of a variant: the scene is turned about A3 through the device's origin.
RunSetup turned_setup(RunSetup setup, double start_orientation_deg);

// The index of an object's scene in the list of load_experiment_scenes().
std::size_t scene_index(const ExperimentPlan& plan, const PlanVariant& variant, std::size_t object);

// Loads every object of the plan in every scale, and checks it in every orientation. Errors, with
// the path of the plan or of the object's file: those of Scene::load(), make_setup(), check_setup()
// and find_way, a scene that is larger than the workspace, an effect that the rate is too low for,
// a scene that no plane cuts, and a strategy that a scene or the device does not accept.
Result<std::vector<ExperimentScene>> load_experiment_scenes(const ExperimentPlan& plan,
                                                            const TrialFunctions& functions);

// The load_warnings() of the objects, and a line where the hand begins inside one of them, each
// after the file of the object and with the keys of the plan in place of fields. scenes: those of
// load_experiment_scenes().
std::vector<std::string> scene_warnings(const ExperimentPlan& plan,
                                        const std::vector<ExperimentScene>& scenes);

// Returns the error of check_simulable(), or one if the hand of a person is unstable on this
// device. Calls check_plant() for every participant of the plan.
std::optional<Error> check_persons(const ExperimentPlan& plan, const RunSetup& setup);

}  // namespace palpate
