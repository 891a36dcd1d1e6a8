// Tests nodes that are flush by intent, and apart by the rounding of the file's numbers: no proxy
// passes between them, and none rests where it would not rest on exact coordinates.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "engine/scene/flush_search.h"
#include "engine/scene/scene.h"
#include "haptics/proxy/god_object.h"
#include "haptics/proxy/live_world.h"
#include "tests/helpers/compiled_scene.h"
#include "tests/helpers/floating_point.h"
#include "tests/helpers/made.h"
#include "tests/helpers/random.h"
#include "tests/helpers/same_cone.h"
#include "tests/helpers/soak.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::compiled;
using test::in_soak_or_else;
using test::Random;

// ---- bodies made of boxes with whole coordinates ------------------------------------------------

using Whole3 = std::array<int, 3>;

struct Block {
  Whole3 low, high;
  Whole3 parts;  // along each axis, the number of parts into which its faces are divided
};

struct Layout {
  std::string kind;
  std::vector<Block> blocks;

  Whole3 low() const {
    Whole3 all = blocks[0].low;
    for (const Block& b : blocks) {
      for (std::size_t k = 0; k < 3; ++k) all[k] = std::min(all[k], b.low[k]);
    }
    return all;
  }
  // Whether a point is in one of the closed boxes, to within `slack`.
  bool contains(const Vec3& p, double slack) const {
    return std::any_of(blocks.begin(), blocks.end(), [&](const Block& b) {
      for (int k = 0; k < 3; ++k) {
        const auto i = static_cast<std::size_t>(k);
        if (p[k] < b.low[i] - slack || p[k] > b.high[i] + slack) return false;
      }
      return true;
    });
  }
  // Whether a cube around the point is inside of the union of the boxes.
  bool is_deep(const Vec3& p, double half) const {
    for (int i = 0; i < 27; ++i) {
      const Vec3 offset(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
      if (!contains(p + half * offset, 1e-3 * half)) return false;
    }
    return true;
  }
};

int between(Random& random, int low, int high) {
  return low + static_cast<int>(random.index(static_cast<std::uint64_t>(high - low + 1)));
}

Whole3 some_parts(Random& random) {
  Whole3 parts = {1, 1, 1};
  if (random.index(2) == 0) return parts;
  for (int& n : parts) n = between(random, 1, 3);
  return parts;
}

// Boxes side by side along the first axis.
Layout row(Random& random, bool has_steps) {
  Layout layout{has_steps ? "steps" : "row", {}};
  const int count = between(random, 2, 6);
  const int height = between(random, 4, 20);
  const int depth = between(random, 4, 20);
  int at = -between(random, 0, 40);
  for (int i = 0; i < count; ++i) {
    const int width = between(random, 3, 20);
    Block b{{at, 0, 0}, {at + width, depth, height}, some_parts(random)};
    if (has_steps) {
      for (const std::size_t k : {std::size_t{1}, std::size_t{2}}) {
        const int inset = between(random, 0, 2);
        if (random.index(2) == 0) b.high[k] -= inset;
        if (random.index(3) == 0) b.low[k] += 1;
      }
    }
    layout.blocks.push_back(b);
    at += width;
  }
  return layout;
}

Layout grid(Random& random) {
  Layout layout{"grid", {}};
  const int width = between(random, 3, 9);
  const bool is_bond = random.index(2) == 0;  // every second row is shifted by half a box
  if (is_bond) layout.kind = "bond";
  const int height = between(random, 3, 9);
  for (int z = 0; z < 3; ++z) {
    for (int x = 0; x < 3; ++x) {
      const int left = 2 * x * width + (is_bond && z % 2 == 1 ? width : 0);
      layout.blocks.push_back(
          {{left, 0, z * height}, {left + 2 * width, 5, (z + 1) * height}, some_parts(random)});
    }
  }
  return layout;
}

// Bars that lie across each other, and a box on top.
Layout bars(Random& random) {
  const int width = between(random, 2, 5);
  return {"bars",
          {{{-20, -width, 0}, {20, width, 4}, some_parts(random)},
           {{-width, -15, 4}, {width + 1, 15, 8}, some_parts(random)},
           {{-1, -1, 8}, {1, 1, 11}, some_parts(random)}}};
}

Layout some_layout(Random& random) {
  switch (random.index(5)) {
    case 0:
      return row(random, true);
    case 1:
      return grid(random);
    case 2:
      return bars(random);
    default:
      return row(random, false);
  }
}

// ---- the same body as nodes of a file -----------------------------------------------------------

double rounded(double x) {
  return static_cast<double>(static_cast<float>(x));
}
Vec3 rounded(const Vec3& p) {
  return {rounded(p[0]), rounded(p[1]), rounded(p[2])};
}

// How a body of boxes is written to a file.
struct Writing {
  enum class Turn : std::uint8_t { kNone, kParent, kNodes, kVertices };

