// Same input, same bits: one trajectory on each of the paper's objects, whose whole output is
// pinned as a hash. The test is compiled twice, with the build's options and at -O0
// (golden_O0_test); both must give these hashes. After a change that is meant to alter the output,
// this command prints the new rows of the table:
//
//   PALPATE_PRINT_GOLDEN=1 build/release/golden_test
//
// Hashes with A4 also depend on the C library, which computes the sines of the elementary rotation.
// Hashes without A4 use only +, -, *, / and sqrt. If only the hashes with A4 differ on a machine,
// its C library is the likely cause.

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "geometry/index/simd.h"
#include "haptics/haptic_loop.h"
#include "haptics/record_vectors.h"
#include "models/paper_objects.h"
#include "models/primitives.h"
#include "tests/helpers/made.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::OwnedWorld;
using test::Soup;

// Of one trajectory: `pinned`, of proxy, forces and pose; `before`, of all bytes that a record had
// before it said what is touched, with the governor's rules in the upper half of the faults, where
// they were; `touch`, of the members that came then.
struct Hashes {
  std::uint64_t pinned, before, touch;
};

struct Golden {
  const char* object;
  Hashes without_a4;
  Hashes with_a4;
};

constexpr Golden kGolden[] = {
    {"star",
     {0xc155d6d010150339, 0x675314438f12f275, 0x59cd12f75ce7a1e7},
     {0x78c61562b50b786f, 0x49cc13b32c88776c, 0x8ef77e6b041006b4}},
    {"labyrinth",
     {0xd6c3429ae376532c, 0x9ce4ebadb23e8dc4, 0xc4c112936826d49c},
     {0x9e33c555694cdc42, 0x950b7ddc73e60049, 0x15f13225b65e2539}},
    {"inverted_labyrinth",
     {0x53ee3c1d14efb698, 0x356a7e31e894bebb, 0xddbc8360ee8955c1},
     {0x48c2402be86310b9, 0x5276c008495074e0, 0x15420b3aceadbafd}},
    {"lock",
     {0x01a5988b134f421a, 0x5774f16f2282eaac, 0x4b5b4474b84aa0c2},
     {0xed1a7db922867cce, 0x6b7bb503023496ef, 0x01f87f4b72c6620d}},
};

void PrintTo(const Golden& golden, std::ostream* out) {
  *out << golden.object;
}

// Of the strategies that are more than force and A4, on the star, in each SIMD width.
struct GoldenOfStrategy {
  const char* strategy;
  Hashes hashes;
};

constexpr GoldenOfStrategy kGoldenOfStrategies[] = {
    {"a4-anticipate", {0xf66b534df44dd604, 0x63b3a307b09df10e, 0xaf9c77a1ce91b3bc}},
    {"a4-passive:0", {0xe2cfd14aebc8374a, 0xaf99ab1ce2404145, 0x8ef77e6b041006b4}},
    {"a4-passive:10", {0xbc1f88d83a688313, 0xfe81bf7b1c4fe544, 0x8ef77e6b041006b4}},
    {"anisotropic:0.25", {0x383a4e4884ef29ac, 0x980b9318b4025f42, 0x7060160a006df8e7}},
    {"anisotropic:4", {0x0e127343dbb4f2e4, 0x06cbb3da12120864, 0x4b0f437f69ec41ac}},
    {"cd", {0xf3e5ff273f3e4989, 0xec530b8cd44a8310, 0xab912266cc48c0fd}},
};

void PrintTo(const GoldenOfStrategy& golden, std::ostream* out) {
  *out << golden.strategy;
}

constexpr double kDt_s = 1e-3;
constexpr int kTicks = 4000;
constexpr double kDepth_m = 3e-3;  // of the goals behind the middle of each wall
constexpr double kStart_m = 5e-3;  // distance of the first goal in front of the first wall

