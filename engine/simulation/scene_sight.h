#pragma once

// What is in the way in a scene.

#include "haptics/proxy/contact_world.h"

namespace palpate {

// Looks along segments for any surface of the scene.
class SceneSight {
 public:
  explicit SceneSight(const ContactWorld& world) : world_(world) {}

  // The part of the segment up to the first surface; infinity if there is none.
  double first_hit(const Vec3& from_scene, const Vec3& to_scene) const;

 private:
  const ContactWorld& world_;
};

}  // namespace palpate
