// The accuracy that the servo's rate, the evenness of its ticks and the steps between them buy.

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
#include "engine/report/human_units.h"

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

// "a device of 0.1 kg and 0.5 N s/m"
std::string device_text(const DeviceDescription& device) {
  return "a device of " + number_text(device.mass_kg) + " kg and " +
         number_text(device.damping_Ns_per_m) + " N s/m";
}

BounceSetup bounce_on(const DeviceDescription& device) {
  BounceSetup setup;
  setup.mass_kg = device.mass_kg;
  return setup;
}

// Level value: the effective period.
Method bounces_at_rates(const BounceSetup& setup, const std::string& name, double half_width,
                        double left_out) {
  Method method{name, {}, 1.0};
  for (const double rate_Hz : kServoRates_Hz) {
    const TickPeriods periods{1.0 / rate_Hz, half_width, left_out};
    method.levels.push_back({periods.effective_s(), rate_text(rate_Hz), [=](std::uint64_t seed) {
                               return bounces(setup, periods, Accuracy{}, seed);
                             }});
  }
  return method;
}

// The common part of the knobs that measure the energy gained in a bounce.
Knob bounce_knob(const DeviceDescription& device) {
  Knob knob;
  knob.level = {"period", "s"};
  knob.error = {"energy gained in a bounce over the energy on arrival", ""};
  knob.time = kTimePerContact;
  knob.reference = "no gain: a spring returns the energy that it has stored";
  knob.default_level = kUsualRate;
  const BounceSetup setup = bounce_on(device);
  knob.run_preset = [setup](std::uint64_t seed, const Accuracy& preset) {
    return bounces(setup, {1.0 / kServoRates_Hz[kUsualRate]}, preset, seed);
  };
  // The energy that viscous damping takes in the time of a bounce.
  knob.enough = -std::expm1(-device.damping_Ns_per_m / setup.mass_kg * setup.contact_s());
  knob.enough_because = device_text(device) +
                        " loses as much energy in the time of a bounce, so that the total does not "
                        "grow";
  return knob;
}

Knob rate_knob(const DeviceDescription& device) {
  Knob knob = bounce_knob(device);
  knob.name = "servo_rate";
  knob.title = "Servo rate";
  knob.workload = "A free mass of " + number_text(device.mass_kg) +
                  " kg hits a flat wall of K = 1000 N/m, B = 0 at 0.2 to 0.3 m/s, at any phase of "
                  "the servo, and bounces off.";
  knob.methods = {bounces_at_rates(bounce_on(device), "held force", 0.0, 0.0)};
  return knob;
}

Knob jitter_knob(const DeviceDescription& device) {
  constexpr double kHalfWidth = 0.5;
  constexpr double kLeftOut = 0.1;
  const BounceSetup setup = bounce_on(device);
  Knob knob = bounce_knob(device);
  knob.name = "jitter";
  knob.title = "Uneven ticks";
  knob.level = {"effective period, mean T² / mean T", "s"};
  knob.workload =
      "The bounce of the servo rate, K = 1000 N/m and B = 0, with ticks that are early, late or "
      "missed.";
  knob.methods = {bounces_at_rates(setup, "even", 0.0, 0.0),
                  bounces_at_rates(setup, "uniform ±50 %", kHalfWidth, 0.0),
                  bounces_at_rates(setup, "one tick in ten left out", 0.0, kLeftOut),
                  bounces_at_rates(setup, "both", kHalfWidth, kLeftOut)};
  knob.levels_are_given = true;  // servo_rate chooses the rate
  return knob;
}

