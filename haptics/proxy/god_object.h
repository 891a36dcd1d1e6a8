#pragma once

// The god-object: the proxy that stays on the surface while the device point goes into it.

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "haptics/proxy/accuracy.h"
#include "haptics/proxy/friction_cone.h"
#include "haptics/proxy/live_world.h"
#include "haptics/proxy/plane_projection.h"
#include "haptics/proxy/proxy_state.h"
#include "haptics/proxy/segment_tracer.h"

namespace palpate {

struct GodObjectSettings {
  double radius_m = 0.0;  // 0: a point
  Accuracy accuracy = {};
};

// What a god-object under friction asks at the faces that it touches.
class FrictionCones {
 public:
  virtual FrictionCone at(const FaceContact& contact, const Vec3& proxy) noexcept = 0;

 protected:
  ~FrictionCones() = default;
};

struct FrictionSource {
  FrictionCones& cones;
  // The size of the coordinates that the goal was made from, if larger than its own: it is rounded
  // as they are. Finite, >= 0: no move is made otherwise (ProxyState::is_refused).
  double coordinates_m = 0.0;
};

// Where a body is to be. Solver frame.
struct BodyMotion {
  std::uint32_t body = 0;
  RigidTransform T_solver_body;
};

// The constraint-based proxy of Zilles & Salisbury (1995) for triangle soup, two-sided, converged
// within the tick: it moves to a local minimum of the distance to the goal along a path that it
// collides along continuously with every triangle (SegmentTracer). Each piece of the path that it
// commits is certified free, and so is the place where it rests.
//
// A local minimum: a tick that is not capped leaves no way on. A way is a straight segment from the
// proxy that crosses no triangle, that never comes nearer to one, but for rounding, than the
// smaller of its distance at the start and one stand-off (SolverScale; of a sphere, the distance
// less the radius), that keeps to the plane of motion if there is one, and that ends nearer to the
// goal by more than 1e-9 of the scene's size. Under friction, slides along what is touched count as
// far as the lag along them exceeds what friction holds. Not for Accuracy::fast().
//
// Capped: the tick ran out of steps, or of work (below); or a point is between faces that are
// nearly parallel, where rounding decides whether a way leads on; or what a point has met last
// tells nothing new, and no way that is tried leads on. The proxy is where a longer tick would have
// come through, free and no farther from the goal than before; the faces that it has met are known
// to the next tick, which goes on from there.
//
// Work: a tick is a call of move_to() with the one of move_bodies() before it, if any. What it does
// is counted (work.h), and ends where Accuracy::work_budget does. The proxy is where the last step
// that was finished has led, no farther from the goal than it was; a body whose push is not
// finished is where it was. The next tick goes on with the search that was cut short, and with all
// that was found: for the goal of then, or, as long as the step is of use for it, for the one that
// it was begun for. Pushes begin as long as half of the budget is left, and a move that was cut
// short for the other half has the next tick for itself.
//
// A proxy that starts within a stand-off of a triangle, or as a sphere overlaps one, may leave it
// or keep its distance, and comes no nearer: place() lifts a point off what it is put on.
//
// Monotone: no tick increases the distance to the goal by more than rounding, capped or not; with a
// fixed mesh this gives the energy certificate of a passive spring. Within a tick no piece of a
// point's path does; a sphere's may on its way round something, by less than 1 % of the radius.
//
// Whatever it is given that is not finite, or so far away that squares of lengths overflow, changes
// nothing, and is told by what the call returns. With settings that check_settings() has an Error
// for, it refuses every call so, and asks nothing of the world.
//
// No allocation, lock or exception after construction. Not thread-safe: one thread owns it.
class GodObject {
 public:
  // The surfaces of the world must outlive the god-object, which has poses of its own for them.
  GodObject(const ContactWorld& world, const GodObjectSettings& settings);
  // What has been moved from is only to be destroyed.
  GodObject(GodObject&&) noexcept;
  GodObject& operator=(GodObject&&) noexcept;
  ~GodObject();

  // Puts the proxy at p. If that is within a stand-off of the surface, where sides cannot be told,
  // it is lifted to the front of the faces there by as much. False if p is refused.
  bool place(const Vec3& p) noexcept;

  // Moves a body wherever the proxy is: for a proxy that has not been placed yet. False if too many
  // bodies move already, or if it is refused: what is no pose (is_pose), or no body of the world.
  bool place_body(std::uint32_t body, const RigidTransform& T_solver_body) noexcept;

  // Moves bodies, at most LiveWorld::kMostMoving, each straight to its new pose as far as the proxy
  // is concerned, which they push out of their way (push_proxy): within a plane of motion, if its
  // normal (unit) is given. Returns how many were held back because there was no room for it, or
  // not enough work left, or refused; with a normal that is none, all are. The next move_to() goes
  // on from there, in the same tick.
  std::size_t move_bodies(std::span<const BodyMotion> motions,
                          const std::optional<Vec3>& motion_plane_normal = std::nullopt) noexcept;

