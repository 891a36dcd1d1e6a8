#include "engine/simulation/simulated_device.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::Random;

// A plan with a constant target.
class OnePlace final : public HandPlan {
 public:
  HandTarget target(double, const ScenePose&, const TickRecord&) noexcept override {
    return {Vec3(0.1, 0.0, 0.0), Vec3::Zero()};
  }
};

// The distance of a hand from its target after this many ticks; 0.1 m at the start.
double distance_after(const PlantSettings& settings, double dt_s, int ticks) {
  OnePlace plan;
  SimulatedDevice device(settings, plan, Vec3::Zero(), {}, false);
  double distance_m = 0.0;
  for (int n = 0; n < ticks; ++n) {
    const DeviceSample sample = device.read(dt_s);
    distance_m = (Vec3(sample.position_m.data()) - Vec3(0.1, 0.0, 0.0)).norm();
  }
  return distance_m;
}

// Without noise, friction and rounding, an accepted hand never moves farther away than its
// overshoot, and a hand that is clearly rejected diverges.
TEST(SimulatedDevice, IsRejectedExactlyWhereItsStepsDiverge) {
  Random random(1603);
  int refused = 0;
  int accepted = 0;
  for (int trial = 0; trial < 400; ++trial) {
    PlantSettings settings;
    settings.intention_noise_m = 0.0;
    settings.device.coulomb_friction_N = 0.0;
    settings.device.encoder_quantum_m = 0.0;
    settings.device.mass_kg = std::pow(10.0, random.uniform(-6.0, 3.0));
    settings.device.damping_Ns_per_m = std::pow(10.0, random.uniform(-3.0, 6.0));
    const double dt_s = std::pow(10.0, random.uniform(-4.0, 0.0));
    if (!check_plant(settings, dt_s)) {
      ++accepted;
      ASSERT_LE(distance_after(settings, dt_s, 2000), 1.0);
      continue;
    }
    PlantSettings lighter = settings;  // slightly less damping: is it also rejected?
    lighter.device.damping_Ns_per_m *= 0.9;
    if (!check_plant(lighter, dt_s)) continue;
    ++refused;
    ASSERT_FALSE(distance_after(settings, dt_s, 2000) <= 1.0);
  }
  EXPECT_GT(accepted, 50);
  EXPECT_GT(refused, 50);
}

TEST(SimulatedDevice, DoesNotRoundIfTheEncoderStepIsTooSmall) {
  PlantSettings settings;
  OnePlace plan;
  for (const double quantum_m : {0.0, 1e-310, 5e-324}) {
    settings.device.encoder_quantum_m = quantum_m;
    SimulatedDevice device(settings, plan, Vec3(0.05, 0.02, 0.01), {}, false);
    const DeviceSample sample = device.read(1e-3);
    EXPECT_EQ(Vec3(sample.position_m.data()), Vec3(0.05, 0.02, 0.01)) << quantum_m;
  }
}

}  // namespace
}  // namespace palpate
