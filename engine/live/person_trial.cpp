#include "engine/live/person_trial.h"

#include <algorithm>
#include <utility>

namespace palpate {

RunSetup PersonTrial::setup_of(const ExperimentScene& scene, const Vec3& start_scene_m,
                               const PersonTrialSettings& settings) {
  RunSetup setup = scene.setup;
  setup.haptics.force = settings.force;
  setup.haptics.a4.enabled = settings.a4;
  if (settings.hand_m) {
    ScenePose& pose = setup.haptics.initial_pose;
    const Vec3 shift_m = *settings.hand_m - pose.point(start_scene_m);
    pose.translation_m += Vec3(shift_m.x(), shift_m.y(), 0.0);
  }
  return setup;
}

Result<std::unique_ptr<PersonTrial>> PersonTrial::create(const ExperimentScene& scene,
                                                         const Vec3& start_scene_m,
                                                         const PersonTrialSettings& settings,
                                                         GuardableDevice* board) {
  const RunSetup setup = setup_of(scene, start_scene_m, settings);
  if (auto error = check_setup(scene.scene, setup)) return *error;
  if (settings.grip) {
    if (auto error = check_plant(led_plant(setup, *settings.grip), setup.dt_s)) return *error;
  }
  const Vec3 start_m = setup.haptics.initial_pose.point(start_scene_m);
  std::unique_ptr<PersonTrial> trial(new PersonTrial(scene, setup, start_m, settings));
  if (auto error = trial->make_rig(scene.scene, setup, settings, board)) return *error;
  return trial;
}

PersonTrial::PersonTrial(const ExperimentScene& scene, const RunSetup& setup,
                         const Vec3& start_device_m, const PersonTrialSettings& settings)
    : pointer_(setup.device, start_device_m, settings.permits_clutch),
      clock_(settings.has_clock
                 ? std::make_unique<TrialClock>(scene.way, settings.trial,
                                                setup.haptics.god_object.radius_m, setup.dt_s)
                 : nullptr),
      watch_(clock_.get(), setup.dt_s, settings.longest_lateness_s, &pointer_.clutch()) {
  if (settings.grip) led_.emplace(pointer_, setup, *settings.grip, start_device_m);
}

std::optional<Error> PersonTrial::make_rig(const Scene& scene, const RunSetup& setup,
                                           const PersonTrialSettings& settings,
                                           GuardableDevice* board) {
  std::vector<TickObserver*> observers{&pointer_};
  if (clock_) observers.push_back(clock_.get());
  observers.push_back(&watch_);
  is_on_board_ = board != nullptr;
  Device& pointed = led_ ? static_cast<Device&>(led_->device()) : pointer_;
  Device& device = board == nullptr ? pointed : *board;
  auto rig = Rig::create(scene, setup, device,
                         {.observers = observers,
                          .sink = settings.sink,
                          // Motors that turn with the linkage are what it can push; two of them
                          // push everywhere, and the plan's axis is a choice.
                          .takes_motors = board != nullptr && board->description().motor_count == 1,
                          // A hand on a board may have moved on since the scene was placed at it.
                          .stays_inside = board ? std::optional(false) : std::nullopt});
  if (!rig) return rig.error();
  rig_ = std::move(*rig);
  const std::size_t most_moving =
      setup.moves.empty() ? 0 : std::min(scene.objects().size(), LiveWorld::kMostMoving);
  publisher_.emplace(rig_->loop(), board == nullptr ? &pointer_ : nullptr, most_moving);
  rig_->session().observe(*publisher_);
  thread_.emplace(
      rig_->session(), board,
      GuardedRunSettings{
          {1.0 / setup.dt_s, 0, settings.cpu}, settings.has_guard, settings.without_realtime});
  return std::nullopt;
}

bool PersonTrial::waits_inside() const {
  return is_on_board_ && rig_->start_inside().status().phase == StartInside::Phase::kInside;
}

std::optional<TripReason> PersonTrial::trip() const {
  GovernorStatus governor;
  if (!rig_->session().latest(governor) || governor.trips == 0) return std::nullopt;
  return governor.trip.reason;
}

}  // namespace palpate
