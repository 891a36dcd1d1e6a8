// Tests seams: a point does not pass between the nodes of a watertight body.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/scene/scene.h"
#include "haptics/proxy/god_object.h"
#include "haptics/proxy/live_world.h"
#include "tests/engine/scene/seam_bodies.h"
#include "tests/helpers/compiled_scene.h"
#include "tests/helpers/made.h"
#include "tests/helpers/random.h"
#include "tests/helpers/soak.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::compiled;
using test::in_soak_or_else;
using test::Random;
using test::SeamBody;
using test::SeamJudge;

Scene scene_of(SeamBody& body, const SceneSettings& settings = {}) {
  if (!body.is_gltf) return compiled(body.description, settings);
  const test::TemporaryFolder folder;
  Result<Scene> scene =
      Scene::load(test::GltfBuilder::write_text(folder, body.gltf.data_uri_text()), settings);
  EXPECT_TRUE(scene.ok()) << (scene.ok() ? "" : scene.error().to_string());
  return std::move(*scene);
}

// The same world without seams: the solver decides on every body in the body's own frame.
ContactWorld without_corners(const ContactWorld& world) {
  ContactWorld copy = world;
  for (ContactBody& body : copy.bodies) body.corners = nullptr;
  return copy;
}

// ---- a hand that aims at the seams --------------------------------------------------------------

// Points of seams, solver frame, rounded to double: a vertex, the middle of an edge, or any point
// on an edge.
class SeamAim {
 public:
  SeamAim(const SeamBody& body, const Vec3& anchor_scene_m)
      : edges_(test::seam_edges(body)), body_(body), anchor_(anchor_scene_m.cast<long double>()) {}

  bool has_seams() const { return !edges_.empty(); }
  void choose_edge(Random& random) { edge_ = edges_[random.index(edges_.size())]; }
  // The point at a fraction along the chosen edge.
  Vec3 at(double fraction) const {
    const test::Wide3& a = body_.vertices_m[edge_[0]];
    const test::Wide3& b = body_.vertices_m[edge_[1]];
    return (a + static_cast<long double>(fraction) * (b - a) - anchor_).cast<double>();
  }
  Vec3 somewhere(Random& random) {
    choose_edge(random);
    const std::uint64_t kind = random.index(4);
    return at(kind == 0 ? 0.0 : kind == 1 ? 0.5 : random.uniform(0.0, 1.0));
  }

 private:
  std::vector<std::array<std::uint32_t, 2>> edges_;
  std::array<std::uint32_t, 2> edge_{};
  const SeamBody& body_;
  test::Wide3 anchor_;
};

struct Passes {
  std::size_t ticks = 0;
  std::size_t contacts = 0;
  std::size_t passes = 0;
  std::size_t bodies_passed = 0;
};

// A point proxy inside or outside of a body, moved by a simulated hand.
class SeamHand {
 public:
  SeamHand(Random& random, const SeamBody& body, const Scene& scene, const ContactWorld& world)
      : random_(random),
        body_(body),
        judge_(body, scene.world().anchor_scene_m),
        aim_(body, scene.world().anchor_scene_m),
        god_(test::made(GodObject::create(world, {}))),
        middle_((body.middle_m - scene.world().anchor_scene_m.cast<long double>()).cast<double>()) {
    begin();
  }

  void move(std::size_t ticks, Passes& sum) {
    const std::size_t before = sum.passes;
    while (ticks > 0) {
      const std::size_t stroke = std::min<std::size_t>(ticks, 1 + random_.index(12));
      aim();
      for (std::size_t n = 0; n < stroke; ++n) tick(n, sum);
      ticks -= stroke;
    }
    sum.bodies_passed += sum.passes > before ? 1 : 0;
  }

 private:
  enum class Way : std::uint8_t { kThrough, kOnto, kAlong, kHome };

