// The loops over the lanes of a pack, in vectors of kWidth lanes. pack_kernels.cpp includes this
// file once for each instruction set, inside a namespace that defines Lanes, Mask and greater(),
// which returns one bit per lane. No operation is fused or reordered, so that all instruction sets
// give identical results.
//
// Error bounds, with u = 2^-24: a local coordinate has an error of at most u |q| + centre_roundoff
// for the query point q, and u for a corner or a component of a normal. All magnitudes are 1-norms,
// which are at least the Euclidean norms.

namespace {

constexpr int kWidth = sizeof(Lanes) / sizeof(float);
constexpr int kParts = TrianglePack::kLanes / kWidth;
constexpr std::uint32_t kAll = (1u << kWidth) - 1u;
constexpr std::uint32_t kEveryLane = (1u << TrianglePack::kLanes) - 1u;
constexpr float kUnit = 0x1p-24f;

// A height n . q - h: three products and sums of inputs with an error of u each give 7 u (|q| + 2).
constexpr float kHeightError = 16 * kUnit;
// A triple product d . (v x w) with an error of 2 u (1 + |q|) in each of v and w: 12 u for the
// arithmetic, 4 u for v and for w.
constexpr float kVolumeError = 32 * kUnit;
// A distance from the point q to a triangle whose corners have an error of u: 4 u (1 + |q|) for the
// inputs, 16 u for the arithmetic, and 16 u for a wrong decision beside an edge that q is above the
// face.
constexpr float kDistanceError = 64 * kUnit;
// Bound on the underflow of products of coordinates; part of every bound on a product.
constexpr float kUnderflow = 0x1p-100f;

inline Lanes fill(float x) {
  return x - Lanes{};
}
inline Lanes load(const float* lanes) {
  return *reinterpret_cast<const Lanes*>(lanes);
}
inline Lanes least(const Lanes& x, const Lanes& y) {
  return x < y ? x : y;
}
inline Lanes most(const Lanes& x, const Lanes& y) {
  return x > y ? x : y;
}
inline Lanes magnitude(const Lanes& x) {
  return most(x, -x);
}
inline float magnitude(float x) {
  return __builtin_fabsf(x);
}

struct Local {
  float x, y, z;
  float norm1() const { return magnitude(x) + magnitude(y) + magnitude(z); }
};

struct LaneVector {
  Lanes x, y, z;
  Lanes norm1() const { return magnitude(x) + magnitude(y) + magnitude(z); }
};

using Corners = float[3][TrianglePack::kLanes];

// Three coordinates and a zero.
using Doubles [[gnu::vector_size(32)]] = double;
using Floats [[gnu::vector_size(16), gnu::may_alias]] = float;

inline Doubles load3(const double* p) {
  return Doubles{p[0], p[1], p[2], 0.0};
}

inline Local scaled(const TrianglePack& pack, const Doubles& d) {
  const Floats local = __builtin_convertvector(d * pack.per_metre, Floats);
  return {local[0], local[1], local[2]};
}

inline Local to_local(const TrianglePack& pack, const Doubles& p) {
  return scaled(pack, p - load3(pack.centre_m));
}

// A length in local units, rounded up.
inline float local_length(const TrianglePack& pack, double length) {
  return static_cast<float>(length * pack.per_metre) * (1 + 2 * kUnit);
}

inline LaneVector from_point(const Corners& corners, int lane, const Local& q) {
  return {load(corners[0] + lane) - q.x, load(corners[1] + lane) - q.y,
          load(corners[2] + lane) - q.z};
}

inline Lanes dot(const LaneVector& v, const LaneVector& w) {
  return v.x * w.x + v.y * w.y + v.z * w.z;
}
inline Lanes dot(const LaneVector& v, const Local& d) {
  return v.x * d.x + v.y * d.y + v.z * d.z;
}

inline LaneVector cross(const LaneVector& v, const LaneVector& w) {
  return {v.y * w.z - v.z * w.y, v.z * w.x - v.x * w.z, v.x * w.y - v.y * w.x};
}
inline LaneVector cross(const Local& d, const LaneVector& w) {
  return {d.y * w.z - d.z * w.y, d.z * w.x - d.x * w.z, d.x * w.y - d.y * w.x};
}

inline LaneVector normals(const TrianglePack& pack, int lane) {
  return {load(pack.normal[0] + lane), load(pack.normal[1] + lane), load(pack.normal[2] + lane)};
}

// The lanes from `lane` on for which a point of the segment q to q + d is within margin of the
// triangle's plane. Comparisons with NaN, where coordinates overflow, are false, so that such a
// lane is kept.
inline std::uint32_t near_planes(const TrianglePack& pack, int lane, const Local& q, const Local& d,
                                 float margin) {
  const LaneVector normal = normals(pack, lane);
  const Lanes start = dot(normal, q) - load(pack.height + lane);
  const Lanes end = start + dot(normal, d);
  const Lanes apart = fill(margin);
  const std::uint32_t above = greater(least(start, end), apart);
  const std::uint32_t below = greater(-apart, most(start, end));
  return ~(above | below) & kAll;
}

// The lanes whose triangle may be within clearance of the line through q along d: the line does not
// certainly pass two edges on opposite sides.
inline std::uint32_t near_line(const TrianglePack& pack, int lane, const Local& q, const Local& d,
                               float clearance) {
  const LaneVector a = from_point(pack.a, lane, q);
  const LaneVector b = from_point(pack.b, lane, q);
  const LaneVector c = from_point(pack.c, lane, q);
  const float reach = 3 + q.norm1();
  const float error = d.norm1() * (kVolumeError * reach + 2 * pack.centre_roundoff + clearance);
  const Lanes size_a = a.norm1();
  const Lanes size_b = b.norm1();
  const Lanes size_c = c.norm1();
  std::uint32_t left = 0;
  std::uint32_t right = 0;
  const auto side = [&](const LaneVector& from, const LaneVector& to, const Lanes& size) {
    const Lanes volume = dot(cross(d, from), to);
    const Lanes bound = size * error + kUnderflow;
    left |= greater(volume, bound);
    right |= greater(-bound, volume);
  };
  side(a, b, size_a + size_b);
  side(b, c, size_b + size_c);
  side(c, a, size_c + size_a);
  return ~(left & right) & kAll;
}

// The vector from the nearest point of each triangle to the origin, and its squared length.
struct Nearest {
  LaneVector apart;
  Lanes squared;
};

inline LaneVector select(const Mask& mask, const LaneVector& x, const LaneVector& y) {
  return {mask ? x.x : y.x, mask ? x.y : y.y, mask ? x.z : y.z};
}

// Updates `nearest` with the edge from -> to, and clears `inside` where the origin is outside this
// edge.
inline void fold_edge(const LaneVector& normal, const LaneVector& from, const LaneVector& to,
                      const Lanes& per_squared_edge, Nearest& nearest, Mask& inside) {
  const LaneVector edge{to.x - from.x, to.y - from.y, to.z - from.z};
  const Lanes along = -dot(from, edge) * per_squared_edge;
  const Lanes t = least(most(along, Lanes{}), fill(1.0f));
  const LaneVector apart{-(from.x + t * edge.x), -(from.y + t * edge.y), -(from.z + t * edge.z)};
  const Lanes squared = dot(apart, apart);
  const Mask nearer = squared < nearest.squared;
  nearest.apart = select(nearer, apart, nearest.apart);
  nearest.squared = nearer ? squared : nearest.squared;
  inside &= dot(cross(normal, edge), from) <= Lanes{};
}

inline void fold_edge(const LaneVector& normal, const LaneVector& from, const LaneVector& to,
                      const Lanes& per_squared_edge, Lanes& squared, Mask& inside) {
  const LaneVector edge{to.x - from.x, to.y - from.y, to.z - from.z};
  const Lanes along = -dot(from, edge) * per_squared_edge;
  const Lanes t = least(most(along, Lanes{}), fill(1.0f));
  const LaneVector apart{from.x + t * edge.x, from.y + t * edge.y, from.z + t * edge.z};
  squared = least(squared, dot(apart, apart));
  inside &= dot(cross(normal, edge), from) <= Lanes{};
}

// The vectors from the triangles from `lane` on to the point q.
inline Nearest nearest_points(const TrianglePack& pack, int lane, const Local& q) {
  const LaneVector normal = normals(pack, lane);
  const LaneVector a = from_point(pack.a, lane, q);
  const LaneVector b = from_point(pack.b, lane, q);
  const LaneVector c = from_point(pack.c, lane, q);
  Nearest nearest{{}, fill(__builtin_inff())};
  Mask inside = ~Mask{};
  fold_edge(normal, a, b, load(pack.per_squared_edge[0] + lane), nearest, inside);
  fold_edge(normal, b, c, load(pack.per_squared_edge[1] + lane), nearest, inside);
  fold_edge(normal, c, a, load(pack.per_squared_edge[2] + lane), nearest, inside);
  const Lanes height = -dot(normal, a);
  nearest.apart =
      select(inside, {height * normal.x, height * normal.y, height * normal.z}, nearest.apart);
  nearest.squared = inside ? height * height : nearest.squared;
  return nearest;
}

// Squared distances from the point q to the triangles from `lane` on: like nearest_points(),
// without the nearest points.
inline Lanes squared_distances(const TrianglePack& pack, int lane, const Local& q) {
  const LaneVector normal = normals(pack, lane);
  const LaneVector a = from_point(pack.a, lane, q);
  const LaneVector b = from_point(pack.b, lane, q);
  const LaneVector c = from_point(pack.c, lane, q);
  Lanes squared = fill(__builtin_inff());
  Mask inside = ~Mask{};
  fold_edge(normal, a, b, load(pack.per_squared_edge[0] + lane), squared, inside);
  fold_edge(normal, b, c, load(pack.per_squared_edge[1] + lane), squared, inside);
  fold_edge(normal, c, a, load(pack.per_squared_edge[2] + lane), squared, inside);
  const Lanes height = dot(normal, a);
  return inside ? height * height : squared;
}

// Bound on the error of a distance whose square may have underflowed.
inline float distance_error(const TrianglePack& pack, const Local& q) {
  return kDistanceError * (2 + q.norm1()) + 4 * pack.centre_roundoff;
}

// The limit for the square of a distance of at most `distance`, including the error bound.
inline float squared_limit(float distance, float error) {
  const float limit = distance + error;
  return limit * limit * (1 + 8 * kUnit);
}

// In two passes. The first pass has no branch, because the packs near a step are hard to predict.
std::size_t in_the_way(const TrianglePack* packs, const std::uint32_t* ids, std::size_t count,
                       const double* p, const double* d, double clearance, PackLanes* out) {
  const Doubles start = load3(p);
  const Doubles move = load3(d);
  for (std::size_t i = 0; i < count; ++i) {
    const TrianglePack& pack = packs[ids[i]];
    const Local q = to_local(pack, start);
    const Local step = scaled(pack, move);
    const float error =
        kHeightError * (q.norm1() + step.norm1() + 2) + 4 * pack.centre_roundoff + kUnderflow;
    const float local_clearance = local_length(pack, clearance);
    const float margin = error + local_clearance;
    std::uint32_t lanes = 0;
    for (int part = 0; part < kParts; ++part) {
      lanes |= near_planes(pack, part * kWidth, q, step, margin) << (part * kWidth);
    }
    out[i] = {ids[i], lanes & pack.lanes()};
  }
  std::size_t found = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (out[i].lanes == 0) continue;
    const TrianglePack& pack = packs[out[i].pack];
    const Local q = to_local(pack, start);
    const Local step = scaled(pack, move);
    const float local_clearance = local_length(pack, clearance);
    std::uint32_t crossed = 0;
    for (int part = 0; part < kParts; ++part) {
      crossed |= near_line(pack, part * kWidth, q, step, local_clearance) << (part * kWidth);
    }
    const PackLanes doubtful{out[i].pack, out[i].lanes & crossed};
    out[found] = doubtful;
    found += doubtful.lanes != 0;
  }
  return found;
}

