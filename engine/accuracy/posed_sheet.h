#pragma once

// A flat square in any pose, to press on.

#include "engine/scene/scene.h"
#include "geometry/base/random.h"
#include "geometry/base/result.h"

namespace palpate {

// Sheet frame: origin in its middle, z its front. The scene frame is the device's.
struct PosedSheet {
  Scene scene;
  RigidTransform T_scene_sheet;

  Vec3 normal() const { return T_scene_sheet.direction(Vec3::UnitZ()); }
};

inline constexpr double kSheetSize_m = 0.2;

// friction: the static and dynamic coefficient; 0 for none. An error only if the build lacks
// friction. Not for the haptic thread.
Result<PosedSheet> sheet_at(const RigidTransform& T_scene_sheet, double friction = 0.0);

// The same in a random pose.
Result<PosedSheet> posed_sheet(SeededRandom& random, double friction = 0.0);

}  // namespace palpate
