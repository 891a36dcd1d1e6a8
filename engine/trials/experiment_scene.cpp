#include "engine/trials/experiment_scene.h"

#include <algorithm>
#include <numbers>
#include <optional>
#include <sstream>
#include <utility>

#include "engine/rig/placed_bounds.h"
#include "engine/rig/workspace.h"
#include "engine/scene/load_warnings.h"
#include "engine/session/start_inside.h"
#include "engine/simulation/plane_height.h"
#include "engine/simulation/simulated_device.h"
#include "engine/trials/as_printed.h"
#include "engine/trials/key_hash.h"
#include "engine/trials/operator_hand.h"
#include "engine/trials/plan_device.h"
#include "io/gltf/file.h"
#include "io/gltf/limits.h"

namespace palpate {
namespace {

constexpr const char* kDeviceElement = "/device";

std::string element_of(const PlanObject& object) {
  return "/objects/" + object.name;
}

Result<std::uint64_t> hash_of_file(const std::string& path) {
  const auto bytes = read_regular_file(path, kMaxGltfFileBytes);
  if (!bytes) return bytes.error();
  const std::string_view text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  return KeyHash().add(text).value();
}

std::uint64_t hash_of_geometry(const Scene& scene) {
  std::vector<Vec3> positions_m;
  std::vector<Triangle> triangles;
  scene.append_triangles_scene(positions_m, triangles);
  KeyHash hash;
  hash.add(std::uint64_t{positions_m.size()});
  for (const Vec3& p : positions_m) hash.add(p.x()).add(p.y()).add(p.z());
  hash.add(std::uint64_t{triangles.size()});
  for (const Triangle& t : triangles) {
    for (const std::uint32_t corner : t) hash.add(std::uint64_t{corner});
  }
  return hash.value();
}

Error scene_error(Error error, const PlanObject& object) {
  error = with_plan_keys(std::move(error));
  if (error.path.empty()) error.path = object.path;
  return error;
}

// An error of the device together with this object.
Error device_error(Error error, const ExperimentPlan& plan) {
  error = as_plan_error(std::move(error), kDeviceElement);
  error.path = plan.path;
  return error;
}

// An error of an object at a level of the plan names the level.
Error of_level(Error error, const std::vector<double>& levels, double level, const char* key,
               const PlanObject& object) {
  const auto place = std::find(levels.begin(), levels.end(), level) - levels.begin();
  error.element = std::string("/") + key + "/" + std::to_string(place);
  error.problem =
      "is " + as_printed(level) + ", with which object " + object.name + " " + error.problem;
  error.hint = "choose another level, or a smaller object";
  return error;
}

// The error of the first orientation in which the scene is larger than the workspace.
std::optional<Error> check_size(const ExperimentPlan& plan, const PlanObject& object,
                                const Scene& scene, const RunSetup& setup) {
  for (const double start_deg : plan.start_orientation_deg) {
    auto misfit = check_fits(scene, turned_setup(setup, start_deg));
    if (!misfit) continue;
    const bool is_of_scene = misfit->element == "scene";
    Error error = device_error(*misfit, plan);
    if (!is_of_scene) return error;
    error.element = element_of(object);
    if (start_deg == 0.0) return error;
    error = of_level(error, plan.start_orientation_deg, start_deg, "start_orientation_deg", object);
    error.path = plan.path;
    return error;
  }
  return std::nullopt;
}

std::optional<Error> choose_plane(const ExperimentPlan& plan, const PlanObject& object,
                                  const Scene& scene, RunSetup& setup) {
  if (plan.device.plane_height_m) return std::nullopt;
  const auto height_m = height_with_contour_m(scene, setup.haptics.initial_pose);
  if (!height_m) {
    return Error{ErrorCode::kInvalidContent, plan.path, element_of(object),
                 "has no contour in a plane across A3: every face lies across A3",
                 "turn the scene with /device/place"};
  }
  setup.haptics.plane_height_m = *height_m;
  return std::nullopt;
}

// An error of finding the way of the trials. The height of the plane is a setting of the plan.
Error way_error(const Error& error, const ExperimentPlan& plan, const PlanObject& object,
                const Scene& scene, const RunSetup& setup) {
  if (error.element != "plane_height_m") return scene_error(error, object);
  const Box bounds = bounds_in_device(scene, setup.haptics.initial_pose);
  std::ostringstream text;
  text << "is " << setup.haptics.plane_height_m << " m; expected a height at which object "
       << object.name << " has a contour; it spans " << bounds.low.z() << " to " << bounds.high.z()
       << " m along A3";
  return {ErrorCode::kInvalidContent, plan.path, std::string(kDeviceElement) + "/plane_height_m",
          text.str(), "choose another height, or leave it out: each object then has its own"};
}

// The error of the first strategy that the scene or the device does not accept.
std::optional<Error> check_strategies(const ExperimentPlan& plan, const PlanObject& object,
                                      const Scene& scene, const RunSetup& setup) {
  for (std::size_t i = 0; i < plan.strategies.size(); ++i) {
    RunSetup with_strategy = setup;
    set_strategy(plan.strategies[i], with_strategy.haptics);
    const auto refused = check_setup(scene, with_strategy);
    if (!refused) continue;
    Error error = device_error(*refused, plan);
    error.element = "/strategies/" + std::to_string(i);
    error.problem = name_of(plan.strategies[i]) + " is refused for object " + object.name + ": " +
                    error.problem;
    return error;
  }
  return std::nullopt;
}

Result<ExperimentScene> load_experiment_scene(const ExperimentPlan& plan, const PlanObject& object,
                                              double scale, const TrialFunctions& functions) {
  auto setup = make_setup(plan.device);
  if (!setup) return device_error(setup.error(), plan);
  const auto file_hash = hash_of_file(object.path);
  if (!file_hash) return file_hash.error();
  SceneSettings settings = object.scene;
  settings.scale *= scale;
  settings.fit_size_m *= scale;
  settings.close_gaps_m *= scale;  // joins the same edges in every size
  settings.proxy_radius_m = plan.device.haptics.god_object.radius_m;
  auto scene = Scene::load(object.path, settings);
  if (!scene) return scene_error(scene.error(), object);
  if (auto error = check_tick_rate(scene->effects(), plan.device.rate_Hz)) {
    return scene_error(*error, object);
  }
  if (scene->objects().empty()) {
    return Error{ErrorCode::kEmptyScene, object.path, "",
                 "has no surface that can be touched; expected one", ""};
  }
  if (auto error = check_size(plan, object, *scene, *setup)) return *error;
  if (auto error = choose_plane(plan, object, *scene, *setup)) return *error;
  if (auto error = check_setup(*scene, *setup)) return device_error(*error, plan);
  if (auto error = check_strategies(plan, object, *scene, *setup)) return *error;
  auto way = functions.find_way(*scene, *setup, plan.trial);
  if (!way) return way_error(way.error(), plan, object, *scene, *setup);
  const std::uint64_t geometry_hash = hash_of_geometry(*scene);
  return ExperimentScene{std::move(*scene), std::move(settings), std::move(*setup),
                         std::move(*way),   *file_hash,          geometry_hash};
}

// The most persons whose starts are examined; more would take longer than a trial.
constexpr int kMostExamined = 256;

// The object that encloses the hand of a person where a trial begins; no value if none does.
std::optional<std::size_t> object_around_start(const ExperimentPlan& plan,
                                               const ExperimentScene& scene) {
  if (scene.way.path.points.size() < 2) return std::nullopt;  // of a stand-in for a trial
  const Following following = plan.followings.empty() ? Following{} : plan.followings.front();
  for (int participant = 1; participant <= std::min(plan.participants, kMostExamined);
       ++participant) {
    const OperatorHand hand(scene.way, draw_person(plan.person, plan.seed, participant), following,
                            plan.trial, scene.setup.haptics.god_object.radius_m);
    if (auto object = enclosing_object(scene.scene, hand.start_scene_m())) return object;
  }
  return std::nullopt;
}

}  // namespace

RunSetup turned_setup(RunSetup setup, double start_orientation_deg) {
  if (start_orientation_deg == 0.0) return setup;
  ScenePose& pose = setup.haptics.initial_pose;
  const Quat turn(
      Eigen::AngleAxisd(start_orientation_deg * std::numbers::pi / 180.0, Vec3::UnitZ()));
  pose = {(turn * pose.rotation).normalized(), turn * pose.translation_m};
  return setup;
}

std::size_t scene_index(const ExperimentPlan& plan, const PlanVariant& variant,
                        std::size_t object) {
  return variant.scale * plan.objects.size() + object;
}

Result<std::vector<ExperimentScene>> load_experiment_scenes(const ExperimentPlan& plan,
                                                            const TrialFunctions& functions) {
  std::vector<ExperimentScene> scenes;
  for (const double scale : plan.scale) {
    for (const PlanObject& object : plan.objects) {
      auto scene = load_experiment_scene(plan, object, scale, functions);
      if (!scene && scale != 1.0 && scene.error().element == element_of(object)) {
        Error error = of_level(scene.error(), plan.scale, scale, "scale", object);
        error.path = plan.path;
        return error;
      }
      if (!scene) return scene.error();
      scenes.push_back(std::move(*scene));
    }
  }
  return scenes;
}

std::vector<std::string> scene_warnings(const ExperimentPlan& plan,
                                        const std::vector<ExperimentScene>& scenes) {
  std::vector<std::string> warnings;
  for (std::size_t i = 0; i < plan.objects.size() && i < scenes.size(); ++i) {
    for (std::string& line : load_warnings(scenes[i].scene)) {
      const Error named = with_plan_keys(Error{ErrorCode::kInvalidContent, "", "", line, ""});
      warnings.push_back(plan.objects[i].path + ": " + named.problem);
    }
    for (std::size_t scaled = i; scaled < scenes.size(); scaled += plan.objects.size()) {
      const auto object = object_around_start(plan, scenes[scaled]);
      if (!object) continue;
      warnings.push_back(plan.objects[i].path + ": " +
                         felt_inside_text(scenes[scaled].scene, *object));
      break;
    }
  }
  return warnings;
}

std::optional<Error> check_persons(const ExperimentPlan& plan, const RunSetup& setup) {
  if (auto error = check_simulable(plan)) return error;
  for (int participant = 1; participant <= plan.participants; ++participant) {
    const OperatorParameters person = draw_person(plan.person, plan.seed, participant);
    if (auto error = check_plant(plant_of(setup, person, 0), setup.dt_s))
      return device_error(*error, plan);
  }
  return std::nullopt;
}

}  // namespace palpate
