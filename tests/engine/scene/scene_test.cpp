// Tests the positions of a file's triangles in a compiled scene, and splitting of node transforms.

#include "engine/scene/scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/scene/node_placement.h"
#include "haptics/haptic_loop.h"
#include "haptics/record_vectors.h"
#include "tests/helpers/floating_point.h"
#include "tests/helpers/gltf_builder.h"
#include "tests/helpers/made.h"
#include "tests/helpers/random.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::GltfBuilder;
using test::kEpsilon;
using test::Random;
using test::TemporaryFolder;

constexpr double kTolerancePerSize = 1e-12;

// A convex solid of eight triangles around the origin, front sides out, with float vertices as in a
// file. All its corners, edges and faces differ.
MeshDescription bent_octahedron(Random& random, const std::string& name = "solid") {
  MeshDescription mesh{name, {}, {}};
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      const Vec3 corner = side * Vec3::Unit(axis) + random.in_box(0.2);
      mesh.positions.push_back(corner.cast<float>().cast<double>());
    }
  }
  for (std::uint32_t octant = 0; octant < 8; ++octant) {
    const std::uint32_t x = octant & 1u;
    const std::uint32_t y = 2 + (octant >> 1 & 1u);
    const std::uint32_t z = 4 + (octant >> 2 & 1u);
    const bool even = (x + y + z) % 2 == 1;
    mesh.triangles.push_back({x, even ? y : z, even ? z : y});
  }
  return mesh;
}

// A rotation with uneven scale and shear; every second matrix is also a mirror.
Mat3 random_linear(Random& random) {
  Mat3 shear = Mat3::Identity();
  shear(0, 1) = random.uniform(-1, 1);
  shear(0, 2) = random.uniform(-1, 1);
  shear(1, 2) = random.uniform(-1, 1);
  const double mirror = random.index(2) == 0 ? -1.0 : 1.0;
  const auto scale = [&] { return std::exp(random.uniform(-2.5, 2.5)); };
  const Vec3 scales(mirror * scale(), scale(), scale());
  return random.rotation().toRotationMatrix() * shear * scales.asDiagonal() *
         random.rotation().toRotationMatrix();
}

double condition(const Mat3& m) {
  return m.norm() * m.inverse().norm();
}

SceneDescription description_of(std::vector<MeshDescription> meshes,
                                std::vector<NodeDescription> nodes) {
  SceneDescription description;
  description.path = "made.glb";
  description.tree.resize(nodes.size());
  description.meshes = std::move(meshes);
  description.nodes = std::move(nodes);
  return description;
}

struct SolverFace {
  Vec3 a_m, b_m, c_m, normal;  // scene frame, metres and unit
};

// A face as the solver uses it: corners and normal, in the scene frame.
SolverFace solver_face(const Scene& scene, std::size_t body, std::size_t face) {
  const ContactBody& b = scene.world().bodies[body];
  for (std::uint32_t p = 0; p < b.index->pack_count(); ++p) {
    const TrianglePack& pack = b.index->pack(p);
    for (int lane = 0; lane < pack.count; ++lane) {
      const std::uint32_t slot = SurfaceIndex::slot(p, lane);
      if (b.index->face(slot) != face) continue;
      TriangleGeometry room;
      const TriangleGeometry& t = b.triangle(slot, room);
      const auto place = [&](const Vec3& v) { return scene.world().to_scene(b.to_solver(v)); };
      return {place(t.a), place(t.b), place(t.c), b.direction_to_solver(t.normal)};
    }
  }
  ADD_FAILURE() << "face " << face << " is in no pack";
  return {};
}

double distance_to_surface(const Scene& scene, std::size_t body, const Vec3& p_scene) {
  const ContactBody& b = scene.world().bodies[body];
  const Vec3 p_body = b.to_body(scene.world().to_solver(p_scene));
  const double radius = b.length_to_body(scene.world().size_m);
  const auto nearest = b.stretch ? closest_point(*b.index, *b.stretch, p_body, radius)
                                 : b.index->closest_point(p_body, radius);
  return nearest ? b.length_to_solver(nearest->distance_m)
                 : std::numeric_limits<double>::infinity();
}

// Checks that every face of `mesh` lies where p -> linear p + translation moves it, and that its
// normal is transformed by the inverse transpose, also on a mirrored node (glTF 3.7.4).
void expect_faces_at(const Scene& scene, std::size_t body, const MeshDescription& mesh,
                     const Mat3& linear, const Vec3& translation_m) {
  const double tolerance_m = kTolerancePerSize * scene.world().size_m;
  const auto place = [&](std::uint32_t i) { return linear * mesh.positions[i] + translation_m; };
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    const Triangle& t = mesh.triangles[f];
    const SolverFace actual = solver_face(scene, body, f);
    EXPECT_LE((actual.a_m - place(t[0])).norm(), tolerance_m);
    EXPECT_LE(std::min((actual.b_m - place(t[1])).norm(), (actual.b_m - place(t[2])).norm()),
              tolerance_m);
    for (const std::uint32_t corner : t) {
      EXPECT_LE(distance_to_surface(scene, body, place(corner)), tolerance_m);
    }
    const Vec3& origin = mesh.positions[t[0]];
    const Vec3 front =
        (mesh.positions[t[1]] - origin).cross(mesh.positions[t[2]] - origin).normalized();
    const Vec3 expected = (linear.inverse().transpose() * front).normalized();
    const double c = condition(linear);
    EXPECT_LE((actual.normal - expected).norm(), 64 * kEpsilon * c * c) << "face " << f;
  }
}

