#include "engine/simulation/calm_chart.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "geometry/base/random.h"

namespace palpate {
namespace {

constexpr double kStart_s = 0.75;          // the governor's rule *start* takes 0.6 s and some ticks
constexpr double kGap_m = 1e-3;            // from the tip to the shape, before the hand moves
constexpr double kPress_s = 0.5;           // how long a bare tip is pressed
constexpr double kApproach_m_per_s = 0.1;  // of a hand that presses
constexpr double kJudged_s = 0.25;  // one period of the slowest swing that counts, 5 Hz, and more

DeviceDescription described(const ChartCase& c, const TipSettings& tip) {
  DeviceDescription device = motor_device(c.motors, c.peak_force_N, c.rate_Hz);
  if (c.states_mechanics) {
    device.mass_kg = tip.mass_kg;
    device.damping_Ns_per_m = tip.damping_Ns_per_m;
  }
  device.encoder_quantum_m = c.encoder_quantum_m;
  // An interval of a tenth; a delay of 0 is stated as an interval that ends a clock's step later.
  if (c.states_delay) device.delay = {0.9 * c.delay_s, std::max(c.delay_s, 1e-6)};
  return device;
}

PortLoopSettings loop_settings(const ChartCase& c) {
  PortLoopSettings settings;
  settings.shape = c.shape;
  settings.turn_rad = c.turn_rad;
  settings.rate_Hz = c.rate_Hz;
  settings.coupling.stiffness_N_per_m = c.stiffness_N_per_m;
  settings.device.tip.hand = hand_of(c.grip);
  settings.device.device = described(c, settings.device.tip);
  settings.device.delay_s = c.delay_s;
  settings.device.ticks_per_sample = c.ticks_per_sample;
  settings.device.device.rate_Hz = c.rate_Hz / c.ticks_per_sample;
  const Mat3 turn = Eigen::AngleAxisd(c.turn_rad, Vec3::UnitZ()).toRotationMatrix();
  settings.device.start_m = kGap_m * (turn * Vec3::UnitX());
  return settings;
}

// One run of a case: what the hand does, and what became of the tip.
class ChartRun {
 public:
  ChartRun(const ChartCase& c, PortLoop& loop) : case_(c), loop_(loop) {}

  void run(ChartResult& result);

 private:
  void approach();
  void press();
  void watch(double seconds, std::vector<Vec3>* places = nullptr);

