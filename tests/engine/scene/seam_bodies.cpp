#include "tests/engine/scene/seam_bodies.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include <nlohmann/json.hpp>

namespace palpate::test {
namespace {

using Json = nlohmann::json;

// A closed surface around the origin. Its coordinates are multiples of 2^-20 below 2, so that they
// are exact in float in all frames below.
struct Solid {
  std::string kind;
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;  // front sides out
  std::vector<std::uint32_t> node_of;
  std::uint32_t node_count = 0;
  bool is_of_instances = false;  // all nodes have the same mesh, in Solid::frames
};

// The frame of a node: x -> rotation * scale * x + translation. The rotations are the 24 of a cube,
// the scales powers of two or their negatives; therefore the map is exact.
struct NodeFrame {
  Quat rotation = Quat::Identity();
  Vec3 scale = Vec3::Ones();
  Vec3 translation = Vec3::Zero();
};

// Components of sqrt(1/2) are rounded to double, as in files.
std::vector<Quat> cube_rotations() {
  std::vector<Quat> all;
  const double half = std::sqrt(0.5);
  for (int i = 0; i < 4; ++i) {
    Quat q(0, 0, 0, 0);
    q.coeffs()[i] = 1.0;
    all.push_back(q);
    for (int j = 0; j < i; ++j) {
      for (const double sign : {-1.0, 1.0}) {
        Quat r(0, 0, 0, 0);
        r.coeffs()[i] = half;
        r.coeffs()[j] = sign * half;
        all.push_back(r);
      }
    }
  }
  for (unsigned signs = 0; signs < 8; ++signs) {
    const auto part = [&](unsigned bit) { return (signs >> bit & 1u) != 0 ? 0.5 : -0.5; };
    all.emplace_back(0.5, part(0), part(1), part(2));
  }
  return all;
}

Mat3 cube_matrix(const Quat& q) {
  return q.toRotationMatrix().array().round().matrix();
}

WideMat3 wide_rotation(const Quat& q) {
  return q.cast<long double>().normalized().toRotationMatrix();
}

NodeFrame random_frame(Random& random) {
  static const std::vector<Quat> rotations = cube_rotations();
  NodeFrame frame;
  frame.rotation = rotations[random.index(rotations.size())];
  for (int i = 0; i < 3; ++i) {
    frame.scale[i] =
        std::ldexp(random.index(3) == 0 ? -1.0 : 1.0, static_cast<int>(random.index(5)) - 2);
    frame.translation[i] = std::ldexp(static_cast<double>(random.index(33)) - 16.0, -4);
  }
  return frame;
}

// ---- solids ------------------------------------------------------------------------------------

class SolidBuilder {
 public:
  explicit SolidBuilder(std::string kind) { solid_.kind = std::move(kind); }

  void add(const Vec3& a, const Vec3& b, const Vec3& c, std::uint32_t node) {
    solid_.triangles.push_back({vertex(a), vertex(b), vertex(c)});
    solid_.node_of.push_back(node);
  }
  Solid take(std::uint32_t nodes) {
    solid_.node_count = nodes;
    return std::move(solid_);
  }

 private:
  std::uint32_t vertex(const Vec3& p) {
    const auto next = static_cast<std::uint32_t>(solid_.vertices.size());
    const auto [known, is_new] = known_.try_emplace({p.x(), p.y(), p.z()}, next);
    if (is_new) solid_.vertices.push_back(p);
    return known->second;
  }

