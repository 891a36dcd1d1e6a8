#pragma once

// Moves nodes of a scene during a session.

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

// Passes poses of nodes from an application to the haptic thread. All nodes below a moved node move
// with it. If a movable node is below another movable node, both motions add up.
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

  // Makes a node movable and returns its handle. node: a name as in find_node(). Returns an error
  // if the node does not exist, if its subtree has no surface to touch, or if more than
  // LiveWorld::kMostMoving bodies would move. Allocates: call it before the session starts.
  Result<std::size_t> add(const std::string& node);

  // Sets the displacement of a node from its pose in the file:
  // p_scene = T_scene_rest * p_scene_as_loaded. An invalid pose (see is_pose) is ignored and sets
  // kFaultBadBodyPose in every tick until another pose is set. Wait-free. Only one thread at a time
  // may set the pose of a node.
  void set(std::size_t handle, const RigidTransform& T_scene_rest) noexcept;

  // Called on the haptic thread before a tick.
  void move_bodies(double time_s, LoopChanges loop) noexcept override;

 private:
  // Plain numbers, so that they can be copied bytewise.
  using PoseNumbers = std::array<double, 7>;  // q w x y z, translation

  struct MovableNode {
    std::uint32_t tree_node;
    std::uint32_t end;            // end of its subtree
    RigidTransform T_scene_rest;  // the last valid pose
    bool has_moved = false;
    std::unique_ptr<SnapshotRing<PoseNumbers>> mailbox;
  };
  struct MovableBody {
    std::uint32_t body;
    std::vector<std::size_t> nodes;  // the movable nodes above it, outermost first
  };

  bool collect() noexcept;
  void find_bodies();

  const Scene* scene_;
  std::vector<MovableNode> nodes_;
  std::vector<MovableBody> bodies_;
};

// A motion with constant velocity and angular velocity. At time 0 the node has its pose in the
// file; it rotates about the point where its origin lies in that pose.
struct SteadyMotion {
  std::string node;
  Vec3 velocity_m_per_s = Vec3::Zero();
  Vec3 turn_rad_per_s = Vec3::Zero();  // scene axes
};

// Moves nodes with constant velocities from time 0 on, as `--move` requests.
class SteadyMotions final : public WorldMover {
 public:
  static Result<SteadyMotions> create(const Scene& scene, const std::vector<SteadyMotion>& motions);

  void move_bodies(double time_s, LoopChanges loop) noexcept override;

  // Of an application, for other nodes than these.
  NodeMotions& nodes() { return *motions_; }

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
