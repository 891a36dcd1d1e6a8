#include "engine/analysis/strategy_comparison.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "haptics/strategies/strategy.h"

namespace palpate {
namespace {

using ScenePlace = std::optional<std::size_t>;

// A strategy, or the tuned one, which stands for a level.
struct Contender {
  std::string name;
  StrategyRole role;
  std::optional<std::size_t> place;  // in StrategyTrials; no value: the tuned one
};

StrategyRole role_of(const std::string& name) {
  return name == "none" || name == "full" ? StrategyRole::kReference : StrategyRole::kTechnique;
}

// How far E is from 1, in powers of 2.
double distance_from_one(const std::string& level) {
  const auto strategy = parse_strategy(level);
  return strategy ? std::abs(std::log2(strategy->parameter)) : 0.0;
}

class Comparer {
 public:
  Comparer(const std::vector<TrialRow>& rows, const std::vector<TrialRow>& tuning_rows,
           const ComparedStrategies& compared, const std::string& following)
      : compared_(compared),
        trials_(rows, following, all_names(compared), compared.scenes),
        tuning_(tuning_rows, following, compared.levels, compared.scenes) {
    for (std::size_t i = 0; i < compared.strategies.size(); ++i) {
      const std::string& name = compared.strategies[i];
      contenders_.push_back({name, role_of(name), i});
    }
    if (compared.levels.empty()) return;
    contenders_.push_back({std::string(kTunedStrategy), StrategyRole::kTechnique, {}});
    for (std::size_t i = 0; i < compared.levels.size(); ++i) {
      contenders_.push_back(
          {compared.levels[i], StrategyRole::kLevel, compared.strategies.size() + i});
    }
  }

  FollowingComparison compare(const std::string& following);

 private:
  static std::vector<std::string> all_names(const ComparedStrategies& compared) {
    std::vector<std::string> names = compared.strategies;
    names.insert(names.end(), compared.levels.begin(), compared.levels.end());
    return names;
  }
  std::optional<std::size_t> place_of_strategy(const std::string& name) const;
  std::size_t tune(const ScenePlace& scene, const ComparedMeasure& measure,
                   std::vector<TuningEntry>& entries) const;
  MeasureComparison compare(const ScenePlace& scene, const ComparedMeasure& measure,
                            std::vector<TuningEntry>& tuning) const;
  void rank(const ScenePlace& scene, const std::vector<std::size_t>& places,
            MeasureComparison& comparison) const;
  std::string scene_name(const ScenePlace& scene) const {
    return scene ? compared_.scenes[*scene] : std::string();
  }

  const ComparedStrategies& compared_;
  StrategyTrials trials_;
  StrategyTrials tuning_;
  std::vector<Contender> contenders_;
};

std::optional<std::size_t> Comparer::place_of_strategy(const std::string& name) const {
  const auto& names = trials_.strategies();
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) return std::nullopt;
  return static_cast<std::size_t>(found - names.begin());
}

// The place of the best level in compared_.levels.
std::size_t Comparer::tune(const ScenePlace& scene, const ComparedMeasure& measure,
                           std::vector<TuningEntry>& entries) const {
  using Key = std::tuple<bool, double, double>;  // the smallest one is the best
  std::optional<Key> best_key;
  std::size_t best = 0;
  const std::size_t first = entries.size();
  for (std::size_t level = 0; level < compared_.levels.size(); ++level) {
    const std::string& name = compared_.levels[level];
    const MeanInterval mean = tuning_.mean(level, scene, measure);
    entries.push_back({scene_name(scene), &measure, name, mean, false});
    if (mean.count == 0) continue;
    const Key key{!tuning_.counts(level).is_comparable(), mean.mean, distance_from_one(name)};
    if (best_key && !(key < *best_key)) continue;
    best_key = key;
    best = level;
  }
  entries[first + best].is_chosen = true;
  return best;
}

// places: of each contender, in trials_.
void Comparer::rank(const ScenePlace& scene, const std::vector<std::size_t>& places,
                    MeasureComparison& comparison) const {
  std::vector<StrategyEntry>& entries = comparison.entries;
  const auto is_ranked = [&](std::size_t i) {
    return entries[i].role == StrategyRole::kTechnique && entries[i].mean.count > 0 &&
           trials_.counts(places[i]).is_comparable();
  };
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (is_ranked(i) && (!best || entries[i].mean.mean < entries[*best].mean.mean)) {
      best = i;
    }
  }
  for (std::size_t i = 0; best && i < entries.size(); ++i) {
    if (!is_ranked(i)) continue;
    // Pairs of the same hands decide. The means may be of other trials, where some are missing.
    const MeanInterval behind =
        trials_.difference(places[i], places[*best], scene, *comparison.measure);
    const bool is_apart = i != *best && behind.excludes_zero() && behind.mean > 0.0;
    entries[i].standing = i == *best ? Standing::kBest
                          : is_apart ? Standing::kOther
                                     : Standing::kTied;
  }
}

