#include "engine/accuracy/pressed_contact.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <unsupported/Eigen/MatrixFunctions>
#include <vector>

#include "engine/accuracy/posed_sheet.h"
#include "engine/accuracy/session_pass.h"
#include "engine/devices/stability_limits.h"
#include "engine/devices/vector_device.h"
#include "engine/simulation/mass_damper.h"

namespace palpate {
namespace {

// Ticks before the motion: one above the wall and two at rest in it, so that the damper starts from
// a velocity of zero. After them the hand releases the device.
constexpr std::size_t kLeadIn = 3;
constexpr double kAbove_m = 0.01;

class PressedDevice final : public VectorDevice {
 public:
  PressedDevice(const PressedContact& contact, const PosedSheet& sheet, double push_after_s)
      : contact_(contact),
        sheet_(sheet),
        plant_(contact.mass_kg, contact.damping_Ns_per_m),
        before_push_s_(push_after_s) {
    plant_.put(sheet.T_scene_sheet.point({0.0, 0.0, -contact.start_depth_m()}), Vec3::Zero());
  }

  Vec3 read_position_m(double dt_s) noexcept override {
    ++readings_;
    if (readings_ == 1) return sheet_.T_scene_sheet.point({0.0, 0.0, kAbove_m});
    if (readings_ > kLeadIn) advance(dt_s);
    return plant_.position_m();
  }
  void command_force_N(const Vec3& force_device) noexcept override { force_N_ = force_device; }

  double depth_m() const { return -sheet_.T_scene_sheet.inverse_point(plant_.position_m()).z(); }
  double pushed_for_s() const { return pushed_for_s_; }

 private:
  void advance(double dt_s) {
    const Vec3 push_N = -contact_.push_N * sheet_.normal();
    const double before_s = std::min(before_push_s_, dt_s);
    plant_.advance(force_N_ + 0.5 * push_N, before_s);
    plant_.advance(force_N_ + push_N, dt_s - before_s);
    before_push_s_ -= before_s;
    pushed_for_s_ += dt_s - before_s;
  }

  const PressedContact& contact_;
  const PosedSheet& sheet_;
  MassDamper plant_;
  double before_push_s_;
  double pushed_for_s_ = 0.0;
  std::size_t readings_ = 0;
  Vec3 force_N_ = Vec3::Zero();
};

// Follows the depth: its deviation from the exact path, and whether its swing about the static
// depth grows.
class Swing {
 public:
  explicit Swing(const PressedContact& contact)
      : contact_(contact),
        period_s_(2.0 * std::numbers::pi *
                  std::sqrt(contact.mass_kg / contact.coupling.stiffness_N_per_m)) {}

  void add(double depth_m, double time_s) {
    const double off_m = std::abs(depth_m - contact_.static_depth_m());
    if (time_s < period_s_) first_m_ = std::max(first_m_, off_m);
    if (time_s > contact_.duration_s - period_s_) last_m_ = std::max(last_m_, off_m);
    worst_m_ = std::max(worst_m_, std::abs(depth_m - contact_.depth_m(time_s)));
  }
  double worst_m() const { return worst_m_; }
  bool grows() const { return last_m_ > first_m_; }

 private:
  const PressedContact& contact_;
  double period_s_;
  double first_m_ = 0.0;
  double last_m_ = 0.0;
  double worst_m_ = 0.0;
};

std::string unstable_text(const PressedContact& contact, double period_s) {
  const Result<StabilityLimits> limits = stability_limits(
      {contact.mass_kg, contact.damping_Ns_per_m}, contact.coupling.damping_Ns_per_m, {period_s});
  char text[128];
  std::snprintf(text, sizeof text,
                "unstable: %.0f N/m; the limit at this rate, without delay, is %.0f N/m",
                contact.coupling.stiffness_N_per_m, limits ? limits->stable_N_per_m : 0.0);
  return text;
}

}  // namespace

PressedContact PressedContact::on(const DeviceDescription& device) {
  constexpr double kShortest_s = 0.5;
  constexpr double kLongest_s = 5.0;
  const PressedContact light;
  const auto time_constant_s = [](const PressedContact& c) {
    return 2.0 * c.mass_kg / (c.damping_Ns_per_m + c.coupling.damping_Ns_per_m);
  };
  PressedContact contact;
  contact.mass_kg = device.mass_kg;
  contact.damping_Ns_per_m = device.damping_Ns_per_m;
  const double longer = time_constant_s(contact) / time_constant_s(light);
  contact.duration_s = std::clamp(light.duration_s * longer, kShortest_s, kLongest_s);
  return contact;
}

double PressedContact::depth_m(double time_s) const {
  // The state is (x - static depth, v / w), so that the entries are alike in size.
  const double w = std::sqrt(coupling.stiffness_N_per_m / mass_kg);
  Eigen::Matrix2d rate;
  rate << 0.0, w, -w, -(damping_Ns_per_m + coupling.damping_Ns_per_m) / mass_kg;
  const Eigen::Matrix2d over_time = (time_s * rate).exp();
  return static_depth_m() + over_time(0, 0) * (start_depth_m() - static_depth_m());
}

Sample press(const PressedContact& contact, double period_s, const Accuracy& accuracy,
             std::uint64_t seed) {
  SeededRandom random(seed);
  const Result<PosedSheet> sheet = posed_sheet(random);
  if (!sheet) return {.failure = sheet.error().to_string()};
  PressedDevice device(contact, *sheet, random.uniform(0.0, period_s));
  const auto ticks = static_cast<std::size_t>(std::ceil(contact.duration_s / period_s));
  const std::vector<double> dt_s(kLeadIn + ticks, period_s);
  Swing swing(contact);
  // Called before the device moves on.
  const OnContact follow = [&](const TickRecord&) {
    swing.add(device.depth_m(), device.pushed_for_s());
  };
  const PassCost cost =
      run_pass(sheet->scene.world(), PassSetup::fully_actuated(contact.coupling, {0.0, accuracy}),
               device, dt_s, kLeadIn, follow);
  Sample sample{swing.worst_m() / contact.static_depth_m(), cost.us_per_s(period_s),
                cost.iterations, cost.ticks, failure_of(cost.faults)};
  if (swing.grows()) {
    sample.failure = unstable_text(contact, period_s);
  } else if (sample.failure.empty() && cost.ticks < ticks) {
    sample.failure = "lost contact";
  }
  return sample;
}

}  // namespace palpate
