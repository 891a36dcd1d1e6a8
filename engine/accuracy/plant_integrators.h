#pragma once

// Numerical integrators of the motion of a pressed device, compared with the exact solution.

#include <cstdint>
#include <limits>

#include "engine/accuracy/knob.h"
#include "engine/accuracy/pressed_contact.h"

namespace palpate {

enum class PlantIntegrator : std::uint8_t {
  kSemiImplicitEuler,  // velocity, then position with the new velocity: order 1
  kRungeKutta4         // the classical method: order 4
};

// The time between the instants at which a path is compared with the exact one. It is a multiple of
// every step.
inline constexpr double kPlantInstant_s = 4e-3;

// The rounding error of sums in double, relative to the depth. Each step rounds the depth by up to
// half a unit in the last place. The roundings of n steps accumulate like a random walk, to sqrt(n)
// times one rounding.
double plant_roundoff(const PressedContact& contact, double step_s);

// Integrates the contact with a continuous spring and damper of the wall, under a random push.
// steps_per_instant: steps per kPlantInstant_s, >= 1. Sample::error: the largest deviation from the
// exact depth (PressedContact::depth_m() under this push), divided by the static depth.
// Sample::time: computing time for one second of contact, us. Sample::ticks: number of steps.
Sample integrate(const PressedContact& contact, PlantIntegrator integrator, int steps_per_instant,
                 std::uint64_t seed);

}  // namespace palpate