  Solid solid_;
  std::map<std::array<double, 3>, std::uint32_t> known_;
};

// The frame of one tile of a box: it maps the unit square, times the widths, to the tile.
struct Tile {
  Vec3 corner, u, v, out;
};

// A box of tiles, with the given number of tiles along each axis.
std::vector<Tile> tiles_of_box(const std::array<int, 3>& counts, const Vec3& widths) {
  std::vector<Tile> tiles;
  for (int axis = 0; axis < 3; ++axis) {
    const int i = (axis + 1) % 3;
    const int j = (axis + 2) % 3;
    for (const double side : {-0.5, 0.5}) {
      for (int m = 0; m < counts[static_cast<std::size_t>(i)]; ++m) {
        for (int n = 0; n < counts[static_cast<std::size_t>(j)]; ++n) {
          const auto at = [&](int k, double steps) {
            return widths[k] * (steps - 0.5 * counts[static_cast<std::size_t>(k)]);
          };
          Tile tile{Vec3::Zero(), widths[i] * Vec3::Unit(i), widths[j] * Vec3::Unit(j),
                    2.0 * side * Vec3::Unit(axis)};
          tile.corner[axis] = side * counts[static_cast<std::size_t>(axis)] * widths[axis];
          tile.corner[i] = at(i, m);
          tile.corner[j] = at(j, n);
          if (side < 0) std::swap(tile.u, tile.v);  // u x v points out
          tiles.push_back(tile);
        }
      }
    }
  }
  return tiles;
}

Solid tiled_box(Random& random, bool one_node_a_side) {
  static const std::vector<std::array<int, 3>> kCounts = {{1, 1, 1}, {1, 1, 2}, {1, 2, 3},
                                                          {2, 2, 2}, {1, 3, 4}, {2, 3, 3}};
  const auto counts = kCounts[random.index(kCounts.size())];
  Vec3 widths;
  for (int i = 0; i < 3; ++i) widths[i] = std::ldexp(1.0, -1 - static_cast<int>(random.index(2)));
  SolidBuilder builder(one_node_a_side ? "box of sides" : "box of tiles");
  std::uint32_t node = 0;
  Vec3 out = Vec3::Zero();
  std::uint32_t sides = 0;
  for (const Tile& t : tiles_of_box(counts, widths)) {
    if (t.out != out) ++sides;
    out = t.out;
    const std::uint32_t id = one_node_a_side ? sides - 1 : node++;
    builder.add(t.corner, t.corner + t.u, t.corner + t.u + t.v, id);
    builder.add(t.corner, t.corner + t.u + t.v, t.corner + t.v, id);
  }
  return builder.take(one_node_a_side ? sides : node);
}

Vec3 on_sphere(const Vec3& p) {
  return (p.normalized().array() * 0x1p20).round().matrix() * 0x1p-20;
}

void split_into(SolidBuilder& builder, const Vec3& a, const Vec3& b, const Vec3& c, int levels,
                const std::function<std::uint32_t(const Vec3&)>& node_at) {
  if (levels == 0) return builder.add(a, b, c, node_at(a + b + c));
  const Vec3 ab = on_sphere(a + b);
  const Vec3 bc = on_sphere(b + c);
  const Vec3 ca = on_sphere(c + a);
  split_into(builder, a, ab, ca, levels - 1, node_at);
  split_into(builder, ab, b, bc, levels - 1, node_at);
  split_into(builder, ca, bc, c, levels - 1, node_at);
  split_into(builder, ab, bc, ca, levels - 1, node_at);
}

// A subdivided octahedron. node_at: the node of a triangle, from the middle of the triangle.
Solid sphere(const std::string& kind, int levels, std::uint32_t nodes,
             const std::function<std::uint32_t(const Vec3&)>& node_at) {
  SolidBuilder builder(kind);
  for (unsigned octant = 0; octant < 8; ++octant) {
    const Vec3 x = ((octant & 1u) != 0 ? 1.0 : -1.0) * Vec3::UnitX();
    const Vec3 y = ((octant & 2u) != 0 ? 1.0 : -1.0) * Vec3::UnitY();
    const Vec3 z = ((octant & 4u) != 0 ? 1.0 : -1.0) * Vec3::UnitZ();
    const bool is_even = x.cross(y).dot(z) > 0.0;
    split_into(builder, x, is_even ? y : z, is_even ? z : y, levels, node_at);
  }
  return builder.take(nodes);
}

std::uint32_t octant_of(const Vec3& p) {
  return (p.x() > 0.0 ? 1u : 0u) + (p.y() > 0.0 ? 2u : 0u) + (p.z() > 0.0 ? 4u : 0u);
}

// Divides the body into pieces around random points; the smallest bodies get one piece per
// triangle.
Solid cut_sphere(Random& random) {
  const int levels = static_cast<int>(random.index(3)) + 1;
  std::vector<Vec3> centres(2 + random.index(49));
  for (Vec3& centre : centres) centre = random.unit_vector();
  Solid solid = sphere("cut sphere", levels, 0, [&](const Vec3& middle) {
    const auto farther = [&](const Vec3& a, const Vec3& b) {
      return a.dot(middle) < b.dot(middle);
    };
    return static_cast<std::uint32_t>(std::max_element(centres.begin(), centres.end(), farther) -
                                      centres.begin());
  });
  std::map<std::uint32_t, std::uint32_t> used;
  for (std::uint32_t& node : solid.node_of) {
    node = used.try_emplace(node, static_cast<std::uint32_t>(used.size())).first->second;
  }
  solid.node_count = static_cast<std::uint32_t>(used.size());
  return solid;
}

// ---- nodes -------------------------------------------------------------------------------------

// A separate mesh for every node: the vertices of its triangles, in the frame of the node.
MeshDescription piece_of(const Solid& solid, std::uint32_t node, const WideMat3& linear,
                         const Wide3& translation) {
  const WideMat3 inverse = linear.inverse();
  MeshDescription mesh{"piece " + std::to_string(node), {}, {}};
  std::map<std::uint32_t, std::uint32_t> known;
  for (std::size_t t = 0; t < solid.triangles.size(); ++t) {
    if (solid.node_of[t] != node) continue;
    Triangle corners{};
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t v = solid.triangles[t][i];
      const auto next = static_cast<std::uint32_t>(known.size());
      const auto [place, is_new] = known.try_emplace(v, next);
      if (is_new) {
        const Wide3 p = inverse * (solid.vertices[v].cast<long double>() - translation);
        mesh.positions.push_back(p.cast<double>());
      }
      corners[i] = place->second;
    }
    if (linear.determinant() < 0) std::swap(corners[1], corners[2]);
    mesh.triangles.push_back(corners);
  }
  return mesh;
}

// A chain of nodes above all other nodes: rotated, scaled, mirrored and away from the origin.
struct Assembly {
  struct Link {
    Quat rotation;
    Vec3 scale, translation_m;
  };
  std::vector<Link> links;  // from the root down
  WideMat3 linear = WideMat3::Identity();
  Wide3 translation_m = Wide3::Zero();