  double unit_m = 1.0;
  Turn turn = Turn::kNone;
  Quat rotation = Quat::Identity();
  Vec3 origin_m = Vec3::Zero();
  bool has_float_vertices = true;
  bool has_float_nodes = true;   // else decimal numbers, which are doubles
  bool is_scaled = false;        // one mesh of unit boxes, and scales
  bool is_middle_origin = true;  // vertices relative to the middle of the box, else to its corner

  Vec3 to_scene(const Vec3& whole) const { return rotation * (unit_m * whole) + origin_m; }
  Vec3 to_whole(const Vec3& p) const { return rotation.conjugate() * Vec3(p - origin_m) / unit_m; }
};

Writing exact_writing() {
  Writing writing;
  writing.has_float_vertices = writing.has_float_nodes = false;
  return writing;
}

Writing some_writing(Random& random) {
  Writing writing;
  writing.unit_m =
      random.index(3) == 0 ? 0.02 * between(random, 1, 13) / 7.0 : random.uniform(0.001, 0.01);
  writing.turn = static_cast<Writing::Turn>(random.index(4));
  if (writing.turn != Writing::Turn::kNone) {
    writing.rotation = random.rotation();
    if (random.index(2) == 0) {
      Quat& q = writing.rotation;
      q = Quat(rounded(q.w()), rounded(q.x()), rounded(q.y()), rounded(q.z()));
      q.normalize();
    }
  }
  if (random.index(2) == 0) writing.origin_m = random.in_box(20 * writing.unit_m);
  writing.has_float_nodes = random.index(2) == 0;
  writing.is_scaled = writing.turn != Writing::Turn::kVertices && random.index(4) == 0;
  writing.is_middle_origin = random.index(2) == 0;
  return writing;
}

// The faces of a box from `low` to `high`, divided into parts.
MeshDescription box_mesh(const Vec3& low, const Vec3& high, const Whole3& parts) {
  test::Soup soup;
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    const int nu = parts[static_cast<std::size_t>(u)];
    const int nv = parts[static_cast<std::size_t>(v)];
    for (const bool is_high : {false, true}) {
      const auto at = [&](int i, int j) {
        Vec3 p;
        p[axis] = is_high ? high[axis] : low[axis];
        p[u] = i == nu ? high[u] : low[u] + (high[u] - low[u]) * i / nu;
        p[v] = j == nv ? high[v] : low[v] + (high[v] - low[v]) * j / nv;
        return p;
      };
      for (int i = 0; i < nu; ++i) {
        for (int j = 0; j < nv; ++j) {
          if (is_high) {
            soup.add_quad(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
          } else {
            soup.add_quad(at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j));
          }
        }
      }
    }
  }
  return {"box", soup.positions, soup.triangles};
}

