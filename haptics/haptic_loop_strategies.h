#pragma once

// The state of a loop's strategy. Private to haptic_loop*.cpp.

#include <optional>

#include "haptics/haptic_loop.h"
#include "haptics/speed_window.h"
#include "haptics/strategies/a4_anticipate.h"
#include "haptics/strategies/control_display.h"

namespace palpate {

struct HapticLoop::StrategyState {
  Step inner = nullptr;  // the step that the step of the strategy calls

  // a4-anticipate
  SpeedWindow window;  // of the device's positions
  std::optional<A4Anticipation> anticipation;

  // cd
  ControlDisplay control_display;
  Vec3 home_m = Vec3::Zero();         // the scene's origin at the start, device frame
  Vec3 last_device_m = Vec3::Zero();  // of the last good sample
};

}  // namespace palpate