  const ChartCase& case_;
  PortLoop& loop_;
  Vec3 start_m_ = Vec3::Zero();
  Vec3 into_ = Vec3::Zero();  // the unit direction in which the hand moves
  double largest_speed_m_per_s_ = 0.0;
  std::uint32_t rules_ = 0;
  bool has_touched_ = false;
};

void ChartRun::watch(double seconds, std::vector<Vec3>* places) {
  const auto ticks = std::llround(seconds / loop_.dt_s());
  for (std::int64_t n = 0; n < ticks; ++n) {
    loop_.tick();
    rules_ |= loop_.last().rules;
    if (places != nullptr) places->push_back(loop_.tip().position_m());
    if (loop_.last().contact != 0) {
      has_touched_ = true;
      largest_speed_m_per_s_ =
          std::max(largest_speed_m_per_s_, loop_.tip().velocity_m_per_s().norm());
    }
  }
}

void ChartRun::approach() {
  loop_.run(kStart_s);
  start_m_ = loop_.tip().position_m();
  into_ = Eigen::AngleAxisd(case_.aim_rad, Vec3::UnitZ()) * -loop_.to_device(Vec3::UnitX());
  loop_.tip().open_account();
  if (case_.contact == ChartContact::kPressed) return press();
  loop_.tip().throw_at(case_.speed_m_per_s * into_);
  // Until the tip has come to the shape, however obliquely.
  watch(2.0 * kGap_m / (case_.speed_m_per_s * std::cos(case_.aim_rad)));
}

// A grip moves its place to where it presses with the push; a bare tip gets the push itself.
void ChartRun::press() {
  const double stiffness = hand_of(case_.grip).stiffness_N_per_m;
  if (!(stiffness > 0.0)) {
    loop_.tip().push(case_.push_N * into_);
    watch(kPress_s);
    loop_.tip().push(Vec3::Zero());
    return;
  }
  const Vec3 end_m = (case_.push_N / stiffness) * into_;
  const Vec3 way_m = end_m - start_m_;
  const double time_s = loop_.dt_s() * std::ceil(way_m.norm() / kApproach_m_per_s / loop_.dt_s());
  loop_.tip().set_hand(start_m_, way_m / time_s);
  watch(time_s);
  loop_.tip().set_hand(end_m);
}

void ChartRun::run(ChartResult& result) {
  approach();
  std::vector<Vec3> places;
  places.reserve(static_cast<std::size_t>((ChartPromise::kRest_s + kJudged_s) * case_.rate_Hz) + 2);
  watch(ChartPromise::kRest_s + kJudged_s, &places);
  const auto judged = static_cast<std::size_t>(ChartPromise::kRest_s * case_.rate_Hz);
  Vec3 low = places.back();
  Vec3 high = places.back();
  for (std::size_t n = judged; n < places.size(); ++n) {
    low = low.cwiseMin(places[n]);
    high = high.cwiseMax(places[n]);
  }
  result.amplitude_m = 0.5 * (high - low).norm();
  const Vec3 end_m = 0.5 * (low + high);
  for (std::size_t n = 0; n < places.size(); ++n) {
    if ((places[n] - end_m).norm() > ChartPromise::kRest_m) {
      result.rest_time_s = static_cast<double>(n + 1) * loop_.dt_s();
    }
  }
  result.trip = loop_.trip();
  result.returned_J = loop_.tip().account().most_returned_J;
  result.given_J = loop_.tip().account().most_given_J;
  result.hand_J = loop_.tip().account().hand_J;
  result.largest_speed_m_per_s = largest_speed_m_per_s_;
  result.rules = rules_;
  result.has_touched = has_touched_;
}

ChartOutcome outcome_of(const ChartResult& result) {
  if (result.returned_J > ChartPromise::kReturned_J) return ChartOutcome::kReturns;
  if (result.trip.reason != TripReason::kNone) return ChartOutcome::kTripped;
  if (result.amplitude_m > ChartPromise::kRest_m) return ChartOutcome::kSwings;
  return result.zone == StiffnessZone::kStable ? ChartOutcome::kStable : ChartOutcome::kControlled;
}

}  // namespace

ChartCase ChartCase::random(std::uint64_t seed, std::uint64_t number) {
  // Two cases share no numbers: the generator begins anew with a mixture of both.
  SeededRandom random(seed * 1'000'003 + number);
  const auto logarithmic = [&](double least, double most) {
    return least * std::pow(most / least, random.uniform(0.0, 1.0));
  };
  using Range = ChartRange;
  ChartCase c;
  c.shape = static_cast<PortShape>(random.index(2));
  c.grip = static_cast<ChartGrip>(random.index(3));
  c.contact = static_cast<ChartContact>(random.index(2));
  c.stiffness_N_per_m = logarithmic(Range::kLeastStiffness_N_per_m, Range::kMostStiffness_N_per_m);
  c.delay_s = random.uniform(0.0, Range::kLongestDelay_s);
  c.rate_Hz = logarithmic(Range::kLeastRate_Hz, Range::kMostRate_Hz);
  c.speed_m_per_s = random.uniform(Range::kSlowest_m_per_s, Range::kFastest_m_per_s);
  c.push_N = random.uniform(0.3, Range::kStrongest_N);
  c.turn_rad = random.uniform(-std::numbers::pi, std::numbers::pi);
  c.aim_rad = random.uniform(-0.7, 0.7);  // a groove's walls have 45 degrees, 0.785
  if (c.grip == ChartGrip::kBare && c.contact == ChartContact::kPressed) {
    c.push_N *= 0.5;
    if (c.shape == PortShape::kWall) c.aim_rad = 0.0;
  }
  c.motors = 2 + static_cast<int>(random.index(2));
  c.peak_force_N = random.index(2) == 0 ? 10.0 : 20.0;
  c.states_mechanics = random.index(2) == 0;
  // The class of a device that states no delay knows its longest one.
  c.states_delay = random.index(4) != 0 || c.delay_s > kBareTip.delay.most_s;
  return c;
}

Result<StiffnessZones> zones_of(const ChartCase& chart_case) {
  const PortLoopSettings settings = loop_settings(chart_case);
  return stiffness_zones(settings.device.device, settings.coupling.damping_Ns_per_m,
                         1.0 / chart_case.rate_Hz, settings.coupling.velocity);
}

Result<ChartResult> run_chart_case(const ChartCase& chart_case, const ChartOptions& options) {
  PortLoopSettings settings = loop_settings(chart_case);
  const auto zones = zones_of(chart_case);
  if (!zones) return zones.error();
  ChartResult result;
  result.zones = *zones;
  result.zone = zones->zone_of(chart_case.stiffness_N_per_m);
  if (result.zone == StiffnessZone::kRefused && !options.runs_refused) return result;
  settings.device.device.moves_motors = options.is_governed;
  const auto loop = PortLoop::create(settings);
  if (!loop) return loop.error();
  ChartRun(chart_case, **loop).run(result);
  result.outcome = outcome_of(result);
  return result;
}

HandImpedance hand_of(ChartGrip grip) {
  switch (grip) {
    case ChartGrip::kBare:
      return kNoHand;
    case ChartGrip::kLight:
      return kLightGrip;
    case ChartGrip::kFirm:
      return kFirmGrip;
  }
  return kNoHand;
}

std::string_view name_of(PortShape shape) {
  return shape == PortShape::kWall ? "wall" : "groove";
}

std::string_view name_of(ChartGrip grip) {
  constexpr std::string_view kNames[] = {"bare", "light", "firm"};
  return kNames[static_cast<std::size_t>(grip)];
}

std::string_view name_of(ChartContact contact) {
  return contact == ChartContact::kThrown ? "thrown" : "pressed";
}

}  // namespace palpate