// ---- node transforms ---------------------------------------------------------------------------

TEST(NodePlacement, SplitsEveryMatrixIntoARotationAndADeformation) {
  Random random(1);
  for (int i = 0; i < 2000; ++i) {
    const Mat3 linear = random_linear(random);
    const auto placement = split_linear(linear);
    ASSERT_TRUE(placement);
    const Mat3 rotation = placement->rotation.toRotationMatrix();
    EXPECT_LE((rotation * placement->deformation - linear).norm(), 16 * kEpsilon * linear.norm());
    EXPECT_NEAR(placement->rotation.norm(), 1.0, 4 * kEpsilon);
    // The deformation is symmetric, so that it contains no rotation.
    const Mat3& deformation = placement->deformation;
    EXPECT_LE((deformation - deformation.transpose()).norm(), 16 * kEpsilon * linear.norm());
  }
}

TEST(NodePlacement, SplitsADiagonalMatrixExactly) {
  Random random(2);
  for (int i = 0; i < 100; ++i) {
    const Vec3 scales(random.uniform(0.1, 3), random.uniform(0.1, 3), random.uniform(0.1, 3));
    const Vec3 signs(i % 2 ? 1 : -1, i / 2 % 2 ? 1 : -1, i / 4 % 2 ? 1 : -1);
    const Mat3 linear = scales.cwiseProduct(signs).asDiagonal();
    const auto placement = split_linear(linear);
    ASSERT_TRUE(placement);
    // At most half a turn about an axis, which does not round a point, and a mirror.
    EXPECT_EQ(placement->deformation, Mat3((signs.prod() * scales).asDiagonal()));
    const Vec3 p = random.in_box(1.0);
    EXPECT_EQ(placement->rotation * Vec3(placement->deformation * p), Vec3(linear * p));
    EXPECT_EQ(placement->rotation.coeffs() == Quat::Identity().coeffs(),
              std::abs(signs.sum()) == 3.0);
  }
}

TEST(NodePlacement, SplitsARotationIntoAnIdenticalDeformation) {
  Random random(3);
  for (int i = 0; i < 500; ++i) {
    const auto placement = split_linear(random.rotation().toRotationMatrix());
    ASSERT_TRUE(placement);
    EXPECT_EQ(placement->deformation, Mat3::Identity());
  }
}

TEST(NodePlacement, RefusesSingularMatrices) {
  Random random(4);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < 100; ++i) {
    const Mat3 turn = random.rotation().toRotationMatrix();
    EXPECT_FALSE(split_linear(turn * Vec3(1, 1, 0).asDiagonal() * turn.transpose()));
    EXPECT_FALSE(split_linear(turn * Vec3(1, 0, 0).asDiagonal()));
    Mat3 broken = turn;
    broken(random.index(3), random.index(3)) = i % 2 ? nan : HUGE_VAL;
    EXPECT_FALSE(split_linear(broken));
  }
  EXPECT_FALSE(split_linear(Mat3::Zero()));
  EXPECT_TRUE(split_linear(Vec3(1e-12, 1, 1).asDiagonal())) << "thin, but a surface";
}

// ---- places ------------------------------------------------------------------------------------

TEST(Scene, HasItsFacesWhereTheNodeTransformsPutThem) {
  Random random(5);
  for (int i = 0; i < 200; ++i) {
    std::vector<MeshDescription> meshes{bent_octahedron(random), bent_octahedron(random)};
    std::vector<NodeDescription> nodes;
    const auto count = static_cast<std::uint32_t>(1 + random.index(3));
    for (std::uint32_t n = 0; n < count; ++n) {
      nodes.push_back({"n", n % 2, random_linear(random), random.in_box(5.0)});
    }
    const auto scene = Scene::compile(description_of(meshes, nodes));
    ASSERT_TRUE(scene) << scene.error().to_string();
    ASSERT_EQ(scene->world().bodies.size(), nodes.size());
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      expect_faces_at(*scene, n, meshes[nodes[n].mesh], nodes[n].linear_scene_mesh,
                      nodes[n].translation_m);
    }
  }
}

