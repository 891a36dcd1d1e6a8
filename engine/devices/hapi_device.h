#pragma once

// The driver of a pantograph on a hAPI board (Haply 2DIY).

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/devices/guardable_device.h"
#include "engine/devices/hapi_link.h"
#include "engine/devices/hapi_settings.h"
#include "engine/devices/hapi_view.h"

namespace palpate {

// Talks with the board on a thread of its own, so that the haptic thread does no I/O: a mailbox in
// each direction holds the newest sample and the newest force.
//
// start() opens the port, sets up the board, waits until it answers, and measures the delay and the
// rate of the line by round trips at zero force (HapiDelay). The description states this delay from
// then on. The device must be in its rest pose at start() (HapiWiring). A guard is given after
// start(), because it needs the open port; without one the driver commands zero
// (HapiSettings::works_without_guard).
//
// The driver has not run on hardware. It cannot tell a frozen encoder behind fresh answers from a
// hand at rest.
class HapiDevice final : public GuardableDevice {
 public:
  // A board must answer start() within this time.
  static constexpr double kAnswerToStart_s = 2.0;
  // The measurement ends after HapiDelay::kMost exchanges or after this time, but not before it has
  // HapiDelay::kFewest, for which the board has kAnswerToStart_s.
  static constexpr double kMeasurement_s = 0.5;

  explicit HapiDevice(HapiSettings settings);
  ~HapiDevice() override;

  const DeviceDescription& description() const noexcept override { return view_.description(); }
  std::optional<std::string> start() override;
  DeviceSample read(double dt_s) noexcept override;
  void command(const DeviceCommand& command) noexcept override;
  std::span<const MotorDescription> motors_now() const noexcept override { return view_.motors(); }
  // Sends zero and closes the port.
  void stop() noexcept override;
  DeviceHealth health() const override;

  int descriptor() const noexcept override;
  std::vector<std::uint8_t> zero_bytes() const override {
    return hapi_zero_bytes(hapi_motors(settings_.wiring));
  }
  void set_guard(WriteGuard* guard) noexcept override;

  // Of this session or, after stop(), the last one.
  HapiCounts counts() const;
  LineRate line_rate() const override;
  // What counts() says.
  std::string summary() const override;

 private:
  class Session;

  std::optional<std::string> open();
  std::optional<std::string> wait_for_answer();
  std::optional<std::string> measure_line();

  HapiSettings settings_;
  HapiView view_;
  HapiSample sample_;  // the last one of the haptic thread
  std::unique_ptr<Session> session_;
  HapiCounts last_counts_;
  HapiSample last_sample_;
  HapiLine line_;
  std::int64_t tick_ns_ = 0;  // the period of the ticks; 0 before the first one
};

}  // namespace palpate