  void add(const Link& link) {
    links.push_back(link);
    const WideMat3 own = wide_rotation(link.rotation) * link.scale.cast<long double>().asDiagonal();
    translation_m += linear * link.translation_m.cast<long double>();
    linear = (linear * own).eval();
  }
};

// The size of the placed vertices.
double extent_m(const Solid& solid, const WideMat3& linear) {
  Wide3 low = Wide3::Constant(std::numeric_limits<long double>::infinity());
  Wide3 high = -low;
  for (const Vec3& v : solid.vertices) {
    const Wide3 p = linear * v.cast<long double>();
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return static_cast<double>((high - low).maxCoeff());
}

// A size from 1e-3 to 1e3 m, at up to 10 sizes from the origin.
Assembly random_assembly(Random& random, const Solid& solid) {
  const double size_m = std::pow(10.0, random.uniform(-3.0, 3.0));
  const double unit_m = size_m / extent_m(solid, WideMat3::Identity());
  const bool is_aligned = random.index(4) == 0;
  const auto rotation = [&] { return is_aligned ? Quat(Quat::Identity()) : random.rotation(); };
  std::vector<Assembly::Link> links = {{rotation(), Vec3::Constant(unit_m), Vec3::Zero()}};
  for (std::uint64_t more = random.index(3); more > 0; --more) {
    Vec3 scale;
    for (int i = 0; i < 3; ++i) {
      scale[i] = random.uniform(0.6, 1.4) * (random.index(4) == 0 ? -1.0 : 1.0);
    }
    links.push_back({rotation(), scale, random.in_box(0.5)});
  }
  Assembly assembly;
  for (const Assembly::Link& link : links) assembly.add(link);
  if (random.index(3) == 0) return assembly;
  const double sizes = random.uniform(0.0, 10.0);
  links.front().translation_m = sizes * extent_m(solid, assembly.linear) * random.unit_vector();
  assembly = {};
  for (const Assembly::Link& link : links) assembly.add(link);
  return assembly;
}

Json json_of(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}
Json json_of(const Quat& q) {
  return {q.x(), q.y(), q.z(), q.w()};
}
// Writes a transform as translation, rotation and scale, or as a matrix.
Json json_of(const Quat& rotation, const Mat3& turn, const Vec3& scale, const Vec3& translation,
             bool as_matrix) {
  if (!as_matrix) {
    return {{"rotation", json_of(rotation)},
            {"scale", json_of(scale)},
            {"translation", json_of(translation)}};
  }
  const Mat3 linear = turn * scale.asDiagonal();
  Json matrix = Json::array();
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 3; ++row) matrix.push_back(linear(row, column));
    matrix.push_back(0.0);
  }
  for (int row = 0; row < 3; ++row) matrix.push_back(translation[row]);
  matrix.push_back(1.0);
  return {{"matrix", std::move(matrix)}};
}

