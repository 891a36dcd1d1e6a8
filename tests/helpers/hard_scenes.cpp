#include "tests/helpers/hard_scenes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace palpate::test {
namespace {

using Profile = std::vector<Eigen::Vector2d>;

constexpr double kHalfSize_m = 0.08;
constexpr double kSliverWidth_m = 1e-9;  // against 0.1 m
constexpr double kDegree_rad = std::numbers::pi / 180.0;

double log_uniform(Random& random, double low, double high) {
  return low * std::pow(high / low, random.uniform(0.0, 1.0));
}

int between(Random& random, int low, int high) {
  return low + static_cast<int>(random.index(static_cast<std::uint64_t>(high - low + 1)));
}

double sign(Random& random) {
  return random.index(2) ? 1.0 : -1.0;
}

void append(const Soup& other, Soup& soup) {
  const auto first = static_cast<std::uint32_t>(soup.positions.size());
  soup.positions.insert(soup.positions.end(), other.positions.begin(), other.positions.end());
  for (const Triangle& t : other.triangles) {
    soup.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
}

Soup moved(Soup soup, const RigidTransform& pose) {
  for (Vec3& p : soup.positions) p = pose.point(p);
  return soup;
}

std::vector<double> random_stations(Random& random, int count) {
  std::vector<double> stations = {-kHalfSize_m, kHalfSize_m};
  for (int i = 0; i < count; ++i) stations.push_back(random.uniform(-kHalfSize_m, kHalfSize_m));
  std::sort(stations.begin(), stations.end());
  return stations;
}

// Stations in bundles; within a bundle they are a sliver's width apart.
std::vector<double> bundled_stations(Random& random) {
  std::vector<double> stations = random_stations(random, between(random, 0, 3));
  const std::size_t bundles = stations.size();
  for (std::size_t i = 0; i < bundles; ++i) {
    const double inwards = stations[i] > 0.0 ? -1.0 : 1.0;
    const int lines = between(random, 0, 4);
    for (int k = 1; k <= lines; ++k) {
      stations.push_back(stations[i] + inwards * k * random.uniform(1.0, 3.0) * kSliverWidth_m);
    }
  }
  std::sort(stations.begin(), stations.end());
  return stations;
}

Profile random_profile(Random& random) {
  const int corners = between(random, 3, 7);
  const double squeeze = log_uniform(random, 1e-3, 1.0);
  std::vector<double> angles;
  for (int i = 0; i < corners; ++i) {
    angles.push_back((i + random.uniform(0.1, 0.9)) * 2 * std::numbers::pi / corners);
  }
  Profile profile;
  for (const double angle : angles) {
    profile.emplace_back(0.06 * std::cos(angle), 0.06 * squeeze * std::sin(angle));
  }
  return profile;
}

Profile box_profile(double half_y, double half_z) {
  return {{-half_y, -half_z}, {half_y, -half_z}, {half_y, half_z}, {-half_y, half_z}};
}

Soup wedge(Random& random) {
  constexpr double kAngles_deg[] = {0.5, 1.0, 5.0, 45.0, 90.0, 175.0, 179.0, 179.9};
  const double angle_deg = random.index(2) ? kAngles_deg[random.index(std::size(kAngles_deg))]
                                           : log_uniform(random, 0.5, 179.9);
  const double half = 0.5 * angle_deg * kDegree_rad;
  const Eigen::Vector2d arm(kHalfSize_m * std::sin(half), -kHalfSize_m * std::cos(half));
  const Profile profile = {{0.0, 0.0}, {-arm.x(), arm.y()}, arm};
  return extruded(profile, random_stations(random, between(random, 0, 6)));
}

// A cone from a polygon, which need not be regular, to a point.
Soup needle(Random& random) {
  const int sides = between(random, 3, 48);
  const double radius = log_uniform(random, 1e-6, 1e-2);
  const Vec3 tip(0.0, 0.0, kHalfSize_m);
  const Vec3 foot(0.0, 0.0, -kHalfSize_m * random.uniform(0.0, 1.0));
  std::vector<Vec3> ring;
  for (int i = 0; i < sides; ++i) {
    const double angle = (i + random.uniform(0.0, 0.8)) * 2 * std::numbers::pi / sides;
    ring.emplace_back(radius * std::cos(angle), radius * std::sin(angle), foot.z());
  }
  Soup soup;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Vec3& next = ring[(i + 1) % ring.size()];
    soup.add(ring[i], next, tip);
    soup.add(next, ring[i], foot);
  }
  return soup;
}

HardScene needles(Random& random) {
  HardScene scene;
  const int count = between(random, 1, 3);
  for (int i = 0; i < count; ++i) {
    append(i == 0 ? needle(random) : moved(needle(random), random.pose(0.02)), scene.soup);
  }
  scene.is_closed = true;
  return scene;
}

// Rings of vertices whose heights alternate around the centre.
Soup saddle(Random& random) {
  const int spokes = 2 * between(random, 3, 20);
  const int waves = random.index(2) ? between(random, 2, 3) : spokes / 2;
  const double height = log_uniform(random, 1e-5, 0.05);
  const double lift = random.index(2) ? 0.0 : random.uniform(-height, height);
  const auto at = [&](int spoke, double radius) {
    const double angle = (spoke % spokes) * 2 * std::numbers::pi / spokes;
    const double z = height * std::cos(waves * angle) * radius / kHalfSize_m;
    return Vec3(radius * std::cos(angle), radius * std::sin(angle), z);
  };
  Soup soup;
  const Vec3 middle(0.0, 0.0, lift);
  const double inner = log_uniform(random, 1e-5, 0.5) * kHalfSize_m;
  for (int i = 0; i < spokes; ++i) {
    soup.add(middle, at(i, inner), at(i + 1, inner));
    soup.add_quad(at(i, inner), at(i, kHalfSize_m), at(i + 1, kHalfSize_m), at(i + 1, inner));
  }
  return soup;
}

// Adds a vertex next to an edge of some faces, just inside. The surface remains closed and gains
// obtuse slivers.
void add_flat_slivers(Soup& soup, Random& random, int count) {
  for (int i = 0; i < count; ++i) {
    Triangle& face = soup.triangles[random.index(soup.triangles.size())];
    const Triangle old = face;
    const Vec3 a = soup.positions[old[0]];
    const Vec3 b = soup.positions[old[1]];
    const Vec3 c = soup.positions[old[2]];
    const double along = random.uniform(0.1, 0.9);
    const Vec3 middle = a + along * (b - a);
    const double inwards = log_uniform(random, kSliverWidth_m, 1e3 * kSliverWidth_m);
    const auto added = static_cast<std::uint32_t>(soup.positions.size());
    soup.positions.push_back(middle + inwards * (c - middle).normalized());
    face = {old[0], old[1], added};
    soup.triangles.push_back({old[1], old[2], added});
    soup.triangles.push_back({old[2], old[0], added});
  }
}

Soup sliver_body(Random& random) {
  const bool is_slab = random.index(2);
  Soup soup =
      extruded(is_slab ? box_profile(kHalfSize_m, 0.5 * kSheetDistance_m) : random_profile(random),
               bundled_stations(random));
  add_flat_slivers(soup, random, between(random, 0, 8));
  return soup;
}

Soup plain_body(Random& random) {
  switch (random.index(3)) {
    case 0:
      return box_soup(Vec3::Constant(0.02) + random.in_box(0.01));
    case 1:
      return extruded(random_profile(random), random_stations(random, between(random, 0, 3)));
    default:
      return wedge(random);
  }
}

HardScene repeated(Random& random) {
  HardScene scene{plain_body(random), true, {}};
  Soup& soup = scene.soup;
  const std::size_t faces = soup.triangles.size();
  const auto some_face = [&] { return soup.triangles[random.index(faces)]; };
  for (int i = between(random, 1, 10); i > 0; --i) {
    Triangle copy = some_face();
    std::rotate(copy.begin(), copy.begin() + between(random, 0, 2), copy.end());
    if (random.index(2)) std::swap(copy[0], copy[1]);
    soup.triangles.push_back(copy);
  }
  for (int i = between(random, 1, 5); i > 0; --i) {
    const Triangle t = some_face();
    soup.triangles.push_back({t[0], t[1], t[0]});
  }
  if (random.index(2)) return scene;
  // The midpoint of an edge, moved off the edge by rounding: a face of almost no area, and one face
  // too many at the edge.
  scene.is_closed = false;
  for (int i = between(random, 1, 5); i > 0; --i) {
    const Triangle t = some_face();
    const Vec3 a = soup.positions[t[0]];
    const Vec3 b = soup.positions[t[1]];
    soup.add(a, b, a + random.uniform(0.1, 0.9) * (b - a));
  }
  return scene;
}

Vec3 flat(Random& random, double half_extent) {
  Vec3 p = random.in_box(half_extent);
  p.z() = 0.0;
  return p;
}

HardScene coplanar_overlap(Random& random) {
  HardScene scene;
  for (int sheet = between(random, 1, 3); sheet > 0; --sheet) {
    Soup overlapping;
    const int faces = between(random, 2, 12);
    for (int i = 0; i < faces; ++i) {
      const Vec3 a = flat(random, kHalfSize_m);
      const double size = log_uniform(random, 1e-3, 2.0);
      overlapping.add(a, a + size * flat(random, kHalfSize_m),
                      a + size * flat(random, kHalfSize_m));
    }
    const Vec3 up(0.0, 0.0, random.index(2) ? 0.0 : random.uniform(-0.02, 0.02));
    // Some sheets lie in exactly the same plane, others cross it.
    const Quat turn = random.index(3) ? Quat(Quat::Identity()) : random.rotation();
    append(moved(overlapping, {turn, up}), scene.soup);
  }
  return scene;
}

// A rectangle of origin, u and v with vertices of its own on its border; some of them miss the
// border by 1 um.
void add_ragged_face(const Vec3& origin, const Vec3& u, const Vec3& v, Random& random, Soup& soup) {
  const int columns = between(random, 1, 4);
  const int rows = between(random, 1, 4);
  const auto fractions = [&](int count) {
    std::vector<double> at = {0.0};
    for (int i = 1; i < count; ++i) at.push_back((i + random.uniform(-0.4, 0.4)) / count);
    at.push_back(1.0);
    return at;
  };
  const std::vector<double> s = fractions(columns);
  const std::vector<double> t = fractions(rows);
  std::vector<Vec3> nodes;
  for (int j = 0; j <= rows; ++j) {
    for (int i = 0; i <= columns; ++i) {
      Vec3 node = origin + s[static_cast<std::size_t>(i)] * u + t[static_cast<std::size_t>(j)] * v;
      const bool at_side = i == 0 || i == columns;
      const bool at_end = j == 0 || j == rows;
      if (at_side != at_end) node[between(random, 0, 2)] += between(random, -1, 1) * kGapWidth_m;
      nodes.push_back(node);
    }
  }
  const auto at = [&](int i, int j) {
    return nodes[static_cast<std::size_t>(j * (columns + 1) + i)];
  };
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      soup.add_quad(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
    }
  }
}

