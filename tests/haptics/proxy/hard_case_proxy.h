#pragma once

// A god-object with a judgement of every tick. The result must be finite and certified, the proxy
// must stay on its side of the surfaces, and no step may increase the distance to the goal.

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "geometry/exact/exact.h"
#include "haptics/proxy/god_object.h"
#include "tests/haptics/proxy/hard_case_exact.h"
#include "tests/helpers/made.h"
#include "tests/helpers/sanitizers.h"
#include "tests/helpers/worlds.h"

namespace palpate::test {

// AddressSanitizer makes a tick up to twenty times slower. If it is used, the number of trials of
// heavy cases is divided by this number.
inline constexpr int kSanitizerDivisor = kHasAddressSanitizer ? 20 : 1;
constexpr int trials(int in_release) {
  return std::max(1, in_release / kSanitizerDivisor);
}

// The accuracy that the specification requires, relative to the scene's size.
inline constexpr double kRelativeAccuracy = 1e-9;

inline std::string radius_name(const testing::TestParamInfo<double>& radius_m) {
  if (radius_m.param == 0.0) return "Point";
  return "Sphere" + std::to_string(std::lround(1e6 * radius_m.param)) + "um";
}

// Tolerance for rounding in the energy of a tick, relative to the energies compared.
inline constexpr double kCertificateTolerance = 1e-12;

// The certificate of a passive spring: whether K/2 |p - x|^2 grew by no more than the work of the
// device, for K = 1 N/m. x is the device point and p the proxy, in the solver frame. If the lag is
// below a thousandth of the coordinates, the rounding of p exceeds the relative tolerance. The
// rounding of p is permitted twice: at the end of a step, and where the proxy is lifted or stopped.
inline bool keeps_energy_certificate(const Vec3& p_before, const Vec3& x_before,
                                     const Vec3& p_after, const Vec3& x_after) {
  const Vec3 moved = x_after - x_before;
  const double before_J = 0.5 * (p_before - x_before).squaredNorm();
  const double after_J = 0.5 * (p_after - x_after).squaredNorm();
  const double given_J = -(p_before - x_before).dot(moved);
  const double leak_J = 0.5 * moved.squaredNorm();
  const double scale_J = before_J + after_J + std::abs(given_J) + leak_J;
  const double rounding_m = 2 * std::sqrt(3.0) * 0x1p-53 * p_after.lpNorm<Eigen::Infinity>();
  const double allowed_J =
      kCertificateTolerance * scale_J + rounding_m * ((p_after - x_after).norm() + rounding_m);
  return after_J - before_J - given_J - leak_J <= allowed_J;
}

// The soup with its corners transformed by a pose and rounded. The resulting body needs no
// transform, so that the solver's triangles are known bit for bit.
inline Soup posed(const Soup& soup, const RigidTransform& pose) {
  Soup moved = soup;
  for (Vec3& p : moved.positions) p = pose.point(p);
  return moved;
}

// Coordinates rounded to multiples of 2^-20 m, whose sums, halves and quarters are exact.
inline Vec3 on_lattice(const Vec3& p_m) {
  return (p_m * 0x1p20).array().round().matrix() * 0x1p-20;
}
inline Soup on_lattice(Soup soup) {
  for (Vec3& p : soup.positions) p = on_lattice(p);
  return soup;
}

// A proxy in the scene frame of its world that judges each of its ticks. verdict() is empty as long
// as every tick satisfies these conditions:
//   - The result is finite, with a normal of length 1 or 0.
//   - The energy certificate holds. No corner of the path is farther from the goal than the
//     previous corner. A sphere that moves round a feature along tangents may exceed this limit by
//     a hundredth of the radius, but not at the end of the tick.
//   - The committed path touches no triangle of the world, in exact arithmetic. At the corners of
//     the path, the distance of a sphere's centre from each triangle is at least the radius.
// Paths are judged only if the bodies need no transform; otherwise the geometry would be known only
// up to rounding.
class JudgedProxy {
 public:
  explicit JudgedProxy(const OwnedWorld& world, double radius_m = 0.0)
      : world_(&world.world()),
        radius_m_(radius_m),
        god_object_(test::made(GodObject::create(world.world(), {.radius_m = radius_m}))) {
    for (const ContactBody& body : world_->bodies) {
      if (!body.is_identity) continue;
      for (std::uint32_t id = 0; id < body.index->pack_count(); ++id) collect(*body.index, id);
    }
  }

  void place(const Vec3& p_scene) { place_solver(world_->to_solver(p_scene)); }
  void place_solver(const Vec3& p) {
    god_object_.place(p);
    last_goal_ = p;
  }

