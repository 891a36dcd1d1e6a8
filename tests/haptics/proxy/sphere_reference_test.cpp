// On a fine sphere, the proxy equals in every tick the god-object of that mesh as computed in long
// double: without a delay, and without a force ripple beyond that of the exact solution.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "haptics/haptic_loop.h"
#include "haptics/record_vectors.h"
#include "models/primitives.h"
#include "tests/haptics/proxy/reference_god_object.h"
#include "tests/helpers/made.h"
#include "tests/helpers/random.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::nearest_inside_convex;
using test::OwnedWorld;
using test::Random;
using test::ReferenceGodObject;
using test::ReferenceSurface;
using test::Soup;
using test::Wide;
using test::WideVec3;
using Side = test::ReferenceSurface::Side;

constexpr double kSphereRadius_m = 0.1;
constexpr double kProxyRadius_m = 0.5e-3;
constexpr double kDt_s = 1e-3;
constexpr double kStep_m = 0.1 * kDt_s;      // 0.1 m/s
constexpr double kLargestError_m = 1e-9;     // required by the specification
constexpr double kStiffness_N_per_m = 1000;  // undamped: the force is the lag of the goal

// A mesh in a random pose, touched through the haptic loop. The device frame is the scene frame.
class Touch {
 public:
  Touch(const TriangleMesh& mesh, const RigidTransform& T_scene_body, double radius_m)
      : T_scene_body_(T_scene_body),
        world_(Soup{mesh.positions_m, mesh.triangles}, T_scene_body, radius_m),
        loop_(test::made(HapticLoop::create(world_.world(), *ActuationModel::from_counts(3, 3),
                                            settings(radius_m)))) {}

  const TickRecord& tick(const Vec3& goal_body) {
    return loop_.tick(T_scene_body_.point(goal_body), kDt_s);
  }
  WideVec3 to_body(const Vec3& p_scene) const {
    const WideVec3 from_origin = p_scene.cast<Wide>() - T_scene_body_.translation_m.cast<Wide>();
    return T_scene_body_.rotation.cast<Wide>().normalized().conjugate() * from_origin;
  }
  WideVec3 to_body_direction(const Vec3& v_scene) const {
    return T_scene_body_.rotation.cast<Wide>().normalized().conjugate() * v_scene.cast<Wide>();
  }

 private:
  static HapticSettings settings(double radius_m) {
    HapticSettings settings;
    settings.god_object.radius_m = radius_m;
    settings.coupling = {kStiffness_N_per_m, 0.0};
    return settings;
  }

  RigidTransform T_scene_body_;
  OwnedWorld world_;
  HapticLoop loop_;
};

// The path of the device below the surface of a sphere of kSphereRadius_m: a great circle that
// slowly turns, at 0.1 m/s, at a depth that oscillates between two values (negative: outside).
class Stroke {
 public:
  Stroke(Random& random, double least_depth_m, double most_depth_m)
      : up_(random.unit_vector()),
        ahead_(up_.cross(random.unit_vector()).normalized()),
        weave_rad_per_s_(random.uniform(-1.0, 1.0)),
        least_depth_m_(least_depth_m),
        most_depth_m_(most_depth_m) {}

  Vec3 start() const { return 1.2 * kSphereRadius_m * up_; }
  Vec3 start_inside() const { return 0.8 * kSphereRadius_m * up_; }
  Vec3 next() {
    constexpr double kSwing_rad_per_s = 2.0;
    const double swing = 0.5 - 0.5 * std::cos(kSwing_rad_per_s * time_s_);
    const double depth_m = least_depth_m_ + swing * (most_depth_m_ - least_depth_m_);
    const double r = kSphereRadius_m - depth_m;
    const Vec3 left = up_.cross(ahead_);
    ahead_ = (ahead_ + weave_rad_per_s_ * kDt_s * left).normalized();
    up_ = (up_ + kStep_m / r * ahead_).normalized();
    ahead_ = (ahead_ - ahead_.dot(up_) * up_).normalized();
    time_s_ += kDt_s;
    return r * up_;
  }

 private:
  Vec3 up_;
  Vec3 ahead_;
  double weave_rad_per_s_;
  double least_depth_m_;
  double most_depth_m_;
  double time_s_ = 0.0;
};

