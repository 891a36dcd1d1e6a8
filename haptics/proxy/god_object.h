#pragma once

// The god-object: a proxy that stays on the surface while the device point penetrates it.

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "geometry/base/result.h"
#include "haptics/proxy/accuracy.h"
#include "haptics/proxy/friction_cone.h"
#include "haptics/proxy/interrupted_work.h"
#include "haptics/proxy/live_world.h"
#include "haptics/proxy/motion_plane.h"
#include "haptics/proxy/plane_projection.h"
#include "haptics/proxy/proxy_rest.h"
#include "haptics/proxy/proxy_state.h"
#include "haptics/proxy/proxy_step.h"
#include "haptics/proxy/segment_tracer.h"
#include "haptics/proxy/slide_extrapolation.h"

namespace palpate {

class AnisotropicNorm;
struct RollArc;

struct GodObjectSettings {
  double radius_m = 0.0;  // 0: a point
  Accuracy accuracy = {};
};

// Provides the friction coefficients of the faces that a god-object touches.
class FrictionCones {
 public:
  // The coefficients at a contact of a proxy at `proxy` (solver frame, m). Called on the haptic
  // thread: must not allocate, lock or throw.
  virtual FrictionCone at(const FaceContact& contact, const Vec3& proxy) noexcept = 0;

 protected:
  ~FrictionCones() = default;
};

struct FrictionSource {
  FrictionCones& cones;
  // The magnitude, m, of the coordinates from which the goal was computed, if it is larger than
  // that of the goal. The rounding of the goal depends on this magnitude. Finite, >= 0; otherwise
  // the move is refused (ProxyState::is_refused).
  double coordinates_m = 0.0;
};

// The constraint-based proxy of Zilles & Salisbury (1995) for a soup of two-sided triangles. In
// each tick the proxy moves to a local minimum of the distance to the goal. Every straight piece of
// its path is tested against all triangles by continuous collision detection (SegmentTracer). Each
// piece and the position where the proxy rests are certified to be free. All points are in the
// solver frame in metres.
//
// Local minimum: at the end of a tick that is not capped, no improving segment exists. An improving
// segment is a straight segment from the proxy with these properties:
//   - It crosses no triangle.
//   - It stays at least one stand-off (SolverScale) from each triangle that is farther than a
//     stand-off from its start, except for rounding. For a sphere, the distance is measured from
//     the sphere's surface.
//   - At its start, it approaches no other triangle. The distance to a triangle is convex along a
//     segment, so it approaches none of them later.
//   - It lies in the plane of motion, if one is given.
//   - Its end is nearer to the goal than its start by more than 1e-9 of the scene's size.
// A segment approaches a triangle if the slope at its start, continued to the point nearest to the
// goal, leads nearer to the triangle by more than 1e-15 of the scene's size (rounding of normals).
// A shorter segment of the same slope may lead nearer by less than the rounding of positions; it is
// no improving segment, because a proxy that took one in every tick would reach the triangle. Two
// cases follow for a point that touches two faces less than two stand-offs apart. If the faces
// converge towards the goal, it rests, at however small an angle they converge. At the rim of the
// gap, it does not turn out of the gap before it has passed the rim.
// Under friction, a slide along a touched surface counts only as far as the tangential lag exceeds
// the friction limit. Accuracy::fast() gives no such guarantee.
//
// Capped: a tick is capped if it runs out of steps or work (below). The tick of a point is also
// capped in two other cases. In the first, the point is between nearly parallel faces, where
// rounding decides whether a segment is free. In the second, the face that the point met last
// yields no new contact plane, and no attempted segment improves the position. After a capped tick,
// the proxy is at a free position on the path that a longer tick would take, and no farther from
// the goal than before. The next tick knows all faces that were met and continues from this
// position.
//
// Work: a tick is a call of move_to() and the preceding call of move_bodies(), if any. Its work is
// counted (work.h) and limited by Accuracy::work_budget. When the budget is spent, the proxy is at
// the end of its last completed step and no farther from the goal than before. A body whose push is
// incomplete is at its old pose. The next tick continues the interrupted search with all results so
// far. If the goal has moved by less than half of its former distance from the proxy, the
// interrupted step is completed for the former goal. A push begins only while half of the budget is
// left. If pushes have used more than half of the budget and the move is then cut short, the next
// tick moves no bodies.
//
// A proxy that starts within a stand-off of a triangle, or a sphere that overlaps one, may leave
// the triangle or keep its distance, but does not move nearer. place() lifts a point off a surface
// that it is placed on.
//
// Monotone: no tick increases the distance to the goal by more than rounding, whether capped or
// not. For a fixed mesh, this certifies that the spring between proxy and goal is passive: the
// motion of the proxy never adds energy to it. Within a tick, no piece of a point's path increases
// the distance by more than rounding, either. The path of a sphere may increase it by less than 1 %
// of the radius while the sphere moves round an obstacle.
//
// Numbers that are not finite, and positions so far away that squares of lengths overflow, are
// invalid input. Invalid input changes nothing; the return value reports it.
//
// Safe on the haptic thread: no allocation, lock or exception after create(). Not thread-safe: one
// thread owns an instance.
class GodObject {
 public:
  // Copies the poses of the bodies. The surfaces of the world must outlive the god-object. Errors:
  // those of check_settings() (check_god_object_settings.h). Not for the haptic thread: allocates.
  static Result<GodObject> create(const ContactWorld& world, const GodObjectSettings& settings);
  // A moved-from god-object may only be destroyed.
  GodObject(GodObject&&) noexcept;
  GodObject& operator=(GodObject&&) noexcept;
  ~GodObject();

