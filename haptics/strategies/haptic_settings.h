#pragma once

// The settings of a haptic loop. They are in this room because a strategy sets several of them.

#include <cstdint>
#include <optional>

#include "haptics/a4/elementary_rotation.h"
#include "haptics/a4/scene_pose.h"
#include "haptics/a4/theoretical_rotation.h"
#include "haptics/effects/virtual_coupling.h"
#include "haptics/proxy/god_object.h"
#include "haptics/strategies/strategy.h"

namespace palpate {

struct A4Settings {
  bool enabled = true;
  Table1Form table1 = Table1Form::kCorrected;
  Alignment align = Alignment::kNearest;
  RotationProfile profile;
  StepRule step = StepRule::kExact;
};

// When `a4-anticipate` turns the scene before a touch (a4_anticipate.h).
struct AnticipationSettings {
  double range_m = 0.020;                 // h: the largest clearance at which turning begins
  double least_approach_m_per_s = 0.002;  // u: turning begins only in a faster approach
};

struct HapticSettings {
  GodObjectSettings god_object;
  CouplingSettings coupling;
  ForceMode force = ForceMode::kActuated;
  A4Settings a4;
  double plane_height_m = 0.0;    // 2 sensors: z of the device point and the proxy, device frame
  ScenePose initial_pose;         // T_device_scene at the first tick
  bool measures_effects = false;  // measures the time of each effect, which costs clock reads
  // Empty, or a strategy that `force` and `a4` do not describe. Set it with set_strategy(), which
  // sets the three together.
  std::optional<Strategy> strategy;
  AnticipationSettings anticipation;  // of a4-anticipate
};

}  // namespace palpate
