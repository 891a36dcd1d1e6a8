#pragma once

// Runs a haptic session tick by tick, as a program does, and adds up the cost of its ticks in
// contact.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "engine/devices/path_device.h"
#include "engine/session/haptic_session.h"
#include "haptics/haptic_loop.h"

namespace palpate {

// The coupling and the period of the knobs that do not vary them.
inline constexpr CouplingSettings kAccuracyCoupling{1000.0, 2.0};
inline constexpr double kAccuracyPeriod_s = 1e-3;

// The settings of a session, without the world.
struct PassSetup {
  ActuationModel actuation;  // usually that of PassSetup::fully_actuated()
  HapticSettings haptics;

  // A setup with three sensors, three actuators, no A4, and this coupling.
  static PassSetup fully_actuated(const CouplingSettings& coupling,
                                  const GodObjectSettings& god_object = {});
};

// The cost of the ticks in contact.
struct PassCost {
  std::uint64_t ticks = 0;
  double tick_ns = 0.0;               // mean time of HapticLoop::tick, minus clock_overhead_ns()
  double iterations = 0.0;            // of the solver, mean
  std::uint32_t faults = kFaultNone;  // all faults of all ticks

  // Computing time for one second of contact at this period, microseconds.
  double us_per_s(double dt_s) const { return 1e-3 * tick_ns / dt_s; }
};

// Called after every tick in contact, on the measuring thread. May allocate, unlike code on a
// haptic thread.
using OnContact = std::function<void(const TickRecord& record)>;

// Runs one tick per element of dt_s. The first `lead_in` ticks move the device to the start of the
// measurement. Only the faults of these ticks count; on_contact is not called for these ticks.
PassCost run_pass(const ContactWorld& world, const PassSetup& setup, Device& device,
                  std::span<const double> dt_s, std::size_t lead_in, const OnContact& on_contact);

// run_pass() for a device that is at path_m[n] in tick n. Device frame, metres.
PassCost run_path(const ContactWorld& world, const PassSetup& setup, std::span<const Vec3> path_m,
                  double dt_s, std::size_t lead_in, const OnContact& on_contact);

// The cost of reading the clock twice, which is subtracted from every tick_ns.
double clock_overhead_ns();

// The first of these faults in words, for Sample::failure; empty if there is none. A capped solver
// is not a failure, because some levels cap it on purpose.
std::string failure_of(std::uint32_t faults);

}  // namespace palpate
