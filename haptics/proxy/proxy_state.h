#pragma once

// What a god-object has found in a tick, and what it touches: all that effects see of it.

#include <array>
#include <span>

#include "haptics/proxy/contact.h"
#include "haptics/proxy/friction_cone.h"
#include "haptics/proxy/live_world.h"
#include "haptics/proxy/plane_projection.h"
#include "haptics/proxy/work.h"

namespace palpate {

// What one step found. Solver frame, metres.
struct ProxyState {
  Vec3 proxy = Vec3::Zero();
  Vec3 normal = Vec3::Zero();  // normalised average of the active planes; 0 if they cancel or none
  bool in_contact = false;     // |proxy - goal| exceeds the step tolerance
  int active_planes = 0;       // that push
  // The unit direction in which two planes leave the proxy free; zero for any other number.
  Vec3 free_direction = Vec3::Zero();
  bool slid = false;     // moved along what it touches, in this step
  bool is_held = false;  // by friction: what it touches has some
  FrictionState friction = FrictionState::kNone;
  FrictionCone cone;  // of what it touches
  int iterations = 0;
  bool capped = false;  // ended before it converged: GodObject says what that means
  // The goal was no goal, or the settings are none: nothing has moved, and the rest of this, but
  // for where the proxy is, is as without contact.
  bool is_refused = false;
  WorkUnits work = 0;  // of the tick, with what its moving bodies took

  // The part of a vector that lies along the planes' normals: what the proxy cannot follow.
  Vec3 pressed_part(const Vec3& v) const {
    if (active_planes > 2 || normal.isZero(0.0)) return v;
    if (active_planes == 2) return v - v.dot(free_direction) * free_direction;
    return v.dot(normal) * normal;
  }
};

// What a god-object touches, for whoever makes forces of it. Solver frame. Valid until it moves.
class ContactView {
 public:
  ContactView(const LiveWorld& world, std::span<const FaceContact> contacts,
              std::span<const ContactPlane> planes, const std::array<int, 3>& plane_of_contact)
      : world_(world), contacts_(contacts), planes_(planes), plane_of_contact_(plane_of_contact) {}

  const LiveWorld& world() const { return world_; }
  // The faces that hold the proxy, at most three, and the unit normals of their planes, which lie
  // in the plane of motion if there is one.
  std::span<const FaceContact> contacts() const { return contacts_; }
  const Vec3& plane_normal(std::size_t i) const {
    return planes_[static_cast<std::size_t>(plane_of_contact_[i])].normal;
  }

 private:
  const LiveWorld& world_;
  std::span<const FaceContact> contacts_;
  std::span<const ContactPlane> planes_;
  const std::array<int, 3>& plane_of_contact_;
};

}  // namespace palpate
