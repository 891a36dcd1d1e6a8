#pragma once

// Magnet: attraction towards a surface.

#include <algorithm>
#include <cmath>

#include "haptics/effects/effect.h"
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
// The search has no work budget: it takes milliseconds where 100,000 triangles are equally near.
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
  struct State {};
  static constexpr ParameterKey kKeys[] = {
      {"magnetForce", "N", 0.0, 100.0, offsetof(Parameters, force_N), ParameterKey::Role::kDeclares,
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
    const bool is_moving = tick.world->is_moving(surface.body);
    const Box box =
        body.stretch ? body.stretch->box_body(surface.index->box()) : surface.index->box();
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
    const auto nearest = body.stretch
                             ? closest_point(*surface.index, *body.stretch, proxy_body, range)
                             : surface.index->closest_point(proxy_body, range);
    const double distance_m = nearest ? body.length_to_solver(nearest->distance_m) : 2.0 * reach_m;
    if (distance_m >= reach_m || distance_m == 0.0) {
      tick.quiet_m = is_moving ? 0.0 : std::max(0.0, distance_m - reach_m);
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
