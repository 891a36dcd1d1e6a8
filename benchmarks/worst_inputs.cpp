#include "benchmarks/worst_inputs.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "geometry/base/decompositions.h"
#include "geometry/base/random.h"
#include "geometry/mesh/surface_mesh.h"
#include "models/primitives.h"

namespace palpate::bench {
namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;

// Typical extent of a scene.
constexpr double kSize_m = 0.2;

struct Soup {
  std::vector<Vec3> positions_m;
  std::vector<Triangle> triangles;

  void add(const Vec3& a, const Vec3& b, const Vec3& c) {
    const auto first = static_cast<std::uint32_t>(positions_m.size());
    positions_m.insert(positions_m.end(), {a, b, c});
    triangles.push_back({first, first + 1, first + 2});
  }
};

// The index of a soup at the origin, for a proxy of radius_m in a scene of size_m.
std::unique_ptr<SurfaceIndex> index_of(const Soup& soup, double size_m, double radius_m) {
  const double stand_off_m = SolverScale::of(size_m, radius_m).stand_off_m;
  const double sweep_m = radius_m > 0.0 ? radius_m + 2 * stand_off_m : 0.0;
  return std::make_unique<SurfaceIndex>(SurfaceMesh::build(soup.positions_m, soup.triangles),
                                        AffineMap{}, sweep_m);
}

void add_body(WorstInput& input, const SurfaceIndex* index, const RigidTransform& T_solver_body) {
  input.world.bodies.push_back({index, {}, true});
  input.world.bodies.back().place(T_solver_body);
}

// Sets the members of the world that depend on all of its bodies.
void complete(WorstInput& input) {
  std::vector<Box> boxes;
  for (const ContactBody& body : input.world.bodies) boxes.push_back(body.box_solver());
  Box bounds = boxes.front();
  for (const Box& box : boxes) bounds = bounds.united(box);
  input.world.bounds_solver = bounds;
  input.world.size_m = (bounds.high - bounds.low).maxCoeff();
  const double sweep_m = input.indices.front()->sweep_radius_m();
  if (boxes.size() > 8) input.world.tree = std::make_shared<BoxTree>(boxes, sweep_m);
}

WorstInput input_of(std::string name, const Soup& soup, double radius_m) {
  WorstInput input;
  input.name = std::move(name);
  input.proxy_radius_m = radius_m;
  input.indices.push_back(index_of(soup, kSize_m, radius_m));
  add_body(input, input.indices.front().get(), {});
  complete(input);
  return input;
}

// A hand that approaches a point, trembles there, circles around it and jumps across it.
struct Visit {
  Vec3 from_m;
  Vec3 to_m;
  double trembles_m;
  double circles_m;
};
constexpr int kTicksToCome = 20;
constexpr int kTicksOfTrembling = 60;
constexpr int kTicksOfCircling = 60;
constexpr int kJumps = 20;
constexpr std::size_t kAcross = 40;  // number of jumps across a sphere

std::vector<Vec3> goals_of(const Visit& visit) {
  SeededRandom random(9);
  std::vector<Vec3> goals_m;
  for (int i = 0; i < kTicksToCome; ++i) {
    goals_m.push_back(visit.from_m + i / (kTicksToCome - 1.0) * (visit.to_m - visit.from_m));
  }
  for (int i = 0; i < kTicksOfTrembling; ++i) {
    goals_m.push_back(visit.to_m + random.in_box(visit.trembles_m));
  }
  for (int i = 0; i < kTicksOfCircling; ++i) {
    const double turn_rad = kTwoPi * i / kTicksOfCircling;
    goals_m.push_back(visit.to_m + visit.circles_m * Vec3(std::cos(turn_rad), std::sin(turn_rad),
                                                          0.3 * std::sin(2 * turn_rad)));
  }
  for (int i = 0; i < kJumps; ++i) {
    const Vec3 beyond_m = 2.0 * visit.to_m - visit.from_m;
    goals_m.push_back(i % 2 == 0 ? beyond_m : visit.from_m);
  }
  return goals_m;
}

void visit(WorstInput& input, const Visit& visit) {
  input.goals_m = goals_of(visit);
  input.away_m = 2.0 * visit.from_m - visit.to_m;
}

WorstInput all_through_one_point(std::size_t count, double radius_m) {
  SeededRandom random(1);
  Soup soup;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 a = 0.5 * kSize_m * random.unit_vector();
    soup.add(Vec3::Zero(), a, (a + 0.1 * random.in_box(kSize_m)).normalized() * 0.5 * kSize_m);
  }
  WorstInput input = input_of("through_one_point", soup, radius_m);
  visit(input, {{0.0, 0.0, 0.7 * kSize_m}, Vec3::Zero(), 1e-4, 0.05 * kSize_m});
  return input;
}

