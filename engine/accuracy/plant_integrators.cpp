#include "engine/accuracy/plant_integrators.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <vector>

#include "engine/accuracy/session_pass.h"
#include "geometry/base/random.h"

namespace palpate {
namespace {

// The path is integrated repeatedly until the clock has measured this many steps.
constexpr std::size_t kTimedSteps = 20000;

struct State {
  double depth_m;
  double speed_m_per_s;
};

double acceleration(const PressedContact& contact, const State& s) {
  const double damping = contact.damping_Ns_per_m + contact.coupling.damping_Ns_per_m;
  return (contact.push_N - contact.coupling.stiffness_N_per_m * s.depth_m -
          damping * s.speed_m_per_s) /
         contact.mass_kg;
}

struct SemiImplicitEuler {
  static State step(const PressedContact& contact, State s, double dt_s) {
    s.speed_m_per_s += dt_s * acceleration(contact, s);
    s.depth_m += dt_s * s.speed_m_per_s;
    return s;
  }
};

struct RungeKutta4 {
  static State step(const PressedContact& contact, const State& s, double dt_s) {
    const auto rate = [&](const State& at) {
      return State{at.speed_m_per_s, acceleration(contact, at)};
    };
    const auto along = [&](const State& r, double t_s) {
      return State{s.depth_m + t_s * r.depth_m, s.speed_m_per_s + t_s * r.speed_m_per_s};
    };
    const State a = rate(s);
    const State b = rate(along(a, 0.5 * dt_s));
    const State c = rate(along(b, 0.5 * dt_s));
    const State d = rate(along(c, dt_s));
    return along(
        {(a.depth_m + 2.0 * (b.depth_m + c.depth_m) + d.depth_m) / 6.0,
         (a.speed_m_per_s + 2.0 * (b.speed_m_per_s + c.speed_m_per_s) + d.speed_m_per_s) / 6.0},
        dt_s);
  }
};

// The depth at every instant.
template <typename Integrator>
void run(const PressedContact& contact, int steps, std::vector<double>& depths_m) {
  const double dt_s = kPlantInstant_s / steps;
  State s{contact.start_depth_m(), 0.0};
  for (double& depth_m : depths_m) {
    for (int n = 0; n < steps; ++n) s = Integrator::step(contact, s, dt_s);
    depth_m = s.depth_m;
  }
}

}  // namespace

double plant_roundoff(const PressedContact& contact, double step_s) {
  return 0.5 * std::numeric_limits<double>::epsilon() * std::sqrt(contact.duration_s / step_s);
}

Sample integrate(const PressedContact& contact, PlantIntegrator integrator, int steps_per_instant,
                 std::uint64_t seed) {
  PressedContact pushed = contact;
  pushed.push_N *= SeededRandom(seed).uniform(0.5, 1.5);
  std::vector<double> depths_m(
      static_cast<std::size_t>(std::lround(contact.duration_s / kPlantInstant_s)));
  const std::size_t steps = depths_m.size() * static_cast<std::size_t>(steps_per_instant);
  const std::size_t times = std::max<std::size_t>(1, kTimedSteps / steps);
  const auto path =
      integrator == PlantIntegrator::kRungeKutta4 ? run<RungeKutta4> : run<SemiImplicitEuler>;
  const auto start = std::chrono::steady_clock::now();
  for (std::size_t i = 0; i < times; ++i) path(pushed, steps_per_instant, depths_m);
  const std::chrono::duration<double, std::micro> took = std::chrono::steady_clock::now() - start;
  Sample sample;
  sample.ticks = steps;
  sample.time = std::max(0.0, took.count() - 1e-3 * clock_overhead_ns()) /
                (static_cast<double>(times) * contact.duration_s);
  for (std::size_t i = 0; i < depths_m.size(); ++i) {
    const double exact_m = pushed.depth_m(static_cast<double>(i + 1) * kPlantInstant_s);
    sample.error = std::max(sample.error, std::abs(depths_m[i] - exact_m));
  }
  sample.error /= pushed.static_depth_m();
  return sample;
}

}  // namespace palpate
