#pragma once

#include <compare>

namespace palpate {

// A place on a straight segment, as a part of its length: 0 at the start, 1 at the end. `Segment`
// is a tag that names the segment, so that a fraction of one cannot be taken for a fraction of
// another, such as of the part of it that a search was cut to.
template <typename Segment>
class FractionOf {
 public:
  constexpr explicit FractionOf(double value) : value_(value) {}
  constexpr double value() const { return value_; }
  friend constexpr auto operator<=>(const FractionOf&, const FractionOf&) = default;

  static constexpr FractionOf start() { return FractionOf(0.0); }
  static constexpr FractionOf end() { return FractionOf(1.0); }

 private:
  double value_;
};

// Of the segment p to p + d that an index or a tree is asked about.
using QueryFraction = FractionOf<struct QueriedSegment>;

}  // namespace palpate
