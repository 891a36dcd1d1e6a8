// The accuracy of the elementary rotation of A4: the integration rule and the rate.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "engine/accuracy/flat_sheet.h"
#include "engine/accuracy/knobs.h"
#include "engine/accuracy/session_pass.h"
#include "geometry/base/degrees.h"

namespace palpate {
namespace {

constexpr double kAligned_rad = 1.0 * kRadPerDegree;  // the turn ends here
constexpr double kMostStart_rad = 89.0 * kRadPerDegree;

// The same at all levels.
constexpr CouplingSettings kCoupling{1000.0, 2.0};
constexpr double kPress_m = 5e-3;

constexpr std::array kA4Rates_Hz = {60, 120, 250, 500, 1000, 2000, 5000, 10000};
constexpr std::size_t kDefaultRate = 4;

// The time that profile S of Figure 3 takes from one angle down to another. Above the knee the
// speed is that of the knee; below, a' = -(S0 + k a) takes ln((S0 + k from) / (S0 + k to)) / k.
double profile_s(double from_rad, double to_rad) {
  const RotationProfile profile;
  const double k_per_s =
      (profile.speed_at_knee_rad_per_s - profile.speed_at_zero_rad_per_s) / profile.knee_rad;
  const auto from_knee_s = [&](double angle_rad) {
    const double above_rad = std::max(0.0, angle_rad - profile.knee_rad);
    const double speed = profile.speed_at_zero_rad_per_s + k_per_s * (angle_rad - above_rad);
    return above_rad / profile.speed_at_knee_rad_per_s +
           std::log(speed / profile.speed_at_knee_rad_per_s) / k_per_s;
  };
  return from_knee_s(from_rad) - from_knee_s(to_rad);
}

// The time within a tick at which the angle passes kAligned_rad, under the motion that the rule
// assumes: a steady turn, or the profile. after_rad <= kAligned_rad < before_rad.
double crossing_s(StepRule rule, double before_rad, double after_rad, double dt_s) {
  if (rule == StepRule::kExact) return profile_s(before_rad, kAligned_rad);
  return dt_s * (before_rad - kAligned_rad) / (before_rad - after_rad);
}

// The time from the first tick in contact on; nothing if the angle is never reached.
std::optional<double> time_to_align_s(const std::vector<double>& alphas_rad, StepRule rule,
                                      double dt_s) {
  for (std::size_t n = 1; n < alphas_rad.size(); ++n) {
    if (alphas_rad[n] > kAligned_rad) continue;
    return static_cast<double>(n - 1) * dt_s +
           crossing_s(rule, alphas_rad[n - 1], alphas_rad[n], dt_s);
  }
  return std::nullopt;
}

std::size_t ticks_to_align(double start_rad, double dt_s) {
  return static_cast<std::size_t>(std::ceil(profile_s(start_rad, kAligned_rad) / dt_s));
}

// The largest effect of rounding on the time. A tick turns the pose by a quaternion product,
// normalises it, converts it to a matrix, turns the normal and reads its angle: sixteen roundings
// of numbers of at most one, at worst all in one direction, in each tick of the longest run. An
// error of the angle shifts the motion in time by what the profile takes to turn it, which is most
// at the end. The rounding of the closed form is smaller.
double time_roundoff_s() {
  constexpr double kRoundings = 16.0;
  const double most_ticks =
      static_cast<double>(ticks_to_align(kMostStart_rad, 1.0 / kA4Rates_Hz.back()));
  const double off_rad = most_ticks * kRoundings * std::numeric_limits<double>::epsilon();
  return off_rad / RotationProfile{}.speed_rad_per_s(kAligned_rad);
}

// A device with one actuated axis, A1, is held in a sheet with another normal.
Sample align(StepRule rule, double dt_s, const Accuracy& accuracy, std::uint64_t seed) {
  SeededRandom random(seed);
  const double start_rad = random.uniform(60.0 * kRadPerDegree, kMostStart_rad);
  const double about_a1_rad = random.uniform(-std::numbers::pi, std::numbers::pi);
  const Vec3 normal(std::cos(start_rad), std::sin(start_rad) * std::cos(about_a1_rad),
                    std::sin(start_rad) * std::sin(about_a1_rad));
  const FlatSheet sheet(normal, random);
  PassSetup setup{*ActuationModel::from_counts(3, 1), {}};
  setup.haptics.god_object.accuracy = accuracy;
  setup.haptics.coupling = kCoupling;
  setup.haptics.a4.step = rule;
  // A tick above the sheet, then the ticks of the turn, with one before and one in reserve.
  std::vector<Vec3> path_m(3 + ticks_to_align(start_rad, dt_s), sheet.below(kPress_m));
  path_m.front() = sheet.below(-1e-3);
  std::vector<double> alphas_rad;
  const PassCost cost =
      run_path(sheet.world(), setup, path_m, dt_s, 1,
               [&](const TickRecord& record) { alphas_rad.push_back(record.alpha_rad); });
  Sample sample{0.0, cost.us_per_s(dt_s), cost.iterations, cost.ticks, failure_of(cost.faults)};
  if (cost.ticks + 1 != path_m.size()) sample.failure = "lost contact";
  const auto took_s = time_to_align_s(alphas_rad, rule, dt_s);
  if (!took_s) sample.failure = "never aligned";
  if (!sample.failure.empty()) return sample;
  sample.error = std::abs(*took_s - profile_s(start_rad, kAligned_rad));
  return sample;
}

std::string rate_label(int rate_Hz) {
  return rate_Hz < 1000 ? std::to_string(rate_Hz) + " Hz" : std::to_string(rate_Hz / 1000) + " kHz";
}

Method method(std::string name, StepRule rule, std::optional<double> order, double floor_s) {
  Method curve{std::move(name), {}, order, floor_s};
  for (const int rate_Hz : kA4Rates_Hz) {
    const double dt_s = 1.0 / rate_Hz;
    curve.levels.push_back({dt_s, rate_label(rate_Hz), [=](std::uint64_t seed) {
                              return align(rule, dt_s, Accuracy{}, seed);
                            }});
  }
  return curve;
}

Knob step_knob() {
  Knob knob;
  knob.name = "a4_step";
  knob.title = "Elementary rotation of A4";
  knob.level = {"period of a tick", "s"};
  knob.error = {"error of the time to align", "s"};
  knob.time = {"computing for a second of contact", "us"};
  knob.workload =
      "a device with three sensors and one actuator is held 5 mm deep in a flat sheet whose normal "
      "is 60 to 89 deg from the actuated axis, until A4 has turned the scene to 1 deg; K = 1000 "
      "N/m, B = 2 N s/m";
  knob.reference =
      "the time that the profile of the paper's Figure 3 takes from an angle of a degrees to 1 "
      "degree: "
      "max(a - 30, 0) / 90 + 6/17 ln((5 + 17/6 min(a, 30)) / (5 + 17/6)) s";
  knob.floor_is = "rounding in double, over the ticks of the turn at 10 kHz";
  knob.methods = {method("speed times dt (paper)", StepRule::kSpeedByDt, 1.0, 0.0),
                  method("exact solution", StepRule::kExact, {}, time_roundoff_s())};
  knob.levels_are_given = true;  // the rate is that of the force
  knob.default_method = 1;
  knob.default_level = kDefaultRate;
  knob.run_preset = [](std::uint64_t seed, const Accuracy& preset) {
    return align(StepRule::kExact, 1.0 / kA4Rates_Hz[kDefaultRate], preset, seed);
  };
  knob.enough = 10e-3;
  knob.enough_because =
      "less than a hundredth of the time of the turn, and less than one frame of a display";
  return knob;
}

}  // namespace

std::vector<Knob> a4_knobs(const MeasurementEffort&) {
  return {step_knob()};
}

}  // namespace palpate