HardScene t_junctions(Random& random) {
  HardScene scene;
  const Vec3 half(random.uniform(0.02, 0.1), random.uniform(0.02, 0.1), random.uniform(0.001, 0.1));
  scene.soup = ragged_box(half, random);
  for (const Vec3& p : scene.soup.positions) {
    if (random.index(4) == 0) scene.aims.push_back(p);
  }
  return scene;
}

// Sheets of strips with slits between them.
HardScene gaps(Random& random) {
  HardScene scene;
  const int sheets = between(random, 1, 3);
  for (int sheet = 0; sheet < sheets; ++sheet) {
    const double z = sheet * log_uniform(random, 1e-5, 0.03);
    const std::vector<double> x = random_stations(random, between(random, 1, 4));
    for (std::size_t i = 0; i + 1 < x.size(); ++i) {
      const double left = x[i] + (i == 0 ? 0.0 : 0.5 * kGapWidth_m);
      const double right = x[i + 1] - (i + 2 == x.size() ? 0.0 : 0.5 * kGapWidth_m);
      scene.soup.add_quad({left, -kHalfSize_m, z}, {right, -kHalfSize_m, z},
                          {right, kHalfSize_m, z}, {left, kHalfSize_m, z});
      for (int k = 0; k < 4 && i > 0; ++k) {
        scene.aims.emplace_back(x[i], random.uniform(-kHalfSize_m, kHalfSize_m), z);
      }
    }
  }
  return scene;
}

