#pragma once

// A logarithmic axis that can show 0, with ticks that people read.

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/report/human_units.h"

namespace palpate {

// Positions along it are log10 of the value; 0 has one of its own, below all others. First see()
// and see_whisker() all that is to be on it, then settle().
class PlotAxis {
 public:
  struct Tick {
    double position;
    std::string label;  // empty for a minor one
  };

  void see(double value);
  // What may be cut off where it reaches far beyond all that was seen.
  void see_whisker(double low, double high);
  // Chooses range, ticks and the unit to show; `unit` is that of the values.
  void settle(const std::string& unit);

  // Of a value that was seen, or of an end of a whisker: never outside of the range.
  double at(double value) const;
  double begin() const { return begin_; }
  double end() const { return end_; }
  // Where the band of 0 ends; none without a 0.
  std::optional<double> zero_band() const { return zero_band_; }
  const std::vector<Tick>& ticks() const { return ticks_; }
  // Room for a few long names of ticks.
  void widen();
  // Instead of numbers with a unit.
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

  double low_ = 1.0, high_ = -1.0;  // log10 of what was seen; low > high: nothing positive
  double whisker_low_ = 0.0, whisker_high_ = 0.0;
  bool has_zero_ = false;
  double begin_ = -1.0, end_ = 1.0, zero_ = 0.0;
  std::optional<double> zero_band_;
  DisplayUnit unit_;
  std::vector<Tick> ticks_;
};

}  // namespace palpate
