// Devices as a user names them.

#include "engine/drivers/drivers.h"

#include <string>

#include <gtest/gtest.h>

#include "engine/drivers/hapi_driver.h"

namespace palpate {
namespace {

std::string error_of(const std::string& text) {
  const auto device = make_device("--device", text, false);
  return device ? "" : device.error().to_string();
}

Result<HapiSettings> settings_of(const std::string& list) {
  const auto values = parse_driver_values(kHapiDriver, list);
  return values ? hapi_settings_of(*values) : Result<HapiSettings>(values.error());
}

TEST(DeviceOptions, ReadsEverySetting) {
  const auto settings = settings_of(
      "port=/dev/ttyACM1,base=0.03,proximal=0.06,distal=0.08,torque-per-Nm=-2.5,"
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
  const auto settings = settings_of("port=/dev/ttyACM0");
  ASSERT_TRUE(settings);
  EXPECT_EQ(settings->links.base_m, 0.02);
  EXPECT_FALSE(settings->torque_per_Nm);
}

TEST(DeviceOptions, ErrorsNameTheSettingAndWhatIsExpected) {
  const std::pair<const char*, const char*> cases[] = {
      {"falcon:port=x", "--device: driver is \"falcon\"; expected hapi"},
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
  EXPECT_NE(error_of("falcon:port=x").find(" (for example hapi:port="), std::string::npos);
}

TEST(Drivers, MakeADeviceThatWorksWithoutAGuardOnlyOnRequest) {
  for (const bool works : {false, true}) {
    const auto device = make_device("--device", "hapi:port=/dev/ttyACM0", works);
    ASSERT_TRUE(device) << device.error().to_string();
    EXPECT_EQ((*device)->description().sensed_axes, 2);
    EXPECT_TRUE((*device)->description().moves_motors);
  }
}

// The list names each key with its range, and what it is without the key is what the driver takes.
TEST(Drivers, ListTheirKeysWithRangesAndInitialValues) {
  const std::string text = drivers_text();
  for (const Driver* driver : drivers()) {
    EXPECT_NE(("\n" + text).find("\n" + std::string(driver->name) + "  "), std::string::npos);
    for (const DriverKey& key : driver->keys()) {
      EXPECT_NE(text.find("\n      " + std::string(key.name) + " "), std::string::npos) << key.name;
    }
  }
  std::string list = "port=/dev/ttyACM0";
  for (const DriverKey& key : kHapiDriver.keys()) {
    if (!key.initial) continue;
    list += "," + std::string(key.name) + "=" + std::to_string(*key.initial);
    if (key.kind == DriverKeyKind::kWhole) list.resize(list.find('.', list.rfind('=')));
  }
  const auto stated = settings_of(list);
  const auto initial = settings_of("port=/dev/ttyACM0");
  ASSERT_TRUE(stated && initial);
  EXPECT_EQ(stated->links.base_m, initial->links.base_m);
  EXPECT_EQ(stated->links.proximal_m, initial->links.proximal_m);
  EXPECT_EQ(stated->links.distal_m, initial->links.distal_m);
  EXPECT_EQ(stated->wiring.device, initial->wiring.device);
  EXPECT_EQ(stated->wiring.counts_per_turn, initial->wiring.counts_per_turn);
  EXPECT_EQ(stated->wiring.rest_deg, initial->wiring.rest_deg);
  EXPECT_EQ(stated->rate_Hz, initial->rate_Hz);
}

// A key just outside of its range is refused by name.
TEST(Drivers, RefuseNumbersOutsideOfTheListedRange) {
  for (const DriverKey& key : kHapiDriver.keys()) {
    if (key.kind == DriverKeyKind::kText) continue;
    const double step = key.kind == DriverKeyKind::kWhole ? 1.0 : 0.01 * (key.most - key.least);
    const double number = key.most + step;
    const std::string text = key.kind == DriverKeyKind::kWhole
                                 ? std::to_string(static_cast<int>(number))
                                 : std::to_string(number);
    std::string list = "hapi:port=x," + std::string(key.name) + "=" + text;
    if (key.name == "torque-per-Nm") list += ",peak-torque=0.1";
    if (key.name == "peak-torque") list += ",torque-per-Nm=1";
    EXPECT_EQ(error_of(list).find("--device: " + std::string(key.name) + ": is "), 0u)
        << error_of(list);
  }
}

TEST(DeviceOptions, ErrorsQuoteTextWithoutControlCharacters) {
  EXPECT_EQ(error_of("hapi:port=x,\x1b[2J=1").find('\x1b'), std::string::npos);
  EXPECT_LT(error_of("hapi:port=x,base=" + std::string(10'000, '9')).size(), 300u);
}

}  // namespace
}  // namespace palpate