HardScene thin_sheets(Random& random) {
  HardScene scene;
  const int sheets = between(random, 2, 5);
  const bool is_closed = random.index(2);
  scene.is_closed = is_closed;
  for (int sheet = 0; sheet < sheets; ++sheet) {
    const Profile profile = box_profile(kHalfSize_m, 0.25 * kSheetDistance_m);
    const Vec3 up(0.0, 0.0, sheet * kSheetDistance_m);
    if (is_closed) {
      append(moved(extruded(profile, random_stations(random, between(random, 0, 3))),
                   {Quat::Identity(), up}),
             scene.soup);
      continue;
    }
    const Vec3 hub = flat(random, 0.5 * kHalfSize_m) + up;
    const double h = kHalfSize_m;
    const Vec3 corners[] = {{-h, -h, 0.0}, {h, -h, 0.0}, {h, h, 0.0}, {-h, h, 0.0}};
    for (int i = 0; i < 4; ++i) {
      scene.soup.add(hub, corners[i] + up, corners[(i + 1) % 4] + up);
    }
  }
  return scene;
}

HardScene self_intersections(Random& random) {
  HardScene scene;
  scene.is_closed = true;
  for (int i = between(random, 2, 4); i > 0; --i) {
    const RigidTransform pose =
        random.index(3) ? random.pose(0.03) : RigidTransform{Quat::Identity(), random.in_box(0.03)};
    append(moved(plain_body(random), pose), scene.soup);
  }
  return scene;
}

