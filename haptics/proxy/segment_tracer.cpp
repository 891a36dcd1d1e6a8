#include "haptics/proxy/segment_tracer.h"

#include <algorithm>
#include <array>

#include "haptics/proxy/float_trace.h"
#include "haptics/proxy/segment_search.h"

namespace palpate {
namespace {

// A cheap tick refills the candidate cache if the present ball will not last this many more ticks.
constexpr double kTicksAhead = 3.0;

// Number of cache refills in one tick. A proxy that needs more is on a long path, and the rest of
// its steps use segment queries.
constexpr int kMostRefills = 4;

// The first part of a sphere's step that is searched, in radii, if the step is longer than
// kShortStep radii; and the growth of that part for each further search.
constexpr double kShortStep = 0.125;
constexpr double kFirstLook = 0.01;
constexpr double kFartherLook = 16.0;

// A tick logs its traces after this fraction (1/16) of its budget is used. Most ticks never reach
// it, and repeating the work before it is cheap.
constexpr WorkUnits kNotedAfterPart = 16;

// Capacity of the trace log: for a move, all attempts at a vertex; for a push, all shortenings.
constexpr std::size_t kMostNotedOfMove = 4096;
constexpr std::size_t kMostNotedOfPush = 256;

// The result of a search that was cut short: the step is stopped at its start.
TraceHit nothing_known() {
  TraceHit hit{};
  hit.contact.normal.setZero();
  hit.contact.feature_point.setZero();
  hit.contact.clearance_m = 0.0;
  return hit;
}

// The narrow phase of a sphere is always double: the index was built for that stand-off.
bool is_in_float(double radius_m, const Accuracy& accuracy) {
  return radius_m == 0.0 && accuracy.narrow_phase == NarrowPhase::kFloat;
}

SolverScale scale_for(const LiveWorld& world, double radius_m, const Accuracy& accuracy) {
  SolverScale scale = SolverScale::of(world.size_m(), radius_m);
  if (!is_in_float(radius_m, accuracy)) return scale;
  for (const ContactBody& body : world.bodies()) {
    if (body.stretch) continue;  // decided in double
    scale.stand_off_m =
        std::max(scale.stand_off_m,
                 float_stand_off_m(body.length_to_solver(body.index->largest_pack_reach_m())));
  }
  scale.stop_m = SolverScale::kStopPerStandOff * scale.stand_off_m;
  scale.clearance_m = SolverScale::kClearancePerStandOff * scale.stand_off_m;
  return scale;
}

}  // namespace

SegmentTracer::SegmentTracer(const LiveWorld& world, double radius_m, const Accuracy& accuracy)
    : world_(&world),
      radius_m_(radius_m),
      accuracy_(accuracy),
      is_in_float_(is_in_float(radius_m, accuracy)),
      scale_(scale_for(world, radius_m, accuracy)),
      // Hits need half a stand-off beyond the radius; two stand-offs also cover rounding.
      cache_(world, radius_m + 2 * scale_.stand_off_m),
      work_(accuracy.work_budget, accuracy.counting),
      noted_from_(accuracy.work_budget / kNotedAfterPart),
      memories_{std::make_unique<Memory>(kMostNotedOfMove),
                std::make_unique<Memory>(kMostNotedOfPush)},
      memory_(memories_[0].get()) {}

void SegmentTracer::forget_steps() noexcept {
  for (const auto& memory : memories_) {
    memory->log.clear();
    memory->progress.reset();
  }
}

bool SegmentTracer::remembers() const noexcept {
  return std::any_of(memories_.begin(), memories_.end(), [](const auto& memory) {
    return memory->progress || !memory->log.is_empty();
  });
}

void SegmentTracer::forget_moving_searches() noexcept {
  for (const auto& memory : memories_) {
    memory->log.clear();
    auto& progress = memory->progress;
    if (!progress || !progress->cursor.is_among_moving) continue;
    progress->cursor.body = progress->cursor.pack = 0;
    progress->best = progress->best_at_rest;
  }
}

[[gnu::always_inline]] inline bool SegmentTracer::search_candidates(Search& search) noexcept {
  std::array<std::uint32_t, CandidateCache::kCapacity> packs;
  std::uint32_t unexamined = 0;
  for (std::size_t n = 0; n < cache_.body_count(); ++n) {
    search.enter_body(cache_.body(n));
    work_.add(Work::kBody);
    const std::size_t count = cache_.packs_along(n, search.p_index, search.d_index, packs);
    if (!search.consider_packs(std::span(packs).first(count), unexamined)) return false;
  }
  return true;
}

// Searches all bodies from the cursor on. False if the budget did not suffice.
bool SegmentTracer::search_all(Search& search, TraceCursor& cursor, const TraceKey& key,
                               std::optional<TraceHit>* best_at_rest) noexcept {
  if (key.only != TraceKey::kNoBody) {
    search.enter_body_at(key.only, key.p, key.q);
    return search_body(search, cursor);
  }
  if (!cursor.is_among_moving) {
    if (!search_resting(search, cursor)) return false;
    cursor.is_among_moving = true;
    cursor.body = cursor.pack = 0;
    if (best_at_rest) *best_at_rest = search.best;
  }
  return search_moving(search, cursor, key.left_out);
}

bool SegmentTracer::search_resting(Search& search, TraceCursor& cursor) noexcept {
  bool is_complete = true;
  const Vec3 d = search.limit.value() * (search.q - search.p);
  const bool counts_seen = accuracy_.counting != CountingRule::kFirst;
  const auto visit = [&](std::uint32_t b) {
    if (b != cursor.body) {
      cursor.body = b;
      cursor.pack = 0;
    }
    search.shorten();
    search.enter_body(b);
    work_.add(Work::kBodySeen);
    // Without a tree, the visit includes bodies that are far away.
    if (search.misses_body()) {
      if (!counts_seen) return true;
      search.has_begun = true;
      if (!work_.is_spent()) return true;
      cursor.body = b + 1;
      cursor.pack = 0;
      is_complete = false;
      return false;
    }
    is_complete = search_body(search, cursor);
    return is_complete;
  };
  work_.add(world_->visit_resting_along(search.p, d, sweep_radius_m(), cursor.body, visit));
  return is_complete;
}

bool SegmentTracer::search_moving(Search& search, TraceCursor& cursor,
                                  std::uint32_t left_out) noexcept {
  const auto moving = world_->moving();
  for (; cursor.body < moving.size(); ++cursor.body, cursor.pack = 0) {
    const std::uint32_t b = moving[cursor.body];
    if (b == left_out) continue;
    search.enter_body(b);
    if (!search_body(search, cursor)) return false;
  }
  return true;
}

// Searches the entered body. False if the budget did not suffice.
bool SegmentTracer::search_body(Search& search, TraceCursor& cursor) noexcept {
  if (search.must_stop()) return false;
  work_.add(Work::kBody);
  struct State {
    Search* search;
    TraceCursor* cursor;
    bool is_complete;
  } state{&search, &cursor, true};
  auto first = cursor.is_resumed ? std::optional(cursor.pack) : std::nullopt;
  // Embree's boxes were not enlarged enough for a point far away from a stretched body.
  const double sweep_radius = search.sweep_radius();
  if (!first && sweep_radius > search.placed->index->sweep_radius_m()) first = 0;
  const QueryWork query = search.placed->index->visit_packs_along(
      search.p_index, search.d_index, sweep_radius, first,
      [](void* s, std::span<const std::uint32_t> packs, bool in_order) {
        State& in = *static_cast<State*>(s);
        std::uint32_t unexamined = 0;
        in.is_complete = in.search->consider_packs(packs, unexamined);
        if (in_order) in.cursor->pack = unexamined;
        return in.is_complete ? QueryFraction(in.search->needed()) : kNothingMore;
      },
      &state);
  count(query);
  search.has_begun = search.has_begun || state.is_complete;
  return state.is_complete;
}

// The fraction of the step that is searched first. For a sphere, a shorter search leaves fewer
// nearby triangles in doubt, and a sphere that falls back to the surface is usually stopped at
// once.
double SegmentTracer::first_look(const Vec3& p, const Vec3& q) const {
  if (radius_m_ == 0.0) return 1.0;
  const double length_m = (q - p).lpNorm<Eigen::Infinity>();
  return length_m <= kShortStep * radius_m_ ? 1.0 : kFirstLook * radius_m_ / length_m;
}

std::optional<TraceHit> SegmentTracer::trace(const Vec3& p, const Vec3& q) noexcept {
  if (!accuracy_.reuse_candidates || must_consult_memory()) [[unlikely]]
    return answer({p, q});
  last_entry_ = nullptr;
  std::optional<TraceHit> hit = find_among_candidates(p, q, TraceKey::kNoBody);
  if (work_.used() >= noted_from_) [[unlikely]]
    finish({p, q}, hit, false);
  return hit;
}

std::optional<TraceHit> SegmentTracer::trace_others(std::uint32_t body, const Vec3& p,
                                                    const Vec3& q) noexcept {
  return answer({p, q, body});
}

std::optional<TraceHit> SegmentTracer::trace_in_body(std::uint32_t body, const Vec3& p_body,
                                                     const Vec3& q_body) noexcept {
  return answer({p_body, q_body, TraceKey::kNoBody, body});
}

std::optional<TraceHit> SegmentTracer::trace_part(const Vec3& p, const Vec3& q) noexcept {
  if (doubtful_.have_overflowed) [[unlikely]]
    return answer({p, q});
  if (must_consult_memory()) [[unlikely]]
    return recall_or_find({p, q}, true);
  last_entry_ = nullptr;
  std::optional<TraceHit> hit = find_part(p, q);
  if (work_.used() >= noted_from_) [[unlikely]]
    finish({p, q}, hit, false);
  return hit;
}

// The logged result, or else the result of a new search if the budget suffices.
std::optional<TraceHit> SegmentTracer::answer(const TraceKey& key) noexcept {
  if (must_consult_memory()) [[unlikely]]
    return recall_or_find(key, false);
  last_entry_ = nullptr;
  std::optional<TraceHit> hit = find(key);
  if (work_.used() >= noted_from_) [[unlikely]]
    finish(key, hit, false);
  return hit;
}

[[gnu::cold]] std::optional<TraceHit> SegmentTracer::recall_or_find(const TraceKey& key,
                                                                    bool is_part) noexcept {
  last_entry_ = nullptr;
  if (is_cut_short_) return nothing_known();
  last_entry_ = memory_->log.recall(key);
  if (last_entry_) {
    doubtful_.clear();
    doubtful_.have_overflowed = true;  // the doubtful triangles of a logged trace are unknown
    return last_entry_->hit;
  }
  auto& unfinished = memory_->progress;
  const bool was_cut_short = unfinished && unfinished->key == key;
  if (work_.is_spent()) {
    if (!was_cut_short) unfinished = TraceProgress{key};
    is_cut_short_ = true;
    has_memory_ = true;
    return nothing_known();
  }
  std::optional<TraceHit> hit;
  if (was_cut_short) {
    TraceProgress progress = *unfinished;
    unfinished.reset();
    doubtful_ = progress.doubtful;
    hit = go_on(progress);
  } else {
    hit = is_part ? find_part(key.p, key.q) : find(key);
  }
  finish(key, hit, was_cut_short);
  return hit;
}

// Logs the result if the tick has used much work, or if the trace was begun by an earlier tick.
[[gnu::cold]] void SegmentTracer::finish(const TraceKey& key, std::optional<TraceHit>& hit,
                                         bool was_cut_short) noexcept {
  if (is_cut_short_) {
    hit = nothing_known();
  } else if (was_cut_short || work_.used() >= noted_from_) {
    last_entry_ = memory_->log.note(key, hit);
    has_memory_ = true;
  }
}

std::optional<TraceHit> SegmentTracer::find_part(const Vec3& p, const Vec3& q) noexcept {
  Search search(*this, p, q, StepFraction::end());
  for (std::size_t i = 0; i < doubtful_.count; ++i) {
    search.enter_body(doubtful_.faces[i].body);
    search.consider(doubtful_.faces[i]);
  }
  return search.best;
}

std::optional<TraceHit> SegmentTracer::find(const TraceKey& key) noexcept {
  const bool may_reuse = accuracy_.reuse_candidates && key.only == TraceKey::kNoBody;
  return may_reuse ? find_among_candidates(key.p, key.q, key.left_out) : find_in_index(key);
}

std::optional<TraceHit> SegmentTracer::find_among_candidates(const Vec3& p, const Vec3& q,
                                                             std::uint32_t left_out) noexcept {
  for (int attempt = 0; attempt < 2; ++attempt) {
    bool is_inside = cache_.covers(p);
    for (double look = first_look(p, q); is_inside; look *= kFartherLook) {
      look = std::min(look, 1.0);
      doubtful_.clear();
      Search search(*this, p, q, StepFraction(look));
      TraceCursor among_moving;
      if (!search_candidates(search) ||
          (!world_->moving().empty() && !search_moving(search, among_moving, left_out))) {
        cut_short({{p, q, left_out}, first_look(p, q)});
        return std::nullopt;
      }
      // All obstacles inside the ball are known, so that the first hit there is the result.
      is_inside =
          cache_.covers(p + (search.best ? search.best->meet_fraction.value() : look) * (q - p));
      if (is_inside && (search.best || look == 1.0)) return search.best;
    }
    // A step too long for any ball needs a segment query.
    if (attempt == 0 && !cache_.may_cover_step(q - p) && cache_.covers(p)) break;
    if (attempt > 0 || refills_ >= kMostRefills) break;
    refills_ = cache_.refill(p, motion_, work_) ? refills_ + 1 : kMostRefills;
  }
  return find_in_index({p, q, left_out});
}

[[gnu::noinline]] std::optional<TraceHit> SegmentTracer::find_in_index(
    const TraceKey& key) noexcept {
  const Vec3& p = key.p;
  const Vec3& q = key.q;
  doubtful_.clear();
  const ContactBody* body = key.only == TraceKey::kNoBody ? nullptr : &world_->body(key.only);
  Search search{*this, body ? body->to_solver(p) : p, body ? body->to_solver(q) : q,
                StepFraction::end()};
  TraceCursor cursor;
  std::optional<TraceHit> best_at_rest;
  if (search_all(search, cursor, key, &best_at_rest)) return search.best;
  // The next tick continues by parts of the step, beginning at its start.
  TraceProgress progress{key, first_look(p, q), cursor, search.best, best_at_rest, doubtful_};
  if (progress.look < 1.0) progress.cursor.begin();
  cut_short(progress);
  return std::nullopt;
}

// Continues the search of an earlier tick that was cut short.
[[gnu::cold]] std::optional<TraceHit> SegmentTracer::go_on(TraceProgress& progress) noexcept {
  const TraceKey& key = progress.key;
  const ContactBody* body = key.only == TraceKey::kNoBody ? nullptr : &world_->body(key.only);
  for (;;) {
    Search search{*this, body ? body->to_solver(key.p) : key.p,
                  body ? body->to_solver(key.q) : key.q, StepFraction(progress.look)};
    search.best = progress.best;
    search.is_resumed = progress.cursor.is_resumed;
    const bool is_complete = search_all(search, progress.cursor, key, &progress.best_at_rest);
    progress.best = search.best;
    if (!is_complete) break;
    const bool is_met = progress.best && progress.best->meet_fraction.value() <= progress.look;
    if (is_met || progress.look == 1.0) return progress.best;
    // The searched part grows by a factor: if many triangles are near the start, each search tests
    // all of them again.
    const double most = progress.best ? progress.best->meet_fraction.value() : 1.0;
    progress.look = std::min(most, kFartherLook * progress.look);
    progress.cursor.begin();
  }
  progress.doubtful = doubtful_;
  cut_short(progress);
  return std::nullopt;
}

[[gnu::cold]] void SegmentTracer::cut_short(const TraceProgress& progress) noexcept {
  memory_->progress = progress;
  memory_->progress->cursor.is_resumed = true;
  is_cut_short_ = true;
  has_memory_ = true;
}

void SegmentTracer::look_ahead(const Vec3& p, const Vec3& step, bool was_cheap) noexcept {
  motion_ = step;
  const bool has_refilled = refills_ > 0;
  refills_ = 0;
  if (!accuracy_.reuse_candidates || !was_cheap || has_refilled || work_.is_spent()) return;
  if (cache_.covers(p + kTicksAhead * step) || !cache_.may_refill(p)) return;
  cache_.refill(p, step, work_);
}

std::optional<FaceContact> SegmentTracer::steepest_contact(const Vec3& p, const Vec3& d) noexcept {
  // The log may also contain the result of this query.
  const bool is_recalled = doubtful_.have_overflowed && doubtful_.count == 0;
  if (is_recalled) return last_entry_ ? last_entry_->steepest : std::nullopt;
  const auto steepest = find_steepest_contact(p, d);
  if (last_entry_) last_entry_->steepest = steepest;
  return steepest;
}

std::optional<FaceContact> SegmentTracer::find_steepest_contact(const Vec3& p,
                                                                const Vec3& d) const {
  std::optional<FaceContact> steepest;
  double least = 0.0;
  for (const FaceRef& face : std::span(doubtful_.faces).first(doubtful_.count)) {
    const FaceContact contact = nearest_contact(face, p);
    const double approach = contact.normal.dot(d);
    if (contact.clearance_m > scale_.stop_m || approach >= 0.0 || approach > least) continue;
    // Faces that share the touched feature are equally steep: the lowest FaceRef counts.
    if (steepest && approach == least && steepest->face < face) continue;
    least = approach;
    steepest = contact;
  }
  return steepest;
}

}  // namespace palpate
