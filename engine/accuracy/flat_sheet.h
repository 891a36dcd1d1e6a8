#pragma once

// A flat sheet in any pose, for knobs that use a plane as reference.

#include "engine/accuracy/posed_sheet.h"
#include "geometry/base/random.h"

namespace palpate {

// A sheet like that of posed_sheet(), but with a given normal. The object can be moved; world() is
// valid as long as the object exists. Not for the haptic thread.
class FlatSheet {
 public:
  // The front of the sheet faces `normal` (unit vector). The rotation about the normal and the
  // position are random. Scene frame.
  FlatSheet(const Vec3& normal, SeededRandom& random);

  const ContactWorld& world() const { return sheet_.scene.world(); }
  const Vec3& normal() const { return normal_; }

  // A point below the sheet (above it, if depth_m < 0), near the middle of one of its triangles.
  // along_m: two lengths along the sheet, at most a tenth of its side. Scene frame, metres.
  Vec3 below(double depth_m, const Eigen::Vector2d& along_m = Eigen::Vector2d::Zero()) const;

 private:
  Vec3 normal_;
  PosedSheet sheet_;
};

}  // namespace palpate