// Bound on the angular error of the direction to the nearest point of a triangle beyond `reach`,
// for a distance error of `error`: the computed point is within `error` of the triangle, and its
// distance exceeds the smallest distance by at most `error`.
inline float direction_error(float reach, float error) {
  const float part = error / reach;
  return __builtin_sqrtf(part * (2 + part)) + part;
}

std::size_t in_reach(const TrianglePack* packs, const std::uint32_t* ids, std::size_t count,
                     const double* p, const double* d, double reach, PackApproach* out) {
  const Doubles start = load3(p);
  const Doubles move = load3(d);
  std::size_t found = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const TrianglePack& pack = packs[ids[i]];
    const Local q = to_local(pack, start);
    const Local step = scaled(pack, move);
    const float error =
        kHeightError * (q.norm1() + step.norm1() + 2) + 4 * pack.centre_roundoff + kUnderflow;
    const float radius = local_length(pack, reach);
    std::uint32_t lanes = 0;
    for (int part = 0; part < kParts; ++part) {
      lanes |= near_planes(pack, part * kWidth, q, step, radius + error) << (part * kWidth);
    }
    lanes &= pack.lanes();
    if (lanes == 0) continue;
    const float distance_off = distance_error(pack, q);
    const float length = step.norm1();
    const float limit = radius + distance_off + kHeightError * length;
    // Bound on the error of distance times slope, for triangles within reach of a step of this
    // length.
    const float fall_off = direction_error(radius, distance_off) * length * (limit + 2 * length);
    PackApproach& approach = out[found];
    approach.squared_limit = limit * limit * (1 + 16 * kUnit);
    const Lanes squared_limit = fill(approach.squared_limit);
    std::uint32_t apart = 0;
    for (int part = 0; part < kParts; ++part) {
      const Nearest nearest = nearest_points(pack, part * kWidth, q);
      // A lane is apart if it is out of reach at the start and d + n . step, multiplied by d, is
      // too.
      const Lanes fall = most(-dot(nearest.apart, step), Lanes{}) + fall_off;
      const Lanes end = nearest.squared - fall;
      *reinterpret_cast<Lanes*>(approach.squared + part * kWidth) = nearest.squared;
      *reinterpret_cast<Lanes*>(approach.fall + part * kWidth) = fall;
      apart |= (greater(nearest.squared, squared_limit) & greater(end, Lanes{}) &
                greater(end * end, squared_limit * nearest.squared))
               << (part * kWidth);
    }
    approach.pack = ids[i];
    approach.lanes = lanes & ~apart;
    found += approach.lanes != 0;
  }
  return found;
}