TEST(Scene, AppendsTheTrianglesOfTheSolver) {
  Random random(6);
  for (int i = 0; i < 50; ++i) {
    const MeshDescription mesh = bent_octahedron(random);
    const std::vector<NodeDescription> nodes{{"a", 0, random_linear(random), random.in_box(5.0)},
                                             {"b", 0, random_linear(random), random.in_box(5.0)}};
    const auto scene = Scene::compile(description_of({mesh}, nodes));
    ASSERT_TRUE(scene);
    std::vector<Vec3> positions;
    std::vector<Triangle> triangles;
    scene->append_triangles_scene(positions, triangles);
    ASSERT_EQ(triangles.size(), 16u);
    for (std::size_t f = 0; f < triangles.size(); ++f) {
      const SolverFace actual = solver_face(*scene, f / 8, f % 8);
      const Vec3& a = positions[triangles[f][0]];
      const Vec3 front = (positions[triangles[f][1]] - a).cross(positions[triangles[f][2]] - a);
      EXPECT_LE((a - actual.a_m).norm(), kTolerancePerSize * scene->world().size_m);
      EXPECT_GT(front.normalized().dot(actual.normal), 0.999);
    }
  }
}

nlohmann::json column_major(const Mat3& linear, const Vec3& translation) {
  nlohmann::json numbers = nlohmann::json::array();
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 3; ++row) numbers.push_back(linear(row, column));
    numbers.push_back(0.0);
  }
  for (int row = 0; row < 3; ++row) numbers.push_back(translation[row]);
  numbers.push_back(1.0);
  return numbers;
}

TEST(Scene, MultipliesAChainOfNodesInDouble) {
  Random random(7);
  const TemporaryFolder folder;
  for (int i = 0; i < 30; ++i) {
    const MeshDescription mesh = bent_octahedron(random);
    GltfBuilder gltf;
    std::vector<Eigen::Vector3f> positions;
    for (const Vec3& p : mesh.positions) positions.push_back(p.cast<float>());
    std::vector<std::uint32_t> indices;
    for (const Triangle& t : mesh.triangles) indices.insert(indices.end(), t.begin(), t.end());
    const auto position_accessor = gltf.add_positions(positions);
    const auto index_accessor = gltf.add_indices(indices);
    const auto mesh_id = gltf.add_mesh(
        {{{"attributes", {{"POSITION", position_accessor}}}, {"indices", index_accessor}}});
    Mat3 linear = Mat3::Identity();
    Vec3 translation = Vec3::Zero();
    std::size_t child = 0;
    for (int level = 0; level < 4; ++level) {  // from the leaf up
      const Mat3 m = random_linear(random);
      const Vec3 t = random.in_box(2.0);
      nlohmann::json node{{"matrix", column_major(m, t)}};
      if (level == 0) node["mesh"] = mesh_id;
      if (level > 0) node["children"] = {child};
      child = level < 3 ? gltf.add_child(node) : gltf.add_node(node);
      translation = m * translation + t;
      linear = m * linear;
    }
    const auto scene = Scene::load(gltf.write_glb(folder));
    ASSERT_TRUE(scene) << scene.error().to_string();
    // A product of four matrices: the rounding errors of the ancestors grow with the scales.
    if (condition(linear) > 1e4) continue;
    expect_faces_at(*scene, 0, mesh, linear, translation);
  }
}

TEST(Scene, KeepsTheVerticesOfIdentityNodesExactly) {
  Random random(8);
  for (int i = 0; i < 100; ++i) {
    const MeshDescription mesh = bent_octahedron(random);
    const auto scene =
        Scene::compile(description_of({mesh}, {{"n", 0, Mat3::Identity(), Vec3::Zero()}}));
    ASSERT_TRUE(scene);
    EXPECT_TRUE(scene->world().bodies[0].is_identity);
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
      const Triangle& t = mesh.triangles[f];
      const SolverFace actual = solver_face(*scene, 0, f);
      EXPECT_EQ(actual.a_m, mesh.positions[t[0]]);
      EXPECT_EQ(actual.b_m, mesh.positions[t[1]]);
      EXPECT_EQ(actual.c_m, mesh.positions[t[2]]);
    }
  }
}

// ---- sharing -----------------------------------------------------------------------------------

std::size_t distinct_indices(const Scene& scene) {
  std::set<const SurfaceIndex*> indices;
  for (const ContactBody& body : scene.world().bodies) indices.insert(body.index);
  return indices.size();
}

