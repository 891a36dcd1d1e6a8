#include "engine/rig/rig.h"

#include <utility>

namespace palpate {

Rig::Rig(HapticLoop loop, const RunSetup& setup, Device& device, const Scene* scene,
         std::optional<SteadyMotions> motions, RigParts parts)
    : motions_(std::move(motions)),
      loop_(std::move(loop)),
      session_(loop_, device, connect(setup, scene, std::move(parts))) {}

// The order of the lists decides the bits of a run with moving nodes, and what a recording holds.
SessionParts Rig::connect(const RunSetup& setup, const Scene* scene, RigParts parts) {
  if (parts.has_measured_times) loop_.use_measured_times();
  keeper_ = std::move(parts.keeper);
  SessionParts session{.max_force_N = setup.max_force_N,
                       .takes_motors = parts.takes_motors,
                       .governor = setup.governor,
                       .sink = parts.sink};
  if (motions_) session.changes.push_back(&*motions_);
  if (scene && parts.has_tuner) session.changes.push_back(&tuner_.emplace(*scene));
  session.changes.insert(session.changes.end(), parts.changes.begin(), parts.changes.end());
  if (scene && parts.stays_inside) {
    session.changes.push_back(&start_inside_.emplace(*scene, *parts.stays_inside));
  }
  if (keeper_) session.observers.push_back(keeper_.get());
  session.observers.insert(session.observers.end(), parts.observers.begin(), parts.observers.end());
  return session;
}

Result<std::unique_ptr<Rig>> Rig::create(const Scene& scene, const RunSetup& setup, Device& device,
                                         RigParts parts) {
  if (auto error = check_setup(scene, setup)) return *error;
  auto motions = SteadyMotions::create(scene, setup.moves);
  if (!motions) return motions.error();
  return create(scene.world(), setup, device, &scene, std::move(*motions), std::move(parts));
}

Result<std::unique_ptr<Rig>> Rig::create(const ContactWorld& world, const RunSetup& setup,
                                         Device& device, RigParts parts) {
  return create(world, setup, device, nullptr, std::nullopt, std::move(parts));
}

Result<std::unique_ptr<Rig>> Rig::create(const ContactWorld& world, const RunSetup& setup,
                                         Device& device, const Scene* scene,
                                         std::optional<SteadyMotions> motions, RigParts parts) {
  auto loop = HapticLoop::create(world, setup.actuation, setup.haptics);
  if (!loop) return loop.error();
  return std::unique_ptr<Rig>(
      new Rig(std::move(*loop), setup, device, scene, std::move(motions), std::move(parts)));
}

std::unique_ptr<RecordKeeper> Rig::take_keeper() {
  keeper_->end_pass(loop_);
  return std::move(keeper_);
}

}  // namespace palpate