// FNV-1a, 64 bits.
class Hash {
 public:
  void add(double x) {
    std::uint64_t bits = std::bit_cast<std::uint64_t>(x);
    for (int byte = 0; byte < 8; ++byte, bits >>= 8) {
      value_ = (value_ ^ (bits & 0xff)) * 0x100000001b3;
    }
  }
  template <typename Vector>
  void add_all(const Vector& v) {
    for (int k = 0; k < v.size(); ++k) add(v[k]);
  }
  void add_bytes(const void* bytes, std::size_t count) {
    const auto* each = static_cast<const unsigned char*>(bytes);
    for (std::size_t i = 0; i < count; ++i) value_ = (value_ ^ each[i]) * 0x100000001b3;
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325;
};

// A point in front of (positive height_m) or behind the middle of wall i. The contour is
// counter-clockwise, so its walls face right of its direction. This trajectory uses no function but
// sqrt.
Vec3 at_wall(const Contour& contour_m, std::size_t i, double height_m) {
  const Point2& from = contour_m[i % contour_m.size()];
  const Point2& to = contour_m[(i + 1) % contour_m.size()];
  const double x = to.x() - from.x();
  const double y = to.y() - from.y();
  const double length = std::sqrt(x * x + y * y);
  return {0.5 * (from.x() + to.x()) + height_m * y / length,
          0.5 * (from.y() + to.y()) - height_m * x / length, 0.0};
}

// The goals: from a place in front of the first wall into it, and on from wall to wall once around,
// in equal steps. They refer to the object's initial pose. A4 turns the object away below this
// path, but the contacts that follow are deterministic.
std::vector<Vec3> trajectory_m(const Contour& contour_m) {
  std::vector<Vec3> corners{at_wall(contour_m, 0, kStart_m)};
  for (std::size_t i = 0; i <= contour_m.size(); ++i) {
    corners.push_back(at_wall(contour_m, i, -kDepth_m));
  }
  const auto legs = static_cast<int>(corners.size()) - 1;
  std::vector<Vec3> path;
  for (int n = 0; n < kTicks; ++n) {
    const int leg = n * legs / kTicks;
    const double share = static_cast<double>(n * legs - leg * kTicks) / kTicks;
    const Vec3& from = corners[static_cast<std::size_t>(leg)];
    const Vec3& to = corners[static_cast<std::size_t>(leg) + 1];
    path.push_back(
        {from.x() + share * (to.x() - from.x()), from.y() + share * (to.y() - from.y()), 0.0});
  }
  return path;
}

// The bytes of the record of before, and those of the members behind it.
void add_record(TickRecord record, Hash& before, Hash& touch) {
  constexpr std::size_t kBytesBefore = offsetof(TickRecord, rules);
  constexpr int kRulesBegin = 16;
  record.faults |= record.rules << kRulesBegin;
  before.add_bytes(&record, kBytesBefore);
  touch.add_bytes(reinterpret_cast<const char*>(&record) + kBytesBefore,
                  sizeof record - kBytesBefore);
}

struct Outcome {
  Hashes hashes = {};
  int ticks_in_contact = 0;
  int ticks_turning = 0;
};

// The object is turned by the angle whose sine is 3/5, so that no wall faces the motor.
ScenePose start_pose() {
  const double length = std::sqrt(10.0);
  return {Quat(3.0 / length, 0.0, 0.0, 1.0 / length), Vec3::Zero()};
}

// A device with two sensors and one motor, as in the paper.
Outcome render(const PaperObject& object, const Strategy& strategy) {
  const double top_m = kPaperObjectHeight_m / 2;
  const Result<TriangleMesh> mesh = prism(object.contour_m, -top_m, top_m);
  if (!mesh) {
    ADD_FAILURE() << mesh.error().to_string();
    return {};
  }
  const OwnedWorld world(Soup{mesh->positions_m, mesh->triangles});
  HapticSettings settings;
  settings.coupling.damping_Ns_per_m = 2.0;
  set_strategy(strategy, settings);
  settings.initial_pose = start_pose();
  auto loop =
      test::made(HapticLoop::create(world.world(), *ActuationModel::from_counts(2, 1), settings));
  Outcome outcome;
  Hash hash, old_members, touch;
  for (const Vec3& p : trajectory_m(object.contour_m)) {
    const TickRecord& record = loop.tick(start_pose().point(p), kDt_s);
    hash.add_all(vec3(record.proxy_scene_m));
    hash.add_all(vec3(record.full_force_device_N));
    hash.add_all(vec3(record.force_device_N));
    hash.add_all(pose_before(record).rotation.coeffs());
    hash.add_all(pose_before(record).translation_m);
    add_record(record, old_members, touch);
    outcome.ticks_in_contact += record.contact;
    const Quat& before = pose_before(record).rotation;
    outcome.ticks_turning += loop.T_device_scene().rotation.coeffs() != before.coeffs();
  }
  outcome.hashes = {hash.value(), old_members.value(), touch.value()};
  return outcome;
}

std::string hex(std::uint64_t value) {
  char text[24];
  std::snprintf(text, sizeof text, "0x%016llx", static_cast<unsigned long long>(value));
  return text;
}

std::string hex(const Hashes& hashes) {
  return "{" + hex(hashes.pinned) + ", " + hex(hashes.before) + ", " + hex(hashes.touch) + "}";
}

const PaperObject& object_called(const std::vector<PaperObject>& objects, std::string_view name) {
  const auto found = std::find_if(objects.begin(), objects.end(),
                                  [&](const PaperObject& o) { return o.name == name; });
  EXPECT_NE(found, objects.end()) << name;
  return *found;
}

class GoldenTrajectory : public testing::TestWithParam<Golden> {};

TEST_P(GoldenTrajectory, ReproducesThePinnedBits) {
  const Golden& golden = GetParam();
  const std::vector<PaperObject> objects = paper_objects();
  const PaperObject& object = object_called(objects, golden.object);
  const Outcome without = render(object, {&kMaskStrategy});
  const Outcome with = render(object, {&kA4Strategy});
  EXPECT_GT(without.ticks_in_contact, kTicks / 4);
  EXPECT_GT(with.ticks_in_contact, kTicks / 4);
  EXPECT_EQ(without.ticks_turning, 0);
  EXPECT_GT(with.ticks_turning, kTicks / 8);

  const std::string row = std::string("    {\"") + object.name + "\", " + hex(without.hashes) +
                          ", " + hex(with.hashes) + "},\n";
  if (std::getenv("PALPATE_PRINT_GOLDEN")) std::fputs(row.c_str(), stdout);
  EXPECT_EQ(hex(without.hashes), hex(golden.without_a4)) << "if the output is meant to change:\n"
                                                         << row;
  EXPECT_EQ(hex(with.hashes), hex(golden.with_a4)) << "if the output is meant to change:\n" << row;
}

class GoldenStrategy : public testing::TestWithParam<GoldenOfStrategy> {};

TEST_P(GoldenStrategy, ReproducesThePinnedBits) {
  const std::vector<PaperObject> objects = paper_objects();
  const Strategy strategy = *parse_strategy(GetParam().strategy);
  for (const SimdLevel level : {SimdLevel::kBaseline, SimdLevel::kAvx2, SimdLevel::kAvx512}) {
    const SimdLevel widest = widest_simd_level();
    limit_simd_level(level);
    const Outcome outcome = render(object_called(objects, "star"), strategy);
    limit_simd_level(widest);
    EXPECT_GT(outcome.ticks_in_contact, kTicks / 8);
    const std::string row =
        std::string("    {\"") + GetParam().strategy + "\", " + hex(outcome.hashes) + "},\n";
    if (std::getenv("PALPATE_PRINT_GOLDEN")) std::fputs(row.c_str(), stdout);
    EXPECT_EQ(hex(outcome.hashes), hex(GetParam().hashes)) << "if the output is meant to change:\n"
                                                           << row;
  }
}

INSTANTIATE_TEST_SUITE_P(Star, GoldenStrategy, testing::ValuesIn(kGoldenOfStrategies),
                         [](const auto& golden) {
                           std::string name = golden.param.strategy;
                           std::replace_if(
                               name.begin(), name.end(),
                               [](char c) { return c == '-' || c == ':' || c == '.'; }, '_');
                           return name;
                         });

TEST(GoldenTrajectories, CoverThePapersObjects) {
  EXPECT_EQ(std::size(kGolden), paper_objects().size());
}

INSTANTIATE_TEST_SUITE_P(PaperObjects, GoldenTrajectory, testing::ValuesIn(kGolden),
                         [](const auto& golden) { return std::string(golden.param.object); });

}  // namespace
}  // namespace palpate
