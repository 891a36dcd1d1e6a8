#include "engine/accuracy/session_pass.h"

#include <algorithm>
#include <chrono>
#include <vector>

#include "engine/rig/rig.h"

namespace palpate {
namespace {

class ContactMeter final : public TickObserver {
 public:
  ContactMeter(std::size_t lead_in, const OnContact& on_contact)
      : lead_in_(lead_in), on_contact_(on_contact) {}

  void on_tick(const TickRecord& record) noexcept override {
    cost_.faults |= record.faults;
    if (count_++ < lead_in_ || !record.contact) return;
    ++cost_.ticks;
    time_ns_ += static_cast<double>(record.step_ns);
    iterations_ += record.iterations;
    if (on_contact_) on_contact_(record);
  }
  PassCost finish(double clock_ns) {
    if (cost_.ticks == 0) return cost_;
    const auto ticks = static_cast<double>(cost_.ticks);
    cost_.tick_ns = std::max(0.0, time_ns_ / ticks - clock_ns);
    cost_.iterations = iterations_ / ticks;
    return cost_;
  }

 private:
  std::size_t lead_in_;
  const OnContact& on_contact_;
  std::size_t count_ = 0;
  PassCost cost_;
  double time_ns_ = 0.0;
  double iterations_ = 0.0;
};

}  // namespace

PassSetup PassSetup::fully_actuated(const CouplingSettings& coupling,
                                    const GodObjectSettings& god_object) {
  PassSetup setup{*ActuationModel::from_counts(3, 3), {}};
  setup.haptics.god_object = god_object;
  setup.haptics.coupling = coupling;
  setup.haptics.a4.enabled = false;
  return setup;
}

double clock_overhead_ns() {
  static const double median_ns = [] {
    std::vector<double> empty_ns(10001);
    for (double& time_ns : empty_ns) {
      const auto start = std::chrono::steady_clock::now();
      const std::chrono::duration<double, std::nano> nothing =
          std::chrono::steady_clock::now() - start;
      time_ns = nothing.count();
    }
    // The mean, like the times that it is subtracted from: one step of the clock is longer than the
    // cost of reading it. The mean of the shortest nine tenths, without interrupts.
    std::sort(empty_ns.begin(), empty_ns.end());
    const std::size_t kept = empty_ns.size() * 9 / 10;
    double sum_ns = 0.0;
    for (std::size_t i = 0; i < kept; ++i) sum_ns += empty_ns[i];
    return sum_ns / static_cast<double>(kept);
  }();
  return median_ns;
}

PassCost run_pass(const ContactWorld& world, const PassSetup& setup, Device& device,
                  std::span<const double> dt_s, std::size_t lead_in, const OnContact& on_contact) {
  ContactMeter meter(lead_in, on_contact);
  const auto rig =
      Rig::create(world, RunSetup{setup.actuation, setup.haptics, kAccuracyPeriod_s, {}}, device,
                  {.observers = {&meter}});
  if (!rig) return {.faults = kFaultBadSettings};
  HapticSession& session = (*rig)->session();
  session.start();
  for (const double dt : dt_s) session.tick(dt);
  return meter.finish(clock_overhead_ns());
}

PassCost run_path(const ContactWorld& world, const PassSetup& setup, std::span<const Vec3> path_m,
                  double dt_s, std::size_t lead_in, const OnContact& on_contact) {
  PathDevice device(path_m);
  const std::vector<double> periods_s(path_m.size(), dt_s);
  return run_pass(world, setup, device, periods_s, lead_in, on_contact);
}

std::string failure_of(std::uint32_t faults) {
  for (int bit = 0; bit < kFaultCount; ++bit) {
    const std::uint32_t fault = 1u << bit;
    if ((faults & fault) == 0 || fault == kFaultSolverCapped) continue;
    return "a tick had the fault " + std::string(kFaultNames[static_cast<std::size_t>(bit)]);
  }
  return "";
}

}  // namespace palpate