  // Places the proxy at p. If p is within a stand-off of a surface, where the side is undecided,
  // the proxy is lifted to a stand-off in front of the faces there, within the plane of motion
  // through p if its unit normal is given. If the faces meet so far away that rounding decides
  // where, the proxy stays at p. Returns false and changes nothing if p or the normal is invalid.
  bool place(const Vec3& p, const std::optional<Vec3>& motion_plane_normal = std::nullopt) noexcept;

  // Moves a body without pushing the proxy; for use before the proxy has been placed. Returns false
  // and changes nothing if kMostMoving bodies have moved already, if T_solver_body is not a rigid
  // pose (is_pose), or if `body` does not exist.
  bool place_body(std::uint32_t body, const RigidTransform& T_solver_body) noexcept;

  // Moves at most LiveWorld::kMostMoving bodies to new poses. Each body pushes the proxy ahead of
  // it (push_proxy), within the plane of motion if its unit normal is given. Seen from the body,
  // the proxy moves along a straight segment. Returns the number of bodies that are not at their
  // new poses. A body is not at its new pose if the proxy had no space, if too little work was
  // left, or if the motion was invalid. If the normal is not a unit vector, no body moves. The next
  // move_to() belongs to the same tick.
  std::size_t move_bodies(std::span<const BodyMotion> motions,
                          const std::optional<Vec3>& motion_plane_normal = std::nullopt) noexcept;

  // Moves the proxy towards the goal. If motion_plane_normal (unit) is given, the proxy keeps to
  // the plane through the goal with that normal, and contact normals lie in that plane. An invalid
  // goal or normal changes nothing, not even contacts() and path(); it is reported by
  // ProxyState::is_refused.
  ProxyState move_to(const Vec3& goal,
                     const std::optional<Vec3>& motion_plane_normal = std::nullopt) noexcept;

