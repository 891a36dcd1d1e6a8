#include "haptics/effects/side_search.h"

#include <algorithm>
#include <span>

#include "geometry/index/pack_queries.h"

namespace palpate {
namespace {

Vec3 vector_of(const double (&v)[3]) {
  return {v[0], v[1], v[2]};
}

// One call of count_crossings().
struct Count {
  const SurfaceIndex& index;
  SideSearch& search;
  WorkMeter& work;
  Vec3 p, q, d;
  bool has_begun = false;
  bool is_cut_short = false;

  void consider(std::uint32_t slot) {
    SignWork signs;
    const Crossing crossing = crossing_of(index.triangle(slot), p, q, signs);
    work.add(Work::kTriangle);
    work.add(Work::kSignByPairs, static_cast<std::size_t>(signs.by_pairs));
    work.add(Work::kSignByZeros, static_cast<std::size_t>(signs.by_zeros));
    work.add(Work::kSignByExpansions, static_cast<std::size_t>(signs.by_expansions));
    if (crossing == Crossing::kNone) return;
    if (crossing == Crossing::kUndecided || search.crossings == kMostCrossings) {
      search.is_undecided = 1;
    } else {
      ++search.crossings;
    }
  }

  // False to end the search.
  bool visit(std::uint32_t pack) {
    search.next_pack = pack;
    if (has_begun && work.is_spent()) {
      is_cut_short = true;
      return false;
    }
    has_begun = true;
    work.add(Work::kPack);
    PackLanes doubtful;
    if (lanes_in_the_way(index.packs(), {&pack, 1}, p, d, 0.0, &doubtful) == 0) return true;
    while (doubtful.lanes != 0 && search.is_undecided == 0) {
      consider(SurfaceIndex::slot(pack, take_lane(doubtful.lanes)));
    }
    return search.is_undecided == 0;
  }
};

}  // namespace

void SideSearch::begin_path(const Vec3& from, const Vec3& to) noexcept {
  *this = {};
  segment = Segment::kPath;
  std::copy_n(to.data(), 3, point);
  std::copy_n(from.data(), 3, other_end);
}

void SideSearch::begin_probe(const SurfaceIndex& index, const Vec3& p, int number) noexcept {
  *this = {};
  segment = Segment::kProbe;
  attempt = static_cast<std::uint16_t>(number);
  std::copy_n(p.data(), 3, point);
  if (!index.box().contains(p)) return;  // no crossing is needed
  const Vec3 end = probe_end(index.box(), p, number);
  std::copy_n(end.data(), 3, other_end);
}

// A path is traced from the known point, as crosses_odd(last, p) does, and a probe from the point.
SideResult count_crossings(const SurfaceIndex& index, SideSearch& search,
                           WorkMeter& work) noexcept {
  const bool is_path = search.segment == SideSearch::Segment::kPath;
  const Vec3 from = vector_of(is_path ? search.other_end : search.point);
  const Vec3 to = vector_of(is_path ? search.point : search.other_end);
  Count count{index, search, work, from, to, to - from};
  const QueryWork query = index.visit_packs_along(
      from, count.d, 0.0, search.next_pack,
      [](void* state, std::span<const std::uint32_t> packs, bool) {
        auto& self = *static_cast<Count*>(state);
        const bool goes_on = std::all_of(packs.begin(), packs.end(),
                                         [&](std::uint32_t pack) { return self.visit(pack); });
        return goes_on ? QueryFraction::end() : kNothingMore;
      },
      &count);
  work.add(query);
  if (count.is_cut_short) return SideResult::kCutShort;
  if (search.is_undecided != 0) return SideResult::kUndecided;
  return search.crossings % 2 != 0 ? SideResult::kOdd : SideResult::kEven;
}

SideResult find_side(const SurfaceIndex& index, SideSearch& search, WorkMeter& work) noexcept {
  const Vec3 p = vector_of(search.point);
  if (index.pack_count() == 0 || !index.box().contains(p)) return SideResult::kEven;
  for (;;) {
    const SideResult result = count_crossings(index, search, work);
    if (result != SideResult::kUndecided) return result;
    const int next = search.attempt + 1;
    if (next == kMostTries) return SideResult::kUndecided;
    search.begin_probe(index, p, next);
    if (work.is_spent()) return SideResult::kCutShort;
  }
}

}  // namespace palpate
