#include "tests/helpers/rest_scenes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "tests/helpers/hard_scenes.h"

namespace palpate::test {
namespace {

constexpr double kTurn_rad = 2 * std::numbers::pi;

double log_uniform(Random& random, double low, double high) {
  return low * std::pow(high / low, random.uniform(0.0, 1.0));
}

int between(Random& random, int low, int high) {
  return low + static_cast<int>(random.index(static_cast<std::uint64_t>(high - low + 1)));
}

void append(const Soup& other, const RigidTransform& pose, double scale, Soup& soup) {
  const auto first = static_cast<std::uint32_t>(soup.positions.size());
  for (const Vec3& p : other.positions) soup.positions.push_back(pose.point(scale * p));
  for (const Triangle& t : other.triangles) {
    soup.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
}

// Rounded to float, as in a file.
Soup in_float(Soup soup) {
  for (Vec3& p : soup.positions) p = p.cast<float>().cast<double>();
  return soup;
}

// Moves the scene to a random pose in two cases of three.
Soup posed(const Soup& soup, Random& random) {
  if (random.index(3) == 0) return soup;
  Soup moved;
  append(soup, random.pose(0.1), 1.0, moved);
  return moved;
}

// Ten stand-offs in a scene of 0.1 to 0.2 m, as a radius of spheres.
constexpr double kFewStandOffs_m = 10 * 0.2 * SolverScale::kStandOffPerSize;

double some_radius_m(ProxyKind proxy, double low, double high, Random& random) {
  return proxy == ProxyKind::kPoint ? 0.0 : log_uniform(random, low, high);
}

// A grid of columns x rows quads, `side_m` wide, with vertices at heights(i, j). Each quad is split
// along a random diagonal.
template <typename Height>
Soup height_field(int columns, int rows, double side_m, Random& random, Height height) {
  Soup soup;
  const auto at = [&](int i, int j) {
    return Vec3(side_m * (static_cast<double>(i) / columns - 0.5),
                side_m * (static_cast<double>(j) / rows - 0.5), height(i, j));
  };
  std::vector<Vec3> nodes;
  for (int j = 0; j <= rows; ++j) {
    for (int i = 0; i <= columns; ++i) nodes.push_back(at(i, j));
  }
  const auto node = [&](int i, int j) {
    return nodes[static_cast<std::size_t>(j * (columns + 1) + i)];
  };
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      if (random.index(2)) {
        soup.add_quad(node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1));
      } else {
        soup.add_quad(node(i + 1, j), node(i + 1, j + 1), node(i, j + 1), node(i, j));
      }
    }
  }
  return soup;
}

template <HardKind kind>
RestScene hard(ProxyKind proxy, Random& random) {
  HardScene scene = hard_scene(kind, random);
  return {std::move(scene.soup), some_radius_m(proxy, 1e-6, 1e-2, random), {}, scene.aims};
}

// ---- what was found ----------------------------------------------------------------------------

// Several plates, as open sheets or with a thickness. The hand meets them in their planes.
RestScene plate_rims(ProxyKind proxy, Random& random) {
  Soup soup;
  for (int i = between(random, 1, 3); i > 0; --i) {
    const Vec3 half(random.uniform(0.02, 0.1), random.uniform(0.02, 0.1),
                    random.index(2) ? 0.0 : log_uniform(random, 1e-6, 1e-2));
    Soup plate;
    if (half.z() > 0.0) {
      plate = box_soup(half);
    } else {
      const int pieces = between(random, 1, 4);
      plate = height_field(pieces, pieces, 2 * half.x(), random, [](int, int) { return 0.0; });
    }
    append(plate, i == 1 ? RigidTransform{} : random.pose(0.05), 1.0, soup);
  }
  return {posed(soup, random), some_radius_m(proxy, 1e-6, 1e-2, random)};
}

RestScene terrains(ProxyKind proxy, Random& random) {
  const int cells = between(random, 3, 24);
  const double rough_m = log_uniform(random, 1e-5, 0.03);
  const double waves = random.uniform(0.0, 8.0);
  Soup soup = height_field(cells, cells, 0.1, random, [&](int i, int j) {
    const double wave = std::cos(waves * i / cells) * std::cos(waves * j / cells);
    return rough_m * (wave + random.uniform(-1.0, 1.0));
  });
  return {in_float(soup), some_radius_m(proxy, 1e-5, 1e-2, random)};
}

// A wall that winds around 0.5 to 6 times, upright or leaning.
RestScene spirals(ProxyKind proxy, Random& random) {
  const int steps = between(random, 12, 120);
  const double turns = random.uniform(0.5, 6.0);
  const double lean = random.index(2) ? 0.0 : random.uniform(-0.5, 0.5);
  const double pitch_m = 0.08 / turns;
  const int floors = between(random, 1, 2);
  const auto at = [&](int k, int level) {
    const double turn_rad = kTurn_rad * turns * k / steps;
    const double z = 0.04 * level / floors;
    const double r = 0.005 + 0.08 * k / steps + lean * z;
    return Vec3(r * std::cos(turn_rad), r * std::sin(turn_rad), z);
  };
  Soup soup;
  for (int k = 0; k < steps; ++k) {
    for (int level = 0; level < floors; ++level) {
      soup.add_quad(at(k, level), at(k + 1, level), at(k + 1, level + 1), at(k, level + 1));
    }
  }
  if (random.index(2)) {
    soup.add_quad({-0.1, -0.1, 0.0}, {0.1, -0.1, 0.0}, {0.1, 0.1, 0.0}, {-0.1, 0.1, 0.0});
  }
  return {in_float(soup), some_radius_m(proxy, 0.01 * pitch_m, 0.45 * pitch_m, random)};
}