  // Moves the proxy towards goal. Given motion_plane_normal (unit), proxy and goal both keep to the
  // plane through the goal with that normal, and contact normals are the in-plane ones. A goal that
  // is refused changes nothing, not even contacts() and path(): ProxyState::is_refused.
  ProxyState move_to(const Vec3& goal,
                     const std::optional<Vec3>& motion_plane_normal = std::nullopt) noexcept;

  // The same under Coulomb's friction (Harwin and Melder 2002): of each step along what it touches,
  // the proxy takes only what the cone does not hold. With s where it would go, d = |s - goal| the
  // depth and t = s - proxy, a contact sticks or slides:
  //
  //   sticking   while |t| <= mu_s d, the proxy keeps its place; otherwise it moves along t until
  //              |t| = mu_k d, and slides
  //   sliding    while |t| > mu_k d, it moves along t until |t| = mu_k d, and slides on; where they
  //              are equal it keeps its place, and slides on; where |t| is less it keeps its place,
  //              and sticks
  //
  // all within rounding (kConeRoundoff). Places are kept to the bit. A new contact sticks. The
  // state goes with the contact over edges, from face to face and from body to body; it ends with
  // the contact, with place() and move_to(), and with end_friction(). So a hand that goes on at one
  // depth feels mu_k in every tick, however slowly and whether the hand moves or what it touches;
  // one that turns back, or presses deeper faster than its lag grows, sticks.
  //
  // Part of a step is as free as the whole, and no farther from the goal than its start: the
  // certificates hold as they do without friction.
  //
  // Of several faces, each holds by what it bears: mu_1 d_1 + mu_2 d_2 + ... . A sphere goes round
  // edges along tangents.
  ProxyState move_with_friction(const Vec3& goal, const std::optional<Vec3>& motion_plane_normal,
                                const FrictionSource& friction) noexcept;

  // Whatever is touched is touched anew, as far as friction goes: it sticks. For a tick that gave
  // no force.
  void end_friction() noexcept { slides_ = false; }

  const Vec3& proxy() const { return proxy_; }
  // The faces that hold the proxy, at most three, and the unit normals of their planes, which lie
  // in the plane of motion if there is one. Valid until the next move.
  std::span<const FaceContact> contacts() const {
    return std::span(last_contacts_).first(static_cast<std::size_t>(last_active_count_));
  }
  const Vec3& plane_normal(std::size_t i) const {
    return planes_of_contact_[static_cast<std::size_t>(projection_.active[i])].normal;
  }
  ContactView contact() const {
    return {*world_, contacts(), planes_of_contact_, projection_.active};
  }
  // The corners of the polyline that the last move_to() committed, from where the proxy was to
  // where it is. Solver frame, metres. Valid until the next call.
  std::span<const Vec3> path() const { return path_; }
  const SolverScale& scale() const { return tracer_.scale(); }
  const LiveWorld& world() const { return *world_; }
  double radius_m() const { return settings_.radius_m; }
  bool has_bad_settings() const { return has_bad_settings_; }

 private:
  enum class Progress : std::uint8_t {
    kMoved,    // as near as the present planes allow
    kHeld,     // it is there already
    kStopped,  // met another face on the way
    kStuck     // no use going on with these planes
  };

