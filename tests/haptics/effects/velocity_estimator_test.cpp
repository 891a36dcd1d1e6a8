#include "haptics/effects/velocity_estimator.h"

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/helpers/floating_point.h"
#include "tests/helpers/random.h"
#include "tests/helpers/ticks.h"

namespace palpate {
namespace {

using test::kEpsilon;
using test::kTick_s;
using test::Random;

constexpr VelocityMethod kMethods[] = {VelocityMethod::kDifference, VelocityMethod::kLineFit,
                                       VelocityMethod::kAdaptive};

struct Moment {
  double dt_s;
  Vec3 position_m;
};

// The rounding error of a velocity from positions of this size over the shortest possible window. A
// line fit cancels up to 64 of its sums' digits, half of which come from each of two products.
double velocity_roundoff(double largest_m, double shortest_s) {
  return 128 * kEpsilon * largest_m / shortest_s;
}

double uneven_tick_s(Random& random) {
  return std::pow(10.0, random.uniform(-4.0, -2.0));
}

int random_window(Random& random) {
  return 1 + static_cast<int>(random.index(VelocityEstimator::kMostTicks));
}

// x = x0 + v t + a t^2 / 2, evaluated with more digits than the estimator has.
Vec3 on_parabola(const Vec3& x0, const Vec3& v, const Vec3& a, long double t_s) {
  Vec3 x;
  for (int i = 0; i < 3; ++i) x[i] = static_cast<double>(x0[i] + t_s * (v[i] + t_s * a[i] / 2));
  return x;
}

TEST(VelocityEstimator, IsExactOnStraightLinesAtUnevenTicks) {
  Random random(4101);
  for (int i = 0; i < 300; ++i) {
    const VelocityMethod method = kMethods[i % 3];
    VelocityEstimator estimator({method, random_window(random), 1e-6});
    const Vec3 start_m = random.in_box(0.1);
    const Vec3 v = random.in_box(1.0);
    long double t_s = 0.0;
    EXPECT_EQ(estimator.add(start_m, 1.0), Vec3(Vec3::Zero()));
    for (int n = 0; n < 200; ++n) {
      const double dt_s = uneven_tick_s(random);
      t_s += dt_s;
      const Vec3 x = on_parabola(start_m, v, Vec3::Zero(), t_s);
      const Vec3 estimate = estimator.add(x, dt_s);
      ASSERT_LE((estimate - v).norm(), velocity_roundoff(x.norm() + start_m.norm(), 1e-4))
          << "method " << i % 3 << " tick " << n;
    }
  }
}

TEST(VelocityEstimator, LagsByHalfItsWindowUnderSteadyAcceleration) {
  Random random(4102);
  for (const VelocityMethod method : {VelocityMethod::kDifference, VelocityMethod::kLineFit}) {
    for (const int window : {1, 2, 3, 8, 17, 32, 63}) {
      VelocityEstimator estimator({method, window, 0.0});
      const Vec3 v = random.in_box(0.1);
      const Vec3 a = random.in_box(10.0);
      for (int n = 0; n < 200; ++n) {
        const double t_s = n * kTick_s;
        const Vec3 estimate = estimator.add(
            on_parabola(Vec3::Zero(), v, a, n * static_cast<long double>(kTick_s)), kTick_s);
        if (n == 0) continue;
        const int there = std::min(n, window);
        const Vec3 expected = v + t_s * a - 0.5 * there * kTick_s * a;
        ASSERT_LE((estimate - expected).norm(), velocity_roundoff(1.0, kTick_s))
            << "window " << window << " tick " << n;
      }
    }
  }
}

// Even at uneven ticks, a difference is the velocity at the middle of its window.
TEST(VelocityEstimator, DifferenceIsTheVelocityInTheMiddleOfItsWindow) {
  Random random(4103);
  for (int i = 0; i < 100; ++i) {
    const int window = random_window(random);
    VelocityEstimator estimator({VelocityMethod::kDifference, window, 0.0});
    const Vec3 a = random.in_box(10.0);
    std::vector<long double> times_s{0.0};
    estimator.add(Vec3::Zero(), kTick_s);
    for (std::size_t n = 1; n < 200; ++n) {
      const double dt_s = uneven_tick_s(random);
      times_s.push_back(times_s.back() + dt_s);
      const Vec3 x = on_parabola(Vec3::Zero(), Vec3::Zero(), a, times_s.back());
      const Vec3 estimate = estimator.add(x, dt_s);
      const std::size_t there = std::min(n, static_cast<std::size_t>(window));
      const auto middle_s = static_cast<double>((times_s[n] + times_s[n - there]) / 2);
      ASSERT_LE((estimate - middle_s * a).norm(), velocity_roundoff(x.norm(), 1e-4));
    }
  }
}

// The formulas in VelocitySettings assume independent rounding errors.
TEST(VelocityEstimator, HasTheNoiseOfTheFormulas) {
  Random random(4104);
  constexpr double kQuantum_m = 20e-6;
  constexpr int kTicks = 100000;
  for (const int window : {1, 2, 5, 16, 32, 63}) {
    VelocityEstimator difference({VelocityMethod::kDifference, window, 0.0});
    VelocityEstimator line_fit({VelocityMethod::kLineFit, window, 0.0});
    double difference_sum = 0.0;
    double line_fit_sum = 0.0;
    for (int n = -window; n < kTicks; ++n) {
      const Vec3 x = random.in_box(kQuantum_m / 2);
      const double by_difference = difference.add(x, kTick_s).squaredNorm();
      const double by_line_fit = line_fit.add(x, kTick_s).squaredNorm();
      if (n < 0) continue;
      difference_sum += by_difference;
      line_fit_sum += by_line_fit;
    }
    const double w = window;
    // Four standard deviations: the ticks of one window are one independent sample of each of three
    // axes.
    const double relative = 4.0 / std::sqrt(2.0 * 3.0 * kTicks / w);
    const double expected = kQuantum_m / (std::sqrt(6.0) * w * kTick_s);
    EXPECT_NEAR(std::sqrt(difference_sum / (3.0 * kTicks)), expected, relative * expected) << w;
    const double expected_fit = kQuantum_m / (kTick_s * std::sqrt(w * (w + 1.0) * (w + 2.0)));
    EXPECT_NEAR(std::sqrt(line_fit_sum / (3.0 * kTicks)), expected_fit, relative * expected_fit)
        << w;
  }
}

// ---- adaptive ----------------------------------------------------------------------------------

// The definition, tested for each window in turn.
Vec3 longest_straight(const std::vector<Moment>& moments, int window, double quantum_m,
                      int& chosen) {
  const Moment& last = moments.back();
  Vec3 velocity = Vec3::Zero();
  double span_s = 0.0;
  for (int k = 1; k <= window && k < static_cast<int>(moments.size()); ++k) {
    span_s += moments[moments.size() - static_cast<std::size_t>(k)].dt_s;
    const Vec3 slope =
        (last.position_m - moments[moments.size() - 1 - static_cast<std::size_t>(k)].position_m) /
        span_s;
    bool is_straight = true;
    double back_s = 0.0;
    for (int j = 1; j < k; ++j) {
      back_s += moments[moments.size() - static_cast<std::size_t>(j)].dt_s;
      const Vec3 on_line = last.position_m - back_s * slope;
      const Vec3 off =
          moments[moments.size() - 1 - static_cast<std::size_t>(j)].position_m - on_line;
      is_straight = is_straight && (off.cwiseAbs().array() <= quantum_m / 2).all();
    }
    if (!is_straight) continue;
    velocity = slope;
    chosen = k;
  }
  return velocity;
}

TEST(AdaptiveVelocity, IsTheDifferenceOverTheLongestStraightWindow) {
  Random random(4105);
  constexpr double kQuantum_m = 20e-6;
  int chosen_count[VelocityEstimator::kMostTicks + 1] = {};
  for (int i = 0; i < 60; ++i) {
    const int window = random_window(random);
    VelocityEstimator estimator({VelocityMethod::kAdaptive, window, kQuantum_m});
    std::vector<Moment> moments;
    const double noise_m = random.uniform(0.2, 0.8) * kQuantum_m;
    Vec3 v = random.in_box(0.1);
    Vec3 x = Vec3::Zero();
    for (int n = 0; n < 200; ++n) {
      if (random.index(50) == 0) v = random.in_box(0.1);
      const double dt_s = random.uniform(5e-4, 2e-3);
      x += dt_s * v;
      moments.push_back({dt_s, x + random.in_box(noise_m / 2)});
      const Vec3 estimate = estimator.add(moments.back().position_m, dt_s);
      int chosen = 0;
      const Vec3 expected = longest_straight(moments, window, kQuantum_m, chosen);
      ASSERT_LE((estimate - expected).norm(), velocity_roundoff(x.norm(), 5e-4))
          << "window " << window << " chosen " << chosen << " tick " << n;
      ++chosen_count[chosen];
    }
  }
  // Both short and long windows occurred.
  EXPECT_GT(chosen_count[1], 20);
  EXPECT_GT(chosen_count[5], 20);
  EXPECT_GT(chosen_count[20], 20);
}

TEST(AdaptiveVelocity, DropsSamplesBeforeAKinkAtOnce) {
  Random random(4106);
  for (int i = 0; i < 100; ++i) {
    const Vec3 before = random.in_box(0.5);
    const Vec3 after = random.in_box(0.5);
    VelocityEstimator adaptive({VelocityMethod::kAdaptive, 32, 1e-9});
    VelocityEstimator difference({VelocityMethod::kDifference, 32, 0.0});
    Vec3 x = Vec3::Zero();
    for (int n = 0; n < 100; ++n) {
      x += kTick_s * (n < 60 ? before : after);
      const Vec3 by_adaptive = adaptive.add(x, kTick_s);
      const Vec3 by_difference = difference.add(x, kTick_s);
      if (n < 40) continue;
      // A window with the kink in it is straight only if the kink is small.
      const Vec3 v = n < 60 ? before : after;
      const double rounding = velocity_roundoff(1.0, kTick_s);
      ASSERT_LE((by_adaptive - v).norm(), rounding) << n;
      if (n >= 60 && n < 60 + 31) {
        ASSERT_GT((by_difference - v).norm(), 1e3 * rounding) << n;
      }
    }
  }
}

// ---- memory ------------------------------------------------------------------------------------

TEST(VelocityEstimator, DropsAllSamplesAtAReset) {
  Random random(4107);
  for (const VelocityMethod method : kMethods) {
    const VelocitySettings settings{method, random_window(random), 1e-5};
    VelocityEstimator used(settings);
    for (int contact = 0; contact < 50; ++contact) {
      VelocityEstimator fresh(settings);
      for (int n = 0; n < 100; ++n) {
        const Vec3 x = random.in_box(1e-4);
        const double dt_s = uneven_tick_s(random);
        const Vec3 estimate = used.add(x, dt_s);
        ASSERT_EQ(estimate, fresh.add(x, dt_s));
        if (n == 0) {
          ASSERT_EQ(estimate, Vec3(Vec3::Zero()));
        }
      }
      used.reset();
    }
  }
}

TEST(VelocityEstimator, UsesTheSamplesPresentUntilTheWindowIsFull) {
  Random random(4108);
  for (const VelocityMethod method : kMethods) {
    VelocityEstimator longest({method, VelocityEstimator::kMostTicks, 1e-5});
    std::vector<Moment> moments;
    for (int n = 0; n <= VelocityEstimator::kMostTicks; ++n) {
      moments.push_back({uneven_tick_s(random), random.in_box(1e-3)});
      const Vec3 estimate = longest.add(moments.back().position_m, moments.back().dt_s);
      if (n == 0) continue;
      VelocityEstimator full({method, n, 1e-5});
      Vec3 expected = Vec3::Zero();
      for (const Moment& m : moments) expected = full.add(m.position_m, m.dt_s);
      ASSERT_EQ(estimate, expected) << n;
    }
  }
}

TEST(VelocityEstimator, ClampsAWindowOutOfRange) {
  Random random(4109);
  for (const VelocityMethod method : kMethods) {
    for (const auto& [asked, taken] : {std::pair(0, 1), std::pair(-7, 1), std::pair(64, 63),
                                       std::pair(std::numeric_limits<int>::max(), 63)}) {
      VelocityEstimator a({method, asked, 1e-5});
      VelocityEstimator b({method, taken, 1e-5});
      for (int n = 0; n < 1000; ++n) {
        const Vec3 x = random.in_box(1e-4);
        ASSERT_EQ(a.add(x, kTick_s), b.add(x, kTick_s));
      }
    }
  }
}

// A million ticks after a pause of thirty years, the length of a tick still has its digits.
TEST(VelocityEstimator, KeepsItsDigitsAfterAnyTime) {
  Random random(4110);
  for (const VelocityMethod method : kMethods) {
    const Vec3 v = random.in_box(0.1);
    VelocityEstimator estimator({method, VelocityEstimator::kMostTicks, 1e-9});
    estimator.add(Vec3::Zero(), kTick_s);
    estimator.add(Vec3::Zero(), 1e9);
    Vec3 estimate = Vec3::Zero();
    for (int n = 0; n < 1000000; ++n) {
      // The motion reverses regularly, so that positions keep their digits as well.
      const int phase = n % 200;
      const double way_s = kTick_s * (phase < 100 ? phase : 200 - phase);
      estimate = estimator.add(way_s * v, kTick_s);
      if (n < 100 || phase < 64 || phase > 99) continue;
      ASSERT_LE((estimate - v).norm(), velocity_roundoff(0.02, kTick_s)) << n;
    }
  }
}

}  // namespace
}  // namespace palpate
