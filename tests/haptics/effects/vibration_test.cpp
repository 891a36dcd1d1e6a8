// The vibration's spectrum, its start and its end.

#include "haptics/effects/vibration.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "tests/haptics/proxy/body_hand.h"
#include "tests/helpers/ticks.h"

namespace palpate {
namespace {

using test::BodyHand;
using test::effect_entry;
using test::effect_number;
using test::hand_settings;
using test::kTick_s;
using test::Random;
using test::square_soup;

constexpr double kContact = 0.0;
constexpr double kSliding = 1.0;

BodyHand humming(double frequency_Hz, double amplitude_N, double when, const RigidTransform& pose) {
  BodyHand hand({square_soup(0.1)}, pose);
  hand.effects.add_body({effect_entry<VibrationEffect>({frequency_Hz, amplitude_N, when})});
  return hand;
}

struct Signal {
  std::vector<double> time_s;
  std::vector<double> value;
};

// The amplitude of a signal at a frequency, from samples at any times, under Hann's window, which
// keeps the side lobes of a peak low.
double amplitude(const Signal& s, double frequency_Hz) {
  std::complex<double> sum = 0.0;
  double weight = 0.0;
  const double length_s = s.time_s.back() - s.time_s.front();
  for (std::size_t i = 0; i < s.time_s.size(); ++i) {
    const double t = s.time_s[i] - s.time_s.front();
    const double window = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * t / length_s);
    sum += window * s.value[i] * std::polar(1.0, -2 * std::numbers::pi * frequency_Hz * t);
    weight += window;
  }
  return 2.0 * std::abs(sum) / weight;
}

double peak_Hz(const Signal& s, double from_Hz, double to_Hz, double step_Hz) {
  double best_Hz = from_Hz;
  double best = 0.0;
  for (double f = from_Hz; f <= to_Hz; f += step_Hz) {
    const double a = amplitude(s, f);
    if (a > best) {
      best = a;
      best_Hz = f;
    }
  }
  return best_Hz;
}

// Two seconds of the force along the normal, minus the spring's, at a constant depth.
Signal vibration_force(BodyHand& hand, Random& random, double jitter, bool slides) {
  hand.go_to({0, 0, 0.001});
  Signal signal;
  double t = 0.0;
  constexpr double kDepth_m = 0.002;
  for (int tick = 0; tick < 2000; ++tick) {
    const double dt_s = kTick_s * (1.0 + jitter * random.uniform(-1.0, 1.0));
    t += dt_s;
    // The hand moves back and forth by 0.05 m and never rests for two ticks.
    const double x = slides ? 0.05 * std::sin(2 * std::numbers::pi * tick / 777.5 + 0.1) : 0.0;
    hand.go_to({x, 0, -kDepth_m}, dt_s);
    if (tick < 100) continue;  // the amplitude still rises
    signal.time_s.push_back(t);
    signal.value.push_back(hand.force().z() - 1000.0 * kDepth_m);
    EXPECT_LE(hand.force().head<2>().norm(), 1e-9);
  }
  return signal;
}

TEST(Vibration, HasTheDeclaredFrequencyAndAmplitude) {
  Random random(6501);
  for (const double frequency_Hz : {20.0, 80.0, 150.0, 333.0}) {
    for (const double jitter : {0.0, 0.2}) {
      for (const double when : {kContact, kSliding}) {
        constexpr double kAmplitude_N = 0.3;
        BodyHand hand = humming(frequency_Hz, kAmplitude_N, when, random.pose(0.3));
        hand.begin(hand_settings());
        const Signal signal = vibration_force(hand, random, jitter, when == kSliding);
        // Search all frequencies below half the tick rate, then those near the peak.
        const double coarse_Hz = peak_Hz(signal, 1.0, 499.0, 0.5);
        const double fine_Hz = peak_Hz(signal, coarse_Hz - 0.5, coarse_Hz + 0.5, 0.02);
        EXPECT_NEAR(fine_Hz, frequency_Hz, 0.002 * frequency_Hz);
        // Ticks at irregular times sample the wave at those times, up to the noise of 2000 samples.
        EXPECT_NEAR(amplitude(signal, frequency_Hz), kAmplitude_N,
                    (jitter > 0.0 ? 0.03 : 0.001) * kAmplitude_N);
        std::printf("%5.0f Hz, jitter %.1f, %s: peak at %.2f Hz, amplitude %.4f N\n", frequency_Hz,
                    jitter, when == kSliding ? "sliding" : "contact", fine_Hz,
                    amplitude(signal, fine_Hz));
      }
    }
  }
}

TEST(Vibration, IsInactiveAtFrequenciesThatWouldAlias) {
  for (const double frequency_Hz : {500.0, 501.0, 750.0, 1000.0, 5000.0}) {
    BodyHand hand = humming(frequency_Hz, 0.3, kContact, {});
    hand.begin(hand_settings());
    hand.go_to({0, 0, 0.001});
    for (int tick = 0; tick < 200; ++tick) {
      hand.go_to({0, 0, -0.002});
      ASSERT_NEAR(hand.force().z(), 2.0, 1e-8);
      ASSERT_FALSE(hand.has_active_effect(effect_number<VibrationEffect>()));
    }
    // At ten times the rate, the ticks can carry frequencies below 5 kHz.
    for (int tick = 0; tick < 200; ++tick) hand.go_to({0, 0, -0.002}, 1e-4);
    EXPECT_EQ(hand.has_active_effect(effect_number<VibrationEffect>()), frequency_Hz < 5000.0);
  }
}

// The sine itself has steps of at most 2 pi f T of the amplitude. The rise and fall add f T of it,
// a quarter of a period out of phase: 1.3 % at most.
TEST(Vibration, StartsAndFadesWithoutAStep) {
  Random random(6503);
  for (int run = 0; run < 40; ++run) {
    const double frequency_Hz = random.uniform(5.0, 200.0);
    const double when = run % 2 ? kSliding : kContact;
    BodyHand hand = humming(frequency_Hz, 0.3, when, random.pose(0.3));
    hand.begin(hand_settings());
    hand.go_to({0, 0, 0.001});
    const double step =
        0.3 * frequency_Hz * kTick_s * std::sqrt(1.0 + 4 * std::numbers::pi * std::numbers::pi);
    double last = 0.0;
    double x = 0.0;
    int hums = 0;
    int silent = 0;
    for (int tick = 0; tick < 3000; ++tick) {
      if (tick / 500 % 2 == 0) x += 1e-5;
      hand.go_to({x, 0, -0.002});
      const double hum = hand.force().z() - 2.0;
      ASSERT_LE(std::abs(hum - last), step + 1e-8) << tick;
      last = hum;
      hums += std::abs(hum) > 0.1;
      silent += std::abs(hum) < 1e-8;
    }
    EXPECT_GT(hums, 300);
    EXPECT_TRUE(when == kContact || silent > 300);
  }
}

TEST(Vibration, WhileSlidingIsSilentAtRestAndRestartsAfterALift) {
  BodyHand hand = humming(50.0, 0.3, kSliding, {});
  hand.begin(hand_settings());
  hand.go_to({0, 0, 0.001});
  for (int tick = 0; tick < 100; ++tick) {
    hand.go_to({0, 0, -0.002 + 1e-6 * tick});  // pressing is not sliding
    // The motion from free space into contact counts as sliding.
    if (tick < 25) continue;
    ASSERT_NEAR(hand.force().z(), 2.0 - 1e-3 * tick, 1e-8);
  }
  std::vector<double> first;
  std::vector<double> second;
  for (std::vector<double>* strokes : {&first, &second}) {
    hand.go_to({0, 0, 0.001});
    ASSERT_EQ(hand.force(), Vec3(0, 0, 0));
    for (int tick = 0; tick < 60; ++tick) {
      hand.go_to({1e-4 * tick, 0, -0.002});
      strokes->push_back(hand.force().z());
    }
    for (int tick = 0; tick < 30; ++tick) hand.go_to({0, 0, 0.001});
  }
  for (std::size_t i = 0; i < first.size(); ++i) ASSERT_NEAR(first[i], second[i], 1e-9) << i;
}

}  // namespace
}  // namespace palpate