// A sphere of 81,920 triangles, created once.
const TriangleMesh& fine_sphere() {
  static const TriangleMesh mesh = icosphere(6, kSphereRadius_m);
  return mesh;
}
const ReferenceSurface& fine_surface(Side side) {
  static const ReferenceSurface outside(fine_sphere().positions_m, fine_sphere().triangles,
                                        Side::kOutside);
  static const ReferenceSurface inside(fine_sphere().positions_m, fine_sphere().triangles,
                                       Side::kInside);
  return side == Side::kOutside ? outside : inside;
}

// Compares one run with the reference, tick by tick.
class Comparison {
 public:
  explicit Comparison(const Touch& touch) : touch_(touch) {}

  void expect(const TickRecord& record, const WideVec3& proxy_body) {
    const WideVec3 goal_body = touch_.to_body(vec3(record.goal_scene_m));
    const auto error_m =
        static_cast<double>((touch_.to_body(vec3(record.proxy_scene_m)) - proxy_body).norm());
    largest_error_m_ = std::max(largest_error_m_, error_m);
    ASSERT_LE(error_m, kLargestError_m) << "tick " << record.tick;
    ASSERT_EQ(record.faults, kFaultNone) << "tick " << record.tick;

    const WideVec3 force_N = touch_.to_body_direction(vec3(record.force_device_N));
    const WideVec3 exact_N = kStiffness_N_per_m * (proxy_body - goal_body);
    if (last_) {
      const WideVec3 ripple_N = (force_N - last_->rendered_N) - (exact_N - last_->exact_N);
      ASSERT_LE(ripple_N.norm(), 2 * kStiffness_N_per_m * kLargestError_m)
          << "tick " << record.tick;
    }
    last_ = Forces{force_N, exact_N};
  }
  double largest_error_m() const { return largest_error_m_; }

 private:
  struct Forces {
    WideVec3 rendered_N;
    WideVec3 exact_N;
  };
  const Touch& touch_;
  std::optional<Forces> last_;
  double largest_error_m_ = 0.0;
};

// ---- the mesh satisfies the assumptions of the references ---------------------------------------

// The neighbouring corners of every face lie on its inner side. A closed surface that is convex
// along all its edges bounds a convex body.
TEST(FineSphere, IsConvex) {
  const auto& [positions, triangles] = fine_sphere();
  ASSERT_EQ(triangles.size(), 81920u);
  const OwnedWorld world(Soup{positions, triangles});
  const SurfaceMesh& mesh = world.mesh();
  const ReferenceSurface surface(positions, triangles, Side::kOutside);
  for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
    for (int e = 0; e < 3; ++e) {
      const std::uint32_t neighbour = mesh.welded_neighbour(f, e);
      ASSERT_NE(neighbour, SurfaceMesh::kNone);
      Wide lowest_m = 0;
      for (const WideVec3& p : surface.faces()[neighbour].corners) {
        lowest_m = std::min(lowest_m, surface.height_m(f, p));
      }
      ASSERT_LT(lowest_m, -1e3L * surface.roundoff_m()) << "face " << f << ", edge " << e;
    }
  }
}

// ---- a point -----------------------------------------------------------------------------------

// The point of a triangle nearest to p, found by testing its plane, edges and corners in turn.
WideVec3 nearest_on_face(const ReferenceSurface& surface, std::uint32_t face, const WideVec3& p) {
  WideVec3 projection = surface.project(face, p, 0);
  const ReferenceSurface::Face& f = surface.faces()[face];
  bool inside = true;
  for (std::size_t e = 0; e < 3; ++e) inside &= f.inward[e].dot(projection - f.corners[e]) >= 0;
  if (inside) return projection;
  WideVec3 nearest = f.corners[0];
  for (std::size_t e = 0; e < 3; ++e) {
    const WideVec3& from = f.corners[e];
    const WideVec3 along = f.corners[(e + 1) % 3] - from;
    const Wide t = std::clamp<Wide>((p - from).dot(along) / along.squaredNorm(), 0, 1);
    const WideVec3 q = from + t * along;
    if ((q - p).squaredNorm() < (nearest - p).squaredNorm()) nearest = q;
  }
  return nearest;
}