std::size_t add_mesh(GltfBuilder& gltf, const MeshDescription& mesh) {
  std::vector<Eigen::Vector3f> positions;
  for (const Vec3& p : mesh.positions) positions.push_back(p.cast<float>());
  std::vector<std::uint32_t> indices;
  for (const Triangle& t : mesh.triangles) indices.insert(indices.end(), t.begin(), t.end());
  const auto position = gltf.add_positions(positions);
  const auto index = gltf.add_indices(indices);
  return gltf.add_mesh({{{"attributes", {{"POSITION", position}}}, {"indices", index}}});
}

// Writes the nodes of a file, either below the chain of nodes, or at the root with transforms
// multiplied out in double, as a program may write them.
class FileNodes {
 public:
  FileNodes(Random& random, SeamBody& body, const Assembly& assembly)
      : random_(random),
        gltf_(body.gltf),
        assembly_(assembly),
        is_flat_(assembly.links.size() == 1 && random.index(2) == 0) {}

  bool is_flat() const { return is_flat_; }
  void add(const NodeFrame& frame, const Json& more) {
    const Mat3 turn = cube_matrix(frame.rotation);
    const bool as_matrix = random_.index(2) == 0;
    if (!is_flat_) {
      Json node = json_of(frame.rotation, turn, frame.scale, frame.translation, as_matrix);
      node.update(more);
      return add(std::move(node));
    }
    const Assembly::Link& root = assembly_.links[0];
    const double unit_m = root.scale.x();  // the same for all axes
    Json node =
        json_of(root.rotation * frame.rotation, root.rotation.toRotationMatrix() * turn,
                unit_m * frame.scale,
                root.rotation * (unit_m * frame.translation) + root.translation_m, as_matrix);
    node.update(more);
    gltf_.add_node(std::move(node));
  }
  void add(Json node) { children_.push_back(gltf_.add_child(std::move(node))); }

  void finish() {
    if (is_flat_) return;
    for (auto link = assembly_.links.rbegin(); link != assembly_.links.rend(); ++link) {
      Json node = {{"rotation", json_of(link->rotation)},
                   {"scale", json_of(link->scale)},
                   {"translation", json_of(link->translation_m)},
                   {"children", std::move(children_)}};
      const bool is_root = std::next(link) == assembly_.links.rend();
      children_ = Json::array(
          {is_root ? gltf_.add_node(std::move(node)) : gltf_.add_child(std::move(node))});
    }
  }

