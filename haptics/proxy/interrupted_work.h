#pragma once

// What a tick of the god-object that ran out of work leaves to be completed: the step of the proxy
// in which it was cut short, and the push of a body.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

#include "haptics/proxy/live_world.h"
#include "haptics/proxy/trace_log.h"

namespace palpate {

// The target pose of a body. Solver frame.
struct BodyMotion {
  std::uint32_t body = 0;
  RigidTransform T_solver_body;
};

// The last step that was cut short. Solver frame, m. ProxyRest::is_cut_short() tells whether it is
// the step of the last tick; it is kept longer, to be recognised if it is cut short once more.
class InterruptedStep {
 public:
  // Where the proxy was to go when the trace was cut short.
  const Vec3& target() const { return target_; }

  // Whether a tick with this goal, whose proxy is here, makes the same queries again.
  bool is_repeated_by(const Vec3& goal, const Vec3& proxy) const {
    return goal == goal_ && proxy == from_;
  }
  // Whether the goal has moved by at most half of its former distance from the proxy.
  bool is_still_wanted(const Vec3& goal, const Vec3& proxy) const {
    return 2.0 * (goal - goal_).norm() <= (goal_ - proxy).norm();
  }
  // Whether this trace from the proxy is the one that was cut short.
  bool is_trace(const TraceKey* unfinished, const Vec3& proxy) const {
    return unfinished && unfinished->p == proxy && unfinished->q == target_;
  }
  // A tick with this goal was cut short in a step that began at `from`. A trace that is cut short
  // again keeps the goal for which it was begun.
  void keep(const Vec3& from, const Vec3& proxy, const Vec3& goal, const TraceKey* unfinished) {
    from_ = from;
    if (is_trace(unfinished, proxy)) return;
    goal_ = goal;
    if (unfinished) target_ = unfinished->q;
  }

 private:
  Vec3 from_ = Vec3::Zero();    // position of the proxy at the start of the step
  Vec3 goal_ = Vec3::Zero();    // goal for which the step was begun
  Vec3 target_ = Vec3::Zero();  // end point of the interrupted trace
};

// The pushes of bodies in their order, and whose turn it is. The pushes of a tick come before its
// move. A turn that the pushes have begun is never reserved for the move: one state says both.
class PushOrder {
 public:
  // What belongs to the tick that is next or under way.
  enum class Turn : std::uint8_t {
    kOpen,    // nothing yet: it begins with pushes or with the move
    kPushed,  // the pushes have been made: the next move belongs to it
    kMove     // the move, which was cut short for lack of work: no body moves
  };
  Turn turn() const { return turn_; }

  // The pushes of a tick begin. False if no body moves in it.
  bool begin_pushes() { return std::exchange(turn_, Turn::kPushed) != Turn::kMove; }
  // The move of a tick begins. False if it is the beginning of the tick.
  bool begin_move() {
    if (turn_ != Turn::kPushed) return false;
    turn_ = Turn::kOpen;
    return true;
  }
  // The move was cut short. needs_turn: the next tick moves no bodies.
  void end_cut_short(bool needs_turn) { turn_ = needs_turn ? Turn::kMove : Turn::kOpen; }

  // The push that was cut short, to its former target.
  bool has_unfinished() const { return unfinished_.has_value(); }
  void cut_short(const BodyMotion& push) { unfinished_ = push; }
  // The push that was cut short is completed now. Only if there is one.
  BodyMotion take_unfinished() {
    const BodyMotion push = *unfinished_;
    unfinished_.reset();
    return push;
  }
  // The proxy has been placed elsewhere.
  void forget_unfinished() { unfinished_.reset(); }

  // The position in the list of motions of the body that is due first.
  std::size_t first() const { return first_; }
  void begin_with(std::size_t first) { first_ = first; }

 private:
  Turn turn_ = Turn::kOpen;
  std::optional<BodyMotion> unfinished_;
  std::size_t first_ = 0;
};

}  // namespace palpate
