#include "engine/accuracy/measurement.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include <Eigen/Core>

#include "engine/accuracy/recommendation.h"

namespace palpate {
namespace {

// The samples of one level over the repeats.
class Gathered {
 public:
  void add(Sample sample) {
    ++repeats_;
    if (!sample.failure.empty()) {
      if (failures_++ == 0) failure_ = std::move(sample.failure);
      return;
    }
    errors_.push_back(sample.error);
    times_.push_back(sample.time);
    iterations_.push_back(sample.iterations);
    ticks_ += sample.ticks;
  }

  LevelResult result(double value, const std::string& label, double floor) const {
    LevelResult r;
    r.value = value;
    r.label = label;
    r.repeats = repeats_;
    r.failures = failures_;
    r.failure = failure_;
    r.ticks = ticks_;
    if (errors_.empty()) return r;
    r.error = Spread::of(errors_);
    r.time = Spread::of(times_);
    r.iterations = Spread::of(iterations_).median;
    r.raw_error = r.error.median;
    r.at_floor = floor > 0.0 && r.raw_error <= floor;
    for (double* e : {&r.error.low, &r.error.median, &r.error.high}) *e = std::max(*e, floor);
    return r;
  }

 private:
  std::vector<double> errors_, times_, iterations_;
  std::uint64_t ticks_ = 0;
  int repeats_ = 0;
  int failures_ = 0;
  std::string failure_;
};

// A sample without finite figures, or without contact, is a failure of its level.
Sample checked(Sample sample) {
  if (!sample.failure.empty()) return sample;
  if (!std::isfinite(sample.error) || !std::isfinite(sample.time)) {
    sample.failure = "not finite";
  } else if (sample.ticks == 0) {
    sample.failure = "no tick in contact";
  }
  return sample;
}

// The stride from level to level in the order of a repeat. It differs between repeats, so that no
// level always follows the same other level, which leaves its mesh in the caches. Coprime to
// `size`, so that each level runs once.
std::size_t stride_of(std::size_t repeat, std::size_t size) {
  std::size_t stride = 1 + repeat % size;
  while (std::gcd(stride, size) != 1) ++stride;
  return stride;
}

// Runs every level and every preset once.
class Round {
 public:
  explicit Round(const Knob& knob) : knob_(knob) {
    for (std::size_t m = 0; m < knob.methods.size(); ++m) {
      for (std::size_t l = 0; l < knob.methods[m].levels.size(); ++l) places_.push_back({m, l});
    }
    gathered_.resize(places_.size() + kAccuracyPresets.size());
  }

  std::size_t size() const { return gathered_.size(); }

  void run(std::size_t i, std::uint64_t seed) {
    if (i < places_.size()) {
      const LevelPlace& p = places_[i];
      gathered_[i].add(checked(knob_.methods[p.method].levels[p.level].run(seed)));
    } else {
      gathered_[i].add(checked(knob_.run_preset(seed, kAccuracyPresets[i - places_.size()])));
    }
  }

  KnobResult result() const {
    KnobResult result;
    result.knob = knob_;
    std::size_t i = 0;
    for (const Method& method : knob_.methods) {
      MethodResult m{method.name, {}, method.expected_order, {}, method.floor};
      for (const Level& level : method.levels) {
        m.levels.push_back(gathered_[i++].result(level.value, level.label, method.floor));
      }
      m.order = fitted_order(m.levels);
      // A flat curve does not depend on the level; noise is not an order.
      constexpr double kFlat = 0.1;
      if (!m.expected_order && m.order && std::abs(*m.order) < kFlat) m.order.reset();
      result.methods.push_back(std::move(m));
    }
    const double floor = knob_.methods[knob_.default_method].floor;
    for (std::size_t p = 0; p < kAccuracyPresets.size(); ++p) {
      result.presets[p] = gathered_[i++].result(static_cast<double>(p), kPresetNames[p], floor);
    }
    return result;
  }

 private:
  const Knob& knob_;
  std::vector<LevelPlace> places_;
  std::vector<Gathered> gathered_;
};

}  // namespace

Spread Spread::of(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const auto at = [&](double share) {
    const double place = share * static_cast<double>(values.size() - 1);
    const auto below = static_cast<std::size_t>(place);
    const std::size_t above = std::min(below + 1, values.size() - 1);
    return values[below] + (place - static_cast<double>(below)) * (values[above] - values[below]);
  };
  return {at(0.25), at(0.5), at(0.75)};
}

std::uint64_t repeat_seed(const MeasurementEffort& effort, int repeat) {
  return effort.seed + static_cast<std::uint64_t>(repeat);
}

std::optional<double> fitted_order(const std::vector<LevelResult>& levels) {
  constexpr std::size_t kLeastLevels = 4;
  // A median that deviates from the line by more than this factor contradicts a power law: noise is
  // a few per cent, and the curvature of an asymptotic law at its coarsest level some tens.
  constexpr double kMostOffLine = 1.5;
  std::vector<Eigen::Vector2d> points;  // log(value), log(error)
  for (const LevelResult& level : levels) {
    if (!level.counts() || level.at_floor || !(level.error.median > 0.0)) continue;
    points.emplace_back(std::log(level.value), std::log(level.error.median));
  }
  if (points.size() < kLeastLevels) return std::nullopt;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p : points) mean += p / static_cast<double>(points.size());
  double xx = 0.0;
  double xy = 0.0;
  for (const Eigen::Vector2d& p : points) {
    xx += (p - mean).x() * (p - mean).x();
    xy += (p - mean).x() * (p - mean).y();
  }
  if (!(xx > 0.0)) return std::nullopt;
  const double order = xy / xx;
  for (const Eigen::Vector2d& p : points) {
    const double off = (p - mean).y() - order * (p - mean).x();
    if (std::abs(off) > std::log(kMostOffLine)) return std::nullopt;
  }
  return order;
}

KnobResult measure(const Knob& knob, const MeasurementEffort& effort,
                   const MeasuringProgress& progress) {
  Round round(knob);
  // A run that does not count: scenes are built, caches and clocks warm up.
  for (std::size_t i = 0; i < round.size(); ++i) Round(knob).run(i, repeat_seed(effort, 0));
  for (int repeat = 0; repeat < MeasurementEffort::kRepeats; ++repeat) {
    const auto turn = static_cast<std::size_t>(repeat);
    const std::size_t stride = stride_of(turn, round.size());
    for (std::size_t i = 0; i < round.size(); ++i) {
      round.run((i * stride + 7 * turn) % round.size(), repeat_seed(effort, repeat));
    }
    if (progress) progress(static_cast<double>(repeat + 1) / MeasurementEffort::kRepeats);
  }
  KnobResult result = round.result();
  judge(result);
  return result;
}

LevelResult measure_level(const Knob& knob, const LevelPlace& place,
                          const MeasurementEffort& effort) {
  const Method& method = knob.methods[place.method];
  const Level& level = method.levels[place.level];
  Gathered gathered;
  level.run(repeat_seed(effort, 0));  // as in measure()
  for (int repeat = 0; repeat < MeasurementEffort::kRepeats; ++repeat) {
    gathered.add(checked(level.run(repeat_seed(effort, repeat))));
  }
  return gathered.result(level.value, level.label, method.floor);
}

}  // namespace palpate