// Sheets in one mesh that coincide up to rounding.
WorstInput stack_in_one_mesh(std::size_t count) {
  SeededRandom random(2);
  Soup soup;
  constexpr std::size_t kPerSheet = 2;
  const double half_m = 0.5 * kSize_m;
  for (std::size_t i = 0; i < count / kPerSheet; ++i) {
    const double z = 1e-12 * static_cast<double>(i);
    const double turn_rad = random.uniform(0.0, kTwoPi);
    const auto corner = [&](int quarter) {
      const double angle_rad = turn_rad + kTwoPi * quarter / 4;
      return Vec3(half_m * std::cos(angle_rad), half_m * std::sin(angle_rad), z);
    };
    soup.add(corner(0), corner(1), corner(2));
    soup.add(corner(0), corner(2), corner(3));
  }
  WorstInput input = input_of("stack_in_one_mesh", soup, 0.0);
  visit(input, {{0.0, 0.0, 0.02}, {0.0, 0.0, -0.005}, 1e-4, 0.01});
  return input;
}

// Bodies that coincide up to rounding; every second body has its faces reversed.
WorstInput stack_of_bodies(std::size_t count) {
  SeededRandom random(3);
  WorstInput input;
  input.name = "stack_of_bodies";
  Soup soup;
  const double half_m = 0.5 * kSize_m;
  constexpr int kCells = 8;
  const auto at = [&](int i, int j) {
    return Vec3(half_m * (2.0 * i / kCells - 1.0), half_m * (2.0 * j / kCells - 1.0),
                1e-3 * std::sin(i + 2.0 * j));
  };
  for (int i = 0; i < kCells; ++i) {
    for (int j = 0; j < kCells; ++j) {
      soup.add(at(i, j), at(i + 1, j), at(i + 1, j + 1));
      soup.add(at(i, j), at(i + 1, j + 1), at(i, j + 1));
    }
  }
  input.indices.push_back(index_of(soup, kSize_m, 0.0));
  for (Triangle& t : soup.triangles) std::swap(t[0], t[1]);
  input.indices.push_back(index_of(soup, kSize_m, 0.0));
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 turn_rad = 1e-9 * random.unit_vector();
    const Quat rotation = Quat(1.0, turn_rad.x(), turn_rad.y(), turn_rad.z()).normalized();
    add_body(input, input.indices[i % 2].get(),
             {rotation, Vec3(0.0, 0.0, 1e-12 * static_cast<double>(i))});
  }
  complete(input);
  visit(input, {{0.0, 0.0, 0.02}, {0.003, 0.001, -0.005}, 1e-4, 0.01});
  return input;
}

// Instances of one cube that all have a corner at the origin and extend below it, turned at random.
// stretch: the bodies are stretched, each by its own factors.
WorstInput instances_at_one_point(std::size_t count, double radius_m, bool is_stretched) {
  SeededRandom random(8);
  WorstInput input;
  input.name = is_stretched ? "stretched_instances_at_one_point" : "instances_at_one_point";
  input.proxy_radius_m = radius_m;
  const Vec3 corner_m = Vec3::Constant(0.05 * kSize_m);
  const TriangleMesh cube = box(corner_m);
  input.indices.push_back(index_of({cube.positions_m, cube.triangles}, kSize_m, radius_m));
  input.stretches = std::make_shared<std::vector<Stretch>>();
  input.stretches->reserve(count);
  const SurfaceIndex* index = input.indices.front().get();
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 upward = (random.unit_vector() + 1.2 * Vec3::UnitZ()).normalized();
    const Quat rotation =
        turn_between(corner_m, upward) *
        Quat(Eigen::AngleAxisd(random.uniform(0.0, kTwoPi), corner_m.normalized()));
    Vec3 top_m = corner_m;
    if (is_stretched) {
      Vec3 factors;
      for (int axis = 2; axis >= 0; --axis) factors[axis] = random.uniform(0.5, 2.0);
      input.stretches->emplace_back(factors.asDiagonal(), index->box());
      top_m = factors.cwiseProduct(corner_m);
    }
    input.world.bodies.push_back({index, {}, true});
    if (is_stretched) input.world.bodies.back().stretch = &input.stretches->back();
    input.world.bodies.back().place({rotation, -(rotation * top_m)});
  }
  input.world.stretches = input.stretches;
  complete(input);
  visit(input, {{0.0, 0.0, 0.1 * kSize_m}, {0.0, 0.0, -0.02 * kSize_m}, 1e-4, 0.02 * kSize_m});
  return input;
}