  void begin() {
    const double far_m = random_.uniform(1.0, 2.0) * body_.size_m;
    start_ = random_.index(2) == 0 ? middle_ : Vec3(middle_ + far_m * random_.unit_vector());
    god_.place(start_);
    is_inside_ = judge_.is_inside(god_.proxy());
    is_planar_ = random_.index(4) == 0;
    if (is_planar_) {
      const Vec3 to_seam = aim_.somewhere(random_) - start_;
      plane_normal_ = to_seam.cross(random_.unit_vector()).normalized();
    }
  }

  // Starts a new stroke: through a point of a seam, exactly onto it, along an edge, or back to the
  // start.
  void aim() {
    if (random_.index(40) == 0) begin();
    way_ = static_cast<Way>(random_.index(4));
    target_ = aim_.somewhere(random_);
    from_ = god_.proxy();
    depth_ = random_.index(4) == 0 ? 0.0 : std::pow(10.0, random_.uniform(-15.0, 0.5));
    out_ = (target_ - (is_inside_ ? middle_ : from_)).normalized();
    if (!is_inside_ && random_.index(2) == 0) out_ = (middle_ - target_).normalized();
  }

  Vec3 goal(std::size_t n) {
    switch (way_) {
      case Way::kThrough:
        return target_ + depth_ * (target_ - from_);
      case Way::kOnto:
        return target_;
      case Way::kAlong:
        return aim_.at(random_.index(3) == 0 ? 0.1 * static_cast<double>(n)
                                             : random_.uniform(0.0, 1.0)) +
               depth_ * body_.size_m * out_;
      case Way::kHome:
        break;
    }
    return start_;
  }

  void tick(std::size_t n, Passes& sum) {
    Vec3 to = goal(n);
    if (is_planar_) to -= plane_normal_.dot(to - start_) * plane_normal_;
    const ProxyState state =
        god_.move_to(to, is_planar_ ? std::optional<Vec3>(plane_normal_) : std::nullopt);
    ++sum.ticks;
    sum.contacts += state.in_contact ? 1 : 0;
    bool has_passed = false;
    for (const Vec3& p : god_.path()) has_passed = has_passed || judge_.is_inside(p) != is_inside_;
    if (judge_.is_inside(god_.proxy()) == is_inside_ && !has_passed) return;
    ++sum.passes;
    begin();
  }

  Random& random_;
  const SeamBody& body_;
  SeamJudge judge_;
  SeamAim aim_;
  GodObject god_;
  Vec3 middle_;
  Vec3 start_ = Vec3::Zero();
  Vec3 plane_normal_ = Vec3::Zero();
  bool is_planar_ = false;
  bool is_inside_ = false;
  Way way_ = Way::kHome;
  Vec3 target_ = Vec3::Zero();
  Vec3 from_ = Vec3::Zero();
  Vec3 out_ = Vec3::Zero();
  double depth_ = 0.0;
};

// ---- distance between the corners used for decisions and those in the index ---------------------

double farthest_apart_m(const ContactWorld& world) {
  double farthest_m = 0.0;
  for (const ContactBody& body : world.bodies) {
    if (!body.corners) continue;
    for (std::uint32_t pack = 0; pack < body.index->pack_count(); ++pack) {
      for (int lane = 0; lane < body.index->pack(pack).count; ++lane) {
        const std::uint32_t slot = SurfaceIndex::slot(pack, lane);
        TriangleGeometry room;
        TriangleGeometry t = body.triangle(slot, room);
        if (body.units_per_metre < 0.0)
          std::swap(t.b, t.c);  // corners are counter-clockwise seen from the front
        const TriangleGeometry u = body.corners->triangle(slot, body.direction_to_solver(t.normal));
        farthest_m =
            std::max({farthest_m, (body.to_solver(t.a) - u.a).norm(),
                      (body.to_solver(t.b) - u.b).norm(), (body.to_solver(t.c) - u.c).norm()});
        EXPECT_GT(body.direction_to_solver(t.normal).dot(u.normal), 0.0);
      }
    }
  }
  return farthest_m;
}

