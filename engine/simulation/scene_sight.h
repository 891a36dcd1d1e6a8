#pragma once

// Obstacles along segments in a scene.

#include "haptics/proxy/contact_world.h"

namespace palpate {

// Finds the first surface of the scene on a segment.
class SceneSight {
 public:
  explicit SceneSight(const ContactWorld& world) : world_(world) {}

  // The fraction of the segment before its first intersection with a surface; infinity if there is
  // no intersection.
  double first_hit(const Vec3& from_scene, const Vec3& to_scene) const;

 private:
  const ContactWorld& world_;
};

}  // namespace palpate
