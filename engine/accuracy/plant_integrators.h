#pragma once

// Ways to simulate a pressed device, against the exact solution.

#include <cstdint>
#include <limits>

#include "engine/accuracy/knob.h"
#include "engine/accuracy/pressed_contact.h"

namespace palpate {

enum class PlantIntegrator : std::uint8_t {
  kSemiImplicitEuler,  // velocity, then position with the new velocity: order 1
  kRungeKutta4         // the classical one: order 4
};

// Instants at which paths are compared; every step divides the time between them.
inline constexpr double kPlantInstant_s = 4e-3;

// Below it, errors are those of adding in double: each step rounds the depth by up to half a unit
// in its last place, and n roundings add up like a random walk, to sqrt(n) of them. As part of the
// depth.
double plant_roundoff(const PressedContact& contact, double step_s);

// Integrates the contact with the spring and the damper of the wall continuous, from a random time
// of it on. steps_per_instant: of kPlantInstant_s, >= 1. error: the largest deviation from
// contact.depth_m() over the static depth; time: computing for a second of contact, us; ticks:
// steps.
Sample integrate(const PressedContact& contact, PlantIntegrator integrator, int steps_per_instant,
                 std::uint64_t seed);

}  // namespace palpate
