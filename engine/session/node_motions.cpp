#include "engine/session/node_motions.h"

#include <algorithm>

#include "engine/scene/node_tree.h"

namespace palpate {
namespace {

RigidTransform pose_of(const std::array<double, 7>& n) {
  return {Quat(n[0], n[1], n[2], n[3]), Vec3(n[4], n[5], n[6])};
}

// Applies inner first, then outer.
RigidTransform composed(const RigidTransform& outer, const RigidTransform& inner) {
  return {outer.rotation * inner.rotation, outer.point(inner.translation_m)};
}

}  // namespace

NodeMotions::NodeMotions(const Scene& scene) : scene_(&scene) {}

Result<std::size_t> NodeMotions::add(const std::string& node) {
  const auto found = find_node(scene_->tree(), node);
  if (!found) return found.error();
  const auto known = std::find_if(nodes_.begin(), nodes_.end(),
                                  [&](const MovableNode& n) { return n.tree_node == *found; });
  if (known != nodes_.end()) return static_cast<std::size_t>(known - nodes_.begin());
  const auto bodies_before = bodies_;
  nodes_.push_back({*found,
                    end_of_subtree(scene_->tree(), *found),
                    {},
                    false,
                    std::make_unique<SnapshotRing<PoseNumbers>>()});
  find_bodies();
  const bool moves_something =
      std::any_of(bodies_.begin(), bodies_.end(), [&](const MovableBody& body) {
        return std::find(body.nodes.begin(), body.nodes.end(), nodes_.size() - 1) !=
               body.nodes.end();
      });
  if (moves_something && bodies_.size() <= LiveWorld::kMostMoving) return nodes_.size() - 1;
  const std::size_t count = bodies_.size();
  nodes_.pop_back();
  bodies_ = bodies_before;
  return Error{ErrorCode::kInvalidArgument, "", "node \"" + node + "\"",
               moves_something ? "raises the number of moving bodies to " + std::to_string(count) +
                                     "; expected at most " + std::to_string(LiveWorld::kMostMoving)
                               : "has no surface that can be touched",
               moves_something ? "move fewer nodes" : "name a node with a solid mesh"};
}

// Lists the bodies below the movable nodes.
void NodeMotions::find_bodies() {
  bodies_.clear();
  const auto& objects = scene_->objects();
  for (std::uint32_t b = 0; b < objects.size(); ++b) {
    MovableBody body{b, {}};
    for (std::size_t n = 0; n < nodes_.size(); ++n) {
      const bool is_below =
          objects[b].tree_node >= nodes_[n].tree_node && objects[b].tree_node < nodes_[n].end;
      if (is_below) body.nodes.push_back(n);
    }
    if (body.nodes.empty()) continue;
    // In the tree, a node precedes the nodes below it.
    std::sort(body.nodes.begin(), body.nodes.end(), [&](std::size_t a, std::size_t c) {
      return nodes_[a].tree_node < nodes_[c].tree_node;
    });
    bodies_.push_back(std::move(body));
  }
}

void NodeMotions::set(std::size_t handle, const RigidTransform& T) noexcept {
  nodes_[handle].mailbox->publish({T.rotation.w(), T.rotation.x(), T.rotation.y(), T.rotation.z(),
                                   T.translation_m.x(), T.translation_m.y(), T.translation_m.z()});
}

// Reads the newest pose of each node and keeps it if it is valid. Returns false if any was invalid.
bool NodeMotions::collect() noexcept {
  bool all_good = true;
  for (MovableNode& node : nodes_) {
    PoseNumbers numbers;
    if (!node.mailbox->read(numbers)) continue;
    RigidTransform T_scene_rest = pose_of(numbers);
    if (!is_pose(T_scene_rest)) {
      all_good = false;
      continue;
    }
    T_scene_rest.rotation.normalize();
    node.T_scene_rest = T_scene_rest;
    node.has_moved = true;
  }
  return all_good;
}

void NodeMotions::move_bodies(double /*time_s*/, LoopChanges loop) noexcept {
  if (!collect()) loop.refuse_body_pose();
  for (const MovableBody& body : bodies_) {
    RigidTransform T_scene_rest;
    bool has_moved = false;
    for (const std::size_t n : body.nodes) {
      T_scene_rest = composed(T_scene_rest, nodes_[n].T_scene_rest);
      has_moved = has_moved || nodes_[n].has_moved;
    }
    if (!has_moved) continue;
    loop.move_body(body.body, composed(T_scene_rest, scene_->objects()[body.body].T_scene_body));
  }
}

Result<SteadyMotions> SteadyMotions::create(const Scene& scene,
                                            const std::vector<SteadyMotion>& motions) {
  SteadyMotions steady(scene);
  for (const SteadyMotion& motion : motions) {
    const auto handle = steady.motions_->add(motion.node);
    if (!handle) return handle.error();
    for (const Mover& mover : steady.movers_) {
      if (mover.handle != *handle) continue;
      return Error{ErrorCode::kInvalidArgument, "", "node \"" + motion.node + "\"",
                   "has two motions; expected one", "remove one of the motions"};
    }
    const auto node = find_node(scene.tree(), motion.node);
    steady.movers_.push_back({*handle, motion, scene.tree()[*node].origin_m});
  }
  return steady;
}

void SteadyMotions::move_bodies(double time_s, LoopChanges loop) noexcept {
  for (const Mover& mover : movers_) {
    RigidTransform T_scene_rest;
    const double angle_rad = time_s * mover.motion.turn_rad_per_s.norm();
    if (angle_rad > 0.0) {
      T_scene_rest.rotation =
          Eigen::AngleAxisd(angle_rad, mover.motion.turn_rad_per_s.normalized());
    }
    T_scene_rest.translation_m = mover.pivot_scene_m - T_scene_rest.rotation * mover.pivot_scene_m +
                                 time_s * mover.motion.velocity_m_per_s;
    motions_->set(mover.handle, T_scene_rest);
  }
  motions_->move_bodies(time_s, loop);
}

}  // namespace palpate