// The outward margin of a box bound: two ulp, of which the conversion to float needs half an ulp,
// plus the smallest normal float for values that underflow.
inline Floats most4(const Floats& x, const Floats& y) {
  return x > y ? x : y;
}
inline Floats least4(const Floats& x, const Floats& y) {
  return x < y ? x : y;
}
inline Floats outwards(const Floats& x) {
  return (x > -x ? x : -x) * 0x1p-22f + 0x1p-126f;
}

std::size_t boxes_along(const BoxPack* packs, std::size_t pack_count, const double* p,
                        const double* d, double reach, const FloatBox& within, std::uint32_t* out) {
  const Doubles start = load3(p);
  const Doubles move = load3(d);
  const Doubles zero{};
  const Floats from = __builtin_convertvector(start + (move < zero ? move : zero) - reach, Floats);
  const Floats to = __builtin_convertvector(start + (move > zero ? move : zero) + reach, Floats);
  const Floats low = most4(from - outwards(from), *reinterpret_cast<const Floats*>(within.low));
  const Floats high = least4(to + outwards(to), *reinterpret_cast<const Floats*>(within.high));
  std::size_t found = 0;
  for (std::size_t i = 0; i < pack_count; ++i) {
    const BoxPack& pack = packs[i];
    for (int part = 0; part < kParts; ++part) {
      const int lane = part * kWidth;
      std::uint32_t apart = 0;
      for (int k = 0; k < 3; ++k) {
        apart |= greater(load(pack.low[k] + lane), fill(high[k]));
        apart |= greater(fill(low[k]), load(pack.high[k] + lane));
      }
      const auto first =
          static_cast<std::uint32_t>(i * TrianglePack::kLanes) + static_cast<std::uint32_t>(lane);
      for (std::uint32_t boxes = ~apart & kAll; boxes != 0; boxes &= boxes - 1) {
        out[found++] = first + static_cast<std::uint32_t>(__builtin_ctz(boxes));
      }
    }
  }
  return found;
}