// Checks that every vertex of a seam is one place, and that every node has such vertices.
void expect_joined(const SeamBody& body, const Scene& scene) {
  const SceneStatistics& s = scene.statistics();
  EXPECT_EQ(s.seam_places, test::seam_vertices(body).size());
  EXPECT_EQ(s.seam_nodes, body.node_count);
  EXPECT_EQ(s.warnings, std::vector<std::string>());
  EXPECT_LE(farthest_apart_m(scene.world()),
            kMostApartPerStandOff * SolverScale::of(scene.world().size_m, 0.0).stand_off_m);
}

std::uint64_t seed_of(std::uint64_t body) {
  return 1300 + body;
}

TEST(Seams, NoPointPassesBetweenTheNodesOfAWatertightBody) {
  const std::uint64_t bodies = in_soak_or_else(1000u, 100u);
  Passes sum;
  for (std::uint64_t n = 0; n < bodies; ++n) {
    Random random(seed_of(n));
    SeamBody body = test::random_seam_body(random);
    SCOPED_TRACE(body.kind + (body.is_gltf ? ", glTF" : ", description") + ", " +
                 std::to_string(body.node_count) + " nodes");
    if (test::seam_edges(body).empty()) continue;
    const Scene scene = scene_of(body);
    expect_joined(body, scene);
    SeamHand hand(random, body, scene, scene.world());
    const std::size_t before = sum.passes;
    hand.move(1000, sum);
    EXPECT_EQ(sum.passes, before);
  }
  RecordProperty("ticks", std::to_string(sum.ticks));
  std::printf("%zu ticks, %zu in contact, %zu passes\n", sum.ticks, sum.contacts, sum.passes);
  EXPECT_GT(sum.contacts, sum.ticks / 4);
}

// A control of the test above: without joined corners, points do pass.
TEST(Seams, PointsPassIfEveryBodyIsTestedInItsOwnFrame) {
  Passes sum;
  for (std::uint64_t n = 0; n < in_soak_or_else(1000u, 40u); ++n) {
    Random random(seed_of(n));
    SeamBody body = test::random_seam_body(random);
    if (test::seam_edges(body).empty()) continue;
    const Scene scene = scene_of(body);
    const ContactWorld world = without_corners(scene.world());
    SeamHand(random, body, scene, world).move(in_soak_or_else(1000u, 200u), sum);
  }
  std::printf("%zu ticks, %zu passes in %zu bodies\n", sum.ticks, sum.passes, sum.bodies_passed);
  EXPECT_GT(sum.bodies_passed, 5u);
}

// ---- joined and unchanged vertices --------------------------------------------------------------

MeshDescription mesh_of(const test::Soup& soup) {
  return {"made", soup.positions, soup.triangles};
}
MeshDescription closed_box(double half_m) {
  return mesh_of(test::box_soup(Vec3::Constant(half_m)));
}
MeshDescription square() {
  test::Soup soup;
  soup.add_quad({0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0});
  return mesh_of(soup);
}

NodeDescription node_at(const Vec3& translation_m, std::uint32_t mesh = 0,
                        const Mat3& linear = Mat3::Identity()) {
  NodeDescription node;
  node.name = "node " + std::to_string(mesh);
  node.mesh = mesh;
  node.linear_scene_mesh = linear;
  node.translation_m = translation_m;
  return node;
}

SceneDescription described_by_number(std::vector<MeshDescription> meshes,
                                     std::vector<NodeDescription> nodes) {
  SceneDescription description;
  description.path = "made.glb";
  description.meshes = std::move(meshes);
  description.nodes = std::move(nodes);
  for (std::size_t i = 0; i < description.nodes.size(); ++i) {
    description.nodes[i].name = "node " + std::to_string(i);
  }
  return description;
}

// Joins only what meets within the rounding of the transforms in double.
SceneSettings without_rounding() {
  SceneSettings settings;
  settings.joins_within_rounding = false;
  return settings;
}

