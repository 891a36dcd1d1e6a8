#pragma once

// The intermediate results of a search that ran out of work, kept for the next tick.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "haptics/proxy/contact.h"

namespace palpate {

// Identifies a query for the first obstacle between two points. Two keys are equal only if their
// points are equal bit for bit.
struct TraceKey {
  static constexpr std::uint32_t kNoBody = ~std::uint32_t{0};

  Vec3 p, q;                         // solver frame, m; body frame of `only` if that is set
  std::uint32_t left_out = kNoBody;  // moving body that the query ignores
  std::uint32_t only = kNoBody;      // the only body that the query tests

  friend bool operator==(const TraceKey& a, const TraceKey& b) {
    return a.p == b.p && a.q == b.q && a.left_out == b.left_out && a.only == b.only;
  }
};

// The triangles that a trace could not rule out in single precision, up to kMost of them.
struct DoubtfulTriangles {
  static constexpr std::size_t kMost = 64;

  std::array<FaceRef, kMost> faces;
  std::size_t count = 0;
  bool have_overflowed = false;

  void clear() {
    count = 0;
    have_overflowed = false;
  }
  void add(const FaceRef& face) {
    if (count == kMost) {
      have_overflowed = true;
    } else {
      faces[count++] = face;
    }
  }
};

// The position of a search in its fixed order. The bodies at rest come first, in ascending order.
// Then come the moving bodies, in the order in which they first moved. Within a body, its packs are
// in ascending order.
struct TraceCursor {
  bool is_among_moving = false;
  bool is_resumed = false;
  std::uint32_t body = 0;  // body number; if is_among_moving, position in LiveWorld::moving()
  std::uint32_t pack = 0;  // first pack of that body that has not been tested

  // Moves the cursor to the first body.
  void begin() {
    is_among_moving = false;
    body = pack = 0;
  }
};

// The state of a trace that was cut short.
struct TraceProgress {
  TraceKey key;
  double look = 1.0;  // fraction of the step that the search covers; it grows up to 1
  TraceCursor cursor{};
  std::optional<TraceHit> best{};          // earliest hit so far
  std::optional<TraceHit> best_at_rest{};  // earliest hit among all bodies at rest, once known
  DoubtfulTriangles doubtful{};
};

// The traces of one step of the god-object with their results, in the order of the queries. If a
// step is cut short, the next tick repeats it from its beginning and makes the same queries. The
// log answers a query only if the key of the query equals the logged key bit for bit.
//
// No allocation, lock or exception after construction. Not thread-safe: one thread owns a log.
class TraceLog {
 public:
  struct Entry {
    TraceKey key;
    std::optional<TraceHit> hit;
    std::optional<FaceContact> steepest;  // result of SegmentTracer::steepest_contact()
  };

  explicit TraceLog(std::size_t capacity) { entries_.reserve(capacity); }

  bool is_empty() const { return entries_.empty(); }
  bool has_answers() const { return next_ < entries_.size(); }

  void clear() {
    entries_.clear();
    next_ = 0;
  }
  // Returns to the first entry. If the previous repetition did not use all entries, the log is
  // cleared, because this repetition would not use them either.
  void rewind() {
    if (has_answers()) entries_.clear();
    next_ = 0;
  }
  // The next entry, or null if its key differs.
  Entry* recall(const TraceKey& key) {
    if (!has_answers() || !(entries_[next_].key == key)) return nullptr;
    return &entries_[next_++];
  }
  // Appends an entry. Returns null if the log is full or if entries of the previous run are still
  // unused.
  Entry* note(const TraceKey& key, const std::optional<TraceHit>& hit) {
    if (has_answers() || entries_.size() == entries_.capacity()) return nullptr;
    entries_.push_back({key, hit, std::nullopt});
    ++next_;
    return &entries_.back();
  }

 private:
  std::vector<Entry> entries_;
  std::size_t next_ = 0;
};

}  // namespace palpate
