#include "benchmarks/side_test_inputs.h"

#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <optional>
#include <random>
#include <utility>

namespace palpate::bench {
namespace {

using boost::multiprecision::cpp_int;
using boost::multiprecision::cpp_rational;

constexpr double kFromOrigin_m = 0.1;
constexpr double kEdge_m = 3e-4;
constexpr double kTracedStep_m = 1e-3;

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  Vec3 in_box(double half_extent) {
    const double x = uniform(-half_extent, half_extent);
    const double y = uniform(-half_extent, half_extent);
    return {x, y, uniform(-half_extent, half_extent)};
  }
  std::int64_t integer(int bits) { return static_cast<std::int64_t>(engine_() >> (64 - bits)); }
  bool coin() { return (engine_() & 1u) != 0; }

 private:
  std::mt19937_64 engine_;
};

struct Edge {
  Vec3 from, to;
};

Vec3 rounded_to_float(const Vec3& p) {
  return p.cast<float>().cast<double>();
}

// An edge as in a mesh from a file: its corners are floats.
Edge random_edge(Random& random) {
  const Vec3 from = rounded_to_float(random.in_box(kFromOrigin_m));
  return {from, rounded_to_float(from + random.in_box(kEdge_m))};
}

// An edge whose midpoint has x = 0. Differences of coordinates there are rounded; elsewhere they
// are exact, because the last bits of nearby coordinates have the same weight.
Edge random_edge_across_plane(Random& random) {
  Edge edge = random_edge(random);
  edge.from.x() = rounded_to_float(random.in_box(kEdge_m)).x();
  edge.to.x() = -edge.from.x();
  return edge;
}

// The step from p to the rounded p + d; nullopt if that step itself needs rounding.
std::optional<SideInput> through(const Vec3& p, const Vec3& d, const Edge& edge) {
  const Vec3 q = p + d;
  const Vec3 step = q - p;
  if (p + step != q || q - step != p || step == Vec3::Zero()) return std::nullopt;
  return SideInput{p, step, edge.from, edge.to};
}

template <typename Make>
std::vector<SideInput> make_inputs(std::size_t count, std::uint64_t seed, Make make) {
  Random random(seed);
  std::vector<SideInput> inputs;
  while (inputs.size() < count) {
    if (const std::optional<SideInput> input = make(random)) inputs.push_back(*input);
  }
  return inputs;
}

using Integers = std::array<cpp_int, 3>;

cpp_int dot(const Integers& a, const Integers& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Integers cross(const Integers& a, const Integers& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// The coefficients of gcd(a, b) = x a + y b.
struct Bezout {
  cpp_int gcd, x, y;
};

Bezout bezout(const cpp_int& a, const cpp_int& b) {
  Bezout last{a, 1, 0};
  Bezout next{b, 0, 1};
  while (next.gcd != 0) {
    const cpp_int quotient = last.gcd / next.gcd;
    const Bezout after{last.gcd - quotient * next.gcd, last.x - quotient * next.x,
                       last.y - quotient * next.y};
    last = std::exchange(next, after);
  }
  return last;
}

// w minus multiples of u and v, chosen so that the result is short, for n = u x v. Leaves the
// component along n as it is.
Integers shortened(const Integers& w, const Integers& u, const Integers& v, const Integers& n) {
  const cpp_int along_u = dot(cross(w, v), n) / dot(n, n);
  const cpp_int along_v = dot(cross(u, w), n) / dot(n, n);
  Integers shorter;
  for (int k = 0; k < 3; ++k) shorter[k] = w[k] - along_u * u[k] - along_v * v[k];
  return shorter;
}

// An integer vector w, no longer than u and v together, with w . (u x v) = +-1. nullopt if the
// components of u x v have a common divisor.
std::optional<Integers> least_volume(const Integers& u, const Integers& v) {
  const Integers n = cross(u, v);
  const Bezout xy = bezout(n[0], n[1]);
  const Bezout xyz = bezout(xy.gcd, n[2]);
  if (abs(xyz.gcd) != 1) return std::nullopt;
  return shortened({xyz.x * xy.x, xyz.x * xy.y, xyz.y}, u, v, n);
}

Vec3 to_metres(const Integers& v) {
  constexpr double kUnit_m = 0x1p-56;  // 50-bit numbers become centimetres
  return kUnit_m *
         Vec3(v[0].convert_to<double>(), v[1].convert_to<double>(), v[2].convert_to<double>());
}

Integers random_integers(Random& random) {
  constexpr int kBits = 50;
  return {random.integer(kBits), random.integer(kBits), random.integer(kBits)};
}

}  // namespace

std::vector<SideInput> easy_side_inputs(std::size_t count) {
  return make_inputs(count, 1, [](Random& random) {
    const Edge edge = random_edge(random);
    return through(edge.from + random.in_box(kTracedStep_m), random.in_box(kTracedStep_m), edge);
  });
}

std::vector<SideInput> near_side_inputs(std::size_t count) {
  return make_inputs(count, 2, [](Random& random) -> std::optional<SideInput> {
    const Edge edge = random.coin() ? random_edge(random) : random_edge_across_plane(random);
    const Vec3 target = edge.from + random.uniform(0.0, 1.0) * (edge.to - edge.from);
    const Vec3 p = target + random.in_box(kTracedStep_m);
    const auto input = through(p, random.uniform(1.0, 2.0) * (target - p), edge);
    if (!input || filter_decides(*input) || true_side(*input) == 0) return std::nullopt;
    return input;
  });
}

std::vector<SideInput> exact_side_inputs(std::size_t count) {
  return make_inputs(count, 3, [](Random& random) -> std::optional<SideInput> {
    const bool across = random.coin();
    const Edge edge = across ? random_edge_across_plane(random) : random_edge(random);
    const double eighths = across ? 0.5 : std::ldexp(static_cast<double>(random.integer(3)), -3);
    const Vec3 target = edge.from + eighths * (edge.to - edge.from);
    Vec3 half = random.in_box(0.5 * kTracedStep_m);
    if (across) half.x() *= kTracedStep_m;  // small: from - p must then round
    // Half of the step lies before the target and half behind it.
    const auto behind = through(target, half, edge);
    if (!behind || target - behind->d + behind->d != target) return std::nullopt;
    const auto input = through(target - behind->d, 2.0 * behind->d, edge);
    if (!input || true_side(*input) != 0) return std::nullopt;
    return input;
  });
}

std::vector<SideInput> hidden_side_inputs(std::size_t count) {
  return make_inputs(count, 4, [](Random& random) -> std::optional<SideInput> {
    const Integers u = random_integers(random);
    const Integers v = random_integers(random);
    const std::optional<Integers> w = least_volume(u, v);
    if (!w) return std::nullopt;
    const Vec3 p = to_metres(random_integers(random));
    const Edge edge{p + to_metres(v), p + to_metres(*w)};
    const auto input = through(p, to_metres(u), random.coin() ? edge : Edge{edge.to, edge.from});
    if (!input || true_side(*input) == 0) return std::nullopt;
    return input;
  });
}

int true_side(const SideInput& in) {
  std::array<cpp_rational, 3> u, v, w;
  for (int k = 0; k < 3; ++k) {
    u[k] = cpp_rational(in.d[k]);
    v[k] = cpp_rational(in.from[k]) - cpp_rational(in.p[k]);
    w[k] = cpp_rational(in.to[k]) - cpp_rational(in.p[k]);
  }
  const cpp_rational volume = u[0] * (v[1] * w[2] - v[2] * w[1]) +
                              u[1] * (v[2] * w[0] - v[0] * w[2]) +
                              u[2] * (v[0] * w[1] - v[1] * w[0]);
  return volume.sign();
}

}  // namespace palpate::bench