// Checks that a scene has no corners, no wider index and no report of seams.
void expect_left_alone(const Scene& scene) {
  EXPECT_EQ(scene.world().seams, nullptr);
  for (const ContactBody& body : scene.world().bodies) {
    EXPECT_EQ(body.corners, nullptr);
    EXPECT_EQ(body.index->sweep_radius_m(), 0.0);
  }
  EXPECT_EQ(scene.statistics().seam_vertices, 0u);
  EXPECT_EQ(scene.statistics().notes, std::vector<std::string>());
  EXPECT_EQ(scene.statistics().warnings, std::vector<std::string>());
}

TEST(Seams, AreAbsentInASceneOfOneBody) {
  expect_left_alone(compiled(described_by_number({square()}, {node_at({3, 4, 5})})));
  expect_left_alone(compiled(described_by_number({closed_box(1.0)}, {node_at({3, 4, 5})})));
}

TEST(Seams, AreAbsentBetweenClosedBodiesThatAreApart) {
  for (const double apart_m : {2.001, 5.0}) {
    expect_left_alone(compiled(
        described_by_number({closed_box(1.0)}, {node_at({0, 0, 0}), node_at({apart_m, 0, 0})})));
  }
}

TEST(Seams, AreAbsentBetweenSeparateOpenBodies) {
  std::vector<NodeDescription> nodes;
  for (int i = 0; i < 100; ++i) nodes.push_back(node_at({1.5 * (i % 10), 1.5 * (i / 10), 0}));
  expect_left_alone(compiled(described_by_number({square()}, nodes)));
}

// The faces of closed bodies coincide, and so do their vertices.
TEST(Seams, JoinClosedBodiesThatAreFlush) {
  const Scene scene =
      compiled(described_by_number({closed_box(1.0)}, {node_at({0, 0, 0}), node_at({2.0, 0, 0})}));
  EXPECT_EQ(scene.statistics().seam_vertices, 8u);
  EXPECT_EQ(scene.statistics().seam_places, 4u);
  EXPECT_EQ(scene.statistics().changed_nodes, 0u);
}

TEST(Seams, StayOpenAtAGapInTheFile) {
  const double far_apart = 0x1p-10;
  expect_left_alone(compiled(
      described_by_number({square()}, {node_at({0, 0, 0}), node_at({1.0 + far_apart, 0, 0})})));
}

// Recordings of before were made without.
TEST(Seams, StayOpenAtARoundingIfTheSettingSaysSo) {
  const SceneSettings settings = without_rounding();
  const double float_apart = 0x1p-24;
  expect_left_alone(compiled(
      described_by_number({square()}, {node_at({0, 0, 0}), node_at({1.0 + float_apart, 0, 0})}),
      settings));
  expect_left_alone(compiled(
      described_by_number({square()}, {node_at({0, 0, 0}), node_at({1, 0.5, 0})}), settings));
}

TEST(Seams, CloseAtARoundingOfTheFile) {
  const double float_apart = 0x1p-24;
  const Scene scene = compiled(
      described_by_number({square()}, {node_at({0, 0, 0}), node_at({1.0 + float_apart, 0, 0})}));
  EXPECT_EQ(scene.statistics().seam_vertices, 4u);
  EXPECT_EQ(scene.statistics().changed_nodes, 1u);
  EXPECT_EQ(scene.world().bodies[0].corners->vertex(1), scene.world().bodies[1].corners->vertex(0));
}

// A corner of each body lies in the middle of an edge of the other one.
TEST(Seams, DivideAnEdgeAtAVertexThatLiesOnIt) {
  const Scene scene =
      compiled(described_by_number({square()}, {node_at({0, 0, 0}), node_at({1, 0.5, 0})}));
  EXPECT_EQ(scene.statistics().seam_places, 2u);
  EXPECT_EQ(scene.statistics().divided_edges, 2u);
  EXPECT_EQ(scene.mesh(scene.objects()[0].mesh).face_count(), 3u);
  EXPECT_EQ(scene.mesh(scene.objects()[1].mesh).face_count(), 3u);
}