SceneDescription described(const Layout& layout, const Writing& writing) {
  SceneDescription description;
  description.path = "flush.glb";
  const auto of_file = [&](const Vec3& p) { return writing.has_float_nodes ? rounded(p) : p; };
  for (const Block& b : layout.blocks) {
    const Vec3 low(b.low[0], b.low[1], b.low[2]);
    const Vec3 high(b.high[0], b.high[1], b.high[2]);
    const Vec3 whole = writing.is_middle_origin ? Vec3(0.5 * (low + high)) : low;
    const double mesh_unit_m = writing.is_scaled ? 1.0 : writing.unit_m;
    MeshDescription mesh = box_mesh(low - whole, high - whole, b.parts);
    NodeDescription node;
    node.name = "node " + std::to_string(description.nodes.size());
    const Mat3 turn = writing.rotation.toRotationMatrix();
    const Vec3 scale =
        Vec3::Constant(writing.is_scaled ? of_file(Vec3::Constant(writing.unit_m))[0] : 1.0);
    const Vec3 own_m = of_file(Vec3(writing.unit_m * whole));
    const TransformProduct of_node = TransformProduct::of(Mat3(scale.asDiagonal()), own_m);
    switch (writing.turn) {
      case Writing::Turn::kNone:
        node.linear_scene_mesh = scale.asDiagonal();
        node.translation_m = of_file(Vec3(writing.origin_m + writing.unit_m * whole));
        node.product = TransformProduct::of(node.linear_scene_mesh, node.translation_m);
        break;
      case Writing::Turn::kParent:
        node.linear_scene_mesh = turn * scale.asDiagonal();
        node.translation_m = turn * own_m + writing.origin_m;
        node.product = TransformProduct::of(turn, writing.origin_m) * of_node;
        break;
      case Writing::Turn::kNodes: {
        Quat q = writing.rotation;
        if (writing.has_float_nodes) {
          q = Quat(rounded(q.w()), rounded(q.x()), rounded(q.y()), rounded(q.z())).normalized();
        }
        node.linear_scene_mesh = q.toRotationMatrix() * scale.asDiagonal();
        node.translation_m = of_file(writing.to_scene(whole));
        node.product = TransformProduct::of(node.linear_scene_mesh, node.translation_m);
        break;
      }
      case Writing::Turn::kVertices:
        node.translation_m = of_file(writing.to_scene(whole));
        node.product = TransformProduct::of(Mat3::Identity(), node.translation_m);
        break;
    }
    for (Vec3& p : mesh.positions) {
      p *= mesh_unit_m;
      if (writing.turn == Writing::Turn::kVertices) p = turn * p;
      if (writing.has_float_vertices) p = rounded(p);
    }
    // Boxes that are equal to the bit are instances.
    const auto same = std::find_if(
        description.meshes.begin(), description.meshes.end(), [&](const MeshDescription& other) {
          return other.positions == mesh.positions && other.triangles == mesh.triangles;
        });
    node.mesh = static_cast<std::uint32_t>(same - description.meshes.begin());
    if (same == description.meshes.end()) description.meshes.push_back(std::move(mesh));
    description.nodes.push_back(std::move(node));
  }
  return description;
}

// Bound on the distance of a surface from the intended one, in whole units.
double bound_of(const SceneDescription& description, const Writing& writing) {
  double most_m = 0.0;
  for (const NodeDescription& node : description.nodes) {
    Vec3 reach_m = Vec3::Zero();
    for (const Vec3& p : description.meshes[node.mesh].positions) {
      reach_m = reach_m.cwiseMax(p.cwiseAbs());
    }
    most_m = std::max(most_m, float_rounding_m(node, reach_m));
  }
  return most_m / writing.unit_m;
}

// ---- a hand that aims at the borders of boxes ---------------------------------------------------

struct Findings {
  std::size_t rows = 0;
  std::size_t ticks = 0;
  std::size_t contacts = 0;
  std::size_t passes = 0;
  std::size_t rows_passed = 0;
  std::size_t other_rests = 0;  // from which a proxy on the exact twin moves on
  double farthest = 0.0;        // by which it comes nearer to its goal, in bounds
};

// A proxy on the nodes of a file and one on the twin with exact coordinates, moved alike.
class FlushHand {
 public:
  FlushHand(Random& random, const Layout& layout, const Writing& writing, const Scene& scene,
            const Scene& twin, double bound, double radius)
      : random_(random),
        layout_(layout),
        writing_(writing),
        scene_(scene),
        twin_scene_(twin),
        bound_(bound),
        radius_(radius),
        god_(test::made(GodObject::create(scene.world(), {radius * writing.unit_m}))),
        twin_(test::made(GodObject::create(twin.world(), {radius}))) {}

  void stroke(Findings& sum) {
    if (!aim()) return;
    god_.place(solver(start()));
    const double depth = random_.index(3) == 0 ? random_.uniform(0.0, 30.0)
                                               : std::pow(10.0, random_.uniform(-9.0, 0.0));
    const Vec3 in = target_ - depth * out_;
    if (!tick(target_ + (radius_ + 0.05) * out_, sum) || !tick(in, sum)) return;
    Vec3 way = random_.unit_vector();
    if (random_.index(2) == 0) {
      way = Vec3::Zero();
      way[static_cast<int>(random_.index(3))] = random_.index(2) == 0 ? 1.0 : -1.0;
    }
    const double step = std::pow(10.0, random_.uniform(-6.0, 0.0));
    for (int n = 1; n <= 12; ++n) {
      if (!tick(in + (random_.index(8) == 0 ? 5.0 : 1.0) * step * n * way, sum)) return;
    }
  }