std::uint32_t boxes_within(const BoxPack& boxes, const float* p, float radius,
                           float* squared_distances) {
  const Lanes limit = fill(radius * radius * (1 + 16 * kUnit));
  std::uint32_t apart = 0;
  for (int lane = 0; lane < TrianglePack::kLanes; lane += kWidth) {
    Lanes squared{};
    for (int k = 0; k < 3; ++k) {
      const Lanes outside =
          most(load(boxes.low[k] + lane) - p[k], p[k] - load(boxes.high[k] + lane));
      const Lanes beyond = most(outside, Lanes{});
      squared += beyond * beyond;
    }
    *reinterpret_cast<Lanes*>(squared_distances + lane) = squared;
    apart |= greater(squared, limit) << lane;
  }
  return ~apart & kEveryLane;
}

// The fractions at a slab have an error of 3 u. A margin of 8 u on each end keeps boxes that only
// rounding separates from the segment.
std::uint32_t boxes_on_segment(const BoxPack& boxes, const float* p, const float* d, float radius) {
  std::uint32_t apart = 0;
  for (int lane = 0; lane < TrianglePack::kLanes; lane += kWidth) {
    apart |= greater(load(boxes.low[0] + lane), load(boxes.high[0] + lane)) << lane;  // empty box
    Lanes enter{};
    Lanes leave = fill(1.0f);
    for (int k = 0; k < 3; ++k) {
      const Lanes to_low = load(boxes.low[k] + lane) - (p[k] + radius);
      const Lanes to_high = load(boxes.high[k] + lane) - (p[k] - radius);
      if (d[k] == 0.0f) {
        apart |= (greater(to_low, Lanes{}) | greater(Lanes{}, to_high)) << lane;
        continue;
      }
      const Lanes at_low = to_low / d[k];
      const Lanes at_high = to_high / d[k];
      enter = most(enter, least(at_low, at_high));
      leave = least(leave, most(at_low, at_high));
    }
    apart |= greater(enter * (1 - 8 * kUnit), leave * (1 + 8 * kUnit)) << lane;
  }
  return ~apart & kEveryLane;
}

std::uint32_t within(const TrianglePack& pack, const double* p, double distance,
                     LaneDistances& distances) {
  const Local q = to_local(pack, load3(p));
  distances.error = distance_error(pack, q);
  const Lanes limit = fill(squared_limit(local_length(pack, distance), distances.error));
  std::uint32_t apart = 0;
  for (int part = 0; part < kParts; ++part) {
    const Lanes squared = squared_distances(pack, part * kWidth, q);
    *reinterpret_cast<Lanes*>(distances.squared + part * kWidth) = squared;
    apart |= greater(squared, limit) << (part * kWidth);
  }
  return ~apart & pack.lanes();
}

}  // namespace

constexpr PackKernels kKernels{in_the_way,   in_reach,         boxes_along,
                               boxes_within, boxes_on_segment, within};