WideVec3 nearest_on_surface(const ReferenceSurface& surface, const WideVec3& p, Wide reach_m) {
  const WideVec3 reach = WideVec3::Constant(reach_m);
  std::optional<WideVec3> nearest;
  for (const std::uint32_t face : surface.faces_around(p - reach, p + reach)) {
    const WideVec3 q = nearest_on_face(surface, face, p);
    if (!nearest || (q - p).squaredNorm() < (*nearest - p).squaredNorm()) nearest = q;
  }
  return nearest.value();
}

// The single face that holds the proxy; nullopt if it is not exactly one.
std::optional<std::uint32_t> only_face(const ReferenceGodObject& reference) {
  if (reference.active().size() != 1) return std::nullopt;
  return reference.active().front().face;
}

TEST(PointOnAFineSphere, IsTheGodObjectEveryTick) {
  constexpr int kTicks = 20000;
  const ReferenceSurface& surface = fine_surface(Side::kOutside);
  Random random(61);
  int changes_of_face = 0;
  int apart_from_nearest = 0;
  double largest_error_m = 0.0;
  for (int path = 0; path < 4; ++path) {
    SCOPED_TRACE(testing::Message() << "path " << path);
    Touch touch(fine_sphere(), random.pose(1.0), 0.0);
    Stroke stroke(random, 3e-3, 5e-3);
    ReferenceGodObject reference(surface,
                                 touch.to_body(vec3(touch.tick(stroke.start()).goal_scene_m)));
    Comparison comparison(touch);
    for (int n = 0; n < kTicks; ++n) {
      const TickRecord& record = touch.tick(stroke.next());
      const WideVec3 goal = touch.to_body(vec3(record.goal_scene_m));
      const auto held_by = only_face(reference);
      ASSERT_TRUE(reference.move_to(goal));
      ASSERT_TRUE(only_face(reference));
      changes_of_face += held_by != only_face(reference);
      if (n % 16 == 0) {
        const WideVec3 nearest = nearest_on_surface(surface, goal, 5.1e-3L);
        apart_from_nearest += (nearest - reference.proxy()).norm() > 1e4L * kLargestError_m;
      }
      ASSERT_NO_FATAL_FAILURE(comparison.expect(record, reference.proxy()));
      // A second reference: the proxy stays on its face until the projection leaves the face.
      if (!held_by || !surface.is_over(*held_by, goal)) continue;
      const WideVec3 projection = surface.project(*held_by, goal, 0);
      ASSERT_LE((touch.to_body(vec3(record.proxy_scene_m)) - projection).norm(), kLargestError_m);
    }
    largest_error_m = std::max(largest_error_m, comparison.largest_error_m());
  }
  EXPECT_GT(apart_from_nearest, 4 * kTicks / 16 / 100)
      << "too few results that differ from the nearest point";
  EXPECT_GT(changes_of_face, 4 * 2000) << "a path of 2 m over edges of 1.6 mm";
  RecordProperty("largest_error_m", std::to_string(largest_error_m * 1e12) + "e-12");
}

// A proxy that is pressed outwards from inside rests on faces, edges and vertices.
TEST(PointInAFineShell, IsTheNearestPointOfTheConvexInsideEveryTick) {
  constexpr int kTicks = 10000;
  const ReferenceSurface& surface = fine_surface(Side::kInside);
  Random random(62);
  std::array<int, 4> held_by{};
  for (int path = 0; path < 2; ++path) {
    SCOPED_TRACE(testing::Message() << "path " << path);
    Touch touch(fine_sphere(), random.pose(1.0), 0.0);
    Stroke stroke(random, -5e-3, -3e-3);
    ReferenceGodObject walk(surface,
                            touch.to_body(vec3(touch.tick(stroke.start_inside()).goal_scene_m)));
    Comparison comparison(touch);
    for (int n = 0; n < kTicks; ++n) {
      const TickRecord& record = touch.tick(stroke.next());
      const WideVec3 goal = touch.to_body(vec3(record.goal_scene_m));
      const auto nearest = nearest_inside_convex(surface, goal, 0, 6e-3L);
      ++held_by[nearest.active.size()];
      ASSERT_NO_FATAL_FAILURE(comparison.expect(record, nearest.point));
      // This compares the reference god-object with the exact nearest point.
      ASSERT_TRUE(walk.move_to(goal));
      ASSERT_LE((walk.proxy() - nearest.point).norm(), 1e-3L * kLargestError_m) << "tick " << n;
    }
  }
  for (const std::size_t planes : {1, 2, 3}) EXPECT_GT(held_by[planes], 0) << planes;
}