  // Like move_to(), but with Coulomb friction (Harwin and Melder 2002): the proxy takes only the
  // part of each step along touched faces that the friction cone does not hold. Let s be the
  // position that the proxy would reach without friction, d = |s - goal| the penetration depth and
  // t = s - proxy the tangential lag. The contact sticks or slides:
  //
  //   sticking   |t| <= mu_s d: the proxy keeps its position and sticks
  //              |t| >  mu_s d: it moves along t until |t| = mu_k d, and slides
  //   sliding    |t| >  mu_k d: it moves along t until |t| = mu_k d, and slides
  //              |t| =  mu_k d: it keeps its position and slides
  //              |t| <  mu_k d: it keeps its position and sticks
  //
  // Comparisons are made to within rounding (kConeRoundoff). A position that is kept stays the same
  // bit for bit. A new contact sticks. The state persists across edges, from face to face and from
  // body to body. It ends with the contact, with place() and move_to(), and with end_friction().
  // Therefore a hand that moves on at constant depth is subject to mu_k in every tick, at any
  // speed, and regardless of whether the hand or the touched body moves. If the hand reverses, or
  // if the penetration depth grows faster than the tangential lag, the contact sticks.
  //
  // The state and the coefficients of a tick are those of the faces that hold the proxy at the end
  // of the tick, at the place where they hold it. A slide that passes a border of materials goes on
  // to the cone of the material where it ends; if the lag is below that cone there, the contact
  // sticks. After a tick that is not capped, the lag is therefore within the cone, and a spring's
  // force needs no correction.
  //
  // Any part of a free step is free, too, and ends no farther from the goal than it began. The
  // certificates therefore hold as they do without friction. With bodies at rest, let g be the
  // goal, E = K |proxy - g|^2 / 2, and F = K (proxy - g) the spring's force. If g then moves by dg,
  //
  //   E' <= K |proxy - g - dg|^2 / 2 = E - F . dg + K |dg|^2 / 2.
  //
  // The bound needs the spring's force as it is. After a capped tick, the lag may be above the cone
  // of the faces that hold the proxy; a force that is shortened to that cone can then break the
  // bound, until a tick has completed the slide.
  //
  // Faces without friction (mu_s = 0) hold the proxy as in move_to(). There, a lag of up to 1e-7 of
  // the depth may remain along a face, since its gain is lost in the rounding of squared distances.
  //
  // Several faces together hold a tangential lag of mu_1 d_1 + mu_2 d_2 + ..., where d_i is the
  // part of the depth that face i bears (bearing_parts). A sphere moves round edges along tangents.
  // Its normal at an edge or vertex belongs to a place within some stand-offs of its own, so that
  // the ratio |t| / d is exact to 1 + mu^2 times some stand-offs over the radius (8e-9 seen).
  ProxyState move_with_friction(const Vec3& goal, const std::optional<Vec3>& motion_plane_normal,
                                const FrictionSource& friction) noexcept;

  // Like move_to(), for a point, but "nearer" and "distance" are meant in this norm, in all that
  // the class comment says about rests, about capped ticks and about monotony; thresholds of
  // lengths are, too. What a segment may cross and the distance that it keeps from triangles stay
  // Euclidean. Refuses a sphere, and a norm whose axes do not lie in the plane of motion.
  ProxyState move_in_norm(const Vec3& goal, const std::optional<Vec3>& motion_plane_normal,
                          const AnisotropicNorm& norm) noexcept;

  // Makes the present contact stick like a new one. To be called in a tick that commands no force.
  void end_friction() noexcept { rest_.end_slide(); }

  const Vec3& proxy() const { return proxy_; }
  // The faces that hold the proxy, at most three. Valid until the next move.
  std::span<const FaceContact> contacts() const { return rest_.holding(); }
  // The unit normal of the contact plane of the i-th contact; under a plane of motion it lies in
  // that plane. Valid until the next move.
  const Vec3& plane_normal(std::size_t i) const { return step_.active_plane(i).normal; }
  ContactView contact() const {
    return {*world_, contacts(), step_.all_planes(), step_.solution().active};
  }
  // The corners of the path of the last move, from the proxy's old position to its new one. Valid
  // until the next call.
  std::span<const Vec3> path() const { return path_; }
  const SolverScale& scale() const { return tracer_.scale(); }
  const LiveWorld& world() const { return *world_; }
  double radius_m() const { return settings_.radius_m; }

 private:
  // The settings must be valid.
  GodObject(const ContactWorld& world, const GodObjectSettings& settings);

  enum class Progress : std::uint8_t {
    kMoved,    // the proxy reached the nearest point that the planes allow
    kHeld,     // the proxy was at that point already
    kStopped,  // another face stopped the step
    kStuck     // the present planes allow no progress
  };

