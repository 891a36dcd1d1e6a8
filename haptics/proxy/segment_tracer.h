#pragma once

// Continuous collision detection between the proxy, on a straight step, and all triangles of the
// world.

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "geometry/exact/triangle.h"
#include "haptics/proxy/accuracy.h"
#include "haptics/proxy/candidate_cache.h"
#include "haptics/proxy/contact.h"
#include "haptics/proxy/live_world.h"
#include "haptics/proxy/made_triangles.h"
#include "haptics/proxy/trace_log.h"
#include "haptics/proxy/triangle_trace.h"
#include "haptics/proxy/work.h"

namespace palpate {

// Finds the first triangle of a world that stops a point or sphere proxy on a straight step. Points
// are in the solver frame in metres unless a function states another frame.
//
// A step is the segment between two points given in double; the caller commits exactly these
// points. A step without a hit is certified: no triangle touches the swept proxy. For a point the
// certificate is exact; for a sphere it holds up to rounding bounds that err on the side of a hit.
// NarrowPhase::kFloat gives no certificate (float_trace.h).
// A point is tested against a triangle in the frame of the triangle's body, or in the solver frame
// if the body has corners there (solver_corners.h).
//
// While the step stays in the safe zone, candidate triangles are read from the cached packs around
// the proxy (CandidateCache); otherwise a segment query finds them. Bodies that move are always
// searched by a segment query. The 16 triangles of a pack are tested together in single precision;
// triangles that this test cannot rule out are tested in double precision.
//
// The work of a tick is counted (work.h). A search that exceeds the budget is cut short: its result
// is a hit at the start of the step without a valid face. Every later search in the tick has the
// same result. If the next tick makes the same query, the search continues where it stopped.
//
// Safe on the haptic thread: no allocation, lock or exception after construction. Not thread-safe:
// one thread owns an instance.
class SegmentTracer {
 public:
  // The world must outlive the tracer. radius_m >= 0; the world's indices must have been built for
  // sweeps of at least radius_m + the stand-off.
  SegmentTracer(const LiveWorld& world, double radius_m, const Accuracy& accuracy = {});

  // The purpose of a search: a move of the proxy, or its push by a body. Each errand keeps its own
  // interrupted search.
  enum class Errand : std::uint8_t { kMove, kPush };

  // Begins a new tick with its whole budget.
  void begin_tick() noexcept {
    if (has_memory_) [[unlikely]]
      has_memory_ = remembers();
    work_.begin_tick();
    is_cut_short_ = false;
  }
  // Whether a search of this tick was cut short. The results of that search and of all searches
  // after it are then unknown.
  bool is_cut_short() const { return is_cut_short_; }
  const WorkMeter& work() const { return work_; }
  // Adds the work of the solver outside of the searches.
  void count(Work kind, std::size_t count) const noexcept { work_.add_of_solver(kind, count); }

  // Begins the searches for another purpose.
  void begin_errand(Errand errand) noexcept {
    memory_ = memories_[static_cast<std::size_t>(errand)].get();
  }
  // Begins another step: clears the log of traces.
  void begin_step() noexcept {
    if (has_memory_) [[unlikely]]
      memory_->log.clear();
  }
  // Repeats the step that was cut short, from its first trace.
  void repeat_step() noexcept { memory_->log.rewind(); }
  // The key of the trace that was cut short, or null.
  const TraceKey* unfinished() const {
    return memory_->progress ? &memory_->progress->key : nullptr;
  }
  // Whether a trace was cut short while it searched the moving bodies.
  bool is_unfinished_among_moving() const {
    return memory_->progress && memory_->progress->cursor.is_among_moving;
  }
  // Clears all logged and interrupted searches. To be called after a body or the proxy has been
  // placed elsewhere, because earlier queries will then not be repeated.
  void forget_steps() noexcept;
  // Clears the logged searches and the part of an interrupted search that concerns moving bodies.
  // To be called after a body that is already among the moving ones has moved again.
  void forget_moving() noexcept {
    if (has_memory_) forget_moving_searches();
  }

  // The first obstacle of the proxy on the step from p to q, or nullopt if the step is free.
  std::optional<TraceHit> trace(const Vec3& p, const Vec3& q) noexcept;

  // Like trace(), but for a step that is the first part, from p to q, of the last step given to
  // trace().
  std::optional<TraceHit> trace_part(const Vec3& p, const Vec3& q) noexcept;

  // The first obstacle in one body, for a proxy that moves from p_body to q_body in the frame of
  // that body. All other bodies are ignored.
  std::optional<TraceHit> trace_in_body(std::uint32_t body, const Vec3& p_body,
                                        const Vec3& q_body) noexcept;

  // The first obstacle on the step from p to q in all bodies except `body`, which is a moving one.
  std::optional<TraceHit> trace_others(std::uint32_t body, const Vec3& p, const Vec3& q) noexcept;