TEST(Seams, StayOpenWithAWarningIfMemoryIsShort) {
  // A row of nodes with one large mesh, which meet within a rounding: each needs a copy.
  MeshDescription large = square();
  Random random(35);
  for (std::uint32_t t = 0; t < 20000; ++t) {
    const auto first = static_cast<std::uint32_t>(large.positions.size());
    const Vec3 at(random.uniform(0.3, 0.7), random.uniform(0.3, 0.7), random.uniform(0, 1));
    large.positions.insert(large.positions.end(),
                           {at, at + 0.1 * random.unit_vector(), at + 0.1 * random.unit_vector()});
    large.triangles.push_back({first, first + 1, first + 2});
  }
  std::vector<NodeDescription> nodes;
  for (int i = 0; i < 12; ++i) nodes.push_back(node_at({i * (1.0 + 0x1p-24), 0, 0}));
  const SceneDescription description = described_by_number({large}, nodes);
  EXPECT_EQ(compiled(description).statistics().changed_nodes, 11u);
  SceneSettings settings = without_rounding();
  const auto used = compiled(description, settings).statistics().memory.total();
  settings.joins_within_rounding = true;
  for (double factor = 1.0; factor < 8.0; factor *= 1.1) {
    settings.max_memory_bytes = static_cast<std::uint64_t>(factor * static_cast<double>(used));
    const auto scene = Scene::compile(description, settings);
    if (!scene) continue;
    EXPECT_LT(scene->statistics().changed_nodes, 11u);
    ASSERT_EQ(scene->statistics().warnings.size(), 1u);
    EXPECT_NE(scene->statistics().warnings[0].find("memory"), std::string::npos);
    return;
  }
  ADD_FAILURE() << "no limit was large enough";
}

// A row of nodes that overlap, without vertices that meet. The last five are beyond the limit, in
// which a boundary edge counts as four vertices.
TEST(Seams, StayOpenWithAWarningIfTheOverlappingNodesHaveTooManyVertices) {
  constexpr std::uint32_t kSide = 300;
  constexpr std::size_t kVertices = (kSide + 1) * (kSide + 1);
  constexpr std::size_t kMost = (std::size_t{1} << 26) / (kVertices + 4 * 4 * kSide);
  MeshDescription grid;
  for (std::uint32_t i = 0; i < kVertices; ++i) {
    grid.positions.push_back(Vec3(i % (kSide + 1), i / (kSide + 1), 0) / kSide);
  }
  for (std::uint32_t row = 0; row < kSide; ++row) {
    for (std::uint32_t column = 0; column < kSide; ++column) {
      const std::uint32_t v = row * (kSide + 1) + column;
      grid.triangles.push_back({v, v + 1, v + kSide + 2});
      grid.triangles.push_back({v, v + kSide + 2, v + kSide + 1});
    }
  }
  std::vector<NodeDescription> nodes;
  for (std::size_t i = 0; i < kMost + 5; ++i) {
    nodes.push_back(node_at({0.8314 * static_cast<double>(i), 0, 0}));
  }
  const Scene scene = compiled(described_by_number({grid}, nodes));
  std::string warnings;
  for (const std::string& warning : scene.statistics().warnings) warnings += warning + "\n";
  EXPECT_NE(warnings.find(" and 4 more nodes: overlap others"), std::string::npos) << warnings;
}

// A row of tiles is rotated by a random angle about a random axis.
TEST(Seams, JoinVerticesSeparatedOnlyByRounding) {
  Random random(31);
  for (int trial = 0; trial < 100; ++trial) {
    const Mat3 turn = random.rotation().toRotationMatrix();
    const Mat3 mirrored = turn * Vec3(-1, 1, 1).asDiagonal();
    const Vec3 origin_m = random.in_box(5.0);
    const Scene scene = compiled(described_by_number(
        {square()}, {node_at(origin_m, 0, turn), node_at(origin_m + turn.col(0), 0, turn),
                     node_at(origin_m + 3.0 * turn.col(0), 0, mirrored)}));
    EXPECT_EQ(scene.statistics().seam_places, 4u);
    EXPECT_EQ(scene.statistics().seam_vertices, 8u);
    ASSERT_EQ(scene.statistics().notes.size(), 1u);
    EXPECT_NE(scene.statistics().notes[0].find("seams: 8 vertices of 3 nodes meet in 4 places"),
              std::string::npos);
    const auto& bodies = scene.world().bodies;
    for (const ContactBody& body : bodies) ASSERT_NE(body.corners, nullptr);
    // Vertices are in the order of the mesh: (0, 0), (1, 0), (1, 1), (0, 1).
    EXPECT_EQ(bodies[0].corners->vertex(1), bodies[1].corners->vertex(0));
    EXPECT_EQ(bodies[0].corners->vertex(2), bodies[1].corners->vertex(3));
    EXPECT_EQ(bodies[1].corners->vertex(1), bodies[2].corners->vertex(1));
    EXPECT_EQ(bodies[1].corners->vertex(2), bodies[2].corners->vertex(2));
  }
}