RestScene convex_rooms(ProxyKind proxy, Random& random) {
  return {convex_room(random), some_radius_m(proxy, 1e-6, 4e-3, random), {Vec3::Zero()}};
}

// A cone from foot to tip, with its thickness at the foot.
void add_needle(const Vec3& foot, const Vec3& tip, double thick_m, Random& random, Soup& soup) {
  const int sides = between(random, 3, 8);
  const Vec3 axis = (tip - foot).normalized();
  const Vec3 across = axis.unitOrthogonal();
  std::vector<Vec3> ring;
  for (int k = 0; k < sides; ++k) {
    const double turn_rad = kTurn_rad * (k + random.uniform(0.0, 0.5)) / sides;
    ring.push_back(
        foot + thick_m * (std::cos(turn_rad) * across + std::sin(turn_rad) * axis.cross(across)));
  }
  for (std::size_t k = 0; k < ring.size(); ++k) {
    soup.add(ring[k], ring[(k + 1) % ring.size()], tip);
    soup.add(ring[(k + 1) % ring.size()], ring[k], foot);
  }
}

// Needles around one place: cones that point to it or away from it, in all directions or side by
// side like the ribs of a hand fan; long, narrow, loose triangles; or the pleats of the fan.
RestScene needle_fans(ProxyKind proxy, Random& random) {
  enum Needle { kLoose, kPleat, kTipIn, kTipOut };
  const auto needle = static_cast<Needle>(random.index(4));
  const int most = needle <= kPleat ? 400 : 40;
  const int needles = static_cast<int>(log_uniform(random, 4.0, most));
  const bool is_flat = random.index(2) || needle == kPleat;
  const double spread_rad = log_uniform(random, 0.05, 0.9 * kTurn_rad);
  const double thick_m = log_uniform(random, 1e-4, 1e-2);
  const Vec3 middle = random.index(2) ? Vec3(Vec3::Zero()) : random.in_box(0.02);
  Soup soup;
  Vec3 last = middle;
  for (int i = 0; i < needles; ++i) {
    const double turn_rad = spread_rad * (i - 0.5 * needles) / needles;
    const Vec3 across = Vec3(std::cos(turn_rad), std::sin(turn_rad), 0.0);
    const Vec3 far = 0.08 * (is_flat ? across : random.unit_vector());
    const Vec3 near = middle + 1e-3 * random.uniform(0.0, 1.0) * random.unit_vector();
    switch (needle) {
      case kLoose:
        soup.add(middle, far, far + thick_m * random.unit_vector());
        break;
      case kPleat: {
        const double up = (i % 2 ? 1.0 : -1.0) * random.uniform(0.5, 1.0);
        const Vec3 next = far + thick_m * up * Vec3::UnitZ();
        if (i > 0) soup.add(middle, last, next);
        last = next;
        break;
      }
      case kTipIn:
        add_needle(far, near, thick_m * random.uniform(0.5, 1.0), random, soup);
        break;
      case kTipOut:
        add_needle(near, far, thick_m * random.uniform(0.5, 1.0), random, soup);
        break;
    }
  }
  return {in_float(soup), some_radius_m(proxy, 1e-5, 1e-2, random), {}, {middle}};
}

Soup ball(int rings, double radius_m) {
  Soup soup;
  const int sides = 2 * rings;
  const auto at = [&](int ring, int k) {
    const double tilt_rad = std::numbers::pi * ring / rings;
    const double turn_rad = kTurn_rad * (k % sides) / sides;
    if (ring == 0) return Vec3(0.0, 0.0, radius_m);
    if (ring == rings) return Vec3(0.0, 0.0, -radius_m);
    return Vec3(radius_m * std::sin(tilt_rad) * std::cos(turn_rad),
                radius_m * std::sin(tilt_rad) * std::sin(turn_rad), radius_m * std::cos(tilt_rad));
  };
  for (int ring = 0; ring < rings; ++ring) {
    for (int k = 0; k < sides; ++k) {
      if (ring > 0) soup.add(at(ring, k), at(ring + 1, k), at(ring, k + 1));
      if (ring + 1 < rings) soup.add(at(ring, k + 1), at(ring + 1, k), at(ring + 1, k + 1));
    }
  }
  return soup;
}

// Meshes of 1 mm to 1 m in size, next to each other and intersecting.
RestScene mixed_scales(ProxyKind proxy, Random& random) {
  Soup soup;
  double place_m = 1.0;
  for (int i = between(random, 3, 8); i > 0; --i) {
    const double scale = log_uniform(random, 1e-3, 1.0);
    place_m = std::min(place_m, scale);
    Soup part;
    switch (random.index(3)) {
      case 0:
        part = box_soup(Vec3::Constant(0.4) + random.in_box(0.3));
        break;
      case 1:
        part = ball(between(random, 3, 20), 0.5);
        break;
      default: {
        const int cells = between(random, 2, 16);
        part = height_field(cells, cells, 1.0, random,
                            [&](int, int) { return random.uniform(-0.2, 0.2); });
        break;
      }
    }
    append(part, random.pose(log_uniform(random, 0.5, 2.0) * scale), scale, soup);
  }
  return {in_float(soup), some_radius_m(proxy, 0.3 * place_m, 0.1, random)};
}