  // Whether the goal and the normal are valid: the squared distance of the goal from the proxy is
  // finite, and the normal, if given, is a unit vector.
  bool is_goal(const Vec3& goal, const std::optional<Vec3>& motion_plane_normal) const {
    return std::isfinite((goal - proxy_).squaredNorm()) &&
           (!motion_plane_normal || is_unit(*motion_plane_normal));
  }
  bool is_motion(std::uint32_t body, const RigidTransform& T_solver_body) const;
  ProxyState refused() const;
  void update_bounds();
  bool move_body(const BodyMotion& motion) noexcept;
  bool push_all(std::span<const BodyMotion> motions) noexcept;
  bool finishes_push(std::span<const BodyMotion> motions) noexcept;
  const Vec3& plane_point() const;
  std::size_t count_not_arrived(std::span<const BodyMotion> motions) const;
  void set_motion_plane(const std::optional<Vec3>& normal);
  // Whether a plane of motion with this normal, or no plane, is that of the last tick.
  bool is_motion_plane(const std::optional<Vec3>& normal) const {
    return normal ? motion_plane_ && motion_plane_->given_normal() == *normal : !motion_plane_;
  }
  // Begins the move of a tick. Returns the work of move_bodies() in this tick.
  WorkUnits begin_tick() {
    if (!pushes_.begin_move()) tracer_.begin_tick();
    tracer_.begin_errand(SegmentTracer::Errand::kMove);
    return tracer_.work().used();
  }
  template <typename Friction>
  ProxyState stay(Friction& friction);
  template <typename Friction>
  void finish_last_step(Friction& friction);
  void keep_step_for_next_tick(const Vec3& from, WorkUnits work_of_bodies);
  ProxyState move_freely();
  void seed_from_last_tick();
  // Friction is a policy, which also states the norm of distances to the goal: NoFriction,
  // CoulombFriction or InNorm. Defined in god_object_steps.h.
  template <typename Friction>
  ProxyState move(const Vec3& goal, const std::optional<Vec3>& motion_plane_normal,
                  Friction& friction);
  struct Tick;
  enum class Verdict : std::uint8_t {
    kRests,       // the proxy is at rest
    kEnds,        // the tick is capped: rounding decides, or its work is spent
    kTriesAgain,  // the position or the planes have changed: another step
    kGoesOn       // other planes first, then another step
  };
  [[gnu::always_inline]] Tick begin_move(const Vec3& goal,
                                         const std::optional<Vec3>& motion_plane_normal);
  [[gnu::always_inline]] void begin_step(Tick& tick);
  template <typename Friction>
  [[gnu::always_inline]] Verdict judge(Progress progress, Tick& tick, Friction& friction);
  template <typename Friction>
  [[gnu::always_inline]] void renew_planes(Progress progress, Tick& tick, Friction& friction);
  template <typename Friction>
  [[gnu::always_inline]] void end_move(const Tick& tick, bool capped, Friction& friction);
  template <typename Friction>
  void find_holding_planes(Friction& friction);
  template <typename Friction>
  PlaneProjection project(const Friction& friction, std::span<const ContactPlane> planes) const;
  template <typename Friction>
  Progress take_step(Friction& friction);
  enum class Way : std::uint8_t {
    kSlides,  // along the planes, as far as friction permits
    kFlies,   // to the first plane, without a slide
    kRolled   // a sphere has moved round a feature
  };
  template <typename Friction>
  [[gnu::always_inline]] Way find_way(Friction& friction);
  template <typename Friction>
  [[gnu::always_inline]] bool is_held_at_once(const Friction& friction, const Vec3& step) const;
  std::optional<Progress> stop_at_first_hit(const Vec3& target);
  // Whether the proxy touches none of the active planes. Friction acts only at touched planes.
  bool is_off_planes() const { return step_.is_off_planes(near_m()); }
  Vec3 step_to_planes() const;
  bool roll_to_answer();
  // Distance, in stand-offs, within which a face is kept, since it may soon hold the proxy again.
  // Faces farther away are dropped.
  static constexpr double kNearPerStandOff = 2.0;
  double near_m() const { return kNearPerStandOff * scale().stand_off_m; }
  // The gain below which a segment, a step of a slow proxy or a turn of a sphere counts as no
  // progress: a tenth of the gain of an improving segment (class comment).
  static constexpr double kLittlePerStandOff = 10.0;
  double little_m() const { return kLittlePerStandOff * scale().stand_off_m; }
  // Whether a step is too small to continue. In the first tick of a goal, the length of the step
  // decides, so that the proxy ends where it will stay. In later ticks with the same goal, the gain
  // decides, because short steps that gain almost nothing would lead far in a flat valley.
  template <typename Friction>
  bool is_little(const Friction& friction, const Vec3& step) const {
    return goal_waits_ ? !may_gain_by(friction, step) : step.norm() <= little_m();
  }
  bool has_converged(const Vec3& step) const {
    return step.squaredNorm() <= step_tolerance_m_ * step_tolerance_m_;
  }
  struct Bearing;
  template <typename Friction>
  void find_cone_at(const Vec3& place, const Bearing& bearing, Friction& friction);
  template <typename Friction>
  Bearing find_bearing(Friction& friction);
  template <typename Friction>
  void find_friction_here(Friction& friction);
  template <typename Friction>
  bool hold_by(Friction& friction);
  template <typename Friction>
  bool roll_to_cone(Friction& friction);
  template <typename Friction>
  bool stays_at_rest(Friction& friction);
  bool is_carried_by(std::uint32_t body) const;
  void add_if_touched(const FaceContact& met);
  void update_planes();
  template <typename Friction>
  void go_on_over_next_face(const Friction& friction);
  template <typename Friction>
  int overreach(Progress progress, int most_steps, Friction& friction);
  template <typename Friction>
  int leap(int most_steps, Friction& friction);
  struct Attempt {
    int steps = 0;
    double beyond_m = 0.0;
    bool is_nearer = false;
  };
  template <typename Friction>
  Attempt fall_from_beyond(const Vec3& displacement, int most_steps, Friction& friction);
  bool roll_between_last_two();
  bool roll_between(const FaceContact& one, const FaceContact& other);
  bool goes_round(const FaceContact& from, FaceContact& to, double reach);
  std::optional<RollArc> arc_round(const FaceContact& now) const;
  bool rolls_along(const RollArc& arc, double part);
  void become_slow();
  void limit_detours();
  double part_free(std::span<const Vec3> corners);
  struct ProxyPlace;
  ProxyPlace place_now() const;
  void return_to(const ProxyPlace& place);
  // Attempts to improve the position of a proxy at rest (god_object_escapes.h, god_object_lines.h).
  struct Faces;
  struct Surroundings;
  enum class Escape : std::uint8_t {
    kNone,            // no attempt has improved the position
    kLeft,            // the proxy has moved nearer to the goal
    kRoundingDecides  // none has, and rounding decides whether an improving segment exists
  };
  template <typename Friction>
  Escape leaves_edges(Progress progress, Friction& friction);
  template <typename Friction>
  Escape leaves_wedge(Friction& friction);
  template <typename Friction>
  bool slides_without_edges(const Faces& holding, Friction& friction);
  template <typename Friction>
  bool slides_up_to_untouched_face(Friction& friction);
  template <typename Friction>
  bool slides_by(const Vec3& along, const FaceContact& face, Friction& friction);
  template <typename Friction>
  bool slides_past(Friction& friction);
  template <typename Friction>
  Escape slides_between(Friction& friction);
  template <typename Friction>
  bool follows(const Vec3& step, std::span<const FaceContact> contacts, Friction& friction);
  template <typename Friction>
  bool slides_at_vertex(Friction& friction);
  template <typename Friction>
  bool lifts_and_slides(std::span<const FaceContact> pair, std::span<const FaceContact> nearest,
                        Friction& friction);
  template <typename Friction>
  Vec3 first_no_farther(const Friction& friction, const Vec3& than, const Vec3& from,
                        const Vec3& to) const;
  template <typename Friction>
  bool slides_along(std::span<const FaceContact> contacts, Friction& friction);
  template <typename Friction>
  bool goes_past_obstacles(Friction& friction);
  template <typename Friction>
  bool goes_along_lines(Friction& friction);
  template <typename Friction>
  bool goes_past_edges(Friction& friction);
  template <typename Friction>
  void add_lines_past_edges(const Friction& friction);
  template <typename Friction>
  void add_lines_past_corners(const Friction& friction);
  template <typename Friction>
  void add_line(const Vec3& step, const Friction& friction);
  template <typename Friction>
  bool goes_along_longest(Friction& friction);
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
  template <typename Friction>
  bool is_gain(const Friction& friction, const Vec3& from, const Vec3& to) const;
  template <typename Friction>
  bool may_gain_by(const Friction& friction, const Vec3& step) const {
    return step.allFinite() && is_gain(friction, proxy_, proxy_ + step);
  }
  void look_around();
  FaceContact contact_of_nearest(const FaceRef& face) const;
  bool is_touched_face(const FaceContact& contact) const;
  template <typename Friction>
  bool is_held_by(const Friction& friction, std::span<const FaceContact> holding) const;
  template <typename Friction>
  bool is_held_by_faces(const Friction& friction);
  template <typename Friction>
  void hold_by_faces(const Friction& friction);
  template <typename Friction>
  Progress rests_or_slides_on_faces(Friction& friction);
  double place_roundoff_m() const;
  Faces holding_faces() const;
  bool falls_to_none(const Vec3& step, std::span<const FaceContact> touched) const;
  bool is_stopped_by_rounding(const Vec3& step);
  template <typename Friction>
  void hold_by_most_violated(const Friction& friction, std::span<const FaceContact> contacts);
  bool is_at_vertex(std::span<const FaceContact> contacts) const;
  Vec3 lift_above(std::span<const FaceContact> faces, std::span<const FaceContact> nearest) const;
  std::optional<Vec3> in_motion_plane(const Vec3& direction) const;
  // The point of the plane of motion nearest to p, or p without such a plane.
  Vec3 point_in_motion_plane(const Vec3& p) const {
    return motion_plane_ ? motion_plane_->nearest(p, goal_) : p;
  }
  Vec3 onto_motion_plane(const Vec3& step) const;
  bool is_same_place(const FaceContact& a, const FaceContact& b) const;
  bool enter_bounds();
  // The end of an attempted step in the plane of motion, or the point where this step leaves the
  // world's bounds, beyond which nothing can be touched.
  Vec3 end_of_step(const Vec3& step) const {
    const Vec3 target = point_in_motion_plane(proxy_ + step);
    return bounds_.contains(target) ? target : leave_bounds(target);
  }
  Vec3 leave_bounds(const Vec3& target) const;
  bool add_plane(const FaceContact& contact);
  void advance_to(const Vec3& target);
  void commit(const Vec3& proxy);
  bool is_above(const FaceContact& contact) const;
  bool settled() const;
  void keep_contacts_for_next_tick(bool capped) {
    rest_.keep_contacts(step_.contacts(), step_.solution(), capped);
  }
  ProxyState report(int iterations, bool capped) const;

  GodObjectSettings settings_;
  std::unique_ptr<LiveWorld> world_;  // on the heap, since the tracer keeps its address
  Box bounds_;                        // no surface can be touched outside
  SegmentTracer tracer_;
  double step_tolerance_m_;  // a step shorter than this has converged
  Vec3 proxy_ = Vec3::Zero();
  Vec3 goal_ = Vec3::Zero();
  std::vector<Vec3> path_;                   // reserved for the largest number of corners
  std::optional<MotionPlane> motion_plane_;  // through goal_

  ProxyStep step_;  // the step under way

  std::unique_ptr<Surroundings> around_;  // faces around the proxy, from the last look_around()

  // State of the present tick.
  double most_lag_m_ = 0.0;  // largest distance to the goal allowed on a sphere's path
  bool is_slow_ = false;     // this tick took more than kPatience steps or continues another
  bool goal_waits_ = false;  // the last tick had the same goal and did not reach it at once
  SlideExtrapolation extrapolation_;  // of a slow sphere

  ProxyRest rest_;  // what the last tick left

  InterruptedStep interrupted_;  // of the tick that was last cut short
  PushOrder pushes_;
};

}  // namespace palpate
