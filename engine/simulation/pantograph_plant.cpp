#include "engine/simulation/pantograph_plant.h"

namespace palpate {

PantographPlant::PantographPlant(const PantographSettings& settings, const Vec2& tip_m)
    : settings_(settings),
      bar_(settings.links),
      body_(settings.mass_kg + settings.hand.mass_kg,
            settings.damping_Ns_per_m + settings.hand.damping_Ns_per_m),
      hand_m_(tip_m),
      joints_rad_(bar_.inverse(tip_m).value_or(Vec2::Zero())) {
  body_.put({tip_m.x(), tip_m.y(), 0.0}, Vec3::Zero());
}

void PantographPlant::advance(const Vec2& torques_Nm, double dt_s) {
  Vec2 force_N = settings_.hand.stiffness_N_per_m * (hand_m_ - tip_m());
  const auto jacobian = bar_.jacobian(joints_rad_);
  // torques = J^T . force
  if (jacobian) force_N += jacobian->transpose().inverse() * torques_Nm;
  const Vec3 before_m = body_.position_m();
  body_.advance({force_N.x(), force_N.y(), 0.0}, dt_s);
  const auto joints_rad = bar_.inverse(tip_m());
  if (joints_rad) {
    joints_rad_ = *joints_rad;
  } else {
    body_.put(before_m, Vec3::Zero());
  }
}

}  // namespace palpate
