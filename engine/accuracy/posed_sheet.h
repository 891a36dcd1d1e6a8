#pragma once

// A flat square in any pose, on which a device presses.

#include "engine/scene/scene.h"
#include "geometry/base/random.h"
#include "geometry/base/result.h"

namespace palpate {

// The sheet frame has its origin in the middle of the sheet and its z axis towards the front. The
// scene frame is equal to the device frame.
struct PosedSheet {
  Scene scene;
  RigidTransform T_scene_sheet;

  Vec3 normal() const { return T_scene_sheet.direction(Vec3::UnitZ()); }
};

inline constexpr double kSheetSize_m = 0.2;

// friction: the static and the dynamic coefficient; 0 for no friction. Returns an error only if the
// effect friction is needed and not in this build. Not for the haptic thread.
Result<PosedSheet> sheet_at(const RigidTransform& T_scene_sheet, double friction = 0.0);

// sheet_at() in a random pose.
Result<PosedSheet> posed_sheet(SeededRandom& random, double friction = 0.0);

}  // namespace palpate