RestScene tiny_soups(ProxyKind proxy, Random& random) {
  Soup soup;
  const double edge_m = log_uniform(random, 5e-4, 1e-2);
  const bool is_flat = random.index(2);
  for (int i = between(random, 100, 800); i > 0; --i) {
    Vec3 middle = random.in_box(0.05);
    if (is_flat) middle.z() *= 0.1;
    soup.add(middle + random.in_box(edge_m), middle + random.in_box(edge_m),
             middle + random.in_box(edge_m));
  }
  return {in_float(soup), some_radius_m(proxy, 0.3 * edge_m, 10 * edge_m, random)};
}

// Tubes and funnels that a sphere cannot enter, and sockets that hold it.
RestScene narrow_tubes(ProxyKind proxy, Random& random) {
  Soup soup;
  const int sides = between(random, 3, 24);
  const int rings = between(random, 1, 6);
  const double mouth_m = random.uniform(0.005, 0.03);
  const double taper = random.index(2) ? 1.0 : random.uniform(0.05, 1.5);
  const double wobble = random.index(2) ? 0.0 : 0.1;
  std::vector<std::vector<Vec3>> nodes;
  for (int ring = 0; ring <= rings; ++ring) {
    const double along = static_cast<double>(ring) / rings;
    nodes.emplace_back();
    for (int k = 0; k < sides; ++k) {
      const double turn_rad = kTurn_rad * k / sides;
      const double r =
          mouth_m * (1.0 + along * (taper - 1.0)) * (1.0 + wobble * random.uniform(-1.0, 1.0));
      nodes.back().emplace_back(r * std::cos(turn_rad), r * std::sin(turn_rad), -0.1 * along);
    }
  }
  const auto at = [&](int ring, int k) {
    return nodes[static_cast<std::size_t>(ring)][static_cast<std::size_t>(k % sides)];
  };
  for (int ring = 0; ring < rings; ++ring) {
    for (int k = 0; k < sides; ++k) {
      soup.add_quad(at(ring, k), at(ring + 1, k), at(ring + 1, k + 1), at(ring, k + 1));
    }
  }
  if (random.index(2)) {  // a flange around the mouth
    for (int k = 0; k < sides; ++k) {
      soup.add_quad(at(0, k), at(0, k + 1), 3.0 * at(0, k + 1), 3.0 * at(0, k));
    }
  }
  RestScene scene{in_float(soup), some_radius_m(proxy, 0.3 * mouth_m, 3.0 * mouth_m, random)};
  scene.starts = {{0.0, 0.0, 2.0 * scene.radius_m + 0.001}};
  scene.aims = {{0.0, 0.0, -0.01}, {0.0, 0.0, -0.05}, {0.0, 0.0, -0.1}};
  return scene;
}

// Spheres with radii of low_edges to high_edges edge lengths, on a ball.
template <int low_edges, int high_edges>
RestScene spheres_on_balls(ProxyKind, Random& random) {
  const int rings = between(random, 6, 24);
  const double radius_m = random.uniform(0.02, 0.05);
  const double edge_m = std::numbers::pi / rings * radius_m;
  return {in_float(ball(rings, radius_m)), log_uniform(random, low_edges, high_edges) * edge_m};
}

// Spheres on a field of hills or noise, or in a dish of similar curvature.
template <int low_edges, int high_edges>
RestScene large_spheres(ProxyKind, Random& random) {
  const double edges = log_uniform(random, low_edges, high_edges);
  const int cells = between(random, 8, 40);
  const double edge_m = 0.1 / cells;
  const double radius_m = edges * edge_m;
  const double rough_m = random.index(3) == 0 ? 0.0 : log_uniform(random, 1e-5, 1.0) * edge_m;
  // The curvature of a dish: from much flatter than the sphere to as deep as the field is wide.
  const double fit = random.index(3) == 0 ? 0.0 : random.uniform(-0.5, 1.2);
  const double bend = std::clamp(fit * 0.5 / radius_m, -20.0, 20.0);
  Soup soup = height_field(cells, cells, 0.1, random, [&](int i, int j) {
    const double x = 0.1 * (static_cast<double>(i) / cells - 0.5);
    const double y = 0.1 * (static_cast<double>(j) / cells - 0.5);
    return bend * (x * x + y * y) + rough_m * random.uniform(-1.0, 1.0);
  });
  return {in_float(soup), radius_m};
}

// The same scenes with edges so short that judging would take long.
RestScene fine_balls(ProxyKind, Random& random) {
  const int rings = static_cast<int>(log_uniform(random, 24, 120));
  const double edge_m = std::numbers::pi / rings * 0.05;
  return {in_float(ball(rings, 0.05)), log_uniform(random, 1.0, 100.0) * edge_m};
}