// Large random triangles: each intersects hundreds of others.
WorstInput dense_soup(std::size_t count, double radius_m) {
  SeededRandom random(4);
  Soup soup;
  for (std::size_t i = 0; i < count; ++i) {
    const double half_m = 0.5 * kSize_m;
    const Vec3 c = random.in_box(half_m);
    const Vec3 b = random.in_box(half_m);
    soup.add(random.in_box(half_m), b, c);
  }
  WorstInput input = input_of("dense_soup", soup, radius_m);
  visit(input, {{0.01, 0.0, 0.6 * kSize_m}, {0.01, 0.0, 0.0}, 1e-3, 0.02});
  return input;
}

// Needles in one plane, in which the hand moves: double cannot decide the sign for any edge.
WorstInput needles_in_doubt(std::size_t count, double radius_m) {
  Soup soup;
  const double half_m = 0.5 * kSize_m;
  for (std::size_t i = 0; i < count; ++i) {
    const double angle_rad = kTwoPi * static_cast<double>(i) / static_cast<double>(count);
    const double next_rad = kTwoPi * (static_cast<double>(i) + 0.4) / static_cast<double>(count);
    soup.add({0.01 * std::cos(angle_rad), 0.01 * std::sin(angle_rad), 0.0},
             {half_m * std::cos(angle_rad), half_m * std::sin(angle_rad), 0.0},
             {half_m * std::cos(next_rad), half_m * std::sin(next_rad), 0.0});
  }
  WorstInput input = input_of("needles_in_doubt", soup, radius_m);
  visit(input, {{-0.7 * kSize_m, 0.0, 0.0}, {0.0, 0.0, 0.0}, 1e-4, 0.03});
  // The same goals again, moved into the plane.
  const std::vector<Vec3> goals_m = input.goals_m;
  for (const Vec3& goal_m : goals_m) input.goals_m.push_back({goal_m.x(), goal_m.y(), 0.0});
  return input;
}

// A sphere proxy as large as the scene.
WorstInput sphere_as_large_as_the_scene(std::size_t count) {
  int subdivisions = 0;
  while (20u << 2 * (subdivisions + 1) <= count) ++subdivisions;
  const TriangleMesh mesh = icosphere(subdivisions, 0.5 * kSize_m);
  WorstInput input =
      input_of("sphere_as_large_as_the_scene", {mesh.positions_m, mesh.triangles}, kSize_m);
  visit(input, {{0.0, 0.1 * kSize_m, 1.8 * kSize_m}, {0.0, 0.0, 1.2 * kSize_m}, 1e-3, 0.1});
  return input;
}

// Cubes that close in on the proxy from all sides and retreat.
WorstInput moving_bodies(std::size_t count) {
  SeededRandom random(5);
  WorstInput input;
  input.name = "moving_bodies";
  const TriangleMesh cube = box(Vec3::Constant(0.1 * kSize_m));
  input.indices.push_back(index_of({cube.positions_m, cube.triangles}, kSize_m, 0.0));
  std::vector<Vec3> directions;
  std::vector<Quat> rotations;
  for (std::size_t i = 0; i < count; ++i) {
    directions.push_back(random.unit_vector());
    rotations.push_back(random.rotation());
    add_body(input, input.indices[0].get(), {rotations[i], 0.5 * kSize_m * directions[i]});
  }
  complete(input);
  visit(input, {{0.0, 0.0, 0.7 * kSize_m}, Vec3::Zero(), 1e-4, 0.02});
  for (std::size_t tick = 0; tick < input.goals_m.size(); ++tick) {
    auto& motions = input.motions.emplace_back();
    const double distance_m =
        kSize_m * (0.25 + 0.2 * std::cos(kTwoPi * static_cast<double>(tick) / 40.0));
    for (std::size_t i = 0; i < count; ++i) {
      motions.push_back(
          {static_cast<std::uint32_t>(i), {rotations[i], distance_m * directions[i]}});
    }
  }
  return input;
}

