#pragma once

// Viscosity: drag in a medium.

#include <algorithm>
#include <cmath>

#include "geometry/index/inside.h"
#include "haptics/effects/effect.h"
#include "haptics/effects/side_search.h"
#include "haptics/proxy/live_world.h"

namespace palpate {

// The region that a medium fills.
struct MediumRegion {
  enum class Shape : std::uint8_t {
    kBox,      // |p| <= half_m along each axis
    kSphere,   // |p| <= half_m.x()
    kInside,   // inside a closed surface that is an obstacle: the surface of a body
    kThrough,  // inside a closed surface that is no obstacle
  };
  Shape shape = Shape::kBox;
  AffineMap p_region_solver;  // kBox, kSphere: linear is a rotation and a scale
  double least_scale = 1.0;   // least length in the solver frame, m, of a unit in the region frame
  Vec3 half_m = Vec3::Zero();
  std::uint32_t body = 0;               // kInside
  const SurfaceIndex* index = nullptr;  // kThrough; in the region frame
};

// Viscous drag in a medium: F = -b v, with v the velocity of the device point in the scene. This is
// the virtual damper of Colgate and Brown 1994 ("Factors affecting the Z-width of a haptic
// display") without a wall. The medium inside a closed surface acts on a proxy inside the surface,
// and not on a proxy that is pressed against the surface from outside. In each tick, the drag
// dissipates b |dx|^2 / T of the hand's work, where T is the length of the tick and dx the motion
// in it. A device of mass m stays stable for about b < m / T.
//
// If the search for the side is cut short, or no work is left, the medium acts as at the last point
// whose side is known; the search continues in the next tick. Drag never gives the hand energy,
// whichever side is assumed.
struct ViscosityEffect {
  static constexpr std::string_view kName = "viscosity";
  static constexpr EffectStage kStage = EffectStage::kSurroundings;
  static constexpr std::uint32_t kNeeds = kNeedsSurroundings | kNeedsVelocity | kNeedsPlace;

  struct Parameters {
    double viscosity_Ns_per_m = 0.0;
    const MediumRegion* region = nullptr;
  };
  struct State {
    double is_known = 0.0;
    double is_inside = 0.0;
    double last_m[3] = {};  // the point for which is_inside was found; region frame
    SideSearch search;      // under way if it was cut short
  };
  static constexpr ParameterKey kKeys[] = {
      {"viscosity", "N s/m", 0.0, 1e4, offsetof(Parameters, viscosity_Ns_per_m),
       ParameterKey::Role::kDeclares, "drag of the medium inside"}};

  static const char* contradiction(const Parameters&) noexcept { return nullptr; }

  static double distance_m(const Parameters& p, const State&, const EffectTick& tick) noexcept {
    const MediumRegion& region = *p.region;
    if (region.shape == MediumRegion::Shape::kInside) return 0.0;
    const Vec3 p_region = region.p_region_solver(tick.proxy_m);
    if (region.shape == MediumRegion::Shape::kThrough) {
      return region.least_scale * std::sqrt(region.index->box().squared_distance(p_region));
    }
    return region.least_scale * std::max(0.0, outside(region, p_region));
  }

  static bool apply(const Parameters& p, State& s, EffectTick& tick) noexcept {
    if (!is_in(*p.region, s, tick)) return false;
    tick.force_N -= p.viscosity_Ns_per_m * tick.velocity_m_per_s;
    return true;
  }

 private:
  static bool is_in(const MediumRegion& region, State& s, EffectTick& tick) noexcept {
    if (region.shape == MediumRegion::Shape::kInside) return is_inside_body(region, s, tick);
    const Vec3 p = region.p_region_solver(tick.proxy_m);
    if (region.shape == MediumRegion::Shape::kThrough) return is_through(region, s, p, tick);
    const double outside_m = outside(region, p);
    if (outside_m <= 0.0) return true;
    tick.quiet_m = region.least_scale * outside_m;
    return false;
  }

  // The distance of a point outside of a box or sphere, region frame.
  static double outside(const MediumRegion& region, const Vec3& p) noexcept {
    return region.shape == MediumRegion::Shape::kSphere
               ? p.norm() - region.half_m.x()
               : (p.cwiseAbs() - region.half_m).cwiseMax(0.0).norm();
  }