RestScene fine_fields(ProxyKind, Random& random) {
  const int cells = static_cast<int>(log_uniform(random, 40, 160));
  const double edge_m = 0.1 / cells;
  const double hill_m = log_uniform(random, 1e-3, 0.05);
  const double waves = random.uniform(2.0, 20.0);
  const double rough_m = log_uniform(random, 0.1, 1.0) * edge_m;
  Soup soup = height_field(cells, cells, 0.1, random, [&](int i, int j) {
    const double wave = std::cos(waves * i / cells) * std::cos(waves * j / cells);
    return hill_m * wave + rough_m * random.uniform(-1.0, 1.0);
  });
  return {in_float(soup), log_uniform(random, 10.0, 100.0) * edge_m};
}

RestScene spokes(ProxyKind proxy, Random& random) {
  const int count = static_cast<int>(log_uniform(random, 8, 600));
  const double rough = random.index(2) ? log_uniform(random, 1e-6, 0.5) : 0.0;
  const double lift = random.uniform(-1.0, 1.0);
  const int waves = between(random, 0, 6);
  std::vector<Vec3> rim;
  for (int k = 0; k < count; ++k) {
    const double turn_rad = kTurn_rad * (k + random.uniform(0.0, 0.5)) / count;
    const double z = lift * std::cos(waves * turn_rad) + rough * random.uniform(-1.0, 1.0);
    rim.push_back(0.08 * Vec3(std::cos(turn_rad), std::sin(turn_rad), z));
  }
  Soup soup;
  const std::size_t last = random.index(3) ? rim.size() : rim.size() - 1;  // some are open
  for (std::size_t k = 0; k < last; ++k) soup.add(Vec3::Zero(), rim[k], rim[(k + 1) % rim.size()]);
  return {in_float(posed(soup, random)), some_radius_m(proxy, 1e-5, 1e-2, random)};
}

RestScene crossing_sheets(ProxyKind proxy, Random& random) {
  Soup soup;
  const double narrow_rad = log_uniform(random, 1e-3, 1.5);
  for (int i = between(random, 2, 6); i > 0; --i) {
    const double u = random.uniform(0.02, 0.09);
    const double v = random.uniform(0.02, 0.09);
    Soup sheet;
    sheet.add_quad({-u, -v, 0.0}, {u, -v, 0.0}, {u, v, 0.0}, {-u, v, 0.0});
    RigidTransform pose = random.pose(0.02);
    if (random.index(2)) {
      const double turn_rad = narrow_rad * random.uniform(-1.0, 1.0);
      pose.rotation = Quat(Eigen::AngleAxisd(turn_rad, random.unit_vector()));
    }
    append(sheet, pose, 1.0, soup);
  }
  return {in_float(posed(soup, random)), some_radius_m(proxy, 1e-5, 1e-2, random)};
}

RestScene thin_slabs(ProxyKind proxy, Random& random) {
  Soup soup;
  for (int i = between(random, 1, 5); i > 0; --i) {
    const Vec3 half(random.uniform(0.02, 0.1), random.uniform(0.02, 0.1),
                    log_uniform(random, 1e-7, 1e-3));
    RigidTransform pose = random.pose(0.03);
    if (random.index(2)) pose.rotation = Quat::Identity();
    append(box_soup(half), pose, 1.0, soup);
  }
  return {posed(soup, random), some_radius_m(proxy, 1e-6, 1e-2, random)};
}

// Steps and boxes with all vertices on one grid: many distances are equal and many edges exactly
// aligned.
RestScene float_lattices(ProxyKind proxy, Random& random) {
  constexpr double kGrid_m = 1.0 / 128;
  Soup soup;
  const int cells = between(random, 2, 8);
  if (random.index(2)) {
    soup = height_field(cells, cells, cells * kGrid_m, random,
                        [&](int, int) { return kGrid_m * between(random, -2, 2); });
  } else {
    for (int i = between(random, 2, 8); i > 0; --i) {
      const auto corner = [&]() -> Vec3 {
        return kGrid_m *
               Vec3(between(random, -4, 4), between(random, -4, 4), between(random, -4, 4));
      };
      if (random.index(2)) {
        const Vec3 half =
            kGrid_m * Vec3(between(random, 1, 3), between(random, 1, 3), between(random, 1, 3));
        append(box_soup(half), {Quat::Identity(), corner()}, 1.0, soup);
      } else {
        soup.add(corner(), corner(), corner());
      }
    }
    soup.add_quad(kGrid_m * Vec3(-8, -8, -1), kGrid_m * Vec3(8, -8, -1), kGrid_m * Vec3(8, 8, -1),
                  kGrid_m * Vec3(-8, 8, -1));
  }
  constexpr double kRadii_m[] = {kFewStandOffs_m, 0x1p-24 * kGrid_m, kGrid_m / 8,
                                 kGrid_m / 2,     kGrid_m,           2 * kGrid_m};
  const double radius_m =
      proxy == ProxyKind::kPoint ? 0.0 : kRadii_m[random.index(std::size(kRadii_m))];
  return {std::move(soup), radius_m, {}, {}, kGrid_m};
}