bool has_face(const Soup& soup) {
  return std::any_of(soup.triangles.begin(), soup.triangles.end(), [&](const Triangle& t) {
    const Vec3 &a = soup.positions[t[0]], &b = soup.positions[t[1]], &c = soup.positions[t[2]];
    return a != b && b != c && c != a;
  });
}

// Few points: triangles share some of them, and some triangles have no area. At least one has.
HardScene loose_triangles(Random& random) {
  HardScene scene;
  std::vector<Vec3> points;
  for (int i = between(random, 6, 30); i > 0; --i) points.push_back(random.in_box(kHalfSize_m));
  const auto some_point = [&] { return points[random.index(points.size())]; };
  for (int i = between(random, 4, 60); i > 0 || !has_face(scene.soup); --i) {
    const Vec3 a = some_point();
    const Vec3 b = random.index(2)
                       ? some_point()
                       : Vec3(a + log_uniform(random, 1e-5, 0.05) * random.unit_vector());
    scene.soup.add(a, b, some_point());
  }
  return scene;
}

HardScene as_built(HardKind kind, Random& random) {
  switch (kind) {
    case HardKind::kWedge:
      return {wedge(random), true, {}};
    case HardKind::kNeedle:
      return needles(random);
    case HardKind::kSaddle:
      return {saddle(random), false, {}};
    case HardKind::kSliver:
      return {sliver_body(random), true, {}};
    case HardKind::kRepeated:
      return repeated(random);
    case HardKind::kCoplanarOverlap:
      return coplanar_overlap(random);
    case HardKind::kTJunction:
      return t_junctions(random);
    case HardKind::kGap:
      return gaps(random);
    case HardKind::kThinSheets:
      return thin_sheets(random);
    case HardKind::kSelfIntersection:
      return self_intersections(random);
    case HardKind::kSoup:
      return loose_triangles(random);
  }
  return {};
}

}  // namespace

const char* name_of(HardKind kind) {
  switch (kind) {
    case HardKind::kWedge:
      return "Wedges";
    case HardKind::kNeedle:
      return "Needles";
    case HardKind::kSaddle:
      return "Saddles";
    case HardKind::kSliver:
      return "Slivers";
    case HardKind::kRepeated:
      return "RepeatedFaces";
    case HardKind::kCoplanarOverlap:
      return "CoplanarOverlaps";
    case HardKind::kTJunction:
      return "TJunctions";
    case HardKind::kGap:
      return "Gaps";
    case HardKind::kThinSheets:
      return "ThinSheets";
    case HardKind::kSelfIntersection:
      return "SelfIntersections";
    case HardKind::kSoup:
      return "LooseTriangles";
  }
  return "";
}

Soup extruded(const std::vector<Eigen::Vector2d>& profile_m,
              const std::vector<double>& stations_m) {
  const std::size_t sides = profile_m.size();
  const auto at = [&](std::size_t station, std::size_t corner) {
    const Eigen::Vector2d& p = profile_m[corner % sides];
    return Vec3(stations_m[station], p.x(), p.y());
  };
  Soup soup;
  const std::size_t last = stations_m.size() - 1;
  for (std::size_t i = 0; i < last; ++i) {
    for (std::size_t k = 0; k < sides; ++k) {
      soup.add_quad(at(i, k), at(i, k + 1), at(i + 1, k + 1), at(i + 1, k));
    }
  }
  for (std::size_t k = 1; k + 1 < sides; ++k) {
    soup.add(at(0, 0), at(0, k + 1), at(0, k));
    soup.add(at(last, 0), at(last, k), at(last, k + 1));
  }
  return soup;
}

Soup ragged_box(const Vec3& half_extent_m, Random& random) {
  Soup soup;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      Vec3 origin = -half_extent_m;
      origin[axis] = side * half_extent_m[axis];
      Vec3 u = Vec3::Zero();
      Vec3 v = Vec3::Zero();
      u[(axis + 1) % 3] = 2 * half_extent_m[(axis + 1) % 3];
      v[(axis + 2) % 3] = 2 * half_extent_m[(axis + 2) % 3];
      add_ragged_face(origin, u, v, random, soup);
    }
  }
  return soup;
}