 private:
  // Chooses a point on an edge of a box that is on the surface of the whole, and a direction out.
  bool aim() {
    for (int attempt = 0; attempt < 50; ++attempt) {
      const Block& b = layout_.blocks[random_.index(layout_.blocks.size())];
      const auto axis = random_.index(3);
      for (std::size_t k = 0; k < 3; ++k) {
        const int i = static_cast<int>(k);
        target_[i] = random_.index(2) == 0 ? b.low[k] : b.high[k];
        if (k != axis) continue;
        const double fraction = random_.index(3) == 0 ? 0.5 : random_.uniform(0.0, 1.0);
        if (random_.index(4) != 0) target_[i] = b.low[k] + fraction * (b.high[k] - b.low[k]);
      }
      out_ = Vec3(between(random_, -1, 1), between(random_, -1, 1), between(random_, -1, 1));
      if (random_.index(3) == 0) out_ = random_.unit_vector();
      if (out_.norm() == 0.0) continue;
      out_.normalize();
      const double off = random_.index(2) == 0 ? 0.0 : bound_ * random_.uniform(-1.0, 1.0);
      target_ += off * random_.unit_vector();
      if (layout_.contains(start(), radius_ + 1e-3)) continue;
      if (layout_.is_deep(target_ - 0.1 * out_, 0.01)) return true;
    }
    return false;
  }

  Vec3 start() const { return target_ + (radius_ + 0.3) * out_; }

  Vec3 solver(const Vec3& whole) const {
    return scene_.world().to_solver(writing_.to_scene(whole));
  }

  bool tick(const Vec3& goal, Findings& sum) {
    const ProxyState state = god_.move_to(solver(goal));
    ++sum.ticks;
    sum.contacts += state.in_contact ? 1 : 0;
    const auto to_whole = [&](const Vec3& s) {
      return writing_.to_whole(s + scene_.world().anchor_scene_m);
    };
    const double deep = 4 * bound_;
    const auto is_deep = [&](const Vec3& s) { return layout_.is_deep(to_whole(s), deep); };
    if (std::any_of(god_.path().begin(), god_.path().end(), is_deep) || is_deep(god_.proxy())) {
      ++sum.passes;
      return false;
    }
    if (!state.in_contact || is_tie(goal)) return true;
    Vec3 p = to_whole(god_.proxy());
    double nearer = nearer_on_twin(p, goal) / bound_;
    // A tick may be too short for a sphere's way over an edge.
    for (int n = 0; n < kMostTicksOfAWay && nearer > kMostNearer; ++n) {
      // A proxy that is held between two ways of equal length has to begin on one of them.
      if (n % 20 == 10)
        god_.place(solver(outside(p + kAside * (p - twin_rest()).normalized(), goal)));
      god_.move_to(solver(goal));
      p = to_whole(god_.proxy());
      nearer = nearer_on_twin(p, goal) / bound_;
    }
    sum.farthest = std::max(sum.farthest, nearer);
    sum.other_rests += nearer > kMostNearer ? 1 : 0;
    if (nearer > kMostNearer && std::getenv("PALPATE_SHOW")) {
      const Vec3 q = twin_.proxy() + twin_scene_.world().anchor_scene_m;
      std::printf(
          "REST %s r %.4g bound %.3g nearer %.4g; goal %.12g %.12g %.12g proxy %.12g %.12g %.12g "
          "twin %.12g %.12g %.12g \n",
          layout_.kind.c_str(), radius_, bound_, nearer, goal[0], goal[1], goal[2], p[0], p[1],
          p[2], q[0], q[1], q[2]);
    }
    return nearer <= kMostNearer;
  }

  // Whether a coordinate of the goal is that of a side of a box, so that rounding decides between
  // two ways.
  bool is_tie(const Vec3& goal) const {
    return std::any_of(layout_.blocks.begin(), layout_.blocks.end(), [&](const Block& b) {
      for (std::size_t k = 0; k < 3; ++k) {
        const double x = goal[static_cast<int>(k)];
        if (std::min(std::abs(x - b.low[k]), std::abs(x - b.high[k])) < 100 * bound_) return true;
      }
      return false;
    });
  }

  // A point near p from which all surfaces are more than a bound away.
  Vec3 outside(const Vec3& p, const Vec3& goal) const {
    const Vec3 lag = (p - goal).normalized();
    for (int i = 0; i < 28; ++i) {
      const Vec3 way =
          i == 0 ? lag : Vec3(lag + Vec3((i - 1) % 3 - 1, (i - 1) / 3 % 3 - 1, (i - 1) / 9 - 1));
      const Vec3 start = p + 4 * bound_ * way;
      if (!layout_.contains(start, radius_ == 0.0 ? bound_ : 0.0)) return start;
    }
    return p;
  }