MeasureComparison Comparer::compare(const ScenePlace& scene, const ComparedMeasure& measure,
                                    std::vector<TuningEntry>& tuning) const {
  std::size_t tuned = 0;
  if (!compared_.levels.empty()) {
    tuned = compared_.strategies.size() + tune(scene, measure, tuning);
  }
  MeasureComparison comparison{&measure, {}};
  std::vector<std::size_t> places;
  const auto minus = [&](std::size_t place, const std::string& name) {
    const auto other = place_of_strategy(name);
    std::optional<MeanInterval> difference;
    if (other && *other != place) difference = trials_.difference(place, *other, scene, measure);
    return difference;
  };
  for (const Contender& contender : contenders_) {
    const std::size_t place = contender.place.value_or(tuned);
    places.push_back(place);
    comparison.entries.push_back({contender.name,
                                  contender.place ? std::string() : trials_.strategies()[place],
                                  contender.role, trials_.mean(place, scene, measure),
                                  minus(place, "mask"), minus(place, "a4"), Standing::kOther});
  }
  rank(scene, places, comparison);
  return comparison;
}

FollowingComparison Comparer::compare(const std::string& following) {
  FollowingComparison all{following, trials_.hands(), {}, {}, {}};
  for (const Contender& contender : contenders_) {
    if (!contender.place) continue;
    all.outcomes.push_back({contender.name, contender.role, trials_.counts(*contender.place)});
  }
  std::vector<ScenePlace> scenes{std::nullopt};
  for (std::size_t i = 0; compared_.scenes.size() > 1 && i < compared_.scenes.size(); ++i) {
    scenes.emplace_back(i);
  }
  for (const ScenePlace& scene : scenes) {
    SceneComparison of_scene{scene_name(scene), {}};
    for (const ComparedMeasure& measure : compared_measures()) {
      of_scene.measures.push_back(compare(scene, measure, all.tuning));
    }
    all.scenes.push_back(std::move(of_scene));
  }
  return all;
}

}  // namespace

std::vector<std::string> MeasureComparison::leaders() const {
  std::vector<std::string> names;
  for (const Standing standing : {Standing::kBest, Standing::kTied}) {
    for (const StrategyEntry& entry : entries) {
      if (entry.standing == standing) names.push_back(entry.strategy);
    }
  }
  return names;
}

bool MeasureComparison::is_tie_of_all() const {
  return leaders().size() > 1 &&
         std::none_of(entries.begin(), entries.end(), [](const StrategyEntry& entry) {
           return entry.role == StrategyRole::kTechnique && entry.standing == Standing::kOther &&
                  entry.mean.count > 0;
         });
}

std::vector<std::string> FollowingComparison::incomplete() const {
  std::vector<std::string> names;
  for (const StrategyOutcome& outcome : outcomes) {
    const bool is_chosen = outcome.role != StrategyRole::kLevel ||
                           std::any_of(tuning.begin(), tuning.end(), [&](const TuningEntry& entry) {
                             return entry.is_chosen && entry.strategy == outcome.strategy;
                           });
    if (is_chosen && !outcome.counts.is_comparable()) names.push_back(outcome.strategy);
  }
  return names;
}

std::vector<A4Loss> FollowingComparison::a4_losses() const {
  std::vector<A4Loss> losses;
  const std::vector<std::string> not_comparable = incomplete();
  const auto is_out = [&](const std::string& strategy) {
    return std::find(not_comparable.begin(), not_comparable.end(), strategy) !=
           not_comparable.end();
  };
  if (is_out("a4")) return losses;
  for (const MeasureComparison& comparison : scenes.front().measures) {
    for (const StrategyEntry& entry : comparison.entries) {
      const auto& minus_a4 = entry.minus_a4;
      if (!minus_a4 || !minus_a4->excludes_zero() || entry.role == StrategyRole::kLevel) continue;
      if (is_out(entry.strategy) || is_out(entry.tuned_to)) continue;
      if (is_better_difference(minus_a4->mean)) losses.push_back({comparison.measure, &entry});
    }
  }
  return losses;
}

FollowingComparison compare_strategies(const std::vector<TrialRow>& rows,
                                       const std::vector<TrialRow>& tuning_rows,
                                       const ComparedStrategies& compared,
                                       const std::string& following) {
  return Comparer(rows, tuning_rows, compared, following).compare(following);
}

}  // namespace palpate
