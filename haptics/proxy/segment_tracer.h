#pragma once

// Continuous collision of the proxy along a straight step.

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
#include "haptics/proxy/work.h"

namespace palpate {

// Answers "how far can the proxy go" against every triangle of a world. Points and spheres.
//
// A step is the segment between two points given in double, the very ones that will be committed. A
// step without a hit is certified: no triangle touches the swept proxy, exactly for a point, up to
// rounding bounds that err on the side of a hit for a sphere. A point and a triangle are taken in
// the frame of the body, or in the solver frame where the body has corners there
// (solver_corners.h).
//
// Triangles are taken from the cached packs around the proxy while the step stays in their safe
// zone, and from a segment query otherwise; of bodies that move, always from one. Packs are asked
// sixteen triangles at a time in single precision; what that cannot rule out is decided in double.
//
// A tick's work is counted (work.h). A search that its budget does not suffice for is cut short: it
// answers that the step is stopped where it starts, by nothing that has a name, and so does each
// one after it. Asked for the same again in the next tick, it goes on from there.
//
// No allocation, lock or exception. One instance serves one thread.
class SegmentTracer {
 public:
  // The world must outlive the tracer. radius_m >= 0; the world's indices must have been built for
  // sweeps of at least radius_m + the stand-off.
  SegmentTracer(const LiveWorld& world, double radius_m, const Accuracy& accuracy = {});

  // What a search is for. What was cut short is kept for each of them.
  enum class Errand : std::uint8_t { kMove, kPush };

  // A new tick, with all of its budget.
  void begin_tick() noexcept {
    if (has_memory_) [[unlikely]]
      has_memory_ = remembers();
    work_.begin_tick();
    is_cut_short_ = false;
  }
  // Whether a search of this tick has been cut short. It knows nothing of what it was asked.
  bool is_cut_short() const { return is_cut_short_; }
  const WorkMeter& work() const { return work_; }

  void begin_errand(Errand errand) noexcept {
    memory_ = memories_[static_cast<std::size_t>(errand)].get();
  }
  // The traces from now on are of another step.
  void begin_step() noexcept {
    if (has_memory_) [[unlikely]]
      memory_->log.clear();
  }
  // The traces from now on are those of the step that was cut short, from its beginning.
  void repeat_step() noexcept { memory_->log.rewind(); }
  // The trace that was cut short, or null.
  const TraceKey* unfinished() const {
    return memory_->progress ? &memory_->progress->key : nullptr;
  }
  bool is_unfinished_among_moving() const {
    return memory_->progress && memory_->progress->cursor.is_among_moving;
  }
  // A body has been put elsewhere, or the proxy has: what was asked before will not be asked again.
  void forget_steps() noexcept;
  // A body that moves already has moved on.
  void forget_moving() noexcept {
    if (has_memory_) forget_moving_searches();
  }

  // The first obstacle of the proxy on its way from p to q.
  std::optional<TraceHit> trace(const Vec3& p, const Vec3& q) noexcept;

  // The same for a shorter step along the last one traced, from the same p.
  std::optional<TraceHit> trace_part(const Vec3& p, const Vec3& q) noexcept;

  // The first obstacle in one body alone, of a proxy that goes from p to q in the body frame,
  // whatever moves.
  std::optional<TraceHit> trace_in_body(std::uint32_t body, const Vec3& p_body,
                                        const Vec3& q_body) noexcept;

  // The first obstacle on the way from p to q in all bodies but one, which moves.
  std::optional<TraceHit> trace_others(std::uint32_t body, const Vec3& p, const Vec3& q) noexcept;

  // To be told when a body moves for the first time.
  void forget_candidates() noexcept {
    cache_.forget();
    forget_steps();
  }

  // Whether there is certainly nothing on the way from p to q.
  bool is_free(const Vec3& p, const Vec3& q) const noexcept {
    return accuracy_.reuse_candidates && cache_.is_empty() && cache_.covers(p, q) &&
           world_->moving().empty();
  }

  // Told at the end of a tick that moved the proxy by `step` to p. A tick that was cheap is a good
  // moment to look for the candidates that the next ones will need.
  void look_ahead(const Vec3& p, const Vec3& step, bool was_cheap) noexcept;