// Triangles in all orientations that meet at one vertex and intersect.
RestScene hubs(ProxyKind proxy, Random& random) {
  Soup soup;
  for (int i = between(random, 20, 370); i > 0; --i) {
    const Vec3 out = random.unit_vector();
    const Vec3 beside = (out + log_uniform(random, 0.02, 1.0) * random.unit_vector()).normalized();
    soup.add(Vec3::Zero(), 0.08 * random.uniform(0.2, 1.0) * out,
             0.08 * random.uniform(0.2, 1.0) * beside);
  }
  soup = in_float(posed(soup, random));
  return {soup, some_radius_m(proxy, kFewStandOffs_m, 1e-2, random), {}, {soup.positions.front()}};
}

// Stacked sheets, a fraction of a stand-off to some ten stand-offs apart, parallel or nearly so.
RestScene stacked_sheets(ProxyKind proxy, Random& random) {
  constexpr double kSize_m = 0.2;
  constexpr double kStandOff_m = SolverScale::kStandOffPerSize * kSize_m;
  Soup soup;
  double z = 0.0;
  for (int i = between(random, 3, 14); i > 0; --i) {
    const double half = 0.5 * kSize_m * random.uniform(0.4, 1.0);
    const double tilt_m = random.index(2) ? 0.0 : kStandOff_m * random.uniform(-10.0, 10.0);
    soup.add_quad({-half, -half, z - tilt_m}, {half, -half, z + tilt_m}, {half, half, z + tilt_m},
                  {-half, half, z - tilt_m});
    z += log_uniform(random, 0.05, 40.0) * kStandOff_m;
  }
  return {posed(soup, random), some_radius_m(proxy, kFewStandOffs_m, 1e-2, random)};
}

// Two slabs or sheets one above the other, with a gap of about 1.75 stand-offs, at whose sides a
// point stops. The gap is constant or narrows, by stand-offs or as slabs in single precision do.
// The rims are aligned, or stand-offs apart, or one slab is wider. The hand aims at the rims of the
// gap. Two specks give the scene a size that fixes the stand-off.
RestScene slab_rims(ProxyKind, Random& random) {
  const double size_m = log_uniform(random, 1e-3, 1e3);
  const double stand_off_m = SolverScale::kStandOffPerSize * size_m;
  const double twice_stop_m = 2 * SolverScale::kStopPerStandOff * stand_off_m;
  const double off = log_uniform(random, 1e-6, 1.0) * (random.index(2) ? 0.5 : -0.5);
  const double gap_m = random.index(3) ? twice_stop_m * (1.0 + off) : twice_stop_m;
  const double narrows_m = random.index(2) ? 0.0 : stand_off_m * log_uniform(random, 1e-3, 1e4);
  const auto some_half = [&] { return size_m * random.uniform(0.05, 0.2); };
  const Vec3 half(some_half(), some_half(), 0.0);
  const bool are_aligned = random.index(3) != 0;
  const Vec3 other_half = are_aligned ? half : Vec3(some_half(), some_half(), 0.0);
  Vec3 shift = Vec3::Zero();
  if (random.index(2)) shift = 3 * stand_off_m * random.in_box(1.0);
  Soup soup;
  const auto add = [&](const Vec3& h, double inner_m, double outward, double tilt_m,
                       const Vec3& middle) {
    const double thick_m = random.index(2) ? 0.0 : size_m * log_uniform(random, 1e-7, 0.03);
    const Vec3 box_half(h.x(), h.y(), 0.5 * thick_m);
    Soup slab;
    if (thick_m > 0.0) {
      slab = box_soup(box_half);
    } else {
      slab.add_quad({-h.x(), -h.y(), 0}, {h.x(), -h.y(), 0}, {h.x(), h.y(), 0}, {-h.x(), h.y(), 0});
    }
    for (Vec3& p : slab.positions) {
      const bool is_inner = p.z() * outward <= 0.0;
      const double z = is_inner ? inner_m : inner_m + outward * thick_m;
      p = Vec3(p.x(), p.y(), z + tilt_m * (p.x() / h.x() - 1.0)) + Vec3(middle.x(), middle.y(), 0);
    }
    append(slab, {}, 1.0, soup);
  };
  add(half, 0.0, -1.0, 0.0, Vec3::Zero());
  add(other_half, gap_m, 1.0, -narrows_m, shift);
  RigidTransform pose;
  if (random.index(3)) pose.rotation = random.pose(0.0).rotation;
  if (random.index(3) == 0) {
    pose.translation_m = size_m * log_uniform(random, 0.1, 100.0) * random.unit_vector();
  }
  RestScene scene;
  append(soup, pose, 1.0, scene.soup);
  for (const double side : {-0.5, 0.5}) {
    const Vec3 corner = pose.translation_m + side * size_m * Vec3::Ones();
    const double speck_m = 1e-3 * side * size_m;
    scene.soup.add(corner, corner - speck_m * Vec3::UnitX(), corner - speck_m * Vec3::UnitY());
  }
  if (random.index(6) == 0) scene.soup = in_float(std::move(scene.soup));
  const auto at_rim = [&](double out_m) {
    Vec3 p = half.cwiseProduct(random.in_box(1.0));
    const Eigen::Index axis = random.index(2) ? 0 : 1;
    p[axis] = std::copysign(half[axis] + out_m, p[axis]);
    p.z() = 0.5 * gap_m;
    return pose.point(p);
  };
  scene.starts = {at_rim(0.1 * size_m)};
  for (int i = 0; i < 12; ++i) {
    const double out_m = log_uniform(random, 1e-12, 0.05) * size_m;
    scene.aims.push_back(at_rim(random.index(3) ? -out_m : out_m));
  }
  return scene;
}

