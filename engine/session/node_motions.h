#pragma once

// Nodes of a scene that move while the hand feels them.

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "engine/devices/snapshot_ring.h"
#include "engine/scene/scene.h"
#include "engine/session/haptic_session.h"
#include "geometry/base/result.h"

namespace palpate {

// Poses of nodes on their way from an application to the haptic thread. A node takes all below it
// along; a moving node below another moves on top of that one's motion.
//
//     NodeMotions motions(scene);
//     const auto lid = motions.add("lid");                 // before the session starts
//     HapticSession session(loop, device, {.changes = {&motions}});
//     ...
//     motions.set(*lid, T_scene_rest);                     // at any time, from one thread
class NodeMotions final : public WorldMover {
 public:
  // The scene must outlive the motions.
  explicit NodeMotions(const Scene& scene);

  // Makes a node movable (named as for find_node) and returns its handle. An error if there is no
  // such node, nothing to touch below it, or more bodies would move than LiveWorld::kMostMoving.
  // Allocates: before the session starts.
  Result<std::size_t> add(const std::string& node);

  // Where the node is, relative to where the file has it: p_scene = T_scene_rest p_scene_as_loaded.
  // Wait-free; one thread at a time for each node. What is no pose (is_pose) is not
  // taken, and kFaultBadBodyPose tells for as long as no other one is set.
  void set(std::size_t handle, const RigidTransform& T_scene_rest) noexcept;

  // On the haptic thread, before a tick.
  void move_bodies(double time_s, HapticLoop& loop) noexcept override;

 private:
  // Plain numbers, so that they can be copied as bits.
  using PoseNumbers = std::array<double, 7>;  // q w x y z, translation

  struct MovableNode {
    std::uint32_t tree_node;
    std::uint32_t end;            // of its subtree
    RigidTransform T_scene_rest;  // the last that was a pose
    bool has_moved = false;
    std::unique_ptr<SnapshotRing<PoseNumbers>> mailbox;
  };
  struct MovableBody {
    std::uint32_t body;
    std::vector<std::size_t> nodes;  // that move it, the outermost first
  };

  bool collect() noexcept;
  void find_bodies();

  const Scene* scene_;
  std::vector<MovableNode> nodes_;
  std::vector<MovableBody> bodies_;
};

// A node that moves steadily: about the origin it has in the file, at first there.
struct SteadyMotion {
  std::string node;
  Vec3 velocity_m_per_s = Vec3::Zero();
  Vec3 turn_rad_per_s = Vec3::Zero();  // scene axes
};

// Moves nodes steadily from time 0 on: what `--move` does.
class SteadyMotions final : public WorldMover {
 public:
  static Result<SteadyMotions> create(const Scene& scene, const std::vector<SteadyMotion>& motions);

  void move_bodies(double time_s, HapticLoop& loop) noexcept override;

 private:
  struct Mover {
    std::size_t handle;
    SteadyMotion motion;
    Vec3 pivot_scene_m;
  };

  explicit SteadyMotions(const Scene& scene) : motions_(std::make_unique<NodeMotions>(scene)) {}

  std::unique_ptr<NodeMotions> motions_;
  std::vector<Mover> movers_;
};

}  // namespace palpate
