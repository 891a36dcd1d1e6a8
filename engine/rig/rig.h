#pragma once

// A rig: a scene, a device, and all that lies between them for one session.

#include <memory>
#include <optional>
#include <vector>

#include "engine/rig/record_keeper.h"
#include "engine/scene/scene.h"
#include "engine/session/haptic_session.h"
#include "engine/session/material_tuner.h"
#include "engine/session/node_motions.h"
#include "engine/session/run_setup.h"
#include "engine/session/start_inside.h"
#include "geometry/base/result.h"

namespace palpate {

// What a session has beside the scene, the setup and the device. All objects must outlive the rig.
struct RigParts {
  // Called before every tick, in the order of the list: after the motions of the nodes and the
  // tuner, and before StartInside.
  std::vector<BeforeTick*> changes = {};
  // Called after every tick, in the order of the list, after the keeper.
  std::vector<TickObserver*> observers = {};
  std::unique_ptr<RecordKeeper> keeper = {};  // null: the rig keeps no records
  TickSink* sink = nullptr;                   // see SessionParts
  bool takes_motors = true;                   // see SessionParts
  bool has_tuner = false;                     // the materials of the scene can be changed
  // The hand may begin inside a closed surface: true: it stays there and feels it; false: it gets
  // no force until it has left (StartInside). No value: the hand is never freed.
  std::optional<bool> stays_inside = {};
  bool has_measured_times = false;  // see HapticLoop::use_measured_times
};

// Owns the loop, the motions of the nodes, the tuner of the materials, the keeper of the records
// and the session. One thread owns a rig; the thread that calls session().tick() may be another.
class Rig {
 public:
  // The nodes that setup.moves names move from the first tick on. scene and device must outlive the
  // rig. Errors: those of check_setup(); a node that setup.moves names does not exist or cannot
  // move.
  static Result<std::unique_ptr<Rig>> create(const Scene& scene, const RunSetup& setup,
                                             Device& device, RigParts parts = {});
  // A rig without a scene. Its nodes do not move: setup.moves, has_tuner and stays_inside do not
  // count. Errors: those of HapticLoop::create().
  static Result<std::unique_ptr<Rig>> create(const ContactWorld& world, const RunSetup& setup,
                                             Device& device, RigParts parts = {});
  Rig(const Rig&) = delete;
  Rig& operator=(const Rig&) = delete;

  HapticSession& session() { return session_; }
  const HapticSession& session() const { return session_; }
  // Without a device: loop().tick() runs a tick at a given position, and no session.
  HapticLoop& loop() { return loop_; }
  const HapticLoop& loop() const { return loop_; }

  // Of a rig with a scene: adds nodes that the application moves, and moves them.
  NodeMotions& nodes() { return motions_->nodes(); }
  // Requires RigParts::has_tuner.
  MaterialTuner& tuner() { return *tuner_; }
  // Requires RigParts::stays_inside.
  StartInside& start_inside() { return *start_inside_; }
  // Hands over the keeper with what this rig's loop counted. Requires RigParts::keeper. Call it
  // once, after the last tick.
  std::unique_ptr<RecordKeeper> take_keeper();

 private:
  // scene: null for a rig without a scene.
  static Result<std::unique_ptr<Rig>> create(const ContactWorld& world, const RunSetup& setup,
                                             Device& device, const Scene* scene,
                                             std::optional<SteadyMotions> motions, RigParts parts);
  Rig(HapticLoop loop, const RunSetup& setup, Device& device, const Scene* scene,
      std::optional<SteadyMotions> motions, RigParts parts);
  SessionParts connect(const RunSetup& setup, const Scene* scene, RigParts parts);

  std::optional<SteadyMotions> motions_;
  std::optional<MaterialTuner> tuner_;
  std::optional<StartInside> start_inside_;
  std::unique_ptr<RecordKeeper> keeper_;
  HapticLoop loop_;
  HapticSession session_;
};

}  // namespace palpate
