// Numbers for readers.

#include "engine/report/human_units.h"

#include <gtest/gtest.h>

namespace palpate {
namespace {

TEST(HumanUnits, AreReadable) {
  EXPECT_EQ(human(134.0, "ns"), "134 ns");
  EXPECT_EQ(human(1340.0, "ns"), "1.34 µs");
  EXPECT_EQ(human(1.3e-6, "m"), "1.3 µm");
  EXPECT_EQ(human(0.025, "m"), "25 mm");
  EXPECT_EQ(human(3.2e-9, "m"), "3.2 nm");
  EXPECT_EQ(human(1e-15, "m"), "1e-15 m");
  EXPECT_EQ(human(1500.0, "m"), "1500 m");
  EXPECT_EQ(human(0.9999e-6, "s"), "1 µs");
  EXPECT_EQ(human(2500.0, "us"), "2.5 ms");
  EXPECT_EQ(human(0.012, "N"), "12 mN");
  EXPECT_EQ(human(2000.0, "Hz"), "2 kHz");
  EXPECT_EQ(human(0.3, "m/s"), "300 mm/s");
  EXPECT_EQ(human(12.345, "deg"), "12.3 deg");
  EXPECT_EQ(human(0.5, ""), "0.5");
  EXPECT_EQ(human(0.0, "m"), "0");
  EXPECT_EQ(short_number(123456.0), "123456");
  EXPECT_EQ(short_number(1.2e7), "1.2e7");
  EXPECT_EQ(short_number(-0.000012), "-1.2e-5");
}

}  // namespace
}  // namespace palpate
