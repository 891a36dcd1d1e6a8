// The places of connections, against a list of those that are left.

#include "engine/viewer/connection_places.h"

#include <memory>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace palpate::test {
namespace {

// A connection that frees its place when it is dropped, as sockets do.
struct Visitor {
  explicit Visitor(ConnectionPlaces& places) {
    place = places.take([this] {
      ++drops;
      place = {};
    });
  }
  ConnectionPlaces::Place place;
  int drops = 0;
};

TEST(ConnectionPlaces, DropTheOldestForANewOne) {
  ConnectionPlaces places(3);
  std::vector<std::unique_ptr<Visitor>> visitors;
  for (int i = 0; i < 10; ++i) visitors.push_back(std::make_unique<Visitor>(places));
  for (std::size_t i = 0; i < visitors.size(); ++i) EXPECT_EQ(visitors[i]->drops, i < 7 ? 1 : 0);
  EXPECT_TRUE(places.is_full());
  visitors.erase(visitors.begin() + 8);  // leaves by itself: nobody is dropped for the next
  EXPECT_EQ(places.size(), 2u);
  const Visitor next(places);
  EXPECT_EQ(visitors[7]->drops, 0);
  const Visitor last(places);
  EXPECT_EQ(visitors[7]->drops, 1);
  EXPECT_EQ(visitors[8]->drops + next.drops + last.drops, 0);
}

TEST(ConnectionPlaces, AreFreeAgainWhenTheyMoveOrEnd) {
  ConnectionPlaces few(1), others(1);
  int drops = 0;
  const auto drop = [&] { ++drops; };
  ConnectionPlaces::Place place = few.take(drop);
  place = others.take(drop);  // the first place is free
  EXPECT_EQ(few.size(), 0u);
  ConnectionPlaces::Place moved = std::move(place);
  EXPECT_EQ(others.size(), 1u);
  moved = {};
  EXPECT_EQ(others.size(), 0u);
  EXPECT_FALSE(others.drop_oldest());
  EXPECT_EQ(drops, 0);
}

}  // namespace
}  // namespace palpate::test