TEST(Scene, BuildsOneIndexForAllScalesOfAMesh) {
  Random random(9);
  const std::vector<MeshDescription> meshes{bent_octahedron(random), bent_octahedron(random)};
  const std::vector<Mat3> scales{Mat3::Identity(), 2.0 * Mat3::Identity(), 0.1 * Mat3::Identity(),
                                 Vec3(1, 2, 3).asDiagonal(), Vec3(-1, 1, 1).asDiagonal()};
  std::vector<NodeDescription> nodes;
  for (std::uint32_t mesh = 0; mesh < 2; ++mesh) {
    for (const Mat3& scale : scales) nodes.push_back({"moved", mesh, scale, random.in_box(3.0)});
    for (int i = 0; i < 20; ++i) {
      for (const Mat3& scale : scales) {
        const Mat3 turned = random.rotation().toRotationMatrix() * scale;
        nodes.push_back({"turned", mesh, turned, random.in_box(3.0)});
      }
    }
  }
  const auto scene = Scene::compile(description_of(meshes, nodes));
  ASSERT_TRUE(scene);
  EXPECT_EQ(distinct_indices(*scene), 2u);
  EXPECT_EQ(scene->statistics().indices, 2u);
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    expect_faces_at(*scene, n, meshes[nodes[n].mesh], nodes[n].linear_scene_mesh,
                    nodes[n].translation_m);
  }
}

TEST(Scene, SharesAnIndexForAnyOrderOfNodes) {
  Random random(10);
  const MeshDescription mesh = bent_octahedron(random);
  const Mat3 turn = random.rotation().toRotationMatrix();
  for (const bool turned_first : {false, true}) {
    const auto scene = Scene::compile(
        description_of({mesh}, {{"a", 0, turned_first ? turn : Mat3::Identity(), Vec3::Zero()},
                                {"b", 0, turned_first ? Mat3::Identity() : turn, Vec3::UnitX()}}));
    ASSERT_TRUE(scene);
    EXPECT_EQ(distinct_indices(*scene), 1u);
  }
}

TEST(Scene, SharesNoIndexBetweenScalesThatDifferSlightly) {
  Random random(11);
  const MeshDescription mesh = bent_octahedron(random);
  const Mat3 turn = random.rotation().toRotationMatrix();
  const Mat3 scales[] = {2.0 * turn, (2.0 + 1e-9) * turn, turn * Vec3(2, 2, 2 + 1e-9).asDiagonal()};
  std::vector<NodeDescription> nodes;
  for (const Mat3& scale : scales) nodes.push_back({"n", 0, scale, Vec3::Zero()});
  SceneSettings settings;
  settings.joins_within_rounding = false;  // the nodes coincide within a rounding
  const auto scene = Scene::compile(description_of({mesh}, nodes), settings);
  ASSERT_TRUE(scene);
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    expect_faces_at(*scene, n, mesh, nodes[n].linear_scene_mesh, Vec3::Zero());
  }
}

// ---- nodes without a surface -------------------------------------------------------------------

TEST(Scene, LeavesOutSingularNodesWithAWarning) {
  Random random(12);
  const MeshDescription mesh = bent_octahedron(random);
  const auto scene = Scene::compile(
      description_of({mesh}, {{"good", 0, Mat3::Identity(), Vec3::Zero()},
                              {"flattened", 0, Vec3(1, 1, 0).asDiagonal(), Vec3::Zero()},
                              {"vanished", 0, Mat3::Zero(), Vec3::Zero()}}));
  ASSERT_TRUE(scene);
  const SceneStatistics& s = scene->statistics();
  EXPECT_EQ(scene->world().bodies.size(), 1u);
  EXPECT_EQ(s.instances, 1u);
  EXPECT_EQ(s.instanced_triangles, 8u);
  ASSERT_EQ(s.warnings.size(), 2u);
  EXPECT_NE(s.warnings[0].find("flattened"), std::string::npos);
  EXPECT_NE(s.warnings[1].find("vanished"), std::string::npos);
}

TEST(Scene, RefusesASceneWithoutAnySurface) {
  Random random(13);
  const auto flattened = Scene::compile(description_of(
      {bent_octahedron(random)}, {{"n", 0, Vec3(1, 1, 0).asDiagonal(), Vec3::Zero()}}));
  ASSERT_FALSE(flattened);
  EXPECT_EQ(flattened.error().code, ErrorCode::kEmptyScene);
  EXPECT_EQ(flattened.error().path, "made.glb");
  EXPECT_NE(flattened.error().hint.find("n: left out"), std::string::npos);
  EXPECT_NE(flattened.error().hint.find("flattens"), std::string::npos);
  const MeshDescription line{"line", {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}}};
  const auto no_area =
      Scene::compile(description_of({line}, {{"n", 0, Mat3::Identity(), Vec3::Zero()}}));
  ASSERT_FALSE(no_area);
  EXPECT_EQ(no_area.error().code, ErrorCode::kEmptyScene);
}

// ---- far away ----------------------------------------------------------------------------------