  // Finite, and so near that squares of lengths are.
  bool is_goal(const Vec3& goal, const std::optional<Vec3>& motion_plane_normal) const {
    return !has_bad_settings_ && std::isfinite((goal - proxy_).squaredNorm()) &&
           (!motion_plane_normal || is_unit(*motion_plane_normal));
  }
  bool is_motion(std::uint32_t body, const RigidTransform& T_solver_body) const;
  ProxyState refused() const;
  void update_bounds();
  bool move_body(const BodyMotion& motion, const std::optional<Vec3>& motion_plane_normal) noexcept;
  bool push_all(std::span<const BodyMotion> motions,
                const std::optional<Vec3>& motion_plane_normal) noexcept;
  bool finishes_push(std::span<const BodyMotion> motions,
                     const std::optional<Vec3>& motion_plane_normal) noexcept;
  std::size_t count_not_there(std::span<const BodyMotion> motions) const;
  void begin_tick() {
    if (!bodies_have_moved_) tracer_.begin_tick();
    bodies_have_moved_ = false;
    work_of_bodies_ = tracer_.work().used();
    tracer_.begin_errand(SegmentTracer::Errand::kMove);
  }
  template <typename Friction>
  ProxyState stay(Friction& friction);
  template <typename Friction>
  void finish_last_step(Friction& friction);
  void keep_step_for_next_tick();
  ProxyState move_freely();
  void seed_from_last_tick();
  // Friction is a policy: NoFriction, or what move_with_friction() makes of its source. Defined in
  // god_object_steps.h.
  template <typename Friction>
  ProxyState move(const Vec3& goal, const std::optional<Vec3>& motion_plane_normal,
                  Friction& friction);
  template <typename Friction>
  void name_what_holds(Friction& friction);
  template <typename Friction>
  Progress take_step(Friction& friction);
  std::optional<Progress> stop_at_first_hit(const Vec3& target);
  bool is_off_planes() const;
  bool touches_planes() const;
  Vec3 way_to_planes() const;
  bool roll_to_answer();
  // A tenth of what a way has to gain: a way that gains so little is none, and neither is a step of
  // a slow proxy, nor a turn of a sphere.
  static constexpr double kLittlePerStandOff = 10.0;
  double little_m() const { return kLittlePerStandOff * scale().stand_off_m; }
  // In one tick a proxy comes to where it stays; over several ones, to where a way gains little: in
  // a flat valley that is far away.
  bool is_little(const Vec3& step) const {
    return goal_waits_ ? !may_gain_by(step) : step.norm() <= little_m();
  }
  bool is_none(const Vec3& step) const {
    return step.squaredNorm() <= step_tolerance_m_ * step_tolerance_m_;
  }
  template <typename Friction>
  bool hold_by(Friction& friction);
  template <typename Friction>
  bool stays_at_rest(Friction& friction);
  bool has_friction() const { return last_holds_[0] || last_holds_[1] || last_holds_[2]; }
  bool is_carried_by(std::uint32_t body) const;
  void add_if_touched(const FaceContact& met);
  void update_planes();
  template <typename Friction>
  void go_on_over_next_face(const Friction& friction);
  template <typename Friction>
  int overreach(Progress progress, int most_steps, Friction& friction);
  double reach_of(const Vec3& slide);
  template <typename Friction>
  int leap(int most_steps, Friction& friction);
  struct Attempt {
    int steps = 0;
    double beyond_m = 0.0;
    bool is_nearer = false;
  };
  template <typename Friction>
  Attempt fall_from_beyond(const Vec3& way, int most_steps, Friction& friction);
  bool roll_between_last_two();
  bool roll_between(const FaceContact& one, const FaceContact& other);
  bool goes_round(const FaceContact& from, FaceContact& to, double reach);
  void become_slow();
  void limit_detours();
  double part_free(std::span<const Vec3> corners);
  struct ProxyPlace;
  ProxyPlace place_now() const;
  void return_to(const ProxyPlace& place);
  // Defined in god_object_ways.h.
  struct Faces;
  struct Surroundings;
  template <typename Friction>
  bool leaves_edges(Progress progress, Friction& friction);
  template <typename Friction>
  bool leaves_wedge(Friction& friction);
  template <typename Friction>
  bool slides_without_edges(const Faces& holding, Friction& friction);
  template <typename Friction>
  bool slides_up_to_what_holds(Friction& friction);
  template <typename Friction>
  bool slides_by(const Vec3& along, const FaceContact& face, Friction& friction);
  template <typename Friction>
  bool slides_past(Friction& friction);
  template <typename Friction>
  bool slides_between(Friction& friction);
  template <typename Friction>
  bool follows(const Vec3& step, std::span<const FaceContact> contacts, Friction& friction);
  template <typename Friction>
  bool slides_at_vertex(Friction& friction);
  template <typename Friction>
  bool lifts_and_slides(std::span<const FaceContact> pair, std::span<const FaceContact> nearest,
                        Friction& friction);
  template <typename Friction>
  bool slides_along(std::span<const FaceContact> contacts, Friction& friction);
  template <typename Friction>
  bool goes_past_obstacles(Friction& friction);
  template <typename Friction>
  bool goes_along_lines(Friction& friction);
  template <typename Friction>
  bool goes_along_line(const Vec3& step, Friction& friction);
  template <typename Friction>
  bool goes_between(Vec3 blocked, Vec3 free, Friction& friction);
  template <typename Friction>
  bool goes_straight(const Vec3& step, Friction& friction,
                     std::optional<TraceHit>* obstacle = nullptr);
  template <typename Friction, typename Step>
  bool tries(Friction& friction, Step step);
  static bool is_beside_face(const FaceContact& contact) {
    return contact.feature != TriangleFeature::kFace;
  }
  bool is_gain(const Vec3& from, const Vec3& to) const;
  bool may_gain_by(const Vec3& step) const {
    return step.allFinite() && is_gain(proxy_, proxy_ + step);
  }
  void look_around();
  FaceContact contact_of_nearest(const FaceRef& face) const;
  bool is_touched_face(const FaceContact& contact) const;
  bool is_held_by(std::span<const FaceContact> holding) const;
  bool is_held_by_faces();
  double place_roundoff_m() const;
  Faces holding_faces() const;
  bool falls_to_none(const Vec3& step, std::span<const FaceContact> touched) const;
  bool is_stopped_by_rounding(const Vec3& step);
  void hold_by_most_violated(std::span<const FaceContact> contacts);
  bool is_at_vertex(std::span<const FaceContact> contacts) const;
  Vec3 lift_above(std::span<const FaceContact> faces, std::span<const FaceContact> nearest) const;
  std::optional<Vec3> in_motion_plane(const Vec3& direction) const;
  Vec3 onto_motion_plane(const Vec3& step) const;
  bool is_same_place(const FaceContact& a, const FaceContact& b) const;
  bool enter_bounds();
  // The target of a step, or where it leaves the world's bounds: there is nothing to touch beyond.
  Vec3 within_bounds(const Vec3& target) const {
    return bounds_.contains(target) ? target : leave_bounds(target);
  }
  Vec3 leave_bounds(const Vec3& target) const;
  bool is_known(const FaceContact& contact, const ContactPlane& plane, int& known) const;
  bool add_plane(const FaceContact& contact);
  void drop_inactive_planes();
  void advance_to(const Vec3& target);
  void commit(const Vec3& proxy);
  bool is_above(const FaceContact& contact) const;
  bool settled() const;
  void keep_contacts_for_next_tick(bool capped);
  ProxyState report(int iterations, bool capped) const;

