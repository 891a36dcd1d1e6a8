#include "engine/trials/sweep/sweep_parameter.h"

#include <algorithm>

#include "engine/report/human_units.h"

namespace palpate {
namespace {

// Those of the view `turning`.
constexpr std::span<const std::string_view> kSweptFollowingNames =
    std::span(kFollowingNames).first(kTurningFollowings);

NumberRange valid_of_person(double OperatorParameters::*field) {
  for (const PersonParameter& parameter : person_parameters()) {
    if (parameter.field == field) return {parameter.least, parameter.most, parameter.is_least_out};
  }
  return {};
}

ParameterRange& range_of(OperatorFile& file, double OperatorParameters::*field) {
  const auto& all = person_parameters();
  const auto place =
      std::find_if(all.begin(), all.end(), [&](const auto& key) { return key.field == field; });
  return file.ranges[static_cast<std::size_t>(place - all.begin())];
}

std::array<SweepParameter, kSweepParameterCount> make_parameters() {
  using P = OperatorParameters;
  std::array<SweepParameter, kSweepParameterCount> all{};
  const auto of_person = [&](SweepParameterIndex index, std::string_view name,
                             std::string_view unit, std::string_view meaning, double P::*field) {
    all[index] = {name, unit, meaning, valid_of_person(field), {}, field, false};
  };
  of_person(kSightDelay, "sight_delay_s", "s", "delay from a picture to the hand",
            &P::sight_delay_s);
  of_person(kIntentionNoise, "intention_noise_m", "m", "noise of the intended position",
            &P::intention_noise_m);
  of_person(kForceNoise, "force_noise", "1", "noise of the hand's force, as a share of it",
            &P::force_noise);
  of_person(kPressDepth, "press_depth_m", "m", "depth of the target inside the wall",
            &P::press_depth_m);
  of_person(kHandStiffness, "hand_stiffness_N_per_m", "N/m", "stiffness of the hand",
            &P::hand_stiffness_N_per_m);
  of_person(kSpeed, "speed_m_per_s", "m/s", "speed along the contour", &P::speed_m_per_s);
  const NumberRange above_zero{0.0, 1e6, true};
  all[kDeviceStiffness] = {"stiffness_N_per_m",
                           "N/m",
                           "stiffness of the device's coupling",
                           above_zero,
                           {},
                           nullptr,
                           false};
  all[kComfortableDepth] = {"comfortable_depth_m",
                            "m",
                            "depth at which the hand slows",
                            {0.0, 1.0, true},
                            {},
                            nullptr,
                            false};
  all[kSweptFollowing] = {
      "following", "",  "how the hand follows the turning scene", {}, kSweptFollowingNames,
      nullptr,     true};
  all[kAlign] = {"align", "",  "rule by which A4 aligns the normal", {}, kAlignmentNames,
                 nullptr, true};
  all[kStartOrientation] = {"start_orientation_deg",
                            "deg",
                            "turn of the scene about A3 before the trial",
                            kStartRange_deg,
                            {},
                            nullptr,
                            false};
  all[kScale] = {"scale", "1", "size of the objects", kScaleRange, {}, nullptr, true};
  return all;
}

}  // namespace

const std::array<SweepParameter, kSweepParameterCount>& sweep_parameters() {
  static const std::array<SweepParameter, kSweepParameterCount> parameters = make_parameters();
  return parameters;
}

std::optional<double> sweep_value(const ExperimentPlan& plan, std::size_t parameter) {
  switch (parameter) {
    case kDeviceStiffness:
      return plan.device.haptics.coupling.stiffness_N_per_m;
    case kComfortableDepth:
      return plan.person.comfortable_depth_m;
    case kSweptFollowing:
      return static_cast<double>(plan.followings.front());
    case kAlign:
      return static_cast<double>(plan.device.haptics.a4.align);
    case kStartOrientation:
      return plan.start_orientation_deg.front();
    case kScale:
      return plan.scale.front();
    default:
      break;
  }
  OperatorFile file = plan.person;
  const ParameterRange& range = range_of(file, sweep_parameters()[parameter].drawn);
  if (range.low == range.high) return range.low;
  return std::nullopt;
}

void set_sweep_value(ExperimentPlan& plan, std::size_t parameter, double value) {
  switch (parameter) {
    case kDeviceStiffness:
      plan.device.haptics.coupling.stiffness_N_per_m = value;
      return;
    case kComfortableDepth:
      plan.person.comfortable_depth_m = value;
      return;
    case kSweptFollowing:
      plan.followings = {static_cast<Following>(static_cast<std::uint8_t>(value))};
      return;
    case kAlign:
      plan.device.haptics.a4.align = static_cast<Alignment>(static_cast<std::uint8_t>(value));
      return;
    case kStartOrientation:
      plan.start_orientation_deg = {value};
      return;
    case kScale:
      plan.scale = {value};
      return;
    default:
      break;
  }
  ParameterRange& range = range_of(plan.person, sweep_parameters()[parameter].drawn);
  range.low = range.high = value;
}

std::string sweep_value_text(std::size_t parameter, double value) {
  const auto& words = sweep_parameters()[parameter].words;
  if (words.empty()) return short_number(value);
  return std::string(words[static_cast<std::size_t>(value)]);
}

}  // namespace palpate