TEST(Scene, KeepsItsShapeExactlyAtAnyDistance) {
  Random random(14);
  for (double distance_m = 1.0; distance_m <= 1e6; distance_m *= 10.0) {
    const MeshDescription mesh = bent_octahedron(random);
    const Mat3 linear = 0.1 * random.rotation().toRotationMatrix();
    const auto near = Scene::compile(description_of({mesh}, {{"n", 0, linear, Vec3::Zero()}}));
    const auto far = Scene::compile(
        description_of({mesh}, {{"n", 0, linear, distance_m * random.unit_vector()}}));
    ASSERT_TRUE(near && far);
    const ContactBody& a = near->world().bodies[0];
    const ContactBody& b = far->world().bodies[0];
    EXPECT_EQ(a.T_solver_body.rotation.coeffs(), b.T_solver_body.rotation.coeffs());
    EXPECT_EQ(b.T_solver_body.translation_m, Vec3::Zero());
    ASSERT_EQ(a.index->pack_count(), b.index->pack_count());
    for (std::uint32_t p = 0; p < a.index->pack_count(); ++p) {
      for (int lane = 0; lane < TrianglePack::kLanes; ++lane) {
        EXPECT_EQ(a.index->triangle(SurfaceIndex::slot(p, lane)).a,
                  b.index->triangle(SurfaceIndex::slot(p, lane)).a);
        EXPECT_EQ(a.index->triangle(SurfaceIndex::slot(p, lane)).b,
                  b.index->triangle(SurfaceIndex::slot(p, lane)).b);
      }
    }
  }
}

TEST(Scene, WithSeveralNodesFarAwayHasOnlyTheRoundingOfItsCoordinates) {
  Random random(15);
  for (double distance_m = 1e3; distance_m <= 1e6; distance_m *= 10.0) {
    const MeshDescription mesh = bent_octahedron(random);
    const Vec3 there = distance_m * random.unit_vector();
    std::vector<NodeDescription> nodes;
    for (int n = 0; n < 3; ++n) {
      nodes.push_back({"n", 0, random_linear(random), there + random.in_box(2.0)});
    }
    const auto scene = Scene::compile(description_of({mesh}, nodes));
    ASSERT_TRUE(scene);
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      for (const Vec3& v : mesh.positions) {
        const Vec3 p = nodes[n].linear_scene_mesh * v + nodes[n].translation_m;
        EXPECT_LE(distance_to_surface(*scene, n, p),
                  kTolerancePerSize * scene->world().size_m + 4 * kEpsilon * distance_m);
      }
    }
  }
}

TEST(Scene, SharesOneIndexBetweenRotatedAndMirroredInstancesOfOneScale) {
  Random random(21);
  for (const Vec3& scale : {Vec3(1, 1, 1), Vec3(-1, 1, 1), Vec3(2, 2, -2), Vec3(-1, 2, 3)}) {
    std::vector<NodeDescription> nodes;
    for (int i = 0; i < 100; ++i) {
      const Mat3 turn = random.rotation().toRotationMatrix();
      nodes.push_back({"n", 0, Mat3(turn * scale.asDiagonal()), random.in_box(10.0)});
    }
    const auto scene = Scene::compile(description_of({bent_octahedron(random)}, nodes));
    ASSERT_TRUE(scene);
    EXPECT_EQ(scene->statistics().indices, 1u) << scale.transpose();
    EXPECT_EQ(scene->statistics().instances, 100u);
  }
}

TEST(Scene, RefusesASizeAtWhichNumbersUnderflowOrOverflow) {
  Random random(22);
  for (const double scale : {1e-170, 1e170}) {
    const auto scene = Scene::compile(description_of(
        {bent_octahedron(random)}, {{"n", 0, scale * Mat3::Identity(), Vec3::Zero()}}));
    ASSERT_FALSE(scene);
    EXPECT_EQ(scene.error().code, ErrorCode::kLimitExceeded);
  }
  // An error names the node and its scale if the scale is too large, also if the settings scale the
  // scene.
  const SceneDescription description =
      description_of({bent_octahedron(random)}, {{"ok", 0}, {"big", 0, 1e40 * Mat3::Identity()}});
  EXPECT_TRUE(Scene::compile(description));
  SceneSettings settings;
  settings.scale = 1e30;
  const auto scaled = Scene::compile(description, settings);
  ASSERT_FALSE(scaled);
  EXPECT_EQ(scaled.error().element, "node \"big\"");
  EXPECT_NE(scaled.error().problem.find("at its scale of 1e+70"), std::string::npos)
      << scaled.error().problem;
}

// Complete loop: a wall pressed by 1 mm, with the device near its own origin and the scene 1000 km
// from its own origin.
TEST(Scene, GivesEqualForcesFarAwayAndNearby) {
  Random random(16);
  const test::Soup box = test::box_soup(Vec3(0.5, 0.25, 0.125));
  for (double distance_m = 1e3; distance_m <= 1e6; distance_m *= 10.0) {
    const Vec3 there = distance_m * random.unit_vector();
    const auto scene = Scene::compile(description_of({{"box", box.positions, box.triangles}},
                                                     {{"n", 0, Mat3::Identity(), there}}));
    ASSERT_TRUE(scene);
    HapticSettings settings;
    settings.a4.enabled = false;
    settings.initial_pose.translation_m = -there;
    auto loop = test::made(
        HapticLoop::create(scene->world(), *ActuationModel::from_counts(3, 3), settings));
    loop.tick({0.6, 0.01, 0.02}, 1e-3);
    const TickRecord& r = loop.tick({0.499, 0.01, 0.02}, 1e-3);
    ASSERT_TRUE(r.contact);
    EXPECT_EQ(vec3(r.normal_scene), Vec3::UnitX());
    EXPECT_NEAR((vec3(r.proxy_scene_m) - vec3(r.goal_scene_m)).norm(), 1e-3,
                4 * kEpsilon * distance_m + 2e-11);
  }
}