constexpr double kAnyCapped = 0.5;  // fewer: most ticks are not capped
constexpr double kPointCapped = 0.01;
constexpr double kSphereCapped = 0.05;
constexpr auto kPoint = ProxyKind::kPoint;
constexpr auto kSphere = ProxyKind::kSphere;

constexpr RestClass kClasses[] = {
    {"Wedges", kPoint, hard<HardKind::kWedge>, kAnyCapped},
    {"Wedges", kSphere, hard<HardKind::kWedge>, kAnyCapped},
    {"Needles", kPoint, hard<HardKind::kNeedle>, kAnyCapped},
    {"Needles", kSphere, hard<HardKind::kNeedle>, kAnyCapped},
    {"Saddles", kPoint, hard<HardKind::kSaddle>, kAnyCapped},
    {"Saddles", kSphere, hard<HardKind::kSaddle>, kAnyCapped},
    {"Slivers", kPoint, hard<HardKind::kSliver>, kAnyCapped},
    {"Slivers", kSphere, hard<HardKind::kSliver>, kAnyCapped},
    {"RepeatedFaces", kPoint, hard<HardKind::kRepeated>, kAnyCapped},
    {"RepeatedFaces", kSphere, hard<HardKind::kRepeated>, kAnyCapped},
    {"CoplanarOverlaps", kPoint, hard<HardKind::kCoplanarOverlap>, kAnyCapped},
    {"CoplanarOverlaps", kSphere, hard<HardKind::kCoplanarOverlap>, kAnyCapped},
    {"TJunctions", kPoint, hard<HardKind::kTJunction>, kAnyCapped},
    {"TJunctions", kSphere, hard<HardKind::kTJunction>, kAnyCapped},
    {"Gaps", kPoint, hard<HardKind::kGap>, kAnyCapped},
    {"Gaps", kSphere, hard<HardKind::kGap>, kAnyCapped},
    {"ThinSheets", kPoint, hard<HardKind::kThinSheets>, kAnyCapped},
    {"ThinSheets", kSphere, hard<HardKind::kThinSheets>, kAnyCapped},
    {"SelfIntersections", kPoint, hard<HardKind::kSelfIntersection>, kAnyCapped},
    {"SelfIntersections", kSphere, hard<HardKind::kSelfIntersection>, kAnyCapped},
    {"LooseTriangles", kPoint, hard<HardKind::kSoup>, kAnyCapped},
    {"LooseTriangles", kSphere, hard<HardKind::kSoup>, kAnyCapped},
    {"PlateRims", kPoint, plate_rims, kAnyCapped},
    {"PlateRims", kSphere, plate_rims, kAnyCapped},
    {"Terrains", kPoint, terrains, kAnyCapped},
    {"Terrains", kSphere, terrains, kAnyCapped},
    {"Spirals", kPoint, spirals, kAnyCapped},
    {"Spirals", kSphere, spirals, kAnyCapped},
    {"ConvexRooms", kPoint, convex_rooms, kAnyCapped},
    {"ConvexRooms", kSphere, convex_rooms, kAnyCapped},
    {"NeedleFans", kPoint, needle_fans, kPointCapped},
    {"NeedleFans", kSphere, needle_fans, kSphereCapped},
    {"MixedScales", kPoint, mixed_scales, kPointCapped},
    {"MixedScales", kSphere, mixed_scales, kSphereCapped},
    {"TinySoups", kPoint, tiny_soups, kPointCapped},
    {"TinySoups", kSphere, tiny_soups, kSphereCapped},
    {"NarrowTubes", kSphere, narrow_tubes, kSphereCapped},
    {"LargeSpheres", kSphere, large_spheres<1, 100>, kSphereCapped},
    {"LargeOnBalls", kSphere, spheres_on_balls<1, 100>, kSphereCapped},
    {"HugeSpheres", kSphere, large_spheres<100, 10000>, kAnyCapped},
    {"HugeOnBalls", kSphere, spheres_on_balls<100, 10000>, kAnyCapped},
    {"Spokes", kPoint, spokes, kAnyCapped},
    {"Spokes", kSphere, spokes, kAnyCapped},
    {"CrossingSheets", kPoint, crossing_sheets, kAnyCapped},
    {"CrossingSheets", kSphere, crossing_sheets, kAnyCapped},
    {"ThinSlabs", kPoint, thin_slabs, kAnyCapped},
    {"ThinSlabs", kSphere, thin_slabs, kAnyCapped},
    {"FloatLattices", kPoint, float_lattices, kAnyCapped},
    {"FloatLattices", kSphere, float_lattices, kAnyCapped},
    {"Hubs", kPoint, hubs, kAnyCapped},
    {"Hubs", kSphere, hubs, kAnyCapped},
    {"SlabRims", kPoint, slab_rims, kAnyCapped},
    {"StackedSheets", kPoint, stacked_sheets, kAnyCapped},
    {"StackedSheets", kSphere, stacked_sheets, kAnyCapped},
};

constexpr RestClass kFineClasses[] = {{"FineBalls", kSphere, fine_balls, kSphereCapped},
                                      {"FineFields", kSphere, fine_fields, kSphereCapped}};

