#include "engine/accuracy/bounce.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "engine/accuracy/measurement.h"
#include "engine/accuracy/posed_sheet.h"
#include "engine/accuracy/session_pass.h"
#include "engine/devices/vector_device.h"
#include "engine/simulation/mass_damper.h"

namespace palpate {
namespace {

// A repeat has enough bounces for this many ticks in contact, whatever the rate, and at least
// kFewestBounces. Uneven periods average out over the ticks.
constexpr double kTicksInContact = 2000.0;
constexpr int kFewestBounces = 16;

// Periods before the wall: enough for uneven periods to meet it at any phase.
constexpr double kPeriodsBefore = 10.0;

// Late forces make a bounce longer than half a period of the spring, but never as long as this; a
// longer bounce is a failure.
constexpr double kContactsToWait = 1.5;
constexpr double kPeriodsToWait = 4.0;

// A mass that moves under the last force alone.
class FreeMass final : public VectorDevice {
 public:
  FreeMass(double mass_kg, const Vec3& at_m, const Vec3& velocity_m_per_s) : plant_(mass_kg, 0.0) {
    plant_.put(at_m, velocity_m_per_s);
  }
  Vec3 read_position_m(double dt_s) noexcept override {
    if (started_) plant_.advance(force_N_, dt_s);
    started_ = true;
    return plant_.position_m();
  }
  void command_force_N(const Vec3& force_device) noexcept override { force_N_ = force_device; }
  double kinetic_J() const { return plant_.kinetic_J(); }
  const Vec3& position_m() const { return plant_.position_m(); }

 private:
  MassDamper plant_;
  Vec3 force_N_ = Vec3::Zero();
  bool started_ = false;
};

// Draws the periods of a bounce that starts `before_s` before the wall.
std::vector<double> draw_periods(const BounceSetup& setup, const TickPeriods& periods,
                                 double before_s, SeededRandom& random) {
  double left_s =
      before_s + kContactsToWait * setup.contact_s() + kPeriodsToWait * periods.effective_s();
  std::vector<double> drawn_s{periods.nominal_s};  // first tick: the mass does not move yet
  while (left_s > 0.0) {
    drawn_s.push_back(periods.draw_s(random));
    left_s -= drawn_s.back();
  }
  return drawn_s;
}

// Sums up the cost of many passes. The time is the median over the passes: a busy machine may
// interrupt a repeat for longer than it runs, but most of its short passes run undisturbed.
class PassCosts {
 public:
  void add(const PassCost& cost) {
    ticks_ += cost.ticks;
    iterations_ += static_cast<double>(cost.ticks) * cost.iterations;
    faults_ |= cost.faults;
    if (cost.ticks > 0) tick_ns_.push_back(cost.tick_ns);
  }
  PassCost sum() const {
    if (ticks_ == 0) return {0, 0.0, 0.0, faults_};
    return {ticks_, Spread::of(tick_ns_).median, iterations_ / static_cast<double>(ticks_),
            faults_};
  }

 private:
  std::uint64_t ticks_ = 0;
  double iterations_ = 0.0;
  std::uint32_t faults_ = kFaultNone;
  std::vector<double> tick_ns_;  // one per pass with contact
};

// One pass: the mass starts in front of the wall.
struct Bounce {
  PassCost cost;
  double kinetic_J;  // after the bounce
  bool is_out;       // the mass has left the wall
};

Bounce bounce(const BounceSetup& setup, const TickPeriods& periods, const PosedSheet& sheet,
              const PassSetup& pass, double speed_m_per_s, double before_s, SeededRandom& random) {
  const Vec3 start_m = sheet.T_scene_sheet.point({0.0, 0.0, before_s * speed_m_per_s});
  FreeMass mass(setup.mass_kg, start_m, -speed_m_per_s * sheet.normal());
  const std::vector<double> dt_s = draw_periods(setup, periods, before_s, random);
  const PassCost cost = run_pass(sheet.scene.world(), pass, mass, dt_s, 0, nullptr);
  const Vec3 end_m = sheet.T_scene_sheet.inverse_point(mass.position_m());
  return {cost, mass.kinetic_J(), end_m.z() > 0.0};
}

int bounce_count(const BounceSetup& setup, const TickPeriods& periods) {
  const double needed = kTicksInContact * periods.mean_s() / setup.contact_s();
  return std::max(kFewestBounces, static_cast<int>(std::ceil(needed)));
}

}  // namespace

double BounceSetup::angular_frequency() const {
  return std::sqrt(stiffness_N_per_m / mass_kg);
}

double BounceSetup::contact_s() const {
  return std::numbers::pi / angular_frequency();
}

double BounceSetup::gain_to_first_order(double period_s) const {
  return 0.5 * std::numbers::pi * angular_frequency() * period_s;
}

Sample bounces(const BounceSetup& setup, const TickPeriods& periods, const Accuracy& accuracy,
               std::uint64_t seed) {
  SeededRandom random(seed);
  const Result<PosedSheet> sheet = posed_sheet(random);
  if (!sheet) return {.failure = sheet.error().to_string()};
  const PassSetup pass = PassSetup::fully_actuated({setup.stiffness_N_per_m, 0.0}, {0.0, accuracy});
  const double speed = random.uniform(setup.least_speed_m_per_s, setup.most_speed_m_per_s);
  const double arrival_J = 0.5 * setup.mass_kg * speed * speed;
  const double first_phase = random.uniform(0.0, 1.0);
  const int count = bounce_count(setup, periods);
  PassCosts costs;
  Sample sample;
  for (int i = 0; i < count; ++i) {
    const double before_s = periods.nominal_s * (kPeriodsBefore + (i + first_phase) / count);
    const Bounce one = bounce(setup, periods, *sheet, pass, speed, before_s, random);
    costs.add(one.cost);
    sample.error += (one.kinetic_J / arrival_J - 1.0) / count;
    if (!one.is_out) sample.failure = "the mass was still in the wall after the time of a bounce";
  }
  const PassCost cost = costs.sum();
  sample.time = cost.us_per_s(periods.mean_s());
  sample.iterations = cost.iterations;
  sample.ticks = cost.ticks;
  if (sample.failure.empty()) sample.failure = failure_of(cost.faults);
  return sample;
}

}  // namespace palpate