Knob pressed_knob(const DeviceDescription& device) {
  const PressedContact contact = PressedContact::on(device);
  Knob knob;
  knob.name = "servo_pressed";
  knob.title = "Servo rate, pressed against a wall";
  knob.level = {"period", "s"};
  knob.error = {"largest deviation of the path over the static depth", ""};
  knob.time = kTimePerContact;
  knob.workload = "The hand presses " + device_text(device) +
                  " against a flat wall of K = 1000 N/m, B = 1 N s/m, then suddenly twice as hard.";
  knob.reference = "the continuous-time solution, by the matrix exponential";
  Method held{"held force", {}, 1.0};
  for (const double rate_Hz : kServoRates_Hz) {
    held.levels.push_back({1.0 / rate_Hz, rate_text(rate_Hz), [=](std::uint64_t seed) {
                             return press(contact, 1.0 / rate_Hz, Accuracy{}, seed);
                           }});
  }
  knob.methods = {std::move(held)};
  knob.default_level = kUsualRate;
  knob.run_preset = [contact](std::uint64_t seed, const Accuracy& preset) {
    return press(contact, 1.0 / kServoRates_Hz[kUsualRate], preset, seed);
  };
  knob.enough = 0.07;
  knob.enough_because = "people distinguish forces that differ by about 7 %";
  return knob;
}

Knob substeps_knob(const DeviceDescription& device) {
  constexpr double kSamplePeriod_s = 1e-3;
  Knob knob;
  knob.name = "substeps";
  knob.title = "Ticks per millisecond under friction";
  knob.level = {"step", "s"};
  knob.error = {"error of the radius of the proxy's circle", "m"};
  knob.time = kTimePerContact;
  knob.workload =
      "A device circles at 2 mm depth in a plane with a friction coefficient of 0.5, on a radius "
      "of "
      "5 mm, twice a second, and drags the proxy along; it is read in every tick; K = 1000 N/m, "
      "B = 2 N s/m.";
  knob.reference =
      "the circle of the continuous law, √(r² - L²): r the radius of the device, L the coefficient "
      "of friction times the depth";
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
  if (device.encoder_quantum_m > 0.0) {
    knob.enough = 0.5 * device.encoder_quantum_m;
    knob.enough_because = "half a step of the encoder, " + human(device.encoder_quantum_m, "m") +
                          ": the device resolves no more";
  } else {
    knob.enough = kEnoughDepth_m;
    knob.enough_because = kEnoughDepthBecause;
  }
  return knob;
}

Method integrator_method(const PressedContact& contact, const std::string& name,
                         PlantIntegrator integrator, double order) {
  Method method{name, {}, order};
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

Knob integrator_knob(const DeviceDescription& device) {
  constexpr std::size_t kTenStepsATick = 5;  // ticks of 1 ms, as in SimulatedDevice
  const PressedContact contact = PressedContact::on(device);
  Knob knob;
  knob.name = "integrator";
  knob.title = "Integrator of the simulated device";
  knob.level = {"step", "s"};
  knob.error = {"largest deviation of the path over the static depth", ""};
  knob.time = kTimePerContact;
  knob.workload = "The hand presses " + device_text(device) +
                  " twice as hard into a wall of K = 1000 N/m, B = 1 N s/m. Device and wall are "
                  "continuous, without a servo; ticks are steps.";
  knob.reference = "the matrix exponential";
  knob.floor_is = "rounding in double, accumulated over the finest level's steps as a random walk";
  knob.methods = {
      integrator_method(contact, "semi-implicit Euler", PlantIntegrator::kSemiImplicitEuler, 1.0),
      integrator_method(contact, "RK4", PlantIntegrator::kRungeKutta4, 4.0)};
  knob.default_level = kTenStepsATick;
  // The run has no proxy: a preset changes nothing.
  const auto& default_run = knob.methods[0].levels[kTenStepsATick].run;
  knob.run_preset = [default_run](std::uint64_t seed, const Accuracy&) {
    return default_run(seed);
  };
  knob.enough = 0.01;
  knob.enough_because = "the force of a hand scatters by 5 %, far more";
  knob.default_because =
      "a device with dry friction that leaves a wall does not move smoothly, and there a higher "
      "order is worth no more than order 1";
  return knob;
}

}  // namespace

// A quick measurement is the same: the mesh has two triangles, and all paths are short.
std::vector<Knob> servo_knobs(const MeasurementEffort&, const DeviceDescription& device) {
  return {rate_knob(device), pressed_knob(device), jitter_knob(device), substeps_knob(device),
          integrator_knob(device)};
}

}  // namespace palpate
