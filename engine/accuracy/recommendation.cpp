#include "engine/accuracy/recommendation.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace palpate {
namespace {

enum class Figure { kTime, kError };

const Spread& spread_of(const LevelResult& level, Figure figure) {
  return figure == Figure::kTime ? level.time : level.error;
}

bool is_clearly_less(const Spread& a, const Spread& b) {
  return a.median < b.median && !is_alike(a, b);
}

// Visits the levels that compete with the level at `place`, which is one of them.
template <typename Visit>
void for_each_rival(const KnobResult& result, const LevelPlace& place, Visit visit) {
  for (std::size_t m = 0; m < result.methods.size(); ++m) {
    if (result.knob.methods_are_given && m != place.method) continue;
    for (std::size_t l = 0; l < result.methods[m].levels.size(); ++l) {
      if (result.knob.levels_are_given && l != place.level) continue;
      const LevelResult& rival = result.methods[m].levels[l];
      if (rival.counts()) visit(LevelPlace{m, l}, rival);
    }
  }
}

void mark_front(KnobResult& result) {
  for (std::size_t m = 0; m < result.methods.size(); ++m) {
    for (std::size_t l = 0; l < result.methods[m].levels.size(); ++l) {
      LevelResult& candidate = result.methods[m].levels[l];
      candidate.on_front = candidate.counts();
      for_each_rival(result, {m, l}, [&](const LevelPlace&, const LevelResult& rival) {
        if (is_clearly_better(rival, candidate)) candidate.on_front = false;
      });
    }
  }
}

// By how many times `better` is less; infinite where it is 0 and `worse` is not.
double times_less(const Spread& better, const Spread& worse) {
  if (!is_clearly_less(better, worse)) return 1.0;
  return better.median > 0.0 ? worse.median / better.median
                             : std::numeric_limits<double>::infinity();
}

void judge_default(KnobResult& result) {
  const LevelPlace place = result.default_place();
  const LevelResult& usual = result.methods[place.method].levels[place.level];
  result.default_behind = 1.0;
  result.better_than_default.clear();
  if (!usual.counts()) {
    result.default_behind = std::numeric_limits<double>::infinity();
    result.better_than_default = "any other level: the default failed, " + usual.failure;
    return;
  }
  for_each_rival(result, place, [&](const LevelPlace& p, const LevelResult& rival) {
    if (!is_clearly_better(rival, usual)) return;
    const double behind =
        std::max(times_less(rival.time, usual.time), times_less(rival.error, usual.error));
    if (behind <= result.default_behind) return;
    result.default_behind = behind;
    result.better_than_default = result.methods[p.method].name + ", " + rival.label;
  });
}

bool is_within_factor(const Spread& a, const Spread& b) {
  return std::max(a.median, b.median) <= kAlikeFactor * std::min(a.median, b.median);
}

// Keeps the levels whose figure is as small as the smallest, in the sense of chosen_level().
void keep_smallest(std::span<const LevelResult* const> levels,
                   std::span<const std::size_t> distance, Figure figure,
                   std::vector<std::size_t>& kept) {
  const Spread* least = nullptr;
  for (const std::size_t i : kept) {
    const Spread& spread = spread_of(*levels[i], figure);
    if (!least || spread.median < least->median) least = &spread;
  }
  std::erase_if(kept, [&](std::size_t i) {
    const Spread& spread = spread_of(*levels[i], figure);
    return distance[i] == 0 ? !is_alike(spread, *least) : !is_within_factor(spread, *least);
  });
}

// Levels of other methods are farther than all levels of the default's method.
std::size_t distance_of(const KnobResult& result, const LevelPlace& place) {
  constexpr std::size_t kOtherMethod = 1'000'000;
  const LevelPlace usual = result.default_place();
  const std::size_t steps =
      place.level > usual.level ? place.level - usual.level : usual.level - place.level;
  return steps + (place.method == usual.method ? 0 : kOtherMethod * (place.method + 1));
}

std::optional<LevelPlace> recommended(const KnobResult& result) {
  std::vector<LevelPlace> places;
  std::vector<const LevelResult*> levels;
  std::vector<std::size_t> distances;
  for_each_rival(result, result.default_place(),
                 [&](const LevelPlace& place, const LevelResult& level) {
                   places.push_back(place);
                   levels.push_back(&level);
                   distances.push_back(distance_of(result, place));
                 });
  const auto chosen = chosen_level(levels, distances, result.knob.enough);
  return chosen ? std::optional(places[*chosen]) : std::nullopt;
}

// Whether the whiskers are wider than the effect of choosing this level instead of the default.
bool is_hidden_by_spread(const KnobResult& result, const LevelPlace& place) {
  const LevelPlace usual_place = result.default_place();
  const LevelResult& usual = result.methods[usual_place.method].levels[usual_place.level];
  const LevelResult& level = result.methods[place.method].levels[place.level];
  return place != usual_place && usual.counts() && !is_below(level.error, usual.error) &&
         !is_below(level.time, usual.time);
}

bool have_same_levels(const KnobResult& a, const KnobResult& b) {
  return std::equal(a.methods.begin(), a.methods.end(), b.methods.begin(), b.methods.end(),
                    [](const MethodResult& x, const MethodResult& y) {
                      return x.name == y.name && x.levels.size() == y.levels.size();
                    });
}

}  // namespace

bool is_below(const Spread& a, const Spread& b) {
  return a.high < b.low;
}

bool is_alike(const Spread& a, const Spread& b) {
  const bool overlaps = a.low <= b.high && b.low <= a.high;
  return overlaps || is_within_factor(a, b);
}

bool is_clearly_better(const LevelResult& a, const LevelResult& b) {
  const bool is_better = is_clearly_less(a.time, b.time) || is_clearly_less(a.error, b.error);
  const bool is_worse = is_clearly_less(b.time, a.time) || is_clearly_less(b.error, a.error);
  return is_better && !is_worse;
}

std::optional<std::size_t> chosen_level(std::span<const LevelResult* const> levels,
                                        std::span<const std::size_t> distance, double enough) {
  std::vector<std::size_t> counting;
  std::vector<std::size_t> left;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    if (!levels[i]->counts()) continue;
    counting.push_back(i);
    if (levels[i]->error.median <= enough) left.push_back(i);
  }
  if (counting.empty()) return std::nullopt;
  if (left.empty()) {
    left = counting;
    keep_smallest(levels, distance, Figure::kError, left);
    keep_smallest(levels, distance, Figure::kTime, left);
  } else {
    keep_smallest(levels, distance, Figure::kTime, left);
    keep_smallest(levels, distance, Figure::kError, left);
  }
  return *std::min_element(left.begin(), left.end(),
                           [&](std::size_t a, std::size_t b) { return distance[a] < distance[b]; });
}

void judge(KnobResult& result) {
  mark_front(result);
  judge_default(result);
  result.recommended = recommended(result);
  result.undecided.reset();
  if (result.recommended && is_hidden_by_spread(result, *result.recommended)) {
    std::swap(result.recommended, result.undecided);
  }
}

void reconcile(std::vector<KnobResult>& results) {
  for (KnobResult& result : results) {
    if (result.knob.decided_by.empty()) continue;
    for (const KnobResult& other : results) {
      if (other.knob.name != result.knob.decided_by || !have_same_levels(result, other)) continue;
      result.recommended = other.recommended;
      result.undecided = other.undecided;
      result.decided_by_title = other.knob.title;
    }
  }
}

}  // namespace palpate