TEST(Seams, AreTheSameForEverySizeOfTheScene) {
  for (const double scale : {1e-12, 1e-3, 1e3, 1e12}) {
    SceneSettings settings;
    settings.scale = scale;
    const Mat3 turn = Quat(0.5, 0.1, -0.7, 0.2).normalized().toRotationMatrix();
    const Scene scene = compiled(described_by_number({square()}, {node_at({0, 0, 0}, 0, turn),
                                                                  node_at(turn.col(0), 0, turn)}),
                                 settings);
    EXPECT_EQ(scene.statistics().seam_places, 2u);
  }
}

// A body whose own vertices are closer together than joined vertices of different bodies.
TEST(Seams, NeverJoinTwoVerticesOfOneBody) {
  const double near = 1e-15;
  test::Soup soup;
  soup.add_quad({0, 0, 0}, {1, 0, 0}, {1, near, 0}, {0, 1, 0});
  const Scene scene = compiled(described_by_number(
      {mesh_of(soup), square()}, {node_at({0, 0, 0}), node_at({1, 0, 0}, 1), node_at({1, -1, 0}, 1),
                                  node_at({1, 0, 0}, 0, Vec3(-1, 1, 1).asDiagonal())}));
  EXPECT_GT(scene.statistics().seam_vertices, 0u);
  for (const ContactBody& body : scene.world().bodies) {
    ASSERT_NE(body.corners, nullptr);
    for (std::uint32_t v = 0; v < 4; ++v) {
      for (std::uint32_t w = 0; w < v; ++w) {
        EXPECT_NE(body.corners->vertex(v), body.corners->vertex(w));
      }
    }
  }
}

// Each vertex is close enough to its predecessor, but not to the predecessor of that one.
TEST(Seams, DoNotGrowAlongAChain) {
  const double step = 5e-15;
  std::vector<NodeDescription> nodes;
  for (int i = 0; i < 20; ++i) nodes.push_back(node_at({0, 0, step * i}));
  const Scene scene = compiled(described_by_number({square()}, nodes), without_rounding());
  EXPECT_GT(scene.statistics().seam_places, 4u);
  EXPECT_LE(farthest_apart_m(scene.world()),
            kMostApartPerStandOff * SolverScale::of(scene.world().size_m, 0.0).stand_off_m);
}

std::string only_warning(const Scene& scene) {
  EXPECT_EQ(scene.statistics().warnings.size(), 1u);
  return scene.statistics().warnings.empty() ? "" : scene.statistics().warnings[0];
}

