#pragma once

// A logarithmic axis of a diagram, which can also show 0, with readable tick labels.

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/report/human_units.h"

namespace palpate {

// The position of a value on the axis is its log10; 0 has a separate position below all others.
// Call see() and see_whisker() for all values and whiskers first, then settle().
class PlotAxis {
 public:
  struct Tick {
    double position;
    std::string label;  // empty for a minor tick
  };

  void see(double value);
  // Takes a whisker into account. A whisker is the line from `low` to `high` through a point. The
  // part of a whisker that lies far beyond all values is cut off.
  void see_whisker(double low, double high);
  // Chooses the range, the ticks and the displayed unit; `unit` is the unit of the values.
  void settle(const std::string& unit);

  // The position of a value or of a whisker's end, clamped to the range.
  double at(double value) const;
  double begin() const { return begin_; }
  double end() const { return end_; }
  // The upper end of the band that shows 0; no value if none of the values is 0.
  std::optional<double> zero_band() const { return zero_band_; }
  const std::vector<Tick>& ticks() const { return ticks_; }
  // Widens the range, to leave space for long tick names.
  void widen();
  // Replaces the numeric tick labels and the unit.
  void use_names(std::vector<Tick> ticks) {
    ticks_ = std::move(ticks);
    unit_.name.clear();
  }
  const std::string& unit() const { return unit_.name; }

 private:
  bool has_positive() const { return low_ <= high_; }
  void place_zero();
  void place_decades(double first, double last);
  void place_steps(double first, double last);
  void place_fine(double first, double last);

  double low_ = 1.0, high_ = -1.0;  // log10 of the values; low > high: no positive value
  double whisker_low_ = 0.0, whisker_high_ = 0.0;
  bool has_zero_ = false;
  double begin_ = -1.0, end_ = 1.0, zero_ = 0.0;
  std::optional<double> zero_band_;
  DisplayUnit unit_;
  std::vector<Tick> ticks_;
};

}  // namespace palpate
