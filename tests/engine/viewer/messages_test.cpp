// The binary messages of `view`, decoded here byte by byte as its page decodes them.

#include "engine/viewer/messages.h"

#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace palpate::test {
namespace {

// Little-endian numbers at their offsets. Does not use the layout of any struct.
std::uint64_t whole(const std::string& bytes, std::size_t at, std::size_t size) {
  std::uint64_t number = 0;
  for (std::size_t i = size; i-- > 0;) {
    number = number << 8 | static_cast<unsigned char>(bytes.at(at + i));
  }
  return number;
}

// IEEE 754 from its definition.
double real64(const std::string& bytes, std::size_t at) {
  const std::uint64_t bits = whole(bytes, at, 8);
  const int exponent = static_cast<int>(bits >> 52 & 0x7ff);
  const auto fraction = static_cast<double>(bits & 0xfffffffffffffu);
  const double sign = bits >> 63 != 0 ? -1.0 : 1.0;
  if (exponent == 0) return sign * std::ldexp(fraction, -1074);
  if (exponent == 0x7ff) return fraction == 0.0 ? sign * INFINITY : NAN;
  return sign * std::ldexp(fraction + 0x1p52, exponent - 1075);
}

double real32(const std::string& bytes, std::size_t at) {
  const std::uint64_t bits = whole(bytes, at, 4);
  const int exponent = static_cast<int>(bits >> 23 & 0xff);
  const auto fraction = static_cast<double>(bits & 0x7fffffu);
  const double sign = bits >> 31 != 0 ? -1.0 : 1.0;
  if (exponent == 0) return sign * std::ldexp(fraction, -149);
  if (exponent == 0xff) return fraction == 0.0 ? sign * INFINITY : NAN;
  return sign * std::ldexp(fraction + 0x1p23, exponent - 150);
}

// A record whose numbers all differ.
TickRecord numbered_record() {
  TickRecord record;
  double next = 0.5;
  for (double* field :
       {record.device_m, record.goal_scene_m, record.proxy_scene_m, record.normal_scene,
        record.full_force_device_N, record.force_device_N, record.o_before_m, record.o_after_m}) {
    for (int k = 0; k < 3; ++k) field[k] = next += 1.25;
  }
  for (double* field : {record.q_before_wxyz, record.q_after_wxyz}) {
    for (int k = 0; k < 4; ++k) field[k] = next += 1.25;
  }
  record.tick = 0x0102030405060708u;
  record.time_s = 3.75;
  record.alpha_rad = 0.625;
  record.rotation_rad = -0.375;
  record.step_ns = -5;
  record.late_ns = 70000;
  record.faults = 0x80000001u;
  record.effects = 17;
  record.iterations = 4;
  record.contact = 1;
  record.friction = FrictionState::kSlides;
  record.rules = kRuleMotors | kRuleTripped;
  record.body = 70000;
  record.contacts = 3;
  record.touch = kTouchBegan;
  return record;
}

TEST(ViewMessages, StateHasTheDocumentedLayout) {
  ViewState state;
  state.record = numbered_record();
  state.pointer = 9;
  state.target_m = {0.1, -0.2, 0.3};
  state.flags = kHandHasTarget | kHandIsHeld;
  const std::vector<BodyPose> bodies = {{3, {0.5, 0.5, -0.5, 0.5}, {1, 2, 3}},
                                        {70000, {1, 0, 0, 0}, {-4, -5, -6}}};
  std::string bytes = "old";
  state.axis_count = 2;
  state.axes = {{{0, 1, 0}, {0, 0, -1}, {1, 0, 0}}};
  state.body_name = "a wall";
  const std::string long_name(300, 'w');
  state.material_name = long_name;
  encode_state(state, bodies, 12.5, bytes);
  constexpr std::size_t kHead = 136;
  ASSERT_EQ(bytes.size(), kHead + sizeof(TickRecord) + 2 * 64 + 6 + 256);
  EXPECT_EQ(whole(bytes, 0, 2), 1u);
  EXPECT_EQ(whole(bytes, 2, 2), 4u);
  EXPECT_EQ(whole(bytes, 4, 4), 5u);
  EXPECT_EQ(whole(bytes, 8, 8), 9u);
  EXPECT_EQ(real64(bytes, 16), 0.1);
  EXPECT_EQ(real64(bytes, 32), 0.3);
  EXPECT_EQ(real64(bytes, 40), 12.5);
  EXPECT_EQ(whole(bytes, 48, 4), sizeof(TickRecord));
  EXPECT_EQ(whole(bytes, 52, 4), 2u);
  EXPECT_EQ(whole(bytes, 56, 4), 2u);
  EXPECT_EQ(whole(bytes, 60, 2), 6u);
  EXPECT_EQ(whole(bytes, 62, 2), 256u);
  EXPECT_EQ(bytes.substr(kHead + sizeof(TickRecord) + 2 * 64), "a wall" + long_name.substr(0, 256));
  EXPECT_EQ(real64(bytes, 64 + 8), 1.0);
  EXPECT_EQ(real64(bytes, 64 + 24 + 16), -1.0);
  EXPECT_EQ(real64(bytes, 64 + 48), 1.0);
  // Fields of the record by the offsets of its table, which the page's decoder uses.
  const auto at = [](std::string_view name) {
    for (const RecordField& field : kRecordFields) {
      if (field.name == name) return kHead + field.offset;
    }
    ADD_FAILURE() << name;
    return std::size_t{0};
  };
  EXPECT_EQ(whole(bytes, at("tick"), 8), 0x0102030405060708u);
  EXPECT_EQ(real64(bytes, at("time_s")), 3.75);
  EXPECT_EQ(real64(bytes, at("proxy_scene_m") + 8), state.record.proxy_scene_m[1]);
  EXPECT_EQ(real64(bytes, at("q_after_wxyz") + 24), state.record.q_after_wxyz[3]);
  EXPECT_EQ(static_cast<std::int64_t>(whole(bytes, at("step_ns"), 8)), -5);
  EXPECT_EQ(whole(bytes, at("faults"), 4), 0x80000001u);
  EXPECT_EQ(whole(bytes, at("contact"), 2), 1u);
  EXPECT_EQ(whole(bytes, at("rules"), 4), 0x1002u);
  EXPECT_EQ(whole(bytes, at("body"), 4), 70000u);
  EXPECT_EQ(whole(bytes, at("material"), 4), 0xffffffffu);
  EXPECT_EQ(whole(bytes, at("contacts"), 2), 3u);
  EXPECT_EQ(whole(bytes, at("touch"), 2), 1u);
  const std::size_t second = kHead + sizeof(TickRecord) + 64;
  EXPECT_EQ(whole(bytes, second, 4), 70000u);
  EXPECT_EQ(whole(bytes, second + 4, 4), 0u);
  EXPECT_EQ(real64(bytes, second + 8), 1.0);
  EXPECT_EQ(real64(bytes, second + 56), -6.0);
}

TickSummary row(double time_s, double force_N, bool in_contact) {
  TickRecord record;
  record.time_s = time_s;
  record.force_device_N[0] = 0.6 * force_N;
  record.force_device_N[2] = -0.8 * force_N;
  record.full_force_device_N[1] = 2 * force_N;
  record.goal_scene_m[1] = 0.003;
  record.proxy_scene_m[0] = 0.004;
  record.alpha_rad = std::numbers::pi / 6;
  record.step_ns = 2500;
  record.contact = in_contact ? 1 : 0;
  return TickSummary::of(record);
}

TEST(ViewMessages, TicksHaveTheDocumentedColumns) {
  const std::vector<TickSummary> rows = {row(1e6, 1.0, true), row(1e6 + 0.001, 3.0, false)};
  std::string bytes;
  encode_ticks(rows, 7, 1, bytes);
  ASSERT_EQ(bytes.size(), 24u + 7 * 2 * 4);
  EXPECT_EQ(whole(bytes, 0, 2), 2u);
  EXPECT_EQ(whole(bytes, 2, 2), 4u);
  EXPECT_EQ(whole(bytes, 4, 4), 2u);
  EXPECT_EQ(real64(bytes, 8), 1e6);
  EXPECT_EQ(whole(bytes, 16, 4), 7u);
  EXPECT_EQ(whole(bytes, 20, 4), 1u);
  const auto column = [&](std::size_t c, std::size_t i) {
    return real32(bytes, 24 + 4 * (2 * c + i));
  };
  // A float has 24 bits; squares and square roots add less than two roundings.
  constexpr double kRounding = 0x1p-22;
  EXPECT_EQ(column(0, 0), 0.0);
  EXPECT_NEAR(column(0, 1), 0.001, 1e6 * 0x1p-52);  // the time itself has 53 bits
  EXPECT_NEAR(column(1, 0), 30.0, 30 * kRounding);
  EXPECT_TRUE(std::isnan(column(1, 1)));
  EXPECT_NEAR(column(2, 0), 0.005, 0.005 * kRounding);
  EXPECT_NEAR(column(3, 1), 3.0, 3 * kRounding);
  EXPECT_NEAR(column(4, 1), 6.0, 6 * kRounding);
  EXPECT_NEAR(column(5, 0), 2.5, 2.5 * kRounding);
  EXPECT_EQ(column(6, 0), 1.0);
  EXPECT_EQ(column(6, 1), 0.0);
}

TEST(ViewMessages, ThinnedTicksKeepTheExtremesOfEachColumnOfEachGroup) {
  EXPECT_EQ(thinning_group(1000.0), 1u);
  EXPECT_EQ(thinning_group(2000.0), 1u);
  EXPECT_EQ(thinning_group(4000.0), 4u);  // two of four
  EXPECT_EQ(thinning_group(20000.0), 20u);
  std::vector<TickSummary> rows;
  for (const double force_N : {5.0, 1.0, 9.0, 2.0, 4.0, 4.0, 4.0, 4.0, 3.0}) {
    rows.push_back(row(static_cast<double>(rows.size()), force_N, true));
  }
  rows[1].step_us = 700.0f;  // the tick with the smallest force
  rows[3].alpha_rad = 0.0f;  // the smallest angle
  rows[2].alpha_rad = 9.0f;  // no angle: without contact
  rows[2].contact = 0;
  std::string bytes;
  encode_ticks(rows, 0, 4, bytes);
  const auto count = static_cast<std::size_t>(whole(bytes, 4, 4));
  ASSERT_EQ(count, 5u) << "the last group has one tick";
  const auto column = [&](std::size_t c) {
    std::vector<double> values;
    for (std::size_t i = 0; i < count; ++i) {
      values.push_back(real32(bytes, 24 + 4 * (count * c + i)));
    }
    return values;
  };
  EXPECT_EQ(column(0), (std::vector<double>{0, 3, 4, 7, 8}));
  EXPECT_EQ(column(1)[0], 0.0);
  EXPECT_NEAR(column(1)[1], 30.0, 30 * 0x1p-22);
  EXPECT_NEAR(column(3)[0], 1.0, 0x1p-22);
  EXPECT_NEAR(column(3)[1], 9.0, 9 * 0x1p-22);
  EXPECT_NEAR(column(4)[1], 18.0, 18 * 0x1p-22);
  EXPECT_EQ(column(5)[0], 2.5);
  EXPECT_EQ(column(5)[1], 700.0);
  EXPECT_EQ(column(6), (std::vector<double>{1, 1, 1, 1, 1}));
}

TEST(ViewMessages, NoTicksAreAMessageToo) {
  std::string bytes;
  encode_ticks({}, 3, 1, bytes);
  EXPECT_EQ(bytes.size(), 24u);
  EXPECT_EQ(whole(bytes, 4, 4), 0u);
  EXPECT_EQ(whole(bytes, 16, 4), 3u);
}

}  // namespace
}  // namespace palpate::test