  // Clears the cached candidates and all searches. To be called when a body moves for the first
  // time.
  void forget_candidates() noexcept {
    cache_.forget();
    forget_steps();
  }

  // Whether the step from p to q is free according to the cache alone. False does not mean that an
  // obstacle exists.
  bool is_free(const Vec3& p, const Vec3& q) const noexcept {
    return accuracy_.reuse_candidates && cache_.is_empty() && cache_.covers(p, q) &&
           world_->moving().empty();
  }

  // To be called at the end of a tick that moved the proxy by `step` to p. If the tick was cheap,
  // the tracer refills the cache for the next ticks.
  void look_ahead(const Vec3& p, const Vec3& step, bool was_cheap) noexcept;

  // Whether a point proxy at p is farther than reach_m beside a face (is_far_beside). Not for a
  // sphere.
  bool is_far_beside_face(const FaceRef& face, const Vec3& p, double reach_m) const noexcept {
    const auto [frame, t] = seat_of(face);
    return is_far_beside(t, frame.to_body(p), frame.length_to_body(reach_m));
  }

  // The contact of a proxy at p with the point of the face that is nearest to p. Its normal is the
  // direction from that point to p.
  FaceContact nearest_contact(const FaceRef& face, const Vec3& p) const noexcept;

  // The normal of a contact with an edge, without its component along the edge. At a stand-off from
  // the edge, rounding of the nearest point gives a unit normal such a component of up to 1e-5.
  Vec3 across_edge(const FaceContact& contact) const noexcept {
    const Vec3 edge = edge_direction(contact);
    return (contact.normal - contact.normal.dot(edge) * edge).normalized();
  }

  // The unit direction of the edge that the contact touches. Only for contacts with an edge.
  Vec3 edge_direction(const FaceContact& contact) const noexcept;

  // The contact of a proxy at p with a face. The result is nearest_contact(), except for a point
  // proxy that is over the face rather than beside it (is_rather_over). The plane of the face holds
  // such a point. If p is so close to the plane that its side is uncertain, the side is that of
  // `side`, an earlier normal.
  FaceContact contact_at(const FaceRef& face, const Vec3& p, const Vec3& side) const noexcept;

  // The contact of a point at p with the plane of a face; the point must be over the face. The
  // normal is on the side of `side`.
  FaceContact contact_over(const FaceRef& face, const Vec3& p, const Vec3& side) const noexcept;

  // For a point at p that has slid off the face `left` towards the goal q: its contact with the
  // face that it is over now. This is the nearest face of the same pack that lies between p and q
  // and has p in its prism. Nullopt if no such face exists. The step to that face is not traced.
  // Not for a sphere.
  std::optional<FaceContact> contact_over_next(const FaceRef& left, const Vec3& p,
                                               const Vec3& q) noexcept;

  // For a point: whether p lies over the face, in its prism. For a sphere: whether the sphere still
  // touches the face.
  bool is_over(const FaceContact& contact, const Vec3& p) const noexcept;

  // Both functions write the contacts of a point at p with the planes of the faces closer than
  // reach_m, in no particular order, and return the number of contacts written. If `contacts` is
  // too short for all, they write the nearest ones. contacts_in_front() uses the normals of the
  // faces, so that a clearance is negative behind a face; contacts_around() uses normals on the
  // side of p.
  std::size_t contacts_in_front(const Vec3& p, double reach_m,
                                std::span<FaceContact> contacts) noexcept;
  std::size_t contacts_around(const Vec3& p, double reach_m,
                              std::span<FaceContact> contacts) noexcept;

  // Considers those faces near the last traced step that the proxy at p already touches. Returns
  // the contact with the face that a step along d approaches most steeply, or nullopt if d
  // approaches none of them.
  std::optional<FaceContact> steepest_contact(const Vec3& p, const Vec3& d) noexcept;

  const SolverScale& scale() const { return scale_; }
  double radius_m() const { return radius_m_; }

  // Whether the body's corners in the solver frame decide where a point is stopped
  // (solver_corners.h).
  bool decides_by_corners(const ContactBody& body) const {
    return body.corners && radius_m_ == 0.0 && !is_in_float_;
  }
  // Whether contacts with the body are computed with these corners, too.
  bool has_contacts_at_corners(const ContactBody& body) const {
    return decides_by_corners(body) && body.corners->are_for_contacts();
  }
  // Whether contacts with the body are those with the triangles by which steps are decided. If not,
  // they are computed in the body frame, whose corners may lie up to kMostApartPerStandOff
  // stand-offs from those in the solver frame.
  bool has_deciding_contacts(const ContactBody& body) const {
    return !decides_by_corners(body) || has_contacts_at_corners(body);
  }

 private:
  struct Search;