// Triangles within a millionth of the scene's size; the proxy starts in the middle of them.
WorstInput start_in_a_cluster(std::size_t count, double radius_m) {
  SeededRandom random(6);
  Soup soup;
  const double half_m = 1e-6 * kSize_m;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 middle = random.in_box(half_m);
    const Vec3 c = middle + random.in_box(0.1 * half_m);
    const Vec3 b = middle + random.in_box(0.1 * half_m);
    soup.add(middle + random.in_box(0.1 * half_m), b, c);
  }
  soup.add({0.5 * kSize_m, 0.0, -0.1}, {-0.5 * kSize_m, 0.4 * kSize_m, -0.1},
           {-0.5 * kSize_m, -0.4 * kSize_m, -0.1});
  WorstInput input = input_of("start_in_a_cluster", soup, radius_m);
  visit(input, {Vec3::Zero(), {0.0, 0.0, 0.1 * half_m}, 0.1 * half_m, half_m});
  input.away_m = {0.0, 0.0, 0.3 * kSize_m};
  return input;
}

// Jumps across a sphere, from the first contact on.
WorstInput jumps_across(std::size_t count, double radius_m) {
  int subdivisions = 0;
  while (20u << 2 * (subdivisions + 1) <= count) ++subdivisions;
  const TriangleMesh mesh = icosphere(subdivisions, 0.5 * kSize_m);
  WorstInput input = input_of("jumps_across", {mesh.positions_m, mesh.triangles}, radius_m);
  SeededRandom random(7);
  for (std::size_t i = 0; i < kAcross; ++i) {
    input.goals_m.push_back(1.5 * kSize_m * random.unit_vector());
  }
  input.away_m = input.goals_m.back();
  return input;
}

WorstInput named(std::string suffix, WorstInput input) {
  input.name += suffix;
  return input;
}

constexpr double kSmallSphere_m = 1e-3;
constexpr double kLargeSphere_m = 0.03;

}  // namespace

const std::vector<WorstKind>& worst_kinds() {
  constexpr std::size_t kVisit = kTicksToCome + kTicksOfTrembling + kTicksOfCircling + kJumps;
  static const std::vector<WorstKind> kinds = {
      {"through_one_point", 500'000, 20'000, kVisit,
       [](std::size_t n) { return all_through_one_point(n, 0.0); }},
      {"through_one_point_sphere", 150'000, 5'000, kVisit,
       [](std::size_t n) { return named("_sphere", all_through_one_point(n, kSmallSphere_m)); }},
      {"through_one_point_large_sphere", 50'000, 5'000, kVisit,
       [](std::size_t n) {
         return named("_large_sphere", all_through_one_point(n, kLargeSphere_m));
       }},
      {"instances_at_one_point", 10'000, 300, kVisit,
       [](std::size_t n) { return instances_at_one_point(n, 0.0, false); }},
      {"instances_at_one_point_sphere", 10'000, 300, kVisit,
       [](std::size_t n) {
         return named("_sphere", instances_at_one_point(n, kSmallSphere_m, false));
       }},
      {"stretched_instances_at_one_point", 3'000, 100, kVisit,
       [](std::size_t n) { return instances_at_one_point(n, 0.0, true); }},
      {"stack_in_one_mesh", 20'000, 4'000, kVisit, stack_in_one_mesh},
      {"stack_of_bodies", 1'000, 100, kVisit, stack_of_bodies},
      {"dense_soup", 200'000, 10'000, kVisit, [](std::size_t n) { return dense_soup(n, 0.0); }},
      {"dense_soup_sphere", 50'000, 2'000, kVisit,
       [](std::size_t n) { return named("_sphere", dense_soup(n, kSmallSphere_m)); }},
      {"needles_in_doubt", 150'000, 10'000, 2 * kVisit,
       [](std::size_t n) { return needles_in_doubt(n, 0.0); }},
      {"needles_in_doubt_sphere", 150'000, 10'000, 2 * kVisit,
       [](std::size_t n) { return named("_sphere", needles_in_doubt(n, kSmallSphere_m)); }},
      {"sphere_as_large_as_the_scene", 100'000, 5'120, kVisit, sphere_as_large_as_the_scene},
      {"moving_bodies", 256, 64, kVisit, moving_bodies},
      {"start_in_a_cluster", 100'000, 10'000, kVisit,
       [](std::size_t n) { return start_in_a_cluster(n, 0.0); }},
      {"start_in_a_cluster_sphere", 100'000, 10'000, kVisit,
       [](std::size_t n) { return named("_sphere", start_in_a_cluster(n, kSmallSphere_m)); }},
      {"jumps_across", 5'242'880, 20'480, kAcross,
       [](std::size_t n) { return jumps_across(n, 0.0); }},
      {"jumps_across_sphere", 5'242'880, 20'480, kAcross,
       [](std::size_t n) { return named("_sphere", jumps_across(n, kSmallSphere_m)); }},
  };
  return kinds;
}

}  // namespace palpate::bench