  // A proxy never changes to the other side of a body, however either of them moves. The side of
  // the point at which a search began is therefore that of the proxy.
  static bool is_inside_body(const MediumRegion& region, State& s, EffectTick& tick) noexcept {
    const ContactBody& body = tick.world->body(region.body);
    if (s.is_known == 0.0) {
      // The proxy keeps a distance from the surface, so that rounding into the index frame cannot
      // change its side.
      const Vec3 p_index = body.to_index(body.to_body(tick.proxy_m));
      const auto inside = is_inside(*body.index, p_index, s.search, tick);
      if (!inside) return false;
      s.is_known = 1.0;
      s.is_inside = *inside ? 1.0 : 0.0;
    }
    if (s.is_inside != 0.0) return true;
    tick.quiet_m = tick.world->size_m();
    return false;
  }

  // If the side of the last point is known, the crossings of the path from that point give the side
  // of p. If the path meets an edge, the crossings are undecided and the side is found anew.
  static bool is_through(const MediumRegion& region, State& s, const Vec3& p,
                         EffectTick& tick) noexcept {
    const Box& box = region.index->box();
    if (!box.contains(p)) {
      tick.quiet_m = region.least_scale * std::sqrt(box.squared_distance(p));
      s.is_known = 0.0;
      s.is_inside = 0.0;
      s.search = {};
      return false;
    }
    // A search that was cut short gives the side of the point at which it began; from there, the
    // path to p gives the side of p.
    if (s.search.is_under_way()) {
      const Vec3 begun_at(s.search.point[0], s.search.point[1], s.search.point[2]);
      if (!find_side(region, s, begun_at, tick) || begun_at == p) return s.is_inside != 0.0;
    }
    find_side(region, s, p, tick);
    return s.is_inside != 0.0;
  }

  // Finds the side of p; on the surface, the side does not change. False if the search was cut
  // short.
  static bool find_side(const MediumRegion& region, State& s, const Vec3& p,
                        EffectTick& tick) noexcept {
    std::optional<bool> inside;
    const bool is_probing = s.search.segment == SideSearch::Segment::kProbe;
    if (s.is_known != 0.0 && !is_probing) {
      const Vec3 last(s.last_m[0], s.last_m[1], s.last_m[2]);
      const auto crosses =
          last == p ? std::optional(false) : crosses_odd(*region.index, last, p, s.search, tick);
      if (s.search.is_under_way()) return false;
      if (crosses) inside = (s.is_inside != 0.0) != *crosses;
    }
    if (!inside) inside = is_inside(*region.index, p, s.search, tick);
    if (s.search.is_under_way()) return false;
    s.is_known = inside ? 1.0 : 0.0;
    if (!inside) return true;
    s.is_inside = *inside ? 1.0 : 0.0;
    std::copy_n(p.data(), 3, s.last_m);
    return true;
  }

  // Both functions begin or continue a search. It is under way afterwards if it was cut short.
  static std::optional<bool> crosses_odd(const SurfaceIndex& index, const Vec3& from,
                                         const Vec3& to, SideSearch& search,
                                         EffectTick& tick) noexcept {
    if (tick.work == nullptr) return palpate::crosses_odd(index, from, to);
    if (!search.is_under_way()) search.begin_path(from, to);
    if (!may_search(tick)) return std::nullopt;
    return answer(count_crossings(index, search, *tick.work), search, tick);
  }
  static std::optional<bool> is_inside(const SurfaceIndex& index, const Vec3& p, SideSearch& search,
                                       EffectTick& tick) noexcept {
    if (tick.work == nullptr) return palpate::is_inside(index, p);
    if (!search.is_under_way()) search.begin_probe(index, p, 0);
    if (!may_search(tick)) return std::nullopt;
    return answer(palpate::find_side(index, search, *tick.work), search, tick);
  }
  static bool may_search(EffectTick& tick) noexcept {
    tick.is_capped = tick.is_capped || tick.work->is_spent();
    return !tick.work->is_spent();
  }
  static std::optional<bool> answer(SideResult result, SideSearch& search,
                                    EffectTick& tick) noexcept {
    if (result == SideResult::kCutShort) {
      tick.is_capped = true;
      return std::nullopt;
    }
    search = {};
    if (result == SideResult::kUndecided) return std::nullopt;
    return result == SideResult::kOdd;
  }
};

}  // namespace palpate