  // Whether a point is beside a face by more than reach_m (is_far_beside). Not for a sphere.
  bool is_far_beside_face(const FaceRef& face, const Vec3& p, double reach_m) const noexcept {
    const ContactBody& body = world_->body(face.body);
    return is_far_beside(made_.of(body, face), body.to_body(p), body.length_to_body(reach_m));
  }

  // The contact of a proxy at p with the place of a face that is nearest to it.
  FaceContact nearest_contact(const FaceRef& face, const Vec3& p) const noexcept;

  // The unit direction of the edge that is touched, of a contact with one.
  Vec3 edge_direction(const FaceContact& contact) const noexcept;

  // The same, but for a point that is rather over the face than beside it (is_rather_over), which
  // is held by its plane. On the side given by the earlier normal where p cannot tell.
  FaceContact contact_at(const FaceRef& face, const Vec3& p, const Vec3& side) const noexcept;

  // The same of a point that is known to be over the face.
  FaceContact contact_over(const FaceRef& face, const Vec3& p, const Vec3& side) const noexcept;

  // A point at p has slid off a face, on its way to the goal q. The contact with a face of the same
  // pack that it is over now, and q behind, if there is one: nothing says that the way there is
  // free. Not for a sphere.
  std::optional<FaceContact> contact_over_next(const FaceRef& left, const Vec3& p,
                                               const Vec3& q) noexcept;

  // Point: true iff p lies over the face, in its prism. Sphere: true iff it is still touching.
  bool is_over(const FaceContact& contact, const Vec3& p) const noexcept;

  // Contacts of a point at p with the faces closer than reach_m, the nearest if there is not room
  // for all, in no order: seen from their fronts, or from where p is. Return how many were written.
  std::size_t contacts_in_front(const Vec3& p, double reach_m,
                                std::span<FaceContact> contacts) noexcept;
  std::size_t contacts_around(const Vec3& p, double reach_m,
                              std::span<FaceContact> contacts) noexcept;

  // Of the faces that the last step traced came near to, the contact that the proxy at p has
  // already and that a step along d leads against most steeply. Nothing if there is none.
  std::optional<FaceContact> steepest_contact(const Vec3& p, const Vec3& d) noexcept;

  const SolverScale& scale() const { return scale_; }
  double radius_m() const { return radius_m_; }

  // Whether a point is stopped by the corners that a body has in the solver frame
  // (solver_corners.h). Contacts are taken in the frame of the body all the same, which may be
  // kMostApartPerStandOff apart.
  bool decides_by_corners(const ContactBody& body) const {
    return body.corners && radius_m_ == 0.0 && !is_in_float_;
  }

 private:
  struct Search;

  void forget_moving_searches() noexcept;

  // What one errand has found out so far.
  struct Memory {
    explicit Memory(std::size_t capacity) : log(capacity) {}

    TraceLog log;
    std::optional<TraceProgress> progress;  // of the trace that was cut short last
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
  // Whether there may be an answer, or no work left to find one.
  bool asks_memory() const { return has_memory_ || work_.is_spent(); }
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
  // For queries of the world's tree, whose float margins cover a point's clearance.
  double sweep_radius_m() const { return radius_m_ == 0.0 ? 0.0 : reach_m(); }

  const LiveWorld* world_;
  double radius_m_;
  Accuracy accuracy_;
  bool is_in_float_;
  SolverScale scale_;
  MadeTriangles made_;
  CandidateCache cache_;
  Vec3 motion_ = Vec3::Zero();  // of the proxy in the last tick
  int refills_ = 0;             // of the cache, in this tick
  WorkMeter work_;
  WorkUnits noted_from_;  // traces are noted when a tick has done so much
  bool is_cut_short_ = false;
  bool may_stop_around_ = false;  // the search for contacts around a point

  bool has_memory_ = false;                          // there may be something in one of these
  std::array<std::unique_ptr<Memory>, 2> memories_;  // of each errand
  Memory* memory_;                                   // of the present one
  TraceLog::Entry* last_entry_ = nullptr;            // of the last trace, if the log has it

  // Of the last trace(), for trace_part().
  DoubtfulTriangles doubtful_;
};

}  // namespace palpate