// The faces of the points' hull, oriented inwards; none if four points lie in one plane.
std::vector<Triangle> hull_of(const std::vector<Vec3>& points) {
  std::vector<Triangle> faces;
  const auto count = static_cast<std::uint32_t>(points.size());
  for (std::uint32_t i = 0; i < count; ++i) {
    for (std::uint32_t j = i + 1; j < count; ++j) {
      for (std::uint32_t k = j + 1; k < count; ++k) {
        int side = 0;
        bool is_face = true;
        for (std::uint32_t l = 0; l < count && is_face; ++l) {
          if (l == i || l == j || l == k) continue;
          const int now = orientation(points[i], points[j], points[k], points[l]);
          if (now == 0) return {};
          is_face = side == 0 || now == side;
          side = now;
        }
        if (!is_face) continue;
        // orientation() is positive where d sees a, b, c clockwise.
        faces.push_back(side < 0 ? Triangle{i, j, k} : Triangle{i, k, j});
      }
    }
  }
  return faces;
}

// True if all walls that share an edge meet at an angle between one degree and one degree less than
// a straight angle.
bool has_clear_edges(const std::vector<Vec3>& points, const std::vector<Triangle>& faces) {
  const double most_cosine = std::cos(kTurn_rad / 360.0);
  for (const Triangle& a : faces) {
    for (const Triangle& b : faces) {
      int shared = 0;
      for (const std::uint32_t i : a) shared += static_cast<int>(std::count(b.begin(), b.end(), i));
      if (shared != 2) continue;
      const auto normal = [&](const Triangle& t) {
        return (points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]).normalized();
      };
      if (std::abs(normal(a).dot(normal(b))) > most_cosine) return false;
    }
  }
  return true;
}

}  // namespace

std::string RestClass::full_name() const {
  return std::string(name) + (proxy == ProxyKind::kPoint ? "Point" : "Sphere");
}

std::span<const RestClass> rest_classes() {
  return kClasses;
}

std::vector<RestClass> restless_classes() {
  std::vector<RestClass> all(std::begin(kClasses), std::end(kClasses));
  all.insert(all.end(), std::begin(kFineClasses), std::end(kFineClasses));
  return all;
}

std::vector<RestClass> large_sphere_classes() {
  std::vector<RestClass> large(std::begin(kFineClasses), std::end(kFineClasses));
  for (const RestClass& rest_class : kClasses) {
    const std::string name = rest_class.name;
    if (name.starts_with("Large") || name.starts_with("Huge")) large.push_back(rest_class);
  }
  return large;
}

Soup convex_room(Random& random) {
  for (;;) {
    const int count = between(random, 4, 16);
    const Vec3 squeeze(1.0, random.uniform(0.3, 1.0), random.uniform(0.3, 1.0));
    std::vector<Vec3> points;
    for (int i = 0; i < count; ++i) {
      const Vec3 p = 0.1 * random.uniform(0.6, 1.0) * random.unit_vector().cwiseProduct(squeeze);
      points.push_back(p.cast<float>().cast<double>());
    }
    const std::vector<Triangle> faces = hull_of(points);
    if (faces.size() < 4 || !has_clear_edges(points, faces)) continue;
    // The origin, with some clearance around it.
    bool is_inside = true;
    for (const Triangle& t : faces) {
      const Vec3 normal =
          (points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]).normalized();
      is_inside = is_inside && -normal.dot(points[t[0]]) > 0.008;
    }
    if (is_inside) return {points, faces};
  }
}

RestHand::RestHand(const std::vector<Corners>& triangles, std::vector<Vec3> aims, double radius_m,
                   double stand_off_m, double grid_m, const Vec3& start, Random& random)
    : triangles_(&triangles),
      aims_(std::move(aims)),
      radius_m_(radius_m),
      stand_off_m_(stand_off_m),
      grid_m_(grid_m),
      random_(&random),
      low_(start),
      high_(start),
      goal_(start),
      aim_(start),
      heading_(random.unit_vector()) {
  for (const Corners& t : triangles) {
    low_ = low_.cwiseMin(t.a).cwiseMin(t.b).cwiseMin(t.c);
    high_ = high_.cwiseMax(t.a).cwiseMax(t.b).cwiseMax(t.c);
  }
  size_m_ = (high_ - low_).maxCoeff();
}

double RestHand::log_uniform(double low, double high) {
  return test::log_uniform(*random_, low, high);
}

const Corners& RestHand::some_triangle() {
  return (*triangles_)[random_->index(triangles_->size())];
}

Vec3 RestHand::on_grid(const Vec3& p) const {
  if (grid_m_ == 0.0) return p;
  const double half_m = 0.5 * grid_m_;
  return half_m * (p / half_m).array().round().matrix();
}

Vec3 RestHand::vertex_or_edge() {
  const Corners& t = some_triangle();
  switch (random_->index(3)) {
    case 0:
      return t.a;
    case 1:
      return 0.5 * (t.b + t.c);
    default:
      return t.c + random_->uniform(0.0, 1.0) * (t.b - t.c);
  }
}

