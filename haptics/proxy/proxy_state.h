#pragma once

// The result of a god-object's tick and its contacts: the interface between the god-object and
// haptic effects.

#include <array>
#include <span>

#include "haptics/proxy/contact.h"
#include "haptics/proxy/friction_cone.h"
#include "haptics/proxy/live_world.h"
#include "haptics/proxy/plane_projection.h"
#include "haptics/proxy/work.h"

namespace palpate {

// The result of one tick of a god-object. Solver frame, metres.
struct ProxyState {
  Vec3 proxy = Vec3::Zero();
  // Normalised average of the active planes' normals; 0 without contact or if the normals cancel.
  // If a capped tick has no active plane, this is the direction from the goal to the proxy.
  Vec3 normal = Vec3::Zero();
  bool in_contact = false;  // |proxy - goal| exceeds the step tolerance
  int active_planes = 0;    // number of active planes, at most 3
  // The unit direction of the line that two active planes leave free; 0 for any other number of
  // active planes.
  Vec3 free_direction = Vec3::Zero();
  bool slid = false;     // the proxy moved along the surface in this tick
  bool is_held = false;  // the touched surface has friction
  FrictionState friction = FrictionState::kNone;
  FrictionCone cone;  // friction coefficients of the contact
  int iterations = 0;
  bool capped = false;  // the tick ended before it converged; see GodObject
  // The goal or the settings were invalid. Nothing has moved, and all fields except `proxy` have
  // their values without contact.
  bool is_refused = false;
  WorkUnits work = 0;  // work of the tick, including that of moving bodies

  // The component of a vector along the active planes' normals, which the proxy cannot follow.
  Vec3 pressed_part(const Vec3& v) const {
    if (active_planes > 2 || normal.isZero(0.0)) return v;
    if (active_planes == 2) return v - v.dot(free_direction) * free_direction;
    return v.dot(normal) * normal;
  }
};

// The contacts of a god-object, for code that computes forces. Solver frame, metres. Valid until
// the god-object moves.
class ContactView {
 public:
  ContactView(const LiveWorld& world, std::span<const FaceContact> contacts,
              std::span<const ContactPlane> planes, const std::array<int, 3>& plane_of_contact)
      : world_(world), contacts_(contacts), planes_(planes), plane_of_contact_(plane_of_contact) {}

  const LiveWorld& world() const { return world_; }
  // The faces that hold the proxy, at most three.
  std::span<const FaceContact> contacts() const { return contacts_; }
  // The unit normal of the contact plane of the i-th contact. Under a plane of motion it lies in
  // that plane.
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
