#pragma once

// What a search that was cut short has found out, for the tick that goes on with it.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "haptics/proxy/contact.h"

namespace palpate {

// What was asked: the first obstacle between two points.
struct TraceKey {
  static constexpr std::uint32_t kNoBody = ~std::uint32_t{0};

  Vec3 p, q;  // solver frame, or that of the one body
  std::uint32_t left_out = kNoBody;
  std::uint32_t only = kNoBody;

  friend bool operator==(const TraceKey& a, const TraceKey& b) {
    return a.p == b.p && a.q == b.q && a.left_out == b.left_out && a.only == b.only;
  }
};

// The triangles that a trace could not rule out, as far as there is room.
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

// How far a search has come. Bodies at rest come first, then those that move, each in ascending
// order, and the packs of each, too.
struct TraceCursor {
  bool is_among_moving = false;
  bool is_resumed = false;
  std::uint32_t body = 0;  // of those at rest; of those that move, its place among them
  std::uint32_t pack = 0;  // of that body: all before have been examined

  // To the first of the bodies.
  void begin() {
    is_among_moving = false;
    body = pack = 0;
  }
};

// What a trace that was cut short has found.
struct TraceProgress {
  TraceKey key;
  double look = 1.0;  // the part of the step that is searched, before the rest is
  TraceCursor cursor{};
  std::optional<TraceHit> best{};
  std::optional<TraceHit> best_at_rest{};  // of the bodies at rest, once they are all examined
  DoubtfulTriangles doubtful{};
};

// The traces of one step of the god-object, in the order in which they were asked for. A step that
// was cut short is taken anew from its beginning by the next tick, which asks for the same again:
// to the bit, or it gets no answer from here.
//
// No allocation, lock or exception after construction.
class TraceLog {
 public:
  struct Entry {
    TraceKey key;
    std::optional<TraceHit> hit;
    std::optional<FaceContact> steepest;  // as SegmentTracer::steepest_contact() found it then
  };

  explicit TraceLog(std::size_t capacity) { entries_.reserve(capacity); }

  bool is_empty() const { return entries_.empty(); }
  bool has_answers() const { return next_ < entries_.size(); }

  void clear() {
    entries_.clear();
    next_ = 0;
  }
  // From the beginning again. What the last time did not ask for is forgotten: it will not, either.
  void rewind() {
    if (has_answers()) entries_.clear();
    next_ = 0;
  }
  // The next answer, if that is to what is asked now.
  Entry* recall(const TraceKey& key) {
    if (!has_answers() || !(entries_[next_].key == key)) return nullptr;
    return &entries_[next_++];
  }
  // Null if there is no room, or if answers of the last time are still to come.
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