HardScene hard_scene(HardKind kind, Random& random) {
  HardScene scene = as_built(kind, random);
  if (random.index(3) == 0) return scene;
  const RigidTransform pose = random.pose(0.1);
  scene.soup = moved(scene.soup, pose);
  for (Vec3& p : scene.aims) p = pose.point(p);
  return scene;
}

std::vector<Corners> solver_triangles(const OwnedWorld& world) {
  const AffineMap to_index{Mat3::Identity(), -world.world().anchor_scene_m};
  std::vector<Vec3> positions;
  for (const Vec3& p : world.mesh().welded_positions()) positions.push_back(to_index(p));
  std::vector<Corners> triangles;
  for (const Triangle& t : world.mesh().faces()) {
    triangles.push_back({positions[t[0]], positions[t[1]], positions[t[2]]});
  }
  return triangles;
}

DeviceMotion::DeviceMotion(const std::vector<Corners>& triangles, std::vector<Vec3> aims,
                           const Vec3& start, Random& random)
    : triangles_(&triangles),
      aims_(std::move(aims)),
      random_(&random),
      goal_(start),
      earlier_goal_(start),
      heading_(random.unit_vector()) {}

double DeviceMotion::step_m() {
  return log_uniform(*random_, 1e-6, 50e-3);
}

// Returns a vertex, a point of an edge or of a face, or a slit.
Vec3 DeviceMotion::place_of_interest() {
  if (!aims_.empty() && random_->index(2)) return aims_[random_->index(aims_.size())];
  const Corners& t = (*triangles_)[random_->index(triangles_->size())];
  switch (random_->index(4)) {
    case 0:
      return t.a;
    case 1:
      return 0.5 * (t.b + t.c);
    case 2:
      return t.b + random_->uniform(0.0, 1.0) * (t.a - t.b);
    default: {
      const double s = random_->uniform(0.0, 1.0);
      return t.a + s * (t.b - t.a) + (1.0 - s) * random_->uniform(0.0, 1.0) * (t.c - t.a);
    }
  }
}

// Continues along the surface and presses on it.
Vec3 DeviceMotion::slide(const ProxyState& state) {
  if (!state.in_contact) return state.proxy + pace_m_ * heading_;
  if (random_->index(20) == 0) heading_ = random_->unit_vector();
  const Vec3 along = heading_ - heading_.dot(state.normal) * state.normal;
  const double depth_m = std::min(1e-3, 3.0 * pace_m_);
  return state.proxy + pace_m_ * along - depth_m * state.normal;
}

Vec3 DeviceMotion::next_goal(const ProxyState& state) {
  constexpr double kReach_m = 0.2;
  if (ticks_left_-- == 0) {
    habit_ = static_cast<Habit>(random_->index(static_cast<std::uint64_t>(Habit::kCount)));
    ticks_left_ = 5 + random_->index(40);
    pace_m_ = step_m();
    heading_ = (place_of_interest() - state.proxy).normalized();
    if (random_->index(8) == 0 || !heading_.allFinite()) heading_ = random_->unit_vector();
  }
  const Vec3 last = goal_;
  switch (random_->index(64)) {
    case 0:  // a jump across the scene
      goal_ = random_->in_box(random_->index(8) ? kReach_m : 100.0);
      break;
    case 1:  // no motion
      break;
    case 2:  // to the proxy
      goal_ = state.proxy;
      break;
    case 3:  // to the bit
      goal_ = place_of_interest();
      break;
    default:
      switch (habit_) {
        case Habit::kWander:
          goal_ += step_m() * random_->unit_vector();
          break;
        case Habit::kSlide:
          goal_ = slide(state);
          break;
        case Habit::kPoke:  // a little before the target, at it, or beyond
          goal_ = place_of_interest() + random_->uniform(-1.0, 1.0) * pace_m_ * heading_;
          break;
        case Habit::kThrough: {  // straight on, as far beyond the target as the proxy is before it
          const Vec3 aim = place_of_interest();
          goal_ = aim + (aim - state.proxy);
          break;
        }
        case Habit::kReturn:
          goal_ = earlier_goal_;
          break;
        default:
          goal_[static_cast<int>(random_->index(3))] += sign(*random_) * step_m();
          break;
      }
  }
  // Return from empty space.
  if (goal_.norm() > kReach_m && random_->index(4) == 0) goal_ = place_of_interest();
  earlier_goal_ = last;
  return goal_;
}

}  // namespace palpate::test