  Vec3 twin_rest() const { return twin_.proxy() + twin_scene_.world().anchor_scene_m; }

  // How much nearer to the goal a proxy on the twin comes if it begins at p.
  double nearer_on_twin(const Vec3& p, const Vec3& goal) {
    twin_.place(twin_scene_.world().to_solver(outside(p, goal)));
    twin_.move_to(twin_scene_.world().to_solver(goal));
    return (p - goal).norm() - (twin_rest() - goal).norm();
  }

  static constexpr double kAside = 1e-3;
  static constexpr int kMostTicksOfAWay = 50;
  // In bounds. A vertex has an error of at most 1 bound. A vertex that is moved to an edge has the
  // error of the edge across it, and its own one along it: sqrt(2). A second round takes it to an
  // edge that the first round has bent by as much: sqrt(2) * sqrt(2). No round after the second
  // changes these bodies. The faces are between their vertices, and the overlap of 1/16 stand-off
  // and the clearance are less than 1e-3 bounds. A proxy rests against at most three planes. They
  // are perpendicular to each other, and each of them is displaced by at most 2 bounds.
  static constexpr double kMostNearer = 2.0 * std::numbers::sqrt3;

  Random& random_;
  const Layout& layout_;
  const Writing& writing_;
  const Scene& scene_;
  const Scene& twin_scene_;
  double bound_;
  double radius_;
  GodObject god_;
  GodObject twin_;
  Vec3 target_ = Vec3::Zero();
  Vec3 out_ = Vec3::Zero();
};

void judge_row(std::uint64_t seed, bool joins, Findings& sum) {
  Random random(seed);
  const Layout layout = some_layout(random);
  const Writing writing = some_writing(random);
  SCOPED_TRACE(layout.kind);
  SceneSettings settings;
  settings.joins_within_rounding = joins;
  const double radius = random.index(3) == 0 ? random.uniform(0.05, 2.0) : 0.0;
  settings.proxy_radius_m = radius * writing.unit_m;
  SceneDescription description = described(layout, writing);
  const double bound = bound_of(description, writing);
  const Scene scene = compiled(std::move(description), settings);
  settings.proxy_radius_m = radius;
  const Scene twin = compiled(described(layout, exact_writing()), settings);
  FlushHand hand(random, layout, writing, scene, twin, bound, radius);
  const Findings before = sum;
  for (int n = 0; n < 30; ++n) hand.stroke(sum);
  ++sum.rows;
  sum.rows_passed += sum.passes > before.passes ? 1 : 0;
  if (!joins) return;
  EXPECT_EQ(sum.passes, before.passes) << "seed " << seed;
  EXPECT_EQ(sum.other_rests, before.other_rests) << "seed " << seed;
}

void print(const Findings& sum) {
  std::printf(
      "%zu bodies, %zu ticks, %zu in contact, %zu passes in %zu bodies, %zu other rests, "
      "at most %.3g bounds nearer on the twin\n",
      sum.rows, sum.ticks, sum.contacts, sum.passes, sum.rows_passed, sum.other_rests,
      sum.farthest);
}

TEST(FlushNodes, HoldAProxyLikeExactCoordinates) {
  Findings sum;
  const std::uint64_t first = test::from_environment("PALPATE_FIRST_SCENE", 4500);
  for (std::uint64_t n = 0; n < in_soak_or_else(1000u, 100u); ++n) judge_row(first + n, true, sum);
  print(sum);
  EXPECT_GT(sum.contacts, sum.ticks / 3);
}

// A control of the test above.
TEST(FlushNodes, LetAPointPassIfTheyAreNotJoined) {
  Findings sum;
  for (std::uint64_t n = 0; n < in_soak_or_else(400u, 60u); ++n) judge_row(4500 + n, false, sum);
  print(sum);
  EXPECT_GT(sum.rows_passed, 5u);
}

// ---- what must not change -----------------------------------------------------------------------

Scene two_boxes(double apart, const SceneSettings& settings = {}) {
  SceneDescription description;
  description.path = "two.glb";
  description.meshes.push_back(box_mesh({0, 0, 0}, {1, 1, 1}, {1, 1, 1}));
  for (const double x : {0.0, 1.0 + apart}) {
    NodeDescription node;
    node.name = x == 0.0 ? "left" : "right";
    node.translation_m = {x, 0, 0};
    node.product = TransformProduct::of(Mat3::Identity(), node.translation_m);
    description.nodes.push_back(node);
  }
  return compiled(std::move(description), settings);
}

