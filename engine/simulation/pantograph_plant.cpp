#include "engine/simulation/pantograph_plant.h"

#include <algorithm>

#include "engine/simulation/probing_hand.h"

namespace palpate {
namespace {

Vec3 in_plane(const Vec2& v) {
  return {v.x(), v.y(), 0.0};
}

}  // namespace

PantographPlant::PantographPlant(const PantographSettings& settings, const Vec2& tip_m)
    : settings_(settings),
      bar_(settings.links),
      tip_({settings.mass_kg, settings.damping_Ns_per_m, settings.hand}, in_plane(tip_m)),
      rest_m_(tip_m),
      joints_rad_(bar_.inverse(tip_m).value_or(Vec2::Zero())),
      low_m_(tip_m),
      high_m_(tip_m) {}

void PantographPlant::begin_probes() {
  if (!settings_.hand_probes || probing_s_) return;
  probing_s_ = 0.0;
  tip_.open_account();
}

void PantographPlant::advance(const Vec2& torques_Nm, double dt_s) {
  if (probing_s_) {
    probe();
    *probing_s_ += dt_s;
  }
  Vec2 force_N = Vec2::Zero();
  const auto jacobian = bar_.jacobian(joints_rad_);
  // torques = J^T . force
  if (jacobian) force_N = jacobian->transpose().inverse() * torques_Nm;
  const Vec3 before_m = tip_.position_m();
  tip_.advance(in_plane(force_N), dt_s);
  const auto joints_rad = bar_.inverse(tip_m());
  if (joints_rad) {
    joints_rad_ = *joints_rad;
  } else {
    tip_.stop_at(before_m);
  }
}

// Moves the hand, and judges the tip in the last part of a hold.
void PantographPlant::probe() {
  const Probe now = ProbingHand::at(*probing_s_);
  const bool is_bare = !(settings_.hand.stiffness_N_per_m > 0.0);
  if (is_bare && now.number != probe_) {
    tip_.throw_at(ProbingHand::kThrow_m_per_s * in_plane(now.direction));
  }
  if (!is_bare) set_hand(rest_m_ + now.share * ProbingHand::kReach_m * now.direction);
  probe_ = now.number;
  if (now.is_judged) {
    low_m_ = was_judged_ ? Vec2(low_m_.cwiseMin(tip_m())) : tip_m();
    high_m_ = was_judged_ ? Vec2(high_m_.cwiseMax(tip_m())) : tip_m();
  } else if (was_judged_) {
    ++probes_.judged;
    probes_.largest_amplitude_m =
        std::max(probes_.largest_amplitude_m, 0.5 * (high_m_ - low_m_).norm());
  }
  was_judged_ = now.is_judged;
}

}  // namespace palpate
