#pragma once

// Runs a haptic session tick by tick, as a program does, and sums up what its ticks in contact
// cost.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "engine/devices/path_device.h"
#include "engine/session/haptic_session.h"
#include "haptics/haptic_loop.h"

namespace palpate {

// The coupling and the tick that the knobs are studied with, unless they are what is studied.
inline constexpr CouplingSettings kAccuracyCoupling{1000.0, 2.0};
inline constexpr double kAccuracyPeriod_s = 1e-3;

// What a session runs with, beside the world.
struct PassSetup {
  ActuationModel actuation;  // PassSetup::fully_actuated() for most
  HapticSettings haptics;

  // Three sensors, three actuators, no A4, the coupling given.
  static PassSetup fully_actuated(const CouplingSettings& coupling,
                                  const GodObjectSettings& god_object = {});
};

// Of ticks in contact.
struct PassCost {
  std::uint64_t ticks = 0;
  double tick_ns = 0.0;               // mean of HapticLoop::tick, less what asking the clock takes
  double iterations = 0.0;            // of the solver, mean
  std::uint32_t faults = kFaultNone;  // of any tick

  // Computing for a second of contact at this period, microseconds.
  double us_per_s(double dt_s) const { return 1e-3 * tick_ns / dt_s; }
};

// Told of every tick in contact, between ticks, on the thread that measures: it may allocate, as no
// haptic thread does.
using OnContact = std::function<void(const TickRecord& record)>;

// As many ticks as dt_s has elements, the first `lead_in` of which neither count nor are told: they
// bring the device to where the measurement begins.
PassCost run_pass(const ContactWorld& world, const PassSetup& setup, Device& device,
                  std::span<const double> dt_s, std::size_t lead_in, const OnContact& on_contact);

// The same with a device that is at path_m[n] in tick n. Device frame, metres.
PassCost run_path(const ContactWorld& world, const PassSetup& setup, std::span<const Vec3> path_m,
                  double dt_s, std::size_t lead_in, const OnContact& on_contact);

// What asking the clock twice takes, which is left out of every tick_ns.
double clock_overhead_ns();

// The first of these faults in words, for Sample::failure; empty for none. A capped solver is no
// failure: it is what some levels are about.
std::string failure_of(std::uint32_t faults);

}  // namespace palpate