TEST(FlushNodes, KeepOneIndexAndNoCornersIfTheyAreApart) {
  for (const double apart : {1e-5, 1e-3, 0.1}) {
    const Scene scene = two_boxes(apart);
    EXPECT_EQ(scene.world().seams, nullptr) << apart;
    EXPECT_EQ(scene.statistics().indices, 1u);
    EXPECT_EQ(scene.statistics().changed_nodes, 0u);
  }
}

TEST(FlushNodes, AreReportedIfTheyAreNearAndNotJoined) {
  const Scene scene = two_boxes(1e-5);
  EXPECT_EQ(scene.statistics().apart_vertices, 8u);
  EXPECT_NEAR(scene.statistics().least_apart_m, 1e-5, 1e-12);
  EXPECT_NEAR(scene.statistics().most_apart_m, 1e-5, 1e-12);
  EXPECT_EQ(two_boxes(0.1).statistics().apart_vertices, 0u);
}

TEST(FlushNodes, JoinUpToTheSumOfTheirBoundsAndNotBeyond) {
  const auto bound_m = [](double x) {
    NodeDescription node;
    node.translation_m = {x, 0, 0};
    node.product = TransformProduct::of(Mat3::Identity(), node.translation_m);
    return float_rounding_m(node, Vec3::Ones());
  };
  const double most_m = bound_m(0.0) + bound_m(1.0);
  EXPECT_EQ(two_boxes(0.99 * most_m).statistics().seam_places, 4u);
  EXPECT_EQ(two_boxes(-0.99 * most_m).statistics().seam_places, 4u);
  EXPECT_EQ(two_boxes(1.01 * most_m).statistics().seam_places, 0u);
}

// Of nodes that meet, the first one in the file keeps its position, whichever side it is on.
TEST(FlushNodes, TakeThePositionOfTheLowestNode) {
  constexpr double kApart = 2e-7;
  for (const bool is_left_first : {true, false}) {
    SceneDescription description;
    description.path = "two.glb";
    description.meshes.push_back(box_mesh({0, 0, 0}, {1, 1, 1}, {1, 1, 1}));
    for (const bool is_left : {is_left_first, !is_left_first}) {
      NodeDescription node;
      node.name = is_left ? "left" : "right";
      node.translation_m = {is_left ? 0.0 : 1.0 + kApart, 0, 0};
      node.product = TransformProduct::of(Mat3::Identity(), node.translation_m);
      description.nodes.push_back(node);
    }
    const Scene scene = compiled(std::move(description));
    EXPECT_EQ(scene.statistics().changed_nodes, 1u);
    std::vector<Vec3> positions_m;
    std::vector<Triangle> triangles;
    scene.append_triangles_scene(positions_m, triangles);
    const double seam_m = is_left_first ? 1.0 : 1.0 + kApart;
    int at_the_seam = 0;
    for (const Vec3& p : positions_m) {
      if (std::abs(p.x() - 1.0) > 0.5) continue;
      EXPECT_NEAR(p.x(), seam_m, 1e-3 * kApart) << is_left_first;
      ++at_the_seam;
    }
    EXPECT_EQ(at_the_seam, 8);
  }
}

TEST(FlushNodes, JoinWiderGapsOnDemand) {
  SceneSettings settings;
  settings.close_gaps_m = 2e-3;
  const Scene scene = two_boxes(1e-3, settings);
  EXPECT_EQ(scene.statistics().seam_places, 4u);
  EXPECT_EQ(scene.statistics().changed_nodes, 1u);
}