// On ridges, valleys and saddles, one tick may pass several local minima, and the path decides
// which one is reached. The reference starts at the proxy's rest and shows whether it is a local
// minimum.
class PointOnABumpySphere : public testing::TestWithParam<bool> {};  // from outside

TEST_P(PointOnABumpySphere, IsALocalMinimumEveryTick) {
  constexpr int kTicks = 20000;
  const bool outside = GetParam();
  const Side side = outside ? Side::kOutside : Side::kInside;
  const TriangleMesh mesh = bumpy_sphere(5, kSphereRadius_m, 3e-3, 7);
  const ReferenceSurface surface(mesh.positions_m, mesh.triangles, side);
  Random random(63);
  for (int path = 0; path < 4; ++path) {
    SCOPED_TRACE(testing::Message() << "path " << path);
    Touch touch(mesh, random.pose(1.0), 0.0);
    Stroke stroke = outside ? Stroke(random, 3e-3, 5e-3) : Stroke(random, -5e-3, -3e-3);
    touch.tick(outside ? stroke.start() : stroke.start_inside());
    Comparison comparison(touch);
    for (int n = 0; n < kTicks; ++n) {
      const TickRecord& record = touch.tick(stroke.next());
      ReferenceGodObject walk(surface, touch.to_body(vec3(record.proxy_scene_m)));
      ASSERT_TRUE(walk.move_to(touch.to_body(vec3(record.goal_scene_m))));
      ASSERT_NO_FATAL_FAILURE(comparison.expect(record, walk.proxy()));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Sides, PointOnABumpySphere, testing::Bool(),
                         [](const auto& outside) { return outside.param ? "outside" : "inside"; });

// A vertex of that sphere, touched from inside. The planes of three faces hold the proxy there, but
// one of these faces ends at the vertex. A valley beyond it is free and leads nearer to the goal.
TEST(PointAtASaddleVertex, ContinuesAlongTheValley) {
  const Soup fan{{{-0.076569, 0.030043, -0.056291},
                  {-0.076269, 0.033340, -0.054868},
                  {-0.073928, 0.031952, -0.057894},
                  {-0.074088, 0.028615, -0.059211},
                  {-0.076786, 0.026708, -0.057658},
                  {-0.079169, 0.028088, -0.054620},
                  {-0.078810, 0.031376, -0.053151}},
                 {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}, {0, 5, 6}, {0, 6, 1}}};
  const Vec3 start(-0.072718, 0.028558, -0.053490);
  const Vec3 goal(-0.080104, 0.031757, -0.059998);
  Touch touch({fan.positions, fan.triangles}, {}, 0.0);
  touch.tick(start);
  const TickRecord& record = touch.tick(goal);
  const ReferenceSurface surface(fan.positions, fan.triangles, Side::kInside);
  ReferenceGodObject walk(surface, touch.to_body(vec3(record.proxy_scene_m)));
  ASSERT_TRUE(walk.move_to(touch.to_body(vec3(record.goal_scene_m))));
  EXPECT_LE((touch.to_body(vec3(record.proxy_scene_m)) - walk.proxy()).norm(), kLargestError_m)
      << "farther from the goal by "
      << (vec3(record.proxy_scene_m) - goal).norm() -
             static_cast<double>((walk.proxy() - goal.cast<Wide>()).norm());
}

// ---- a sphere ----------------------------------------------------------------------------------

TEST(SphereInAFineShell, IsTheNearestPointOfTheConvexInsideEveryTick) {
  constexpr int kTicks = 10000;
  const ReferenceSurface& surface = fine_surface(Side::kInside);
  Random random(64);
  for (int path = 0; path < 2; ++path) {
    SCOPED_TRACE(testing::Message() << "path " << path);
    Touch touch(fine_sphere(), random.pose(1.0), kProxyRadius_m);
    Stroke stroke(random, -5e-3, -3e-3);
    touch.tick(stroke.start_inside());
    Comparison comparison(touch);
    for (int n = 0; n < kTicks; ++n) {
      const TickRecord& record = touch.tick(stroke.next());
      const WideVec3 goal = touch.to_body(vec3(record.goal_scene_m));
      ASSERT_NO_FATAL_FAILURE(comparison.expect(
          record, nearest_inside_convex(surface, goal, kProxyRadius_m, 6e-3L).point));
    }
  }
}

// Goals outside the mesh but nearer than the radius. The offset surface at the distance of one
// radius is curved round edges and vertices there, and its only nearest point lies straight out
// from the convex mesh.
TEST(SphereOnAFineSphere, IsStraightOutFromTheMeshWhereTheGoalIsOutside) {
  constexpr int kTicks = 10000;
  const ReferenceSurface& surface = fine_surface(Side::kOutside);
  Random random(65);
  for (int path = 0; path < 2; ++path) {
    SCOPED_TRACE(testing::Message() << "path " << path);
    Touch touch(fine_sphere(), random.pose(1.0), kProxyRadius_m);
    Stroke stroke(random, -0.9 * kProxyRadius_m, -0.1 * kProxyRadius_m);
    touch.tick(stroke.start());
    Comparison comparison(touch);
    for (int n = 0; n < kTicks; ++n) {
      const TickRecord& record = touch.tick(stroke.next());
      const WideVec3 goal = touch.to_body(vec3(record.goal_scene_m));
      const WideVec3 q = nearest_on_surface(surface, goal, kProxyRadius_m);
      const WideVec3 expected = q + static_cast<Wide>(kProxyRadius_m) * (goal - q).normalized();
      ASSERT_NO_FATAL_FAILURE(comparison.expect(record, expected));
    }
  }
}

// The local minima of the distance for a goal so deep that the proxy cannot rest on edges and
// vertices: straight above the goal, on a face near `around`.
struct RestingPlace {
  std::uint32_t face;
  WideVec3 centre;
};
std::vector<RestingPlace> resting_places(const ReferenceSurface& surface, const WideVec3& goal,
                                         const WideVec3& around) {
  const WideVec3 reach = WideVec3::Constant(2e-3L);  // the longest edge is 1.8 mm
  std::vector<RestingPlace> places;
  for (const std::uint32_t face : surface.faces_around(around - reach, around + reach)) {
    if (surface.height_m(face, goal) < 0 && surface.is_over(face, goal)) {
      places.push_back({face, surface.project(face, goal, kProxyRadius_m)});
    }
  }
  return places;
}

// For deep goals, the proxy rests where it touches a single face with the goal under it: the edges
// and vertices of a convex mesh push it away. It stays on that face until the projection leaves it.
TEST(SphereOnAFineSphere, StaysOnItsFaceUntilTheProjectionLeavesIt) {
  constexpr int kTicks = 10000;
  const ReferenceSurface& surface = fine_surface(Side::kOutside);
  Random random(66);
  int changes_of_face = 0;
  int places_to_choose_from = 0;
  for (int path = 0; path < 2; ++path) {
    SCOPED_TRACE(testing::Message() << "path " << path);
    Touch touch(fine_sphere(), random.pose(1.0), kProxyRadius_m);
    Stroke stroke(random, 3e-3, 5e-3);
    touch.tick(stroke.start());
    Comparison comparison(touch);
    std::optional<std::uint32_t> face;
    for (int n = 0; n < kTicks; ++n) {
      const TickRecord& record = touch.tick(stroke.next());
      const WideVec3 goal = touch.to_body(vec3(record.goal_scene_m));
      const WideVec3 proxy = touch.to_body(vec3(record.proxy_scene_m));
      if (!face || !surface.is_over(*face, goal)) {
        ++changes_of_face;
        const auto places = resting_places(surface, goal, proxy);
        ASSERT_FALSE(places.empty()) << "tick " << n;
        places_to_choose_from += static_cast<int>(places.size());
        face = std::min_element(places.begin(), places.end(),
                                [&](const RestingPlace& a, const RestingPlace& b) {
                                  return (a.centre - proxy).norm() < (b.centre - proxy).norm();
                                })
                   ->face;
      }
      const WideVec3 expected = surface.project(*face, goal, kProxyRadius_m);
      ASSERT_NO_FATAL_FAILURE(comparison.expect(record, expected));
    }
  }
  EXPECT_GT(changes_of_face, 2 * 1000);
  EXPECT_LT(places_to_choose_from, 3 * changes_of_face) << "too many resting places to choose from";
}

}  // namespace
}  // namespace palpate
