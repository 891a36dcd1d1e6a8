#include "haptics/energy_budgets.h"

namespace palpate {
namespace {

// What the hand has put into a contact is forgotten after this time without one.
constexpr double kForget_s = 1.0;

}  // namespace

void GivenByDesign::clear() noexcept {
  for (std::size_t n = 0; n < kEnergySourceCount; ++n) left_J_[n] = budgets_.of[n].tank_J;
  stored_J_ = 0.0;
}

double GivenByDesign::add(const Work& work) noexcept {
  double excess_J = take(EnergySource::kMotors, work.motors_J, work.step_s);
  excess_J += take(EnergySource::kNodes, work.nodes_J, work.step_s);
  double rest_J = work.even_J - work.motors_J - work.nodes_J;
  for (std::size_t n = 0; n < work.effects_J.size(); ++n) {
    const auto source = static_cast<EnergySource>(kFirstGivingEffect + n);
    excess_J += take(source, work.effects_J[n], work.step_s);
    rest_J -= work.effects_J[n];
  }
  return excess_J + take_rest(rest_J, work);
}

double GivenByDesign::take(EnergySource source, double work_J, double step_s) noexcept {
  const auto n = static_cast<std::size_t>(source);
  given_J_[n] += work_J;
  const EnergyBudget& budget = budgets_.of[n];
  double left_J = left_J_[n] + budget.power_W * step_s - work_J;
  const double excess_J = std::max(0.0, -left_J);
  left_J_[n] = std::min(budget.tank_J, left_J + excess_J);
  return excess_J;
}

// The rest: a spring gives back what the hand has put in.
double GivenByDesign::take_rest(double work_J, const Work& work) noexcept {
  stored_J_ -= work_J;
  free_s_ = work.in_contact ? 0.0 : free_s_ + work.step_s;
  if (free_s_ > kForget_s) stored_J_ = std::min(stored_J_, 0.0);
  stored_J_ = std::min(stored_J_, work.most_stored_J);
  if (stored_J_ >= 0.0) return take(EnergySource::kOther, 0.0, work.step_s);
  const double beyond_J = -stored_J_;
  stored_J_ = 0.0;
  return take(EnergySource::kOther, beyond_J, work.step_s);
}

}  // namespace palpate
