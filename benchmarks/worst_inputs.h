#pragma once

// Scenes and motions that ask more of a tick than any other: what the budget of a tick is for.

#include <cstddef>
#include <memory>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/index/surface_index.h"
#include "haptics/proxy/contact_world.h"
#include "haptics/proxy/god_object.h"

namespace palpate::bench {

// One of them. Owns what its world points to; solver frame, metres.
struct WorstInput {
  std::string name;
  double proxy_radius_m = 0.0;
  std::vector<std::unique_ptr<SurfaceIndex>> indices;
  ContactWorld world;
  std::vector<Vec3> goals_m;  // one each tick; the first is where the proxy is put
  Vec3 away_m;                // a goal that nothing is in the way of, from where the last one is
  // Where bodies are to be in each tick; none if nothing moves.
  std::vector<std::vector<BodyMotion>> motions;
};

// All by name, and one made: with about so many triangles, or bodies where the name says so.
struct WorstKind {
  std::string_view name;
  std::size_t most;   // triangles, or bodies: for benchmarks
  std::size_t least;  // for tests
  std::size_t ticks;  // as many as goals
  WorstInput (*make)(std::size_t count);
};
inline void PrintTo(const WorstKind& kind, std::ostream* out) {
  *out << kind.name;
}
const std::vector<WorstKind>& worst_kinds();

}  // namespace palpate::bench
