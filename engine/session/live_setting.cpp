#include "engine/session/live_setting.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace palpate {
namespace {

// Two settings with one number or one name do not compile.
consteval bool settings_are_distinct() {
  for (std::size_t i = 0; i < kLiveSettings.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      if (kLiveSettings[i].number == kLiveSettings[k].number) return false;
      if (kLiveSettings[i].name == kLiveSettings[k].name) return false;
    }
  }
  return true;
}
static_assert(settings_are_distinct());

double number_at(const TickInput& input, std::size_t place) {
  double number = 0.0;
  std::memcpy(&number, input.bytes.data() + place * sizeof number, sizeof number);
  return number;
}

}  // namespace

bool LiveSetting::can_be(double x) const noexcept {
  switch (kind) {
    case Kind::kFlag:
      return x == 0.0 || x == 1.0;
    case Kind::kChoice:
      return x >= 0.0 && x < static_cast<double>(choices.size()) && x == std::floor(x);
    case Kind::kNumber:
      return std::isfinite(x);
  }
  return false;
}

void LiveSetting::set(HapticLoop& loop, double x) const noexcept {
  HapticSettings settings = loop.settings();
  put(settings, x);
  apply(loop, settings);
}

LiveChanges::LiveChanges(const TickInput& input) noexcept {
  if (input.kind == InputKind::kA4) add(live_setting("a4"), input.handle != 0 ? 1.0 : 0.0);
  if (input.kind == InputKind::kForce) add(live_setting("force"), input.handle);
  if (input.kind == InputKind::kCoupling) {
    add(live_setting("stiffness"), number_at(input, 0));
    add(live_setting("damping"), number_at(input, 1));
    if (count_ < changes_.size()) count_ = 0;
  }
  if (input.kind != InputKind::kSetting) return;
  const auto found = std::find_if(kLiveSettings.begin(), kLiveSettings.end(),
                                  [&](const LiveSetting& s) { return s.number == input.handle; });
  if (found == kLiveSettings.end()) return;
  add(static_cast<std::size_t>(found - kLiveSettings.begin()), number_at(input, 0));
}

void LiveChanges::add(std::size_t setting, double value) noexcept {
  if (kLiveSettings[setting].can_be(value)) changes_[count_++] = {setting, value};
}

}  // namespace palpate
