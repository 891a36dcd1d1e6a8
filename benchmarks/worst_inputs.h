#pragma once

// Scenes and motions that need the most work in a tick. The work budget limits the work of each
// tick.

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

// One input. Owns the indices that its world points to; solver frame, metres.
struct WorstInput {
  std::string name;
  double proxy_radius_m = 0.0;
  std::vector<std::unique_ptr<SurfaceIndex>> indices;
  std::shared_ptr<std::vector<Stretch>> stretches;  // of the bodies, if they are stretched
  ContactWorld world;
  std::vector<Vec3> goals_m;  // one per tick; the first is the proxy's initial position
  Vec3 away_m;                // a goal that is freely reachable from the last goal
  // The poses of the bodies in each tick; empty if no body moves.
  std::vector<std::vector<BodyMotion>> motions;
};

// A kind of input. make() takes an approximate number of triangles, or of bodies if the name says
// so.
struct WorstKind {
  std::string_view name;
  std::size_t most;   // argument of make() for benchmarks
  std::size_t least;  // argument of make() for tests
  std::size_t ticks;  // number of goals
  WorstInput (*make)(std::size_t count);
};
inline void PrintTo(const WorstKind& kind, std::ostream* out) {
  *out << kind.name;
}
const std::vector<WorstKind>& worst_kinds();

}  // namespace palpate::bench