 private:
  Random& random_;
  GltfBuilder& gltf_;
  const Assembly& assembly_;
  bool is_flat_;
  Json children_ = Json::array();
};

void describe(SeamBody& body, std::uint32_t node, std::uint32_t mesh, const Assembly& assembly,
              const WideMat3& linear, const Wide3& translation) {
  NodeDescription description;
  description.name = "node " + std::to_string(node);
  description.mesh = mesh;
  description.linear_scene_mesh = (assembly.linear * linear).cast<double>();
  description.translation_m =
      (assembly.linear * translation + assembly.translation_m).cast<double>();
  body.description.nodes.push_back(std::move(description));
}

// The unit square as a mesh, and the frames that make it the tiles of a box.
MeshDescription unit_tile() {
  return {"tile", {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}};
}
std::vector<NodeFrame> tile_frames(const Solid& solid) {
  static const std::vector<Quat> rotations = cube_rotations();
  std::vector<NodeFrame> frames;
  for (std::size_t t = 0; t < solid.triangles.size(); t += 2) {
    const Vec3 corner = solid.vertices[solid.triangles[t][0]];
    const Vec3 u = solid.vertices[solid.triangles[t][1]] - corner;
    const Vec3 v = solid.vertices[solid.triangles[t + 1][2]] - corner;
    Mat3 axes;
    axes << u.normalized(), v.normalized(), u.normalized().cross(v.normalized());
    const auto same = std::find_if(rotations.begin(), rotations.end(),
                                   [&](const Quat& q) { return cube_matrix(q) == axes; });
    frames.push_back({*same, {u.norm(), v.norm(), 1.0}, corner});
  }
  return frames;
}

// One octant of a sphere as a mesh, and the mirrored frames of the other octants.
std::vector<NodeFrame> octant_frames() {
  std::vector<NodeFrame> frames;
  for (unsigned octant = 0; octant < 8; ++octant) {
    const auto sign = [&](unsigned bit) { return (octant & bit) != 0 ? 1.0 : -1.0; };
    frames.push_back({Quat::Identity(), {sign(1), sign(2), sign(4)}, Vec3::Zero()});
  }
  return frames;
}

// For float attributes: sqrt(1/2) is rounded to float, equally in both components.
void add_instances(GltfBuilder& gltf, Json& node, const std::vector<NodeFrame>& frames) {
  std::vector<float> translations, rotations, scales;
  const auto add = [](std::vector<float>& list, const auto& numbers) {
    for (const double x : numbers) list.push_back(static_cast<float>(x));
  };
  for (const NodeFrame& frame : frames) {
    add(translations, frame.translation);
    add(rotations, frame.rotation.coeffs());
    add(scales, frame.scale);
  }
  const auto accessor = [&](const std::vector<float>& numbers, const char* type, std::size_t size) {
    return gltf.add_accessor(gltf.add_view(bytes_of(numbers)), GltfBuilder::kFloat,
                             numbers.size() / size, type);
  };
  gltf.json["extensionsUsed"] = {"EXT_mesh_gpu_instancing"};
  node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"TRANSLATION", accessor(translations, "VEC3", 3)},
      {"ROTATION", accessor(rotations, "VEC4", 4)},
      {"SCALE", accessor(scales, "VEC3", 3)}};
}