// Nodes that meet no other node have numbers, too.
TEST(FlushNodes, AreJoinedAlikeWhereverTheirNumbersAre) {
  const double step = 0.1 / 7.0;
  const auto positions_of = [&](std::size_t alone_before) {
    SceneDescription description;
    description.path = "numbers.glb";
    description.meshes.push_back(
        box_mesh(Vec3::Constant(-0.5 * step), Vec3::Constant(0.5 * step), {1, 1, 1}));
    for (std::size_t i = 0; i < 60; ++i) {
      NodeDescription node;
      const bool is_alone = i < alone_before || i >= alone_before + 10;
      const auto place = static_cast<double>(i - alone_before);
      node.name = "node " + std::to_string(i);
      node.translation_m = is_alone ? Vec3(static_cast<double>(i) * step * 3, 1.0, 0.0)
                                    : rounded(Vec3(place * step, 0, 0));
      node.product = TransformProduct::of(Mat3::Identity(), node.translation_m);
      description.nodes.push_back(node);
    }
    const Scene scene = compiled(std::move(description));
    EXPECT_EQ(scene.statistics().seam_places, 36u) << alone_before;
    std::vector<Vec3> positions_m;
    std::vector<Triangle> triangles;
    scene.append_triangles_scene(positions_m, triangles);
    const auto first = static_cast<std::ptrdiff_t>(8 * alone_before);
    return std::vector<Vec3>(positions_m.begin() + first, positions_m.begin() + first + 80);
  };
  const std::vector<Vec3> first = positions_of(0);
  EXPECT_EQ(positions_of(25), first);
  EXPECT_EQ(positions_of(50), first);
}

// A row of boxes with divided faces, and one of its seams, along which a point moves on one side.
class SeamOfBoxes {
 public:
  explicit SeamOfBoxes(Random& random) {
    Layout layout = row(random, false);
    for (Block& block : layout.blocks) {
      block.parts = {between(random, 1, 4), between(random, 1, 8), between(random, 1, 8)};
    }
    writing_.unit_m = kUnit_m;
    scene_.emplace(compiled(described(layout, writing_)));
    const Block& block = layout.blocks[1 + random.index(layout.blocks.size() - 1)];
    const bool is_on_top = random.index(2) == 0;
    along_ = is_on_top ? 1 : 2;
    across_ = is_on_top ? 2 : 1;
    seam_ = block.low[0];
    length = block.high[static_cast<std::size_t>(along_)];
    top_ = block.high[static_cast<std::size_t>(across_)];
  }

  const ContactWorld& world() const { return scene_->world(); }
  // The place, solver frame, at this way along the seam, this height above the side, and so far
  // aside of the seam, all in units of the row.
  Vec3 at(double way, double height, double aside = 0.0) const {
    Vec3 p;
    p[0] = seam_ + aside;
    p[along_] = way;
    p[across_] = top_ + height;
    return world().to_solver(writing_.to_scene(p));
  }

  static constexpr double kUnit_m = 1.0 / 64;
  double length = 0.0;  // of the row along the seam

 private:
  Writing writing_ = exact_writing();
  std::optional<Scene> scene_;
  int along_ = 1;
  int across_ = 2;  // the axis against whose positive side the point presses
  double seam_ = 0.0;
  double top_ = 0.0;
};

// A point whose goal moves exactly along a seam follows it in every tick, whatever edges of either
// node lie there. Hardly a tick is capped: the search for improvements of the rest fits into the
// work budget.
TEST(FlushNodes, LetAPointFollowASeamInEveryTick) {
  std::size_t capped = 0;
  std::size_t ticks = 0;
  for (std::uint64_t n = 0; n < in_soak_or_else(2000u, 60u); ++n) {
    Random random(7100 + n);
    const SeamOfBoxes seam(random);
    const double depth = random.uniform(0.01, 1.0);
    const double step = seam.length * std::pow(2.0, -random.uniform(4.0, 9.0));
    auto god = test::made(GodObject::create(seam.world(), {}));
    double way = 0.2 * seam.length;
    god.place(seam.at(way, 1.0));
    for (int tick = 0; tick < 60; ++tick) {
      if (tick % 6 != 5) way = std::min(way + step, 0.9 * seam.length);  // sometimes the hand waits
      const ProxyState state = god.move_to(seam.at(way, -depth));
      ++ticks;
      capped += state.capped;
      const Vec3 off = god.proxy() - seam.at(way, 0.0);
      ASSERT_LE(off.norm(), 8 * god.scale().stand_off_m + 64 * test::kEpsilon) << n << " " << tick;
    }
  }
  EXPECT_LE(capped, ticks / 10000) << "of " << ticks;
}