TEST(Seams, AreNotSearchedTooFarFromTheOriginWithAWarning) {
  const Vec3 far_m(1e5, 0, 0);
  const Scene scene =
      compiled(described_by_number({square()}, {node_at(far_m), node_at(far_m + Vec3::UnitX())}));
  EXPECT_EQ(scene.world().seams, nullptr);
  EXPECT_NE(only_warning(scene).find("node 0 and 1 more nodes: too far from the origin"),
            std::string::npos);
  // The same for vertices far from the origin of their mesh.
  MeshDescription far_square = square();
  for (Vec3& p : far_square.positions) p += far_m;
  const Scene other = compiled(
      described_by_number({far_square}, {node_at(-far_m), node_at(Vec3::UnitX() - far_m)}));
  EXPECT_EQ(other.world().seams, nullptr);
  EXPECT_NE(only_warning(other).find("too far from the origin"), std::string::npos);
  // The same for a long translation and back.
  SceneDescription there_and_back =
      described_by_number({square()}, {node_at({0, 0, 0}), node_at({1, 0, 0})});
  for (NodeDescription& node : there_and_back.nodes) node.product = {2, 1.0, Vec3::Ones(), 2e5};
  EXPECT_NE(only_warning(compiled(there_and_back)).find("too far from the origin"),
            std::string::npos);
  // No warning if there are no vertices to join.
  EXPECT_TRUE(compiled(described_by_number({square()}, {node_at(far_m), node_at(2 * far_m)}))
                  .statistics()
                  .warnings.empty());
}

// One vertex is so far away that the distances of all other vertices are within rounding errors.
// Comparing nodes with thousands of such vertices would take years.
TEST(Seams, AreNotSearchedAmongCrowdedVerticesWithAWarning) {
  Random random(33);
  MeshDescription grass;
  for (std::uint32_t t = 0; t < 3000; ++t) {
    const Vec3 at = random.in_box(1.0);
    for (int k = 0; k < 3; ++k) grass.positions.push_back(at + random.in_box(0.1));
    grass.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  grass.positions.front() *= 1e24;
  std::vector<NodeDescription> nodes;
  for (int i = 0; i < 300; ++i) nodes.push_back(node_at({0.01 * i, 0, 0}));
  const Scene scene = compiled(described_by_number({grass}, nodes), without_rounding());
  EXPECT_EQ(scene.world().seams, nullptr);
  const std::string warning = only_warning(scene);
  EXPECT_NE(warning.find("more nodes: too small relative to the scene to determine"),
            std::string::npos)
      << warning;
}

TEST(Seams, AreClosedTenSizesFromTheOriginBelowAChainOfNodes) {
  SceneDescription description = described_by_number(
      {square()}, {node_at({20, 20, 20}), node_at({21, 20, 20}), node_at({20, 21, 20})});
  for (NodeDescription& node : description.nodes) node.product = {5, 1.0, Vec3::Ones(), 36.0};
  const Scene scene = compiled(description);
  EXPECT_EQ(scene.statistics().seam_nodes, 3u);
  EXPECT_EQ(scene.statistics().warnings, std::vector<std::string>());
}

TEST(Seams, OpenAtABodyThatMoves) {
  const Scene scene =
      compiled(described_by_number({square()}, {node_at({0, 0, 0}), node_at({1, 0, 0})}));
  LiveWorld live(scene.world());
  ASSERT_NE(live.body(0).corners, nullptr);
  ASSERT_TRUE(live.place(0, live.body(0).T_solver_body));
  EXPECT_EQ(live.body(0).corners, nullptr);
  EXPECT_NE(live.body(1).corners, nullptr);
}

TEST(Seams, ChangeNothingForASphere) {
  for (std::uint64_t n = 0; n < 20; ++n) {
    Random random(seed_of(n));
    SeamBody body = test::random_seam_body(random);
    const double radius_m = 0.02 * body.size_m;
    SceneSettings settings;
    settings.proxy_radius_m = radius_m;
    const Scene scene = scene_of(body, settings);
    const ContactWorld world = without_corners(scene.world());
    GodObjectSettings sphere;
    sphere.radius_m = radius_m;
    auto with = test::made(GodObject::create(scene.world(), sphere));
    auto without = test::made(GodObject::create(world, sphere));
    const Vec3 middle =
        (body.middle_m - scene.world().anchor_scene_m.cast<long double>()).cast<double>();
    with.place(middle);
    without.place(middle);
    for (int tick = 0; tick < 50; ++tick) {
      const Vec3 goal = middle + random.in_box(body.size_m);
      with.move_to(goal);
      without.move_to(goal);
      ASSERT_EQ(with.proxy(), without.proxy());
    }
  }
}

}  // namespace
}  // namespace palpate