  // The triangle with which contacts of a face are computed, and its frame. The references are
  // valid until the next call.
  struct Seat {
    const ContactBody& frame;
    const TriangleGeometry& triangle;
  };
  Seat seat_of(const FaceRef& face) const noexcept {
    const ContactBody& body = world_->body(face.body);
    if (has_contacts_at_corners(body)) [[unlikely]]
      return {solver_frame_, made_at_corners_.at_corners(body, face)};
    return {body, made_.of(body, face)};
  }

  void forget_moving_searches() noexcept;

  // The stored results of one errand.
  struct Memory {
    explicit Memory(std::size_t capacity) : log(capacity) {}

    TraceLog log;
    std::optional<TraceProgress> progress;  // state of the trace that was cut short last
  };

  std::optional<TraceHit> answer(const TraceKey& key) noexcept;
  std::optional<TraceHit> recall_or_find(const TraceKey& key, bool is_part) noexcept;
  void finish(const TraceKey& key, std::optional<TraceHit>& hit, bool was_cut_short) noexcept;
  std::optional<TraceHit> find(const TraceKey& key) noexcept;
  std::optional<TraceHit> find_among_candidates(const Vec3& p, const Vec3& q,
                                                std::uint32_t left_out) noexcept;
  std::optional<TraceHit> find_in_index(const TraceKey& key) noexcept;
  std::optional<TraceHit> find_part(const Vec3& p, const Vec3& q) noexcept;
  std::optional<TraceHit> go_on(TraceProgress& progress) noexcept;
  void cut_short(const TraceProgress& progress) noexcept;
  bool remembers() const noexcept;
  // Whether a trace must consult the stored results: they may have its answer, or the budget is
  // spent.
  bool must_consult_memory() const { return has_memory_ || work_.is_spent(); }
  // Adds the work of a query for packs.
  void count(const QueryWork& query) noexcept {
    work_.add(Work::kPackListed, query.listed);
    work_.add(Work::kSorted, query.sorted);
    work_.add(Work::kBoxes, query.boxes);
  }
  void count(const TriangleWork& triangle) noexcept {
    work_.add(Work::kTriangle);
    work_.add(Work::kSignByPairs, static_cast<std::size_t>(triangle.signs.by_pairs));
    work_.add(Work::kSignByZeros, static_cast<std::size_t>(triangle.signs.by_zeros));
    work_.add(Work::kSignByExpansions, static_cast<std::size_t>(triangle.signs.by_expansions));
    work_.add(Work::kNearestPoint, static_cast<std::size_t>(triangle.nearest_points));
  }
  double first_look(const Vec3& p, const Vec3& q) const;
  bool search_candidates(Search& search) noexcept;
  bool search_all(Search& search, TraceCursor& cursor, const TraceKey& key,
                  std::optional<TraceHit>* best_at_rest) noexcept;
  bool search_resting(Search& search, TraceCursor& cursor) noexcept;
  bool search_moving(Search& search, TraceCursor& cursor, std::uint32_t left_out) noexcept;
  bool search_body(Search& search, TraceCursor& cursor) noexcept;
  template <typename Visitor>
  void visit_contacts(std::uint32_t body, const Vec3& p, double reach_m, std::size_t& packs_left,
                      const Visitor& visit) noexcept;
  std::optional<FaceContact> find_steepest_contact(const Vec3& p, const Vec3& d) const;
  double reach_m() const { return radius_m_ + scale_.stand_off_m; }
  // The sweep radius for queries of the world's tree. It is 0 for a point, since the tree's float
  // margins cover a point's clearance.
  double sweep_radius_m() const { return radius_m_ == 0.0 ? 0.0 : reach_m(); }

  const LiveWorld* world_;
  double radius_m_;
  Accuracy accuracy_;
  bool is_in_float_;
  SolverScale scale_;
  MadeTriangles made_;
  MadeTriangles made_at_corners_;
  // Stands for the frame of corners, in which a point needs no transformation.
  ContactBody solver_frame_{nullptr, {}, true};
  CandidateCache cache_;
  Vec3 motion_ = Vec3::Zero();  // motion of the proxy in the last tick
  int refills_ = 0;             // refills of the cache in this tick
  mutable WorkMeter work_;      // mutable: contacts are computed in const functions
  WorkUnits noted_from_;        // traces are logged once a tick has done this much work
  bool is_cut_short_ = false;
  bool may_stop_around_ = false;  // whether a search for contacts around a point may be cut short

  bool has_memory_ = false;                          // whether memories_ may hold anything
  std::array<std::unique_ptr<Memory>, 2> memories_;  // one for each errand
  Memory* memory_;                                   // that of the present errand
  TraceLog::Entry* last_entry_ = nullptr;            // entry of the last trace, if it is logged

  // The candidates of the last trace() that single precision could not rule out, for trace_part().
  DoubtfulTriangles doubtful_;
};

}  // namespace palpate
