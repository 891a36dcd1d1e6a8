// Devices as a user names them.

#include "engine/devices/device_options.h"

#include <string>

#include <gtest/gtest.h>

namespace palpate {
namespace {

std::string error_of(const std::string& text) {
  const auto settings = parse_device("--device", text);
  return settings ? "" : settings.error().to_string();
}

TEST(DeviceOptions, ReadsEverySetting) {
  const auto settings =
      parse_device("--device",
                   "hapi:port=/dev/ttyACM1,base=0.03,proximal=0.06,distal=0.08,torque-per-Nm=-2.5,"
                   "peak-torque=0.1,dev=7,counts=4096,angle1=170,angle2=10,rate=500");
  ASSERT_TRUE(settings) << settings.error().to_string();
  EXPECT_EQ(settings->port, "/dev/ttyACM1");
  EXPECT_EQ(settings->links.base_m, 0.03);
  EXPECT_EQ(settings->links.proximal_m, 0.06);
  EXPECT_EQ(settings->links.distal_m, 0.08);
  EXPECT_EQ(settings->torque_per_Nm, -2.5);
  EXPECT_EQ(settings->peak_torque_Nm, 0.1);
  EXPECT_EQ(settings->wiring.device, 7);
  EXPECT_EQ(settings->wiring.counts_per_turn, 4096.0f);
  EXPECT_EQ(settings->wiring.rest_deg, (HapiNumbers{170.0f, 10.0f}));
  EXPECT_EQ(settings->rate_Hz, 500.0);
  EXPECT_FALSE(settings->works_without_guard);
}

TEST(DeviceOptions, ThePortAloneIsEnough) {
  const auto settings = parse_device("--device", "hapi:port=/dev/ttyACM0");
  ASSERT_TRUE(settings);
  EXPECT_EQ(settings->links.base_m, 0.02);
  EXPECT_FALSE(settings->torque_per_Nm);
}

TEST(DeviceOptions, ErrorsNameTheSettingAndWhatIsExpected) {
  const std::pair<const char*, const char*> cases[] = {
      {"falcon:port=x", "--device: driver is \"falcon\"; expected hapi (for example"},
      {"", "--device: driver is \"\"; expected hapi"},
      {"hapi", "--device: port: is missing; expected port=FILE"},
      {"hapi:", "--device: port: is missing; expected port=FILE"},
      {"hapi:port=", "--device: port: is missing; expected port=FILE"},
      {"hapi:prot=x", "--device: key is \"prot\"; expected one of port, dev, base, "},
      {"hapi:port=x,fast", "--device: part is \"fast\"; expected key=value"},
      {"hapi:port=x,port=y", "--device: port: is given twice; expected it once"},
      {"hapi:port=x,base=wide", "--device: base: is \"wide\"; expected a finite number"},
      {"hapi:port=x,base=nan", "--device: base: is \"nan\"; expected a finite number"},
      {"hapi:port=x,base=1e999", "--device: base: is \"1e999\"; expected a finite number"},
      {"hapi:port=x,base=-1", "--device: base: is -1; expected a number from 0.001 to 1"},
      {"hapi:port=x,distal=2", "--device: distal: is 2; expected a number from 0.001 to 1"},
      {"hapi:port=x,dev=0", "--device: dev: is \"0\"; expected a whole number from 1 to 127"},
      {"hapi:port=x,dev=5.5", "--device: dev: is \"5.5\"; expected a whole number from 1 to 127"},
      {"hapi:port=x,rate=1e5", "--device: rate: is 100000; expected a number from 50 to 4000"},
      {"hapi:port=x,counts=0", "--device: counts: is 0; expected a number from 1 to "},
      {"hapi:port=x,torque-per-Nm=0,peak-torque=1", "--device: torque-per-Nm: is 0; expected"},
      {"hapi:port=x,torque-per-Nm=1",
       "--device: peak-torque: is missing; expected a number beside"},
      {"hapi:port=x,torque-per-Nm=1,peak-torque=-1", "--device: peak-torque: is -1; expected"},
      {"hapi:port=x,base=0.5", "--device: angle1, angle2: are angles at which the links cannot"},
      {"hapi:port=x,angle1=0,angle2=180,base=0.5,proximal=0.05",
       "--device: angle1, angle2: are angles at which"},
  };
  for (const auto& [text, error] : cases) {
    EXPECT_EQ(error_of(text).find(error), 0u) << text << " gives " << error_of(text);
    EXPECT_EQ(error_of(text).find('\n'), std::string::npos);
  }
}

TEST(DeviceOptions, ErrorsQuoteTextWithoutControlCharacters) {
  EXPECT_EQ(error_of("hapi:port=x,\x1b[2J=1").find('\x1b'), std::string::npos);
  EXPECT_LT(error_of("hapi:port=x,base=" + std::string(10'000, '9')).size(), 300u);
}

}  // namespace
}  // namespace palpate