// All nodes have the same mesh.
void place_instances(Random& random, const Solid& solid, const Assembly& assembly, SeamBody& body) {
  const bool is_box = solid.kind == "box of tiles";
  const std::vector<NodeFrame> frames = is_box ? tile_frames(solid) : octant_frames();
  const MeshDescription mesh =
      is_box ? unit_tile() : piece_of(solid, 7, WideMat3::Identity(), Wide3::Zero());
  if (!body.is_gltf) {
    body.description.meshes.push_back(mesh);
    for (std::uint32_t n = 0; n < frames.size(); ++n) {
      const Mat3 linear = cube_matrix(frames[n].rotation) * frames[n].scale.asDiagonal();
      describe(body, n, 0, assembly, linear.cast<long double>(),
               frames[n].translation.cast<long double>());
    }
    return;
  }
  const std::size_t id = add_mesh(body.gltf, mesh);
  FileNodes nodes(random, body, assembly);
  if (!nodes.is_flat() && random.index(2) == 0) {
    Json node = {{"mesh", id}};
    add_instances(body.gltf, node, frames);
    nodes.add(std::move(node));
  } else {
    for (const NodeFrame& frame : frames) nodes.add(frame, {{"mesh", id}});
  }
  nodes.finish();
}

// Every node has its own mesh and its own frame.
void place_pieces(Random& random, const Solid& solid, const Assembly& assembly, SeamBody& body) {
  FileNodes nodes(random, body, assembly);
  const bool is_turned_freely = !body.is_gltf && random.index(2) == 0;
  for (std::uint32_t n = 0; n < solid.node_count; ++n) {
    const NodeFrame frame = random_frame(random);
    WideMat3 linear = (cube_matrix(frame.rotation) * frame.scale.asDiagonal()).cast<long double>();
    if (is_turned_freely) linear = (wide_rotation(random.rotation()) * linear).eval();
    const Wide3 translation = frame.translation.cast<long double>();
    const MeshDescription mesh = piece_of(solid, n, linear, translation);
    if (body.is_gltf) {
      nodes.add(frame,
                {{"mesh", add_mesh(body.gltf, mesh)}, {"name", "node " + std::to_string(n)}});
    } else {
      body.description.meshes.push_back(mesh);
      describe(body, n, n, assembly, linear, translation);
    }
  }
  if (body.is_gltf) nodes.finish();
}

Solid random_solid(Random& random) {
  switch (random.index(5)) {
    case 0:
      return tiled_box(random, true);
    case 1:
    case 2: {
      Solid box = tiled_box(random, false);
      box.is_of_instances = random.index(2) == 0;
      return box;
    }
    case 3: {
      Solid octants =
          sphere("sphere of octants", 1 + static_cast<int>(random.index(3)), 8, octant_of);
      octants.is_of_instances = random.index(2) == 0;
      return octants;
    }
    default:
      return cut_sphere(random);
  }
}

}  // namespace

SeamBody random_seam_body(Random& random) {
  const Solid solid = random_solid(random);
  const Assembly assembly = random_assembly(random, solid);
  SeamBody body;
  body.kind = solid.kind + (solid.is_of_instances ? ", instances" : "");
  body.triangles = solid.triangles;
  body.node_of = solid.node_of;
  body.node_count = solid.node_count;
  body.middle_m = assembly.translation_m;
  for (const Vec3& v : solid.vertices) {
    body.vertices_m.push_back(assembly.linear * v.cast<long double>() + assembly.translation_m);
  }
  if (assembly.linear.determinant() < 0) {
    for (Triangle& t : body.triangles) std::swap(t[1], t[2]);
  }
  body.size_m = extent_m(solid, assembly.linear);
  body.description.path = "made.gltf";
  body.is_gltf = random.index(2) == 0;
  if (solid.is_of_instances) {
    place_instances(random, solid, assembly, body);
  } else {
    place_pieces(random, solid, assembly, body);
  }
  return body;
}

std::vector<std::array<std::uint32_t, 2>> seam_edges(const SeamBody& body) {
  std::map<std::array<std::uint32_t, 2>, std::uint32_t> node_at;
  std::vector<std::array<std::uint32_t, 2>> seams;
  for (std::size_t t = 0; t < body.triangles.size(); ++t) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = body.triangles[t][i];
      const std::uint32_t b = body.triangles[t][(i + 1) % 3];
      const std::array<std::uint32_t, 2> edge = {std::min(a, b), std::max(a, b)};
      const auto [other, is_new] = node_at.try_emplace(edge, body.node_of[t]);
      if (!is_new && other->second != body.node_of[t]) seams.push_back(edge);
    }
  }
  return seams;
}