Vec3 RestHand::place_of_interest() {
  if (!aims_.empty() && random_->index(2)) return aims_[random_->index(aims_.size())];
  if (random_->index(2)) return vertex_or_edge();
  const Corners& t = some_triangle();
  const double s = random_->uniform(0.0, 1.0);
  return t.a + s * (t.b - t.a) + (1.0 - s) * random_->uniform(0.0, 1.0) * (t.c - t.a);
}

// A place beside a triangle, in its plane or within some stand-offs of it, from which a path leads
// across the triangle.
Vec3 RestHand::graze_start() {
  const Corners& t = some_triangle();
  const Vec3 normal = (t.b - t.a).cross(t.c - t.a).normalized();
  const Vec3 middle = (t.a + t.b + t.c) / 3.0;
  Vec3 out = random_->index(2) ? Vec3(0.5 * (t.a + t.b) - middle) : Vec3(t.a - middle);
  heading_ = -out.normalized();
  constexpr double kHeights[] = {0.0, 0.5, 1.0, 1.5, 3.0, 100.0, 1e4};
  const double height_m =
      (random_->index(2) ? 1.0 : -1.0) * stand_off_m_ * kHeights[random_->index(7)];
  const double above_m = random_->index(3) ? 0.0 : (random_->index(2) ? radius_m_ : -radius_m_);
  aim_ = middle + (height_m + above_m) * normal;
  const double away_m = out.norm() + 2.0 * radius_m_ + log_uniform(1e-4, 0.3) * size_m_;
  return aim_ - away_m * heading_;
}

void RestHand::choose(const ProxyState& state) {
  constexpr Habit kRestless[] = {Habit::kPlunge, Habit::kSlide, Habit::kWander, Habit::kTour};
  habit_ = is_restless_
               ? kRestless[random_->index(std::size(kRestless))]
               : static_cast<Habit>(random_->index(static_cast<std::uint64_t>(Habit::kCount)));
  ticks_left_ = habit_ == Habit::kTour ? between(*random_, 40, 100) : between(*random_, 3, 25);
  pace_m_ = log_uniform(1e-5, 0.2) * size_m_;
  depth_m_ = log_uniform(1e-6, 0.3) * size_m_;
  stage_ = 0;
  heading_ = (place_of_interest() - state.proxy).normalized();
  if (!heading_.allFinite() || random_->index(6) == 0) heading_ = random_->unit_vector();
}

Vec3 RestHand::make_goal(const ProxyState& state) {
  switch (habit_) {
    case Habit::kPlunge: {  // straight through the target
      const Vec3 aim = place_of_interest();
      return aim + random_->uniform(0.0, 1.0) * (aim - state.proxy);
    }
    case Habit::kSlide: {
      if (!state.in_contact) return state.proxy + pace_m_ * heading_;
      const Vec3 along = heading_ - heading_.dot(state.normal) * state.normal;
      return state.proxy + pace_m_ * along - depth_m_ * state.normal;
    }
    case Habit::kGraze:
      switch (stage_++ % 4) {
        case 0:
          return graze_start();
        case 1:
          return goal_ + random_->uniform(0.5, 1.0) * (aim_ - goal_);
        case 2:
          return aim_;
        default:
          return aim_ + log_uniform(1e-3, 1.0) * size_m_ * heading_;
      }
    case Habit::kAim:
      return vertex_or_edge();
    case Habit::kPress: {  // at the proxy, then deeper
      const Vec3 n = state.in_contact ? state.normal : random_->unit_vector();
      const Vec3 beside = random_->index(2) ? Vec3(Vec3::Zero()) : random_->in_box(0.1 * depth_m_);
      return state.proxy + beside - depth_m_ * n;
    }
    case Habit::kJump: {
      const Vec3 middle = 0.5 * (low_ + high_);
      const double far = random_->index(8) ? 0.7 : 3.0;
      return middle + far * (high_ - low_).cwiseProduct(random_->in_box(1.0)) +
             random_->in_box(radius_m_);
    }
    case Habit::kTour: {
      const Vec3 left = aim_ - goal_;
      const double pace_m = 0.1 * pace_m_;
      if (left.norm() > pace_m) return goal_ + pace_m * left.normalized();
      aim_ = place_of_interest();
      if (random_->index(2)) {  // deep inside, if the surface is closed
        aim_ += random_->uniform(0.0, 0.5) * (0.5 * (low_ + high_) - aim_);
      } else {
        aim_ += random_->uniform(-1.0, 1.0) * depth_m_ * random_->unit_vector();
      }
      return goal_;
    }
    default:
      return goal_ + pace_m_ * random_->unit_vector();
  }
}

Vec3 RestHand::next_goal(const ProxyState& state) {
  if (rest_left_ > 0) {
    --rest_left_;
    return goal_;
  }
  if (ticks_left_-- <= 0) choose(state);
  goal_ = on_grid(make_goal(state));
  // Return from empty space.
  const double reach_m = 2.0 * size_m_ + 2.0 * radius_m_;
  if (((goal_ - high_).array() > reach_m).any() || ((low_ - goal_).array() > reach_m).any()) {
    goal_ = on_grid(place_of_interest());
  }
  const std::uint64_t rarely = habit_ == Habit::kTour ? 40 : 4;
  if (!is_restless_ && random_->index(rarely) == 0) rest_left_ = between(*random_, 1, 8);
  return goal_;
}

}  // namespace palpate::test