  bool has_bad_settings_;
  GodObjectSettings settings_;        // the default ones instead of bad ones
  std::unique_ptr<LiveWorld> world_;  // its address is what the tracer keeps
  Box bounds_;                        // nothing is to be touched outside
  SegmentTracer tracer_;
  double step_tolerance_m_;  // a step shorter than this is none: the iteration has converged
  Vec3 proxy_ = Vec3::Zero();
  Vec3 goal_ = Vec3::Zero();
  std::vector<Vec3> path_;  // never grows: its capacity is what the iterations can fill
  std::optional<Vec3> motion_plane_normal_;

  // The planes met, and the contacts they come from.
  std::array<ContactPlane, kMaxContactPlanes> planes_of_contact_{};
  std::array<FaceContact, kMaxContactPlanes> contacts_{};
  int plane_count_ = 0;
  PlaneProjection projection_;
  // Each plane is that of what the proxy touches where it is now.
  bool planes_are_current_ = false;
  bool is_over_next_ = false;  // the plane is that of a face which is not touched yet

  std::span<const ContactPlane> planes() const {
    return std::span(planes_of_contact_).first(static_cast<std::size_t>(plane_count_));
  }

  std::unique_ptr<Surroundings> around_;  // of the proxy where it was when it last looked around

  // Of the present tick.
  double most_lag_m_ = 0.0;              // that a sphere's path may have
  bool is_slow_ = false;                 // more than kPatience steps, or goes on
  bool goal_waits_ = false;              // the last one had this goal, and did not reach it at once
  double last_slide_m_ = 0.0;            // length of the last whole slide along planes
  Vec3 last_slide_from_ = Vec3::Zero();  // where it began
  double overreach_ = 1.0;               // by how much the last one was extended
  Vec3 leap_from_ = Vec3::Zero();        // where the way of the next leap begins
  double leap_reach_ = 1.0;              // of that way, how much farther it goes
  int steps_to_leap_ = 0;
  std::optional<FaceContact> last_round_;  // the feature that a sphere went round last

  bool rounding_decides_ = false;  // whether a way leads on

  bool settled_ = false;    // the last tick ended at a local minimum
  bool confirmed_ = false;  // it was not cut short, and no body has pushed the proxy since
  bool goes_on_ = false;  // it was cut short, or its goal had waited, and this one goes on with it
  // Those that held the proxy first, then others that are worth knowing.
  std::array<FaceContact, kMaxContactPlanes> last_contacts_{};
  int last_count_ = 0;
  std::array<bool, 3> last_holds_{};  // those of them that held the proxy sideways, too
  int last_active_count_ = 0;
  bool slides_ = false;  // the contact of the last tick, under friction

  // Of a tick that was cut short.
  bool repeats_step_ = false;            // the next one begins with the planes of this one
  Vec3 step_from_ = Vec3::Zero();        // where the proxy was when the present step began
  Vec3 step_goal_ = Vec3::Zero();        // what the step was taken for
  Vec3 step_target_ = Vec3::Zero();      // where the trace was to end
  std::optional<BodyMotion> last_push_;  // that was cut short
  std::size_t first_motion_ = 0;         // of the bodies that move, the next to be pushed
  bool bodies_have_moved_ = false;       // in this tick
  WorkUnits work_of_bodies_ = 0;         // in this tick, before the move
  bool move_has_turn_ = false;           // the next tick moves no bodies
};

}  // namespace palpate