  ProxyState move_to(const Vec3& goal_scene) {
    ProxyState state = move_to_solver(world_->to_solver(goal_scene));
    state.proxy = world_->to_scene(state.proxy);
    return state;
  }
  ProxyState move_to_solver(const Vec3& goal,
                            const std::optional<Vec3>& motion_plane_normal = std::nullopt) {
    const Vec3 before = god_object_.proxy();
    const ProxyState state = god_object_.move_to(goal, motion_plane_normal);
    ++ticks_;
    if (verdict_.empty()) {
      judge_numbers(state);
      judge_energy(before, goal, state);
      judge_path();
      if (!verdict_.empty()) describe(before, goal, state);
    }
    last_goal_ = goal;
    return state;
  }

  const Vec3& proxy_solver() const { return god_object_.proxy(); }
  Vec3 proxy_scene() const { return world_->to_scene(god_object_.proxy()); }
  const SolverScale& scale() const { return god_object_.scale(); }
  double size_m() const { return world_->size_m; }
  const std::string& verdict() const { return verdict_; }

 private:
  void collect(const SurfaceIndex& index, std::uint32_t pack) {
    for (int lane = 0; lane < index.pack(pack).count; ++lane) {
      const TriangleGeometry& t = index.triangle(SurfaceIndex::slot(pack, lane));
      if (exactly_collinear(t.a, t.b, t.c)) continue;  // no area: part of its neighbours' edges
      corners_.push_back({t.a, t.b, t.c});
      triangles_.push_back(t);
    }
  }

  void judge_numbers(const ProxyState& state) {
    const double length = state.normal.norm();
    const bool unit = length == 0.0 || std::abs(length - 1.0) < 1e-15;
    if (!state.proxy.allFinite() || !state.normal.allFinite() || !unit) {
      verdict_ += "the result is not finite or its normal is not a unit vector; ";
    }
  }

  void judge_energy(const Vec3& before, const Vec3& goal, const ProxyState& state) {
    if (!keeps_energy_certificate(before, last_goal_, state.proxy, goal)) {
      verdict_ += "the tick created energy; ";
    }
    const auto path = god_object_.path();
    for (std::size_t i = 1; i < path.size(); ++i) {
      judge_segment(path[i - 1], path[i], goal, 0.01 * radius_m_);
    }
    judge_segment(path.front(), path.back(), goal, 0.0);
  }

  void judge_segment(const Vec3& from, const Vec3& to, const Vec3& goal, double allowed_m) {
    const double nearer = (from - goal).norm();
    // Tolerance for the rounding of a corner's coordinates.
    const double roundoff = 4 * 0x1p-52 * (nearer + to.lpNorm<Eigen::Infinity>());
    const double excess = (to - goal).norm() - nearer;
    if (!(excess <= allowed_m + roundoff))
      verdict_ += "the path increases the distance to the goal by " + number(excess) + "; ";
  }

  void judge_path() {
    const auto path = god_object_.path();
    if (triangles_.empty() || path.size() < 2) return;
    for (std::size_t i = 1; i < path.size(); ++i) {
      for (const auto& corners : corners_) {
        if (exactly_touch(corners, path[i - 1], path[i])) {
          verdict_ += "piece " + std::to_string(i) + " of the path touches a triangle; ";
        }
      }
      if (radius_m_ > 0.0) judge_clearance(path[i]);
    }
    if (path.back() != god_object_.proxy()) verdict_ += "the path does not end at the proxy; ";
  }

  void judge_clearance(const Vec3& centre) {
    for (const TriangleGeometry& t : triangles_) {
      const Box box{t.a.cwiseMin(t.b).cwiseMin(t.c), t.a.cwiseMax(t.b).cwiseMax(t.c)};
      if (box.squared_distance(centre) > 2 * radius_m_ * radius_m_) continue;
      const double clearance = closest_point_on_triangle(t, centre).distance - radius_m_;
      if (!(clearance >= 0.0)) verdict_ += "the sphere overlaps by " + number(-clearance) + "; ";
    }
  }

  void describe(const Vec3& before, const Vec3& goal, const ProxyState& state) {
    std::ostringstream text;
    text << std::hexfloat << "at tick " << ticks_ << " (solver frame) from (" << before.transpose()
         << ") to goal (" << goal.transpose() << "), last goal (" << last_goal_.transpose()
         << "), ended at (" << state.proxy.transpose() << ") after " << state.iterations
         << " iterations";
    verdict_ += text.str();
  }
  static std::string number(double value) {
    std::ostringstream text;
    text << value;
    return text.str();
  }

  const ContactWorld* world_;
  double radius_m_;
  GodObject god_object_;
  std::vector<std::array<Vec3, 3>> corners_;
  std::vector<TriangleGeometry> triangles_;
  Vec3 last_goal_ = Vec3::Zero();
  std::uint64_t ticks_ = 0;
  std::string verdict_;
};

}  // namespace palpate::test
