#include "engine/simulation/scene_sight.h"

#include <algorithm>
#include <cstdint>
#include <limits>

namespace palpate {
namespace {

struct Look {
  const ContactWorld* world;
  Vec3 from, to;
  double fraction;

  void at(std::uint32_t b) {
    const ContactBody& body = world->bodies[b];
    const Vec3 from_body = body.to_body(from);
    const auto hit = body.index->first_hit(from_body, body.to_body(to) - from_body);
    if (hit) fraction = std::min(fraction, hit->fraction);
  }
};

}  // namespace

double SceneSight::first_hit(const Vec3& from_scene, const Vec3& to_scene) const {
  Look look{&world_, world_.to_solver(from_scene), world_.to_solver(to_scene),
            std::numeric_limits<double>::infinity()};
  const auto visit = [](void* state, std::uint32_t body) {
    static_cast<Look*>(state)->at(body);
    return true;
  };
  if (world_.tree) {
    world_.tree->visit_along(look.from, look.to - look.from, 0.0, 0, visit, &look);
  } else {
    for (std::uint32_t b = 0; b < world_.bodies.size(); ++b) look.at(b);
  }
  return look.fraction;
}

}  // namespace palpate