// A point that friction holds, whose goal moves along a seam or within rounding of it, slides with
// mu_k on one material, at any speed and whatever edges of either node lie there: an edge bears no
// part of the lag of a point that is over a face. Where the point meets an edge, its normal may tip
// for one tick, and the slide then ends a little below the cone.
TEST(FlushNodes, LetAPointSlideAlongASeam) {
  std::size_t capped = 0;
  std::size_t slides = 0;
  std::size_t sticks = 0;
  double least = 1.0;
  for (std::uint64_t n = 0; n < in_soak_or_else(2000u, 100u); ++n) {
    Random random(9100 + n);
    const SeamOfBoxes seam(random);
    const double mu_k = random.uniform(0.05, 1.0);
    const double mu_s = mu_k * random.uniform(1.0, 1.5);
    const double depth = random.uniform(0.01, 0.2) * seam.length;
    const double step = seam.length * std::pow(2.0, -random.uniform(5.0, 9.0));
    const double beside = random.index(2) == 0 ? 0.0 : std::pow(10.0, random.uniform(-16.0, -6.0));
    const bool is_slow = n % 3 == 0;  // once it slides, the hand may crawl
    auto god = test::made(GodObject::create(seam.world(), {}));
    test::SameCone cone({mu_s, mu_k});
    double way = 0.1 * seam.length;
    const Vec3 out = (seam.at(way, 1.0) - seam.at(way, 0.0)).normalized();
    god.place(seam.at(way, 0.01));
    double pulled = 0.0;
    for (int tick = 0; tick < 80 && way + step < 0.9 * seam.length; ++tick) {
      const Vec3 goal = seam.at(way, -depth, random.index(2) == 0 ? beside : -beside);
      const ProxyState state = god.move_with_friction(goal, std::nullopt, {cone, 0.0});
      capped += state.capped;
      const bool crawls = is_slow && pulled > (mu_s + 0.1) * depth + 2 * step;
      const double moved = crawls ? step * std::pow(2.0, -random.uniform(0.0, 34.0)) : step;
      way += moved;
      pulled += moved;
      if (tick == 0 || state.capped || pulled < (mu_s + 0.1) * depth + 2 * step) continue;
      ++slides;
      const Vec3 lag = god.proxy() - goal;
      const double depth_m = lag.dot(out);
      const double ratio = (lag - depth_m * out).norm() / depth_m;
      // The proxy keeps its height to within a stand-off, and the goal swings by twice `beside`.
      const double off_m = god.scale().stand_off_m + 2 * beside * SeamOfBoxes::kUnit_m;
      const double tolerance = 1e-9 + 2 * off_m / depth_m;
      ASSERT_LE(ratio, mu_k + tolerance) << n << " " << tick << " " << beside;
      sticks += ratio < mu_k - tolerance;
      least = std::min(least, ratio / mu_k);
    }
  }
  std::printf("%zu slides, %zu below the cone, the lowest by %.3g of mu_k; %zu capped\n", slides,
              sticks, 1.0 - least, capped);
  EXPECT_GT(slides, 1000u);
  EXPECT_LE(capped, 1 + slides / 10000) << "of " << slides;
  EXPECT_LE(sticks, slides / 100);
  EXPECT_GE(least, 0.999);
}

// Instances of one box at multiples of its width, which are rounded to float.
TEST(FlushNodes, HoldAPressAtEverySeamOfInstancesWithFloatTranslations) {
  int seams_held = 0;
  for (int k = 0; k < 12; ++k) {
    const double step = 0.02 * (1 + k) / 7.0;
    SceneDescription description;
    description.path = "instances.glb";
    description.meshes.push_back(
        box_mesh(Vec3::Constant(-0.5 * step), Vec3::Constant(0.5 * step), {1, 1, 1}));
    for (Vec3& p : description.meshes[0].positions) p = rounded(p);
    for (int i = 0; i < 5; ++i) {
      NodeDescription node;
      node.name = "node " + std::to_string(i);
      node.translation_m = rounded(Vec3(i * step, 0, 0));
      node.product = TransformProduct::of(Mat3::Identity(), node.translation_m);
      description.nodes.push_back(node);
    }
    const Scene scene = compiled(std::move(description));
    for (int i = 0; i < 4; ++i) {
      auto god = test::made(GodObject::create(scene.world(), {}));
      const double x = (i + 0.5) * step;
      god.place(scene.world().to_solver({x, 0, 0.6 * step}));
      for (const double z : {0.52, 0.2, 0.0}) {
        god.move_to(scene.world().to_solver({x, 0, z * step}));
      }
      const Vec3 p = god.proxy() + scene.world().anchor_scene_m;
      seams_held += std::abs(p.z() - 0.5 * step) < 1e-6 * step ? 1 : 0;
    }
  }
  EXPECT_EQ(seams_held, 48);
}

}  // namespace
}  // namespace palpate
