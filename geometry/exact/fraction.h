#pragma once

#include <compare>

namespace palpate {

// A position on a straight segment as a fraction of its length: 0 at the start, 1 at the end.
// `Segment` is a tag type that names the segment. The tag prevents the mixing of fractions of
// different segments, for example of a query segment and of the part to which a search is limited.
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

// A fraction of the query segment p to p + d of an index or a tree.
using QueryFraction = FractionOf<struct QueriedSegment>;

}  // namespace palpate