// ---- figures -----------------------------------------------------------------------------------

TEST(Scene, CountsInputDroppedAndRemainingTriangles) {
  Random random(17);
  MeshDescription dirty = bent_octahedron(random, "dirty");
  dirty.triangles.push_back(dirty.triangles[0]);                            // repeated
  dirty.triangles.push_back({dirty.triangles[3][2], dirty.triangles[3][0],  // turned about
                             dirty.triangles[3][1]});
  dirty.triangles.push_back({1, 1, 2});  // no area
  const MeshDescription clean = bent_octahedron(random, "clean");
  std::vector<NodeDescription> nodes;
  for (const std::uint32_t mesh : {0u, 1u, 1u, 1u}) {
    nodes.push_back({"n", mesh, random_linear(random), random.in_box(1.0)});
  }
  const auto scene = Scene::compile(description_of({dirty, clean}, nodes));
  ASSERT_TRUE(scene);
  const SceneStatistics& s = scene->statistics();
  EXPECT_EQ(s.nodes, 4u);
  EXPECT_EQ(s.meshes, 2u);
  EXPECT_EQ(s.instances, 4u);
  EXPECT_EQ(s.cleaning.triangles_in, 19u);
  EXPECT_EQ(s.cleaning.dropped_degenerate, 1u);
  EXPECT_EQ(s.cleaning.dropped_duplicate, 2u);
  EXPECT_EQ(s.cleaning.triangles, 16u);
  EXPECT_EQ(s.cleaning.welded_vertices, 12u);
  EXPECT_EQ(s.instanced_triangles, 32u);
  EXPECT_EQ(s.cleaning.boundary_edges, 0u);
  EXPECT_EQ(s.cleaning.non_manifold_edges, 0u);
  EXPECT_GT(s.memory.total(), 32 * sizeof(TrianglePack) / TrianglePack::kLanes);
  EXPECT_TRUE(s.warnings.empty());
}

TEST(Scene, ReportsTheExtentOfItsPlacedTriangles) {
  Random random(18);
  for (int i = 0; i < 50; ++i) {
    const MeshDescription mesh = bent_octahedron(random);
    const std::vector<NodeDescription> nodes{{"a", 0, random_linear(random), random.in_box(1.0)},
                                             {"b", 0, random_linear(random), random.in_box(1.0)}};
    Vec3 low = Vec3::Constant(HUGE_VAL);
    Vec3 high = -low;
    for (const NodeDescription& node : nodes) {
      for (const Vec3& v : mesh.positions) {
        const Vec3 p = node.linear_scene_mesh * v + node.translation_m;
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
      }
    }
    const auto scene = Scene::compile(description_of({mesh}, nodes));
    ASSERT_TRUE(scene);
    const double size_m = (high - low).maxCoeff();
    EXPECT_LE((scene->statistics().extent_m - (high - low)).norm(), kTolerancePerSize * size_m);
    EXPECT_NEAR(scene->world().size_m, size_m, kTolerancePerSize * size_m);
    // The bounds of the solver contain every corner.
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      for (const Vec3& v : mesh.positions) {
        const Vec3 p = nodes[n].linear_scene_mesh * v + nodes[n].translation_m;
        EXPECT_LE(
            std::sqrt(scene->world().bounds_solver.squared_distance(scene->world().to_solver(p))),
            kTolerancePerSize * size_m);
      }
    }
  }
}

// The extent of the scene is small: only the mesh coordinates and the translation are out of
// bounds.
TEST(Scene, RefusesAMeshBeyondTheLimitOfTheScene) {
  Random random(20);
  const MeshDescription mesh = bent_octahedron(random);
  for (const double scale : {1e61, 1e150, 1e290, 1e306}) {
    MeshDescription flat = mesh;
    for (Vec3& v : flat.positions) v = Vec3(1.0, v.y() / scale, v.z() / scale);
    const Mat3 linear = scale * Mat3::Identity();
    const std::vector<NodeDescription> nodes{{"far", 0, linear, Vec3(-scale, 0.0, 0.0)}};
    const auto scene = Scene::compile(description_of({flat}, nodes));
    ASSERT_FALSE(scene) << scale;
    EXPECT_EQ(scene.error().code, ErrorCode::kLimitExceeded);
    EXPECT_EQ(scene.error().element, "node \"far\"") << scale;
  }
}

