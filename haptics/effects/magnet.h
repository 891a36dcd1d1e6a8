#pragma once

// Magnet: attraction towards a surface.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "haptics/effects/effect.h"
#include "haptics/effects/nearest_search.h"
#include "haptics/proxy/live_world.h"

namespace palpate {

// The magnetic surface of one body.
struct MagneticSurface {
  std::uint32_t body = 0;
  std::uint32_t material = 0;  // of the effect program
  const SurfaceIndex* index =
      nullptr;  // of the faces with that material; in the frame of the body's index
};

// Attraction towards the nearest point of a surface within a range r: F = F0 (1 - s / r)^2 at a
// distance s from the proxy. This is a gravity well (Hwang, Keates, Langdon and Clarkson 2003,
// "Multiple haptic targets for motion-impaired computer users") with the potential
// -F0 r (1 - s / r)^3 / 3. The force and its slope therefore vanish at the end of the range, and a
// closed loop gains no energy. In contact s is 0: the force F0 holds the device point, which rests
// at a penetration depth of F0 / K. The direction jumps where two points of one surface are equally
// near. The forces of several surfaces add.
//
// If the search is cut short, the point is the nearest of those found so far: the magnet pulls less
// than it would, towards a point of its surface. The next tick continues the search. If no work is
// left, the magnet does not pull.
struct MagnetEffect {
  static constexpr std::string_view kName = "magnet";
  static constexpr EffectStage kStage = EffectStage::kSurroundings;
  // The effect needs the contact: when the proxy touches the surface, the vector to the nearest
  // point is shorter than its rounding error, and the touched faces give the direction instead.
  static constexpr std::uint32_t kNeeds = kNeedsSurroundings | kNeedsPlace | kNeedsContact;

  struct Parameters {
    double force_N = 0.0;
    double range_m = 0.0;
    const MagneticSurface* surface = nullptr;
  };
  struct State {
    // The last search: the proxy in the body frame, and a lower bound of the distance there.
    double searched_at[3] = {};
    double least = -1.0;   // < 0: no search yet
    NearestCursor cursor;  // of a search that was cut short
    std::uint32_t padding = 0;
  };
  static constexpr ParameterKey kKeys[] = {
      {"magnetForce", "N", 0.0, 100.0, offsetof(Parameters, force_N), ParameterKey::Role::kDeclares,
       "attraction at the surface"},
      {"magnetRange", "m", 0.0, 1000.0, offsetof(Parameters, range_m),
       ParameterKey::Role::kRequired, "distance from the surface at which the attraction ends",
       true, true}};

  static const char* contradiction(const Parameters&) noexcept { return nullptr; }

  // The distance from the box or, if it is larger, the distance that the last search leaves: in the
  // body frame, the distance from a rigid surface changes by at most the motion.
  static double distance_m(const Parameters& p, const State& s, const EffectTick& tick) noexcept {
    const MagneticSurface& surface = *p.surface;
    if (touched(surface, tick) != nullptr) return 0.0;
    const ContactBody& body = tick.world->body(surface.body);
    const Vec3 proxy_body = body.to_body(tick.proxy_m);
    double least = std::sqrt(box_of(body, surface).squared_distance(proxy_body));
    const Vec3 searched_at(s.searched_at[0], s.searched_at[1], s.searched_at[2]);
    if (s.least >= 0.0) least = std::max(least, s.least - (proxy_body - searched_at).norm());
    return body.length_to_solver(least);
  }

  static bool apply(const Parameters& p, State& s, EffectTick& tick) noexcept {
    const MagneticSurface& surface = *p.surface;
    if (const Touch* touch = touched(surface, tick)) {
      tick.force_N -= p.force_N * touch->normal;
      return true;
    }
    const ContactBody& body = tick.world->body(surface.body);
    const Vec3 proxy_body = body.to_body(tick.proxy_m);
    const bool is_moving = tick.world->is_moving(surface.body);
    const Box box = box_of(body, surface);
    const double to_box = std::sqrt(box.squared_distance(proxy_body));
    const double to_box_m = body.length_to_solver(to_box);
    const double reach_m = p.range_m + tick.radius_m;
    if (to_box_m >= reach_m) {
      tick.quiet_m = is_moving ? 0.0 : to_box_m - reach_m;
      return false;
    }
    // The search covers twice the reach, so that a surface out of range gives a useful quiet_m. The
    // whole surface is nearer than `farthest`, which limits the search if the range is even larger.
    const double farthest = to_box + kMostBoxes * (box.high - box.low).norm();
    const double range = std::min(body.length_to_body(2.0 * reach_m), farthest);
    const bool has_work = tick.work == nullptr || !tick.work->is_spent();
    const auto nearest =
        has_work ? nearest_point(body, surface, proxy_body, range, s, tick) : std::nullopt;
    if (!has_work) tick.is_capped = true;
    const double distance_m = nearest ? body.length_to_solver(nearest->distance) : 2.0 * reach_m;
    if (distance_m >= reach_m || distance_m == 0.0) {
      if (!tick.is_capped) tick.quiet_m = is_moving ? 0.0 : std::max(0.0, distance_m - reach_m);
      return false;
    }
    const double part = 1.0 - std::max(0.0, distance_m - tick.radius_m) / p.range_m;
    const Vec3 towards = body.direction_to_solver(nearest->point - proxy_body) / nearest->distance;
    tick.force_N += p.force_N * part * part * towards;
    return true;
  }

 private:
  static constexpr double kMostBoxes = 64.0;

  // The touch of the surface, or null.
  static const Touch* touched(const MagneticSurface& surface, const EffectTick& tick) noexcept {
    const auto found =
        std::find_if(tick.touches.begin(), tick.touches.end(), [&](const Touch& touch) {
          return touch.body == surface.body && touch.material == surface.material;
        });
    return found == tick.touches.end() ? nullptr : &*found;
  }

  static Box box_of(const ContactBody& body, const MagneticSurface& surface) noexcept {
    return body.stretch ? body.stretch->box_body(surface.index->box()) : surface.index->box();
  }

  // The nearest point within `range`, body frame.
  static std::optional<NearestPoint> nearest_point(const ContactBody& body,
                                                   const MagneticSurface& surface,
                                                   const Vec3& proxy_body, double range, State& s,
                                                   EffectTick& tick) noexcept {
    if (tick.work == nullptr) {  // the search of before the budget
      const auto nearest = body.stretch
                               ? closest_point(*surface.index, *body.stretch, proxy_body, range)
                               : surface.index->closest_point(proxy_body, range);
      if (!nearest) return std::nullopt;
      return NearestPoint{nearest->point_m, nearest->distance_m, NearestCursor::kNone};
    }
    const Vec3 searched_at(s.searched_at[0], s.searched_at[1], s.searched_at[2]);
    const bool has_moved = s.least < 0.0 || searched_at != proxy_body;
    const NearestResult found = find_nearest(*surface.index, body.stretch, proxy_body, range,
                                             has_moved, s.cursor, *tick.work);
    std::copy_n(proxy_body.data(), 3, s.searched_at);
    tick.is_capped = tick.is_capped || found.is_cut_short;
    s.least = found.is_cut_short ? 0.0 : found.nearest ? found.nearest->distance : range;
    return found.nearest;
  }
};

}  // namespace palpate
