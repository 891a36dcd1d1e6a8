#include "engine/report/plot_axis.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace palpate {
namespace {

// Lengths along the axis, in decades.
constexpr double kLeastSpan = 0.12;     // so that noise of a few per cent looks small
constexpr double kMargin = 0.07;        // of the span, on either side
constexpr double kZeroBand = 0.12;      // of the span
constexpr double kWhiskerBeyond = 1.5;  // how far a whisker may stretch the axis
constexpr double kDecadesFrom = 2.6;    // from this span on: labels at powers of ten only
constexpr double kStepsFrom = 0.75;     // from this span on: labels at 1, 2 and 5
constexpr double kMostDecadeLabels = 7.0;
constexpr double kWidening = 0.2;  // of the span, on either side
constexpr int kLargestPlainPower = 3;

std::string superscript(int number) {
  constexpr std::array<const char*, 10> kDigits = {"⁰", "¹", "²", "³", "⁴",
                                                   "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text = number < 0 ? "⁻" : "";
  for (const char digit : std::to_string(std::abs(number))) text += kDigits[digit - '0'];
  return text;
}

// The smallest of 1, 2 or 5 times a power of ten that is not below at_least.
double nice_step(double at_least) {
  const double power = std::pow(10.0, std::floor(std::log10(at_least)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= at_least) return factor * power;
  }
  return 10.0 * power;
}

}  // namespace

void PlotAxis::see(double value) {
  if (!(value > 0.0)) {
    has_zero_ = true;
    return;
  }
  const double position = std::log10(value);
  if (!has_positive()) {
    low_ = high_ = whisker_low_ = whisker_high_ = position;
  }
  low_ = std::min(low_, position);
  high_ = std::max(high_, position);
  whisker_low_ = std::min(whisker_low_, low_);
  whisker_high_ = std::max(whisker_high_, high_);
}

void PlotAxis::see_whisker(double low, double high) {
  if (!has_positive()) return;
  if (low > 0.0) whisker_low_ = std::min(whisker_low_, std::log10(low));
  if (high > 0.0) whisker_high_ = std::max(whisker_high_, std::log10(high));
}

void PlotAxis::settle(const std::string& unit) {
  ticks_.clear();
  if (!has_positive()) {
    unit_ = display_unit(0.0, unit);
    zero_ = 0.0;
    ticks_.push_back({0.0, "0"});
    return;
  }
  double first = std::max(whisker_low_, low_ - kWhiskerBeyond);
  double last = std::min(whisker_high_, high_ + kWhiskerBeyond);
  const double lacking = std::max(0.0, kLeastSpan - (last - first));
  first -= 0.5 * lacking;
  last += 0.5 * lacking;
  const double span = last - first;
  begin_ = first - kMargin * span;
  end_ = last + kMargin * span;
  unit_ = display_unit(std::pow(10.0, high_), unit);
  // Powers of ten are clearest with an unprefixed unit.
  const double low_shown = begin_ + std::log10(unit_.factor);
  if (span >= kDecadesFrom && low_shown < -kLargestPlainPower) unit_ = display_unit(0.0, unit);
  const double shift = std::log10(unit_.factor);
  if (span >= kDecadesFrom) {
    place_decades(begin_ + shift, end_ + shift);
  } else if (span >= kStepsFrom) {
    place_steps(begin_ + shift, end_ + shift);
  } else {
    place_fine(begin_ + shift, end_ + shift);
  }
  for (Tick& tick : ticks_) tick.position -= shift;
  if (has_zero_) place_zero();
}

void PlotAxis::widen() {
  const double more = kWidening * (end_ - begin_);
  begin_ -= more;
  end_ += more;
}

// Places 0 below all positive values.
void PlotAxis::place_zero() {
  const double band = kZeroBand * std::max(end_ - begin_, 1.0);
  zero_band_ = begin_;
  zero_ = begin_ - 0.5 * band;
  begin_ -= band;
  ticks_.push_back({zero_, "0"});
}

double PlotAxis::at(double value) const {
  if (!(value > 0.0)) return has_zero_ ? zero_ : begin_;
  return std::clamp(std::log10(value), begin_, end_);
}

void PlotAxis::place_decades(double first, double last) {
  const int from = static_cast<int>(std::ceil(first)), to = static_cast<int>(std::floor(last));
  const int stride = std::max(1, static_cast<int>(std::ceil((to - from) / kMostDecadeLabels)));
  const bool plain = from >= -kLargestPlainPower && to <= kLargestPlainPower;
  for (int power = from; power <= to; ++power) {
    std::string label;
    if (power % stride == 0) {
      label = plain ? short_number(std::pow(10.0, power)) : "10" + superscript(power);
    }
    ticks_.push_back({static_cast<double>(power), label});
  }
  if (stride > 1) return;
  for (int power = from - 1; power <= to; ++power) {
    for (int digit = 2; digit <= 9; ++digit) {
      const double position = power + std::log10(digit);
      if (position >= first && position <= last) ticks_.push_back({position, ""});
    }
  }
}

void PlotAxis::place_steps(double first, double last) {
  for (int power = static_cast<int>(std::floor(first)); power <= last; ++power) {
    for (int digit = 1; digit <= 9; ++digit) {
      const double position = power + std::log10(digit);
      if (position < first || position > last) continue;
      const bool labelled = digit == 1 || digit == 2 || digit == 5;
      ticks_.push_back({position, labelled ? short_number(std::pow(10.0, position)) : ""});
    }
  }
}

void PlotAxis::place_fine(double first, double last) {
  constexpr double kLabels = 5.0;
  const double low = std::pow(10.0, first), high = std::pow(10.0, last);
  const double step = nice_step((high - low) / kLabels);
  for (double n = std::ceil(low / step); n * step <= high; n += 1.0) {
    ticks_.push_back({std::log10(n * step), short_number(n * step)});
  }
}

}  // namespace palpate
