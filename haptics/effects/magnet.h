#pragma once

// A surface that attracts.

#include <algorithm>
#include <cmath>

#include "haptics/effects/effect.h"
#include "haptics/proxy/live_world.h"

namespace palpate {

// The magnetic surface of one body.
struct MagneticSurface {
  std::uint32_t body = 0;
  std::uint32_t material = 0;           // of the effect program
  const SurfaceIndex* index = nullptr;  // of the faces with that material, as the body's own
};

// Attraction towards the nearest point of a surface within a range: F = F0 (1 - s / r)^2 at a
// distance s from the proxy, a gravity well (Hwang, Keates, Langdon and Clarkson 2003, "Multiple
// haptic targets for motion-impaired computer users") with the potential -F0 r (1 - s / r)^3 / 3,
// so that force and its slope vanish at the range's end and nothing is gained round a loop. In
// contact s is 0: the proxy is held by F0, and rests at a depth of F0 / K. Where two points of one
// surface are nearest, the direction jumps. Several surfaces add. Its search is in no budget: it
// takes milliseconds where 100,000 triangles are equally near.
struct MagnetEffect {
  static constexpr std::string_view kName = "magnet";
  static constexpr EffectStage kStage = EffectStage::kSurroundings;
  // In contact, where the way to the nearest point is shorter than its rounding, touches tell.
  static constexpr std::uint32_t kNeeds = kNeedsSurroundings | kNeedsPlace | kNeedsContact;

  struct Parameters {
    double force_N = 0.0;
    double range_m = 0.0;
    const MagneticSurface* surface = nullptr;
  };
  struct State {};
  static constexpr ParameterKey kKeys[] = {
      {"magnetForce", "N", 0.0, 100.0, offsetof(Parameters, force_N), ParameterKey::Role::kCallsFor,
       "attraction at the surface"},
      {"magnetRange", "m", 0.0, 1000.0, offsetof(Parameters, range_m),
       ParameterKey::Role::kRequired, "distance from the surface at which the attraction ends",
       true, true}};

  static const char* contradiction(const Parameters&) noexcept { return nullptr; }

  static bool apply(const Parameters& p, State&, EffectTick& tick) noexcept {
    const MagneticSurface& surface = *p.surface;
    for (const Touch& touch : tick.touches) {
      if (touch.body != surface.body || touch.material != surface.material) continue;
      tick.force_N -= p.force_N * touch.normal;
      return true;
    }
    const ContactBody& body = tick.world->body(surface.body);
    const Vec3 proxy_body = body.to_body(tick.proxy_m);
    const bool may_come = tick.world->is_moving(surface.body);
    const Box box =
        body.stretch ? body.stretch->box_body(surface.index->box()) : surface.index->box();
    const double to_box = std::sqrt(box.squared_distance(proxy_body));
    const double to_box_m = body.length_to_solver(to_box);
    const double reach_m = p.range_m + tick.radius_m;
    if (to_box_m >= reach_m) {
      tick.quiet_m = may_come ? 0.0 : to_box_m - reach_m;
      return false;
    }
    // Twice as far, so that what is seen to be out of range is out of it for a while.
    // All of it is nearer than this, however large the range.
    const double farthest = to_box + kMostBoxes * (box.high - box.low).norm();
    const double range = std::min(body.length_to_body(2.0 * reach_m), farthest);
    const auto nearest = body.stretch
                             ? closest_point(*surface.index, *body.stretch, proxy_body, range)
                             : surface.index->closest_point(proxy_body, range);
    const double distance_m = nearest ? body.length_to_solver(nearest->distance_m) : 2.0 * reach_m;
    if (distance_m >= reach_m || distance_m == 0.0) {
      tick.quiet_m = may_come ? 0.0 : std::max(0.0, distance_m - reach_m);
      return false;
    }
    const double part = 1.0 - std::max(0.0, distance_m - tick.radius_m) / p.range_m;
    const Vec3 towards =
        body.direction_to_solver(nearest->point_m - proxy_body) / nearest->distance_m;
    tick.force_N += p.force_N * part * part * towards;
    return true;
  }

 private:
  static constexpr double kMostBoxes = 64.0;
};

}  // namespace palpate
