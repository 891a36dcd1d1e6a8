#pragma once

// How the god-object moves in one tick, for the files that do it with and without friction. Each
// compiles its own copy: a world without friction runs no line of the other.

#include <algorithm>

#include "haptics/god_object.h"

namespace palpate {

struct NoFriction {
  static constexpr bool kHolds = false;
};

// Faces tried at a vertex. Among more of them a free way is hardly wider than a stand-off.
constexpr std::size_t kMostAtVertex = 12;

template <typename Friction>
ProxyState GodObject::move(const Vec3& goal, const std::optional<Vec3>& motion_plane_normal,
                           Friction& friction) {
  goal_ = goal;
  motion_plane_normal_ = motion_plane_normal;
  path_.clear();
  path_.push_back(proxy_);
  if (last_active_count_ == 0 && tracer_.is_free(proxy_, goal)) return move_freely();
  seed_from_last_tick();
  if constexpr (Friction::kHolds) {
    if (stays_at_rest(friction)) return friction.complete(report(1, false));
  }
  bool began_empty = plane_count_ == 0;
  Vec3 round_start = proxy_;
  bool capped = true;
  settled_ = false;
  int iteration = 0;
  while (iteration < settings_.accuracy.iterations) {
    ++iteration;
    [[maybe_unused]] Vec3 before;
    if constexpr (Friction::kHolds) before = proxy_;
    const Progress progress = take_step(friction);
    if constexpr (Friction::kHolds) friction.end_step(proxy_ != before);
    if (progress == Progress::kStopped) continue;
    // A round ends where its planes let the proxy go no nearer. That is the local minimum if the
    // face of the one plane is really there, or if a round from scratch ends where it began and
    // leaving out some of its planes does not help.
    settled_ = progress == Progress::kMoved && settled();
    if (settled_) capped = false;
    const bool is_at_rest = began_empty && is_none(proxy_ - round_start);
    if (is_at_rest) capped = find_way_out(friction);
    if (!capped) break;
    // Another round from scratch needs two steps to meet anything: a proxy that is cut short before
    // keeps the planes that hold it.
    if (settings_.accuracy.iterations - iteration < 2) break;
    if (!is_at_rest) plane_count_ = 0;
    began_empty = !is_at_rest;
    round_start = proxy_;
  }
  keep_active_for_next_tick();
  tracer_.look_ahead(proxy_, proxy_ - path_.front(), iteration == 1);
  confirmed_ = !capped;
  if constexpr (Friction::kHolds) return friction.complete(report(iteration, capped));
  return report(iteration, capped);
}

template <typename Friction>
GodObject::Progress GodObject::take_step(Friction& friction) {
  if (plane_count_ == 0 && !enter_bounds()) return Progress::kMoved;
  projection_ = project_onto_planes(planes(), goal_ - proxy_);
  if (!projection_.solved) return Progress::kStuck;
  if constexpr (Friction::kHolds) {
    if (!hold_by(friction) && roll_to_answer()) return Progress::kStopped;
  } else {
    if (roll_to_answer()) return Progress::kStopped;
  }
  // Free, the proxy goes to the goal, to the bit and however near it is; held by planes, it has
  // converged when it hardly moves.
  const bool is_free = projection_.active_count == 0;
  const Vec3& step = projection_.displacement_m;
  if (!is_free && is_none(step)) return Progress::kMoved;
  Vec3 target = is_free ? goal_ : Vec3(proxy_ + step);
  const bool leaves = !bounds_.contains(target);
  if (leaves) target = proxy_ + leave_bounds(step) * step;  // nothing to touch beyond
  if (const auto stopped = stop_at_first_hit(target)) return *stopped;
  if (leaves && is_free) commit(goal_);
  return leaves && !is_free ? Progress::kStuck : Progress::kMoved;
}

// Two or three planes hold the proxy, each met from where it is. On a saddle that need not be a
// minimum: the room around a vertex is not convex, and another pair of faces can leave a way on
// between them. Tries the slides along each face here alone and along each two. True if one of them
// led anywhere.
template <typename Friction>
bool GodObject::find_way_out(Friction& friction) {
  const PlaneProjection held = projection_;
  if (held.active_count < 2) return false;
  std::array<FaceContact, 3> holding;
  for (int i = 0; i < held.active_count; ++i) holding[i] = contacts_[held.active[i]];
  const auto holding_now = std::span(holding).first(static_cast<std::size_t>(held.active_count));

  std::array<FaceContact, kMostAtVertex> near;
  std::size_t count = holding_now.size();
  if (is_at_vertex(holding_now)) {
    count = tracer_.contacts_around(proxy_, 4 * scale().stand_off_m, near);
  } else {
    std::copy(holding_now.begin(), holding_now.end(), near.begin());
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (slides_along({near[i]}, friction)) return true;
    for (std::size_t j = 0; j < i; ++j) {
      if (slides_along({near[i], near[j]}, friction)) return true;
    }
  }
  plane_count_ = 0;
  for (const FaceContact& contact : holding_now) add_plane(contact);
  projection_ = held;
  for (int i = 0; i < held.active_count; ++i) projection_.active[i] = i;
  return false;
}

// Takes a step held by these planes alone; true if it led anywhere.
template <typename Friction>
bool GodObject::slides_along(std::initializer_list<FaceContact> contacts, Friction& friction) {
  plane_count_ = 0;
  for (const FaceContact& contact : contacts) {
    if (!add_plane(contact)) return false;
  }
  const Vec3 before = proxy_;
  const std::size_t corners = path_.size();
  const Friction friction_before = friction;
  take_step(friction);
  if (!is_none(proxy_ - before)) {
    if constexpr (Friction::kHolds) friction.end_step(true);
    return true;
  }
  friction = friction_before;
  proxy_ = before;
  path_.resize(corners);
  return false;
}

}  // namespace palpate