// Coordinates near the largest double, before the scene is fitted. Their sums must not overflow.
TEST(Scene, FitsCoordinatesNearTheLargestDouble) {
  Random random(21);
  const MeshDescription mesh = bent_octahedron(random);
  MeshDescription large = mesh;
  for (Vec3& v : large.positions) v *= 0x1p1020;
  SceneSettings settings;
  settings.fit_size_m = 1.0;
  const auto fitted = Scene::compile(description_of({large}, {{"large", 0}}), settings);
  const auto expected = Scene::compile(description_of({mesh}, {{"small", 0}}), settings);
  ASSERT_TRUE(fitted) << fitted.error().problem;
  ASSERT_TRUE(expected);
  EXPECT_EQ(fitted->statistics().extent_m, expected->statistics().extent_m);
}

TEST(Scene, KeepsTheCountsAndWarningsOfTheFile) {
  Random random(19);
  SceneDescription description =
      description_of({bent_octahedron(random)}, {{"n", 0, Mat3::Identity(), Vec3::Zero()}});
  description.tree.resize(7);
  description.warnings = {"something of the file"};
  description.parse_ms = 12.5;
  const auto scene = Scene::compile(std::move(description));
  ASSERT_TRUE(scene);
  EXPECT_EQ(scene->statistics().nodes, 7u);
  EXPECT_EQ(scene->statistics().warnings, std::vector<std::string>{"something of the file"});
  EXPECT_EQ(scene->statistics().parse_ms, 12.5);
  EXPECT_EQ(scene->objects()[0].name, "n");
}

// Cleaning drops triangles, so that the numbers of faces and source triangles differ.
TEST(Scene, FacesKeepTheMaterialsOfTheirTriangles) {
  MeshDescription mesh{"patches", {}, {}};
  for (int i = 0; i < 10; ++i) mesh.positions.push_back(Vec3(i / 2, i % 2, 0.1 * i * i));
  const std::vector<Triangle> good = {{0, 1, 2}, {1, 2, 3}, {2, 3, 4}, {3, 4, 5},
                                      {4, 5, 6}, {5, 6, 7}, {6, 7, 8}, {7, 8, 9}};
  // Triangles:        0        1          2        3          4        5          6        7
  mesh.triangles = {good[0], {3, 3, 3}, good[1], {2, 1, 0}, good[2], {0, 0, 1}, good[3], good[4]};
  mesh.material_runs = {{0, std::nullopt}, {1, 2}, {3, 0}, {6, 1}, {7, std::nullopt}};
  mesh.haptic_material = 4;
  MeshDescription plain{"plain", mesh.positions, good};
  NodeDescription placed{"placed", 0};
  placed.physics_material = 7;
  const auto scene =
      Scene::compile(description_of({mesh, plain}, {{"plain", 1}, placed, {"again", 0}}));
  ASSERT_TRUE(scene.ok());
  ASSERT_EQ(scene->objects().size(), 3u);
  using Material = std::optional<std::uint32_t>;
  const std::vector<Material> expected = {std::nullopt, 2, 0, 1, std::nullopt};
  for (const std::size_t object : {1u, 2u}) {
    ASSERT_EQ(scene->mesh(scene->objects()[object].mesh).face_count(), expected.size());
    for (std::size_t face = 0; face < expected.size(); ++face) {
      EXPECT_EQ(scene->material(object, face), expected[face]) << face;
    }
    EXPECT_EQ(scene->haptic_material(object), Material(4));
  }
  EXPECT_EQ(scene->objects()[1].physics_material, Material(7));
  EXPECT_FALSE(scene->objects()[2].physics_material);
  for (std::size_t face = 0; face < good.size(); ++face) EXPECT_FALSE(scene->material(0, face));
  EXPECT_FALSE(scene->haptic_material(0));
}

// --- Contours ------------------------------------------------------------------------------------

// The nodes "root", "object" with a mesh and a contour, and "part" below it with a contour; then
// "other" with a mesh and a contour. The contours start at (1, 2, 3), (5, 2, 3) and (-8, 2, 3).
SceneDescription scene_with_contours(Random& random) {
  SceneDescription description = description_of(
      {bent_octahedron(random)}, {{"object", 0}, {"other", 0, Mat3::Identity(), {9, 0, 0}}});
  description.tree = {{"root", 0, {}, false, Vec3::Zero()},
                      {"object", 1, 0u, true, Vec3::Zero()},
                      {"part", 2, 1u, false, Vec3::Zero()},
                      {"other", 3, 0u, true, Vec3::Zero()}};
  description.nodes[0].tree_node = 1;
  description.nodes[1].tree_node = 3;
  const auto contour = [](const std::string& node, std::uint32_t tree_node, double x) {
    return ContourDescription{node,
                              "/nodes/" + std::to_string(tree_node) + "/extras/palpate_contour",
                              {x, 2, 3},
                              {x, 5, 6},
                              tree_node};
  };
  description.contours = {contour("object", 1, 1), contour("part", 2, 5), contour("other", 3, -8)};
  return description;
}

