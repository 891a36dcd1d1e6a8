// What a servo's rate, its evenness and the steps between its ticks buy.

#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

#include "engine/accuracy/bounce.h"
#include "engine/accuracy/friction_circle.h"
#include "engine/accuracy/knobs.h"
#include "engine/accuracy/plant_integrators.h"
#include "engine/accuracy/pressed_contact.h"
#include "engine/devices/light_device.h"

namespace palpate {
namespace {

constexpr double kServoRates_Hz[] = {250, 500, 1000, 2000, 4000, 10000, 20000};
constexpr std::size_t kUsualRate = 2;  // 1 kHz

const Quantity kTimePerContact{"computing for a second of contact", "us"};

std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

std::string rate_text(double rate_Hz) {
  return rate_Hz < 1000.0 ? number_text(rate_Hz) + " Hz" : number_text(1e-3 * rate_Hz) + " kHz";
}

// Level value: the effective period.
Method bounces_at_rates(const std::string& name, double half_width, double left_out) {
  Method method{name, {}, 1.0};
  for (const double rate_Hz : kServoRates_Hz) {
    const TickPeriods periods{1.0 / rate_Hz, half_width, left_out};
    method.levels.push_back({periods.effective_s(), rate_text(rate_Hz), [=](std::uint64_t seed) {
                               return bounces({}, periods, Accuracy{}, seed);
                             }});
  }
  return method;
}

// Energy gained in a bounce: what two knobs measure.
Knob bounce_knob() {
  Knob knob;
  knob.level = {"period", "s"};
  knob.error = {"energy gained in a bounce over the energy that came", ""};
  knob.time = kTimePerContact;
  knob.reference = "no gain: a spring gives back what it was given";
  knob.default_level = kUsualRate;
  knob.run_preset = [](std::uint64_t seed, const Accuracy& preset) {
    return bounces({}, {1.0 / kServoRates_Hz[kUsualRate]}, preset, seed);
  };
  // What viscous damping takes of the energy in the time of a bounce.
  const BounceSetup setup;
  knob.enough = -std::expm1(-light_device().damping_Ns_per_m / setup.mass_kg * setup.contact_s());
  knob.enough_because =
      "a light device, of 0.1 kg and 0.5 N s/m, loses as much in the time of a bounce, so that "
      "the sum is no gain";
  return knob;
}

Knob rate_knob() {
  Knob knob = bounce_knob();
  knob.name = "servo_rate";
  knob.title = "Servo rate";
  knob.workload =
      "A free mass of 0.1 kg bounces off a flat wall of K = 1000 N/m, B = 0, which it meets at 0.2 "
      "to 0.3 m/s and at any phase of the servo.";
  knob.methods = {bounces_at_rates("held force", 0.0, 0.0)};
  return knob;
}

Knob jitter_knob() {
  constexpr double kHalfWidth = 0.5;
  constexpr double kLeftOut = 0.1;
  Knob knob = bounce_knob();
  knob.name = "jitter";
  knob.title = "Uneven ticks";
  knob.level = {"effective period, mean T² / mean T", "s"};
  knob.workload =
      "The bounce of the servo rate, K = 1000 N/m and B = 0, with ticks that come early, late or "
      "not at all.";
  knob.methods = {bounces_at_rates("even", 0.0, 0.0),
                  bounces_at_rates("uniform ±50 %", kHalfWidth, 0.0),
                  bounces_at_rates("one tick in ten left out", 0.0, kLeftOut),
                  bounces_at_rates("both", kHalfWidth, kLeftOut)};
  knob.levels_are_given = true;  // the rate is the matter of servo_rate
  return knob;
}

Knob pressed_knob() {
  Knob knob;
  knob.name = "servo_pressed";
  knob.title = "Servo rate, pressed against a wall";
  knob.level = {"period", "s"};
  knob.error = {"largest deviation of the path over the static depth", ""};
  knob.time = kTimePerContact;
  knob.workload =
      "A device of 0.1 kg and 0.5 N s/m rests in a flat wall of K = 1000 N/m, B = 1 N s/m, when "
      "the hand pushes twice as hard from one moment to the next.";
  knob.reference = "the continuous-time solution, by the matrix exponential";
  Method held{"held force", {}, 1.0};
  for (const double rate_Hz : kServoRates_Hz) {
    held.levels.push_back({1.0 / rate_Hz, rate_text(rate_Hz), [=](std::uint64_t seed) {
                             return press({}, 1.0 / rate_Hz, Accuracy{}, seed);
                           }});
  }
  knob.methods = {std::move(held)};
  knob.default_level = kUsualRate;
  knob.run_preset = [](std::uint64_t seed, const Accuracy& preset) {
    return press({}, 1.0 / kServoRates_Hz[kUsualRate], preset, seed);
  };
  knob.enough = 0.07;
  knob.enough_because = "people tell forces apart that differ by about 7 %";
  return knob;
}

Knob substeps_knob() {
  constexpr double kSamplePeriod_s = 1e-3;
  Knob knob;
  knob.name = "substeps";
  knob.title = "Ticks per millisecond under friction";
  knob.level = {"step", "s"};
  knob.error = {"error of the radius that the proxy goes round at", "m"};
  knob.time = kTimePerContact;
  knob.workload =
      "A proxy under friction of 0.5 is dragged on a plane by a device that goes round a circle of "
      "5 mm twice a second, 2 mm deep, and is read in every tick; K = 1000 N/m, B = 2 N s/m.";
  knob.reference =
      "the circle of the continuous law, √(r² - L²): r that of the device, L the coefficient of "
      "friction times the depth";
  Method ticks{"ticks of 1/n ms", {}, 1.0};
  for (const int n : {1, 2, 4, 8, 16, 32}) {
    const double step_s = kSamplePeriod_s / n;
    ticks.levels.push_back({step_s, std::to_string(n), [=](std::uint64_t seed) {
                              return go_round({}, step_s, Accuracy{}, seed);
                            }});
  }
  knob.methods = {std::move(ticks)};
  knob.run_preset = [](std::uint64_t seed, const Accuracy& preset) {
    return go_round({}, kSamplePeriod_s, preset, seed);
  };
  knob.enough = 10e-6;
  knob.enough_because = "half a step of a usual encoder, 20 µm: the device knows it no better";
  return knob;
}

Method integrator_method(const std::string& name, PlantIntegrator integrator, double order) {
  Method method{name, {}, order};
  const PressedContact contact;
  double step_s = kPlantInstant_s;
  for (const int steps : {1, 2, 4, 8, 20, 40, 80, 200, 400, 800}) {
    step_s = kPlantInstant_s / steps;
    method.levels.push_back({step_s, number_text(1e3 * step_s) + " ms", [=](std::uint64_t seed) {
                               return integrate(contact, integrator, steps, seed);
                             }});
  }
  method.floor = plant_roundoff(contact, step_s);
  return method;
}

Knob integrator_knob() {
  constexpr std::size_t kTenStepsATick = 5;  // of 1 ms: what SimulatedDevice takes
  Knob knob;
  knob.name = "integrator";
  knob.title = "Integrator of the simulated device";
  knob.level = {"step", "s"};
  knob.error = {"largest deviation of the path over the static depth", ""};
  knob.time = kTimePerContact;
  knob.workload =
      "A device of 0.1 kg and 0.5 N s/m is pushed twice as hard into a wall of K = 1000 N/m, B = 1 "
      "N s/m, both continuous, without a servo; ticks are steps.";
  knob.reference = "the matrix exponential";
  knob.floor_is = "rounding of double, added up over the finest level's steps like a random walk";
  knob.methods = {
      integrator_method("semi-implicit Euler", PlantIntegrator::kSemiImplicitEuler, 1.0),
      integrator_method("RK4", PlantIntegrator::kRungeKutta4, 4.0)};
  knob.default_level = kTenStepsATick;
  // No proxy: a preset changes nothing.
  const auto& default_run = knob.methods[0].levels[kTenStepsATick].run;
  knob.run_preset = [default_run](std::uint64_t seed, const Accuracy&) {
    return default_run(seed);
  };
  knob.enough = 0.01;
  knob.enough_because = "far below the 5 % by which a hand's force scatters";
  knob.default_because =
      "a device with dry friction, and a wall to leave, is not smooth: there a higher order is "
      "worth "
      "no more than 1";
  return knob;
}

}  // namespace

// A quick study has nothing to leave out: there are two triangles, and all paths are short.
std::vector<Knob> servo_knobs(const StudyEffort&) {
  return {rate_knob(), pressed_knob(), jitter_knob(), substeps_knob(), integrator_knob()};
}

}  // namespace palpate