std::vector<std::uint32_t> seam_vertices(const SeamBody& body) {
  std::vector<std::uint32_t> vertices;
  for (const auto& edge : seam_edges(body))
    vertices.insert(vertices.end(), edge.begin(), edge.end());
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  return vertices;
}

// ---- the inside test ---------------------------------------------------------------------------

SeamJudge::SeamJudge(const SeamBody& body, const Vec3& origin_m) {
  const long double size = body.size_m;
  for (const Triangle& t : body.triangles) {
    const auto corner = [&](std::size_t i) {
      return Wide3(body.vertices_m[t[i]] - origin_m.cast<long double>());
    };
    Face face{corner(0), corner(1), corner(2), {}, {}};
    const double margin = 1e-9 * body.size_m;
    const Wide3 low = face.a.cwiseMin(face.b).cwiseMin(face.c);
    const Wide3 high = face.a.cwiseMax(face.b).cwiseMax(face.c);
    face.low = (low.cast<double>().array() - margin).matrix();
    face.high = (high.cast<double>().array() + margin).matrix();
    faces_.push_back(face);
  }
  doubt_m2_ = 4e-18L * size * size;
  doubt_m3_ = doubt_m2_ * size;
}

bool SeamJudge::is_inside(const Vec3& p_m) const {
  const Wide3 p = p_m.cast<long double>();
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      const Answer answer = by_parity(p, p_m, axis, side);
      if (answer != Answer::kDoubtful) return answer == Answer::kInside;
    }
  }
  return by_solid_angle(p);
}

// Counts the faces on a ray along an axis, to one side. The ray meets a face at t = volume / turn.
SeamJudge::Answer SeamJudge::by_parity(const Wide3& p, const Vec3& rounded, int axis,
                                       double side) const {
  const int i = (axis + 1) % 3;
  const int j = (axis + 2) % 3;
  bool is_odd = false;
  for (const Face& face : faces_) {
    if (rounded[i] < face.low[i] || rounded[i] > face.high[i] || rounded[j] < face.low[j] ||
        rounded[j] > face.high[j]) {
      continue;
    }
    if (side > 0 ? rounded[axis] > face.high[axis] : rounded[axis] < face.low[axis]) continue;
    const Wide3 a = face.a - p;
    const Wide3 b = face.b - p;
    const Wide3 c = face.c - p;
    const auto turn = [&](const Wide3& u, const Wide3& v) { return u[i] * v[j] - u[j] * v[i]; };
    const auto [least, most] = std::minmax({turn(a, b), turn(b, c), turn(c, a)});
    if (least < -doubt_m2_ && most > doubt_m2_) continue;
    const long double volume = a.dot(b.cross(c));
    const bool is_certain = least > doubt_m2_ || most < -doubt_m2_;
    if (!is_certain || std::abs(volume) <= doubt_m3_) return Answer::kDoubtful;
    const bool is_ahead = (volume > 0) == (most > 0);
    if (is_ahead == (side > 0)) is_odd = !is_odd;
  }
  return is_odd ? Answer::kInside : Answer::kOutside;
}

// The sum of the solid angles is 4 pi inside and 0 outside (A. van Oosterom and J. Strackee, "The
// Solid Angle of a Plane Triangle", 1983).
bool SeamJudge::by_solid_angle(const Wide3& p) const {
  long double half_sum = 0;
  for (const Face& face : faces_) {
    const Wide3 a = face.a - p;
    const Wide3 b = face.b - p;
    const Wide3 c = face.c - p;
    const long double la = a.norm();
    const long double lb = b.norm();
    const long double lc = c.norm();
    half_sum +=
        std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return std::abs(half_sum) > std::numbers::pi_v<long double>;
}

}  // namespace palpate::test
