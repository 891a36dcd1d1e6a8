#include "engine/analysis/strategy_text.h"

#include <algorithm>
#include <cmath>

#include "engine/analysis/statistics_text.h"
#include "engine/report/human_units.h"

namespace palpate {
namespace {

constexpr std::size_t kHeadingColumns = 26;
constexpr std::size_t kLeastColumns = 9;

std::string joined_names(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

std::string padded_left(std::string text, std::size_t columns) {
  if (text.size() < columns) text.insert(0, columns - text.size(), ' ');
  return text;
}

std::string padded_right(std::string text, std::size_t columns) {
  text.resize(std::max(columns, text.size()), ' ');
  return text;
}

// Three digits, in the shown unit.
int digits_after_point(double largest) {
  if (!(largest > 0.0)) return 0;
  return std::clamp(2 - static_cast<int>(std::floor(std::log10(largest))), 0, 4);
}

std::string standing_mark(const MeasureComparison& comparison, Standing standing) {
  if (comparison.is_tie_of_all()) return "  ";
  return standing == Standing::kBest ? " *" : standing == Standing::kTied ? " =" : "  ";
}

std::string means_text(const FollowingComparison& comparison) {
  const auto& first = comparison.scenes.front().measures.front().entries;
  std::string text =
      padded_right("mean over " + std::to_string(comparison.hands) + " hands", kHeadingColumns);
  std::vector<std::size_t> widths;
  for (const StrategyEntry& entry : first) {
    if (entry.role == StrategyRole::kLevel) continue;  // in the report
    widths.push_back(std::max(kLeastColumns, entry.strategy.size() + 2));
    text += padded_left(entry.strategy, widths.back()) + "  ";
  }
  text = text.substr(0, text.find_last_not_of(' ') + 1) + "\n";
  for (const MeasureComparison& measure : comparison.scenes.front().measures) {
    std::string line = padded_right(measure_heading(*measure.measure), kHeadingColumns);
    for (std::size_t i = 0; i < widths.size(); ++i) {  // levels come last
      const StrategyEntry& entry = measure.entries[i];
      line += padded_left(shown_mean(*measure.measure, entry.mean, shown_decimals(measure)),
                          widths[i]) +
              standing_mark(measure, entry.standing);
    }
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  return text + "* best technique; = tied: the 95 % interval of the paired difference holds 0\n";
}

std::string losses_text(const FollowingComparison& comparison) {
  const auto& entries = comparison.scenes.front().measures.front().entries;
  if (std::none_of(entries.begin(), entries.end(),
                   [](const StrategyEntry& entry) { return entry.strategy == "a4"; })) {
    return "";
  }
  const auto losses = losses_by_strategy(comparison, "+-");
  if (losses.empty()) return "a4 loses by no measure\n";
  std::string text = "a4 loses (paired difference to a4):\n";
  for (const LossesToStrategy& to : losses) {
    text += "  to " + to.strategy +
            (to.role == StrategyRole::kReference ? " (a reference): " : ": ") +
            joined_names(to.measures) + "\n";
  }
  return text;
}

// Whether another level has another mean.
bool matters(const FollowingComparison& comparison, const TuningEntry& chosen) {
  return std::any_of(comparison.tuning.begin(), comparison.tuning.end(),
                     [&](const TuningEntry& entry) {
                       return entry.scene == chosen.scene && entry.measure == chosen.measure &&
                              entry.mean.mean != chosen.mean.mean;
                     });
}

std::string tuning_text(const FollowingComparison& comparison) {
  std::string text;
  for (const TuningEntry& entry : comparison.tuning) {
    if (!entry.scene.empty() || !entry.is_chosen || !matters(comparison, entry)) continue;
    const std::string value = entry.strategy.substr(entry.strategy.find(':') + 1);
    text += (text.empty() ? "" : ", ") + std::string(entry.measure->name) + " " + value;
  }
  return text.empty() ? "" : "anisotropic, E tuned on other hands: " + text + "\n";
}

}  // namespace

const std::string kSimulatedHandsSentence =
    "The hands are simulated: the intervals speak of seeds and of the ranges in the operator file, "
    "not of people.";

std::string measure_heading(const ComparedMeasure& measure) {
  const std::string name(measure.name);
  return measure.shown_unit.empty() ? name : name + ", " + std::string(measure.shown_unit);
}

int shown_decimals(const MeasureComparison& comparison) {
  double largest = 0.0;
  for (const StrategyEntry& entry : comparison.entries) {
    const double shown = std::abs(entry.mean.mean) * comparison.measure->shown_per_unit;
    if (entry.mean.count > 0) largest = std::max(largest, shown);
  }
  return digits_after_point(largest);
}

std::string shown_mean(const ComparedMeasure& measure, const MeanInterval& mean, int decimals) {
  if (mean.count == 0) return "-";
  std::string text = with_decimals(mean.mean * measure.shown_per_unit, decimals);
  const bool is_zero = text.find_first_of("123456789") == std::string::npos;
  return is_zero && text.front() == '-' ? text.substr(1) : text;
}

std::string shown_interval(const ComparedMeasure& measure, const MeanInterval& interval,
                           int decimals, const std::string& plus_minus) {
  const std::string mean = shown_mean(measure, interval, decimals);
  if (interval.count < 2) return mean;
  return mean + " " + plus_minus + " " +
         with_decimals(interval.half_width * measure.shown_per_unit, decimals);
}

std::vector<LossesToStrategy> losses_by_strategy(const FollowingComparison& comparison,
                                                 const std::string& plus_minus) {
  std::vector<LossesToStrategy> all;
  const auto losses = comparison.a4_losses();
  for (const StrategyEntry& entry : comparison.scenes.front().measures.front().entries) {
    LossesToStrategy to{entry.strategy, entry.role, {}};
    for (const A4Loss& loss : losses) {
      if (loss.better->strategy != entry.strategy) continue;
      const ComparedMeasure& measure = *loss.measure;
      const MeanInterval& difference = *loss.better->minus_a4;
      const int decimals = digits_after_point(std::abs(difference.mean) * measure.shown_per_unit);
      std::string text = std::string(measure.name) + " " +
                         shown_interval(measure, difference, decimals, plus_minus);
      if (!measure.shown_unit.empty()) text += " " + std::string(measure.shown_unit);
      to.measures.push_back(std::move(text));
    }
    if (!to.measures.empty()) all.push_back(std::move(to));
  }
  return all;
}

std::string leaders_text(const MeasureComparison& comparison) {
  auto names = comparison.leaders();
  if (names.empty()) return "-";
  if (comparison.is_tie_of_all()) return "tie of all";
  const std::string best = names.front();
  names.erase(names.begin());
  return names.empty() ? best : best + " (tied: " + joined_names(names) + ")";
}

std::string comparison_text(const FollowingComparison& comparison) {
  std::string text = means_text(comparison) + tuning_text(comparison) + losses_text(comparison);
  for (const std::string& name : comparison.incomplete()) {
    const auto found =
        std::find_if(comparison.outcomes.begin(), comparison.outcomes.end(),
                     [&](const StrategyOutcome& each) { return each.strategy == name; });
    text += "not comparable: " + std::to_string(found->counts.done) + " of " +
            std::to_string(found->counts.trials) + " trials of " + name +
            " ended at the red sphere; expected 90 %\n";
  }
  return text;
}

}  // namespace palpate
