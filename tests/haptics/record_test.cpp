// The record of a tick and the table of its fields. Static assertions in record.h check that both
// agree byte by byte.

#include "palpate/record.h"

#include <cstddef>
#include <cstring>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "haptics/record_vectors.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

TEST(RecordTable, NamesEveryFieldAndColumnOnce) {
  std::set<std::string_view> names;
  std::set<std::string_view> columns;
  for (const RecordField& field : kRecordFields) {
    EXPECT_TRUE(names.insert(field.name).second) << field.name;
    EXPECT_TRUE(columns.insert(field.column).second) << field.column;
    EXPECT_GE(field.count, 1u);
  }
}

// The unit and the frame of a field agree with those in its name.
TEST(RecordTable, HasTheUnitsAndFramesOfItsNames) {
  for (const RecordField& field : kRecordFields) {
    for (const std::string_view unit : {"s", "m", "N", "rad", "ns"}) {
      if (field.name.ends_with("_" + std::string(unit))) {
        EXPECT_EQ(field.unit, unit) << field.name;
      }
    }
    for (const std::string_view frame : {"device", "scene"}) {
      if (field.name.find(frame) != std::string_view::npos) {
        EXPECT_EQ(field.frame, frame) << field.name;
      }
    }
    if (field.count == 3) {
      EXPECT_FALSE(field.frame.empty()) << field.name;
    }
  }
}

TEST(RecordTable, NamesEveryFaultAndReservesBitsForGovernors) {
  const std::set<std::string_view> names(kFaultNames.begin(), kFaultNames.end());
  EXPECT_EQ(names.size(), static_cast<std::size_t>(kFaultCount));
  EXPECT_FALSE(names.contains(""));
  EXPECT_EQ(kFaultEffectsCapped, 1u << (kFaultCount - 1)) << "the last one";
  EXPECT_EQ(kFaultsWithoutForce >> 16, 0u) << "reserved";
}

TEST(RecordTable, NamesEveryRuleOfTheGovernorFromBit0On) {
  const std::set<std::string_view> names(kGovernorRuleNames.begin(), kGovernorRuleNames.end());
  EXPECT_EQ(names.size(), static_cast<std::size_t>(kGovernorRuleCount));
  EXPECT_FALSE(names.contains(""));
  EXPECT_EQ(kRuleBadSample, 1u << 0) << "the first one";
  EXPECT_EQ(kRuleRelease, 1u << (kGovernorRuleCount - 1)) << "the last one";
  EXPECT_EQ(kRuleTripped, 1u << 12) << "recordings of before have it there";
}

// Programs and recordings of before find the members where they were.
TEST(RecordTable, KeepsTheOffsetsOfTheMembersOfBefore) {
  EXPECT_EQ(offsetof(TickRecord, step_ns), 288u);
  EXPECT_EQ(offsetof(TickRecord, faults), 304u);
  EXPECT_EQ(offsetof(TickRecord, friction), 318u);
  EXPECT_EQ(offsetof(TickRecord, rules), 320u);
  EXPECT_EQ(sizeof(TickRecord), 336u);
}

TEST(Record, ReturnsVectorsAndPosesToTheBit) {
  test::Random random(1601);
  for (int n = 0; n < 1000; ++n) {
    TickRecord record;
    const RigidTransform before = random.pose(2.0);
    const RigidTransform after = random.pose(2.0);
    const Vec3 force = random.pose(2.0).translation_m;
    put(before, record.q_before_wxyz, record.o_before_m);
    put(after, record.q_after_wxyz, record.o_after_m);
    put(force, record.force_device_N);
    TickRecord copy;
    std::memcpy(static_cast<void*>(&copy), &record, sizeof copy);
    ASSERT_EQ(pose_before(copy).rotation.coeffs(), before.rotation.coeffs());
    ASSERT_EQ(pose_before(copy).translation_m, before.translation_m);
    ASSERT_EQ(pose_after(copy).rotation.coeffs(), after.rotation.coeffs());
    ASSERT_EQ(pose_after(copy).translation_m, after.translation_m);
    ASSERT_EQ(vec3(copy.force_device_N), force);
  }
}

}  // namespace
}  // namespace palpate
