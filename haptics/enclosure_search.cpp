#include "haptics/enclosure_search.h"

#include <algorithm>

#include "geometry/index/pack_queries.h"

namespace palpate {

// One call of EnclosureSearch::search().
struct EnclosureSearch::Visit {
  const SurfaceIndex& index;
  const ClosedParts& parts;
  EnclosureSearch& search;
  WorkMeter& work;
  Vec3 p, q, d;
  bool has_begun = false;
  bool is_cut_short = false;

  void consider(std::uint32_t slot) {
    const std::uint32_t part = parts.part(index.face(slot));
    if (part == ClosedParts::kOpen) return;
    SignWork signs;
    const Crossing crossing = crossing_of(index.triangle(slot), p, q, signs);
    work.add(Work::kTriangle);
    work.add(Work::kSignByPairs, static_cast<std::size_t>(signs.by_pairs));
    work.add(Work::kSignByZeros, static_cast<std::size_t>(signs.by_zeros));
    work.add(Work::kSignByExpansions, static_cast<std::size_t>(signs.by_expansions));
    if (crossing == Crossing::kNone) return;
    if (crossing == Crossing::kUndecided || !search.count(part)) search.is_undecided_ = true;
  }

  // False to end the search.
  bool visit(std::uint32_t pack) {
    search.next_pack_ = pack;
    if (has_begun && work.is_spent()) {
      is_cut_short = true;
      return false;
    }
    has_begun = true;
    work.add(Work::kPack);
    PackLanes doubtful;
    if (lanes_in_the_way(index.packs(), {&pack, 1}, p, d, 0.0, &doubtful) == 0) return true;
    while (doubtful.lanes != 0 && !search.is_undecided_) {
      consider(SurfaceIndex::slot(pack, take_lane(doubtful.lanes)));
    }
    return !search.is_undecided_;
  }
};

void EnclosureSearch::begin(const Vec3& p_index) noexcept {
  point_ = p_index;
  begin_probe(0);
}

void EnclosureSearch::begin_probe(int attempt) noexcept {
  attempt_ = attempt;
  next_pack_ = 0;
  is_undecided_ = false;
  crossings_ = 0;
  crossed_count_ = 0;
}

bool EnclosureSearch::count(std::uint32_t part) noexcept {
  if (crossings_ == kMostCrossings) return false;
  ++crossings_;
  const auto end = crossed_.begin() + static_cast<std::ptrdiff_t>(crossed_count_);
  const auto known = std::find(crossed_.begin(), end, part);
  const auto at = static_cast<std::size_t>(known - crossed_.begin());
  if (known == end) {
    crossed_[crossed_count_] = part;
    is_odd_[crossed_count_++] = false;
  }
  is_odd_[at] = !is_odd_[at];
  return true;
}

EnclosureSearch::Result EnclosureSearch::search(const SurfaceIndex& index, const ClosedParts& parts,
                                                WorkMeter& work) noexcept {
  if (index.pack_count() == 0 || !index.box().contains(point_)) return Result::kOutside;
  for (;;) {
    const Vec3 end = probe_end(index.box(), point_, attempt_);
    Visit visit{index, parts, *this, work, point_, end, end - point_};
    work.add(index.visit_packs_along(
        point_, visit.d, 0.0, next_pack_,
        [](void* state, std::span<const std::uint32_t> packs, bool) {
          auto& self = *static_cast<Visit*>(state);
          const bool goes_on = std::all_of(packs.begin(), packs.end(),
                                           [&](std::uint32_t pack) { return self.visit(pack); });
          return goes_on ? QueryFraction::end() : kNothingMore;
        },
        &visit));
    if (visit.is_cut_short) return Result::kCutShort;
    if (!is_undecided_) break;
    if (attempt_ + 1 == kMostTries) return Result::kUndecided;
    begin_probe(attempt_ + 1);
    if (work.is_spent()) return Result::kCutShort;
  }
  const auto odd_end = is_odd_.begin() + static_cast<std::ptrdiff_t>(crossed_count_);
  return std::find(is_odd_.begin(), odd_end, true) != odd_end ? Result::kInside : Result::kOutside;
}

void EnclosingBodySearch::begin() noexcept {
  tested_ = kNone;
  are_resting_done_ = false;
  next_ = 0;
  found_ = kNone;
}

// Tests body next_, or goes on with its test. Returns whether it is outside.
bool EnclosingBodySearch::test(const LiveWorld& world, std::uint32_t body, const Vec3& p_solver,
                               WorkMeter& work) noexcept {
  const ClosedParts& parts = *parts_[body];
  if (parts.count == 0) return true;
  work.add(Work::kBody);
  const ContactBody& b = world.body(body);
  if (tested_ != body) search_.begin(b.to_index(b.to_body(p_solver)));
  const auto result = search_.search(*b.index, parts, work);
  // An undecided point is tested again where it is in the next tick.
  tested_ = result == EnclosureSearch::Result::kCutShort ? body : kNone;
  if (result == EnclosureSearch::Result::kInside) found_ = body;
  return result == EnclosureSearch::Result::kOutside;
}

// Tests the bodies at rest near the point, from number next_ on, at least one of them. True if all
// are done.
bool EnclosingBodySearch::test_resting(const LiveWorld& world, const Vec3& p_solver,
                                       WorkMeter& work) noexcept {
  bool has_tested = tested_ != kNone;
  // The point may have left the box of a body whose test has begun.
  if (has_tested) {
    if (!test(world, tested_, p_solver, work)) return false;
    ++next_;
  }
  bool are_done = true;
  work.add(world.visit_resting_near(p_solver, 0.0, NearSearch::kInOrder, [&](std::uint32_t body) {
    work.add(Work::kBodySeen);
    if (body < next_) return true;
    are_done = (!has_tested || !work.is_spent()) && test(world, body, p_solver, work);
    has_tested = true;
    next_ = are_done ? body + 1 : body;
    return are_done;
  }));
  return are_done;
}

bool EnclosingBodySearch::test_moving(const LiveWorld& world, const Vec3& p_solver,
                                      WorkMeter& work) noexcept {
  const auto moving = world.moving();
  for (bool has_tested = false; next_ < moving.size(); ++next_, has_tested = true) {
    if (has_tested && work.is_spent()) return false;
    if (!test(world, moving[next_], p_solver, work)) return false;
  }
  return true;
}

EnclosingBodySearch::State EnclosingBodySearch::search(const LiveWorld& world, const Vec3& p_solver,
                                                       WorkMeter& work) noexcept {
  if (found_ != kNone) return State::kInside;
  if (!are_resting_done_ && test_resting(world, p_solver, work)) {
    are_resting_done_ = true;
    next_ = 0;
  }
  const bool are_done = are_resting_done_ && test_moving(world, p_solver, work);
  if (found_ != kNone) return State::kInside;
  return are_done ? State::kOutside : State::kSearches;
}

}  // namespace palpate
