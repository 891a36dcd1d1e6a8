// The least rates of a device that moves motors.

#include "engine/devices/line_rate.h"

#include <gtest/gtest.h>

namespace palpate {
namespace {

DeviceDescription pushing_device() {
  DeviceDescription device;
  device.name = "a device";
  device.motor_count = 2;
  return device;
}

LineRate line_of(double asked_Hz, double at_start_Hz, double in_session_Hz = 0.0,
                 double slowest_Hz = 0.0) {
  return {asked_Hz, at_start_Hz, in_session_Hz, slowest_Hz, {}, 0.0};
}

std::string error_of(const DeviceDescription& device, const LineRate& line, double tick_rate_Hz) {
  const auto error = check_least_rates(device, line, tick_rate_Hz);
  return error ? error->to_string() : "";
}

TEST(LeastRates, RefusesTicksAndMessagesBelow250Hz) {
  const DeviceDescription device = pushing_device();
  EXPECT_EQ(error_of(device, {}, 1000.0), "");
  EXPECT_EQ(error_of(device, line_of(1000.0, 250.0), 250.0), "");
  EXPECT_EQ(error_of(device, {}, 249.0).find("rate_Hz: is 249 Hz; expected at least 250"), 0u);
  EXPECT_EQ(error_of(device, line_of(1000.0, 249.0), 1000.0)
                .find("a device: reaches only 249 of 1000 messages per second; expected at least "
                      "250 for a device that moves motors"),
            0u);
  EXPECT_EQ(error_of(device, line_of(80.0, 80.0), 1000.0)
                .find("a device: is asked for 80 messages per second; expected at least 250"),
            0u);
  // A line that was not measured reaches what the device states.
  DeviceDescription slow = device;
  slow.rate_Hz = 100.0;
  EXPECT_NE(error_of(slow, {}, 1000.0), "");
}

TEST(LeastRates, ADeviceThatMovesNoMotorsMayBeSlow) {
  DeviceDescription simulated = pushing_device();
  simulated.moves_motors = false;
  DeviceDescription sensor = pushing_device();
  sensor.motor_count = 0;
  for (const DeviceDescription& device : {simulated, sensor}) {
    EXPECT_EQ(error_of(device, line_of(50.0, 50.0), 50.0), "");
    EXPECT_TRUE(slow_rate_warnings(device, line_of(50.0, 50.0), 50.0).empty());
  }
}

TEST(LeastRates, WarnsBelow500HzAndBelowHalfOfWhatWasAsked) {
  const DeviceDescription device = pushing_device();
  EXPECT_TRUE(slow_rate_warnings(device, line_of(1000.0, 500.0), 500.0).empty());
  EXPECT_EQ(slow_rate_warnings(device, line_of(1000.0, 1000.0), 499.0).size(), 1u);
  EXPECT_EQ(slow_rate_warnings(device, line_of(499.0, 499.0), 1000.0).size(), 1u);
  EXPECT_EQ(slow_rate_warnings(device, line_of(4000.0, 1999.0), 1000.0).size(), 1u);
  const auto both = slow_rate_warnings(device, line_of(1000.0, 320.0), 1000.0);
  ASSERT_EQ(both.size(), 2u);
  EXPECT_EQ(both[1], "the line to the device reaches only 320 of 1000 messages per second");
}

TEST(LeastRates, TellsOfALineThatBecameSlowerAndOfLateForces) {
  DeviceDescription device = pushing_device();
  device.delay = {1e-3, 2e-3};
  LineRate line = line_of(1000.0, 1000.0, 900.0, 600.0);
  EXPECT_TRUE(line_warnings(device, line).empty());
  line.slowest_Hz = 499.0;
  ASSERT_EQ(line_warnings(device, line).size(), 1u);
  EXPECT_EQ(line_warnings(device, line)[0],
            "the line to the device became slower: in one second it carried only 499 of 1000 "
            "messages per second");
  line.at_start_Hz = 499.0;  // it was so from the start on, which was told then
  EXPECT_TRUE(line_warnings(device, line).empty());
  line.delayed_share = 0.05;
  EXPECT_TRUE(line_warnings(device, line).empty());
  line.delayed_share = 0.06;
  EXPECT_EQ(line_warnings(device, line).size(), 1u);
}

}  // namespace
}  // namespace palpate
