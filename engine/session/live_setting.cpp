#include "engine/session/live_setting.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <variant>

#include "engine/session/run_setting.h"

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

const RunSetting& LiveSetting::of_run() const noexcept {
  return run_setting_with(number);
}

LiveSetting::Kind LiveSetting::kind() const noexcept {
  const SettingValuePlace& place = of_run().value;
  if (std::holds_alternative<SettingPlace<bool>>(place)) return Kind::kFlag;
  return std::holds_alternative<SettingChoice>(place) ? Kind::kChoice : Kind::kNumber;
}

std::span<const std::string_view> LiveSetting::words() const noexcept {
  const auto* const choice = std::get_if<SettingChoice>(&of_run().value);
  return choice ? choice->words : std::span<const std::string_view>();
}

double LiveSetting::least() const noexcept {
  return kind() == Kind::kNumber ? of_run().range.least : 0.0;
}

double LiveSetting::most() const noexcept {
  switch (kind()) {
    case Kind::kFlag:
      return 1.0;
    case Kind::kChoice:
      return static_cast<double>(words().size()) - 1.0;
    case Kind::kNumber:
      return page_most;
  }
  return 0.0;
}

double LiveSetting::value(const HapticSettings& settings) const noexcept {
  const SettingValuePlace& place = of_run().value;
  if (const auto* flag = std::get_if<SettingPlace<bool>>(&place)) {
    return flag->read_haptics(settings) ? 1.0 : 0.0;
  }
  if (const auto* choice = std::get_if<SettingChoice>(&place)) {
    return static_cast<double>(choice->get(settings));
  }
  return std::get_if<SettingPlace<double>>(&place)->read_haptics(settings);
}

void LiveSetting::put(HapticSettings& settings, double x) const noexcept {
  const SettingValuePlace& place = of_run().value;
  if (const auto* flag = std::get_if<SettingPlace<bool>>(&place)) {
    flag->in_haptics(settings) = x != 0.0;
  } else if (const auto* choice = std::get_if<SettingChoice>(&place)) {
    choice->put(settings, static_cast<std::size_t>(x));
  } else {
    std::get_if<SettingPlace<double>>(&place)->in_haptics(settings) = x;
  }
}

bool LiveSetting::can_be(double x) const noexcept {
  if (kind() == Kind::kNumber) return std::isfinite(x);
  return x >= 0.0 && x <= most() && x == std::floor(x);
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