TEST(StatedContours, AreScaledWithTheScene) {
  Random random(23);
  const auto plain = Scene::compile(scene_with_contours(random));
  ASSERT_TRUE(plain.ok()) << plain.error().to_string();
  ASSERT_EQ(plain->contours().size(), 3u);
  EXPECT_EQ(plain->contours()[0].start_scene_m, Vec3(1, 2, 3));
  EXPECT_EQ(plain->contours()[2].end_scene_m, Vec3(-8, 5, 6));
  SceneSettings settings;
  settings.scale = 0.125;
  const auto small = Scene::compile(scene_with_contours(random), settings);
  ASSERT_TRUE(small.ok());
  settings = {};
  settings.fit_size_m = random.uniform(0.01, 100.0);
  const auto fitted = Scene::compile(scene_with_contours(random), settings);
  ASSERT_TRUE(fitted.ok());
  for (const auto* scene : {&*small, &*fitted}) {
    ASSERT_EQ(scene->contours().size(), 3u);
    const double scale = scene->statistics().scale;
    EXPECT_NE(scale, 1.0);
    EXPECT_EQ(scene->contours()[0].start_scene_m, Vec3(scale * Vec3(1, 2, 3)));
    EXPECT_EQ(scene->contours()[1].start_scene_m, Vec3(scale * Vec3(5, 2, 3)));
    EXPECT_EQ(scene->contours()[2].end_scene_m, Vec3(scale * Vec3(-8, 5, 6)));
    EXPECT_TRUE(scene->statistics().warnings.empty());
  }
}

TEST(StatedContours, AreThoseOfTheSelectedNode) {
  Random random(24);
  SceneSettings settings;
  settings.node = "object";
  const auto scene = Scene::compile(scene_with_contours(random), settings);
  ASSERT_TRUE(scene.ok()) << scene.error().to_string();
  ASSERT_EQ(scene->contours().size(), 2u);
  EXPECT_EQ(scene->contours()[0].node, "object");
  EXPECT_EQ(scene->contours()[1].node, "part");
  EXPECT_EQ(scene->contours()[1].start_scene_m, Vec3(5, 2, 3));
  for (const ContourDescription& contour : scene->contours()) {
    EXPECT_EQ(scene->tree().at(contour.tree_node).name, contour.node);
  }
  settings.node = "other";
  const auto other = Scene::compile(scene_with_contours(random), settings);
  ASSERT_TRUE(other.ok());
  ASSERT_EQ(other->contours().size(), 1u);
  EXPECT_EQ(other->contours()[0].start_scene_m, Vec3(-8, 2, 3));
}

TEST(StatedContours, PointsThatTheScaleMakesEqualOrInfiniteAreAWarning) {
  Random random(25);
  for (const double far_m : {1e-320, 1e300}) {
    SceneDescription description = scene_with_contours(random);
    description.contours[1].start_scene_m = Vec3::Zero();
    description.contours[1].end_scene_m = {0, 0, far_m};
    SceneSettings settings;
    settings.scale = far_m < 1.0 ? 1e-10 : 1e10;
    const auto scene = Scene::compile(std::move(description), settings);
    ASSERT_TRUE(scene.ok()) << scene.error().to_string();
    ASSERT_EQ(scene->contours().size(), 3u);
    EXPECT_EQ(scene->contours()[0].problem, "");
    EXPECT_NE(scene->contours()[1].problem, "");
    EXPECT_EQ(scene->contours()[1].end_scene_m, Vec3::Zero());
    ASSERT_EQ(scene->statistics().warnings.size(), 1u);
    EXPECT_EQ(scene->statistics().warnings[0].rfind("/nodes/2/extras/palpate_contour: ", 0), 0u);
  }
}

TEST(StatedContours, AMalformedContourOfAFileDoesNotRefuseTheScene) {
  const TemporaryFolder folder;
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["nodes"][0]["extras"]["palpate_contour"] = {{"start_m", {0, 0, 0}}};
  SceneSettings settings;
  settings.scale = 3.0;
  const auto scene = Scene::load(asset.write_glb(folder), settings);
  ASSERT_TRUE(scene.ok()) << scene.error().to_string();
  ASSERT_EQ(scene->statistics().warnings.size(), 1u);  // once, although the scene is scaled
  ASSERT_EQ(scene->contours().size(), 1u);
  const ContourDescription& contour = scene->contours()[0];
  EXPECT_EQ(contour.element, "/nodes/0/extras/palpate_contour/end_m");
  EXPECT_EQ(contour.problem, "is missing; expected three numbers");
  EXPECT_EQ(scene->statistics().warnings[0].rfind(contour.element + ": " + contour.problem, 0), 0u);
  EXPECT_NE(scene->statistics().warnings[0].find(contour.hint), std::string::npos);
}

}  // namespace
}  // namespace palpate
