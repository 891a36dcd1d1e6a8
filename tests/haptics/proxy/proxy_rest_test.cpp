#include "haptics/proxy/proxy_rest.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::Random;

// A contact that can be told from others by its face.
FaceContact contact_with(std::uint32_t slot) {
  FaceContact contact{};
  contact.face.slot = slot;
  contact.normal = contact.feature_point = Vec3::UnitZ();
  return contact;
}

std::vector<FaceContact> contacts_up_to(std::uint32_t count) {
  std::vector<FaceContact> contacts;
  for (std::uint32_t slot = 0; slot < count; ++slot) contacts.push_back(contact_with(slot));
  return contacts;
}

std::vector<std::uint32_t> slots_of(std::span<const FaceContact> contacts) {
  std::vector<std::uint32_t> slots;
  for (const FaceContact& contact : contacts) slots.push_back(contact.face.slot);
  return slots;
}

TEST(ProxyRest, KnowsNothingAtFirst) {
  const ProxyRest rest;
  EXPECT_TRUE(rest.known().empty());
  EXPECT_TRUE(rest.holding().empty());
  EXPECT_FALSE(rest.is_settled());
  EXPECT_FALSE(rest.goes_on());
  EXPECT_FALSE(rest.is_cut_short());
  EXPECT_FALSE(rest.has_friction());
  EXPECT_FALSE(rest.slide().slides);
}

// Three questions of the next tick, answered by a flag each.
struct RestFlags {
  bool is_settled = false;
  bool goes_on = false;
  bool is_cut_short = false;
};

TEST(ProxyRest, AnswersAsIndependentFlagsAfterAnySequenceOfTicks) {
  Random random(4701);
  ProxyRest rest;
  RestFlags flags;
  std::array<int, 5> seen{};
  for (int i = 0; i < 20000; ++i) {
    const int what = static_cast<int>(random.uniform(0.0, 8.0));
    switch (what) {
      case 0:
        rest.place();
        flags = {};
        break;
      case 1:
        rest.move_freely();
        flags = {};
        break;
      case 2:
        rest.settle(false);
        flags = {true, false, false};
        break;
      case 3:
        rest.settle(true);
        flags = {true, true, false};
        break;
      case 4:
        rest.cap(false);
        flags = {false, true, false};
        break;
      case 5:
        rest.cap(true);
        flags = {false, true, true};
        break;
      case 6:
        rest.disturb();
        flags.is_settled = flags.is_cut_short = false;
        break;
      default:
        rest.drop_step();
        flags.is_cut_short = false;
    }
    ++seen[static_cast<std::size_t>(rest.end())];
    ASSERT_EQ(rest.is_settled(), flags.is_settled) << "tick " << i << ", action " << what;
    ASSERT_EQ(rest.goes_on(), flags.goes_on) << "tick " << i << ", action " << what;
    ASSERT_EQ(rest.is_cut_short(), flags.is_cut_short) << "tick " << i << ", action " << what;
  }
  EXPECT_GT(*std::min_element(seen.begin(), seen.end()), 500);
}

TEST(ProxyRest, KeepsTheHoldingFacesFirstAndTheOthersOnlyAfterACappedTick) {
  const std::vector<FaceContact> met = contacts_up_to(6);
  PlaneProjection projection;
  projection.active = {1, 4, 0};
  projection.active_count = 2;
  ProxyRest rest;
  rest.keep_contacts(met, projection, true);
  EXPECT_EQ(slots_of(rest.holding()), (std::vector<std::uint32_t>{1, 4}));
  EXPECT_EQ(slots_of(rest.known()), (std::vector<std::uint32_t>{1, 4, 0, 2, 3, 5}));
  rest.keep_contacts(met, projection, false);
  EXPECT_EQ(slots_of(rest.holding()), (std::vector<std::uint32_t>{1, 4}));
  EXPECT_EQ(slots_of(rest.known()), (std::vector<std::uint32_t>{1, 4}));
}

TEST(ProxyRest, KeepsAsManyFacesAsThereCanBePlanes) {
  const std::vector<FaceContact> met = contacts_up_to(kMaxContactPlanes);
  PlaneProjection projection;
  projection.active = {3, 7, 23};
  projection.active_count = 3;
  ProxyRest rest;
  rest.keep_contacts(met, projection, true);
  EXPECT_EQ(slots_of(rest.holding()), (std::vector<std::uint32_t>{3, 7, 23}));
  std::vector<std::uint32_t> slots = slots_of(rest.known());
  std::sort(slots.begin(), slots.end());
  EXPECT_EQ(slots, slots_of(met));
}

TEST(ProxyRest, ForgetsFacesAndFrictionWhenTheProxyIsPlaced) {
  PlaneProjection projection;
  projection.active_count = 1;
  ProxyRest rest;
  rest.keep_contacts(contacts_up_to(2), projection, true);
  rest.end_with_friction({true, false, false}, {true, 0.5, 0.0});
  EXPECT_TRUE(rest.has_friction());
  EXPECT_TRUE(rest.holds_by_friction(0));
  EXPECT_TRUE(rest.slide().slides);
  rest.end_slide();
  EXPECT_TRUE(rest.has_friction());
  EXPECT_FALSE(rest.slide().slides);
  rest.end_with_friction({true, false, false}, {true, 0.5, 0.0});
  rest.place();
  EXPECT_TRUE(rest.known().empty());
  EXPECT_TRUE(rest.holding().empty());
  EXPECT_FALSE(rest.has_friction());
  EXPECT_FALSE(rest.slide().slides);
}

}  // namespace
}  // namespace palpate
