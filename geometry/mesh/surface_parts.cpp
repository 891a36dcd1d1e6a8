#include "geometry/mesh/surface_parts.h"

#include "geometry/base/box.h"

namespace palpate {

std::vector<double> part_extents_m(const WeldedSurface& surface,
                                   const std::vector<std::uint32_t>& vertices) {
  constexpr std::uint32_t kNone = ~std::uint32_t{0};
  const auto positions = surface.positions();
  LowestUnion parts(positions.size());
  for (const Triangle& face : surface.faces()) {
    parts.unite(face[0], face[1]);
    parts.unite(face[1], face[2]);
  }
  std::vector<std::uint32_t> box_of(positions.size(), kNone);  // by the lowest vertex of the part
  std::vector<Box> boxes;
  for (const std::uint32_t v : vertices) {
    std::uint32_t& box = box_of[parts.lowest(v)];
    if (box != kNone) continue;
    box = static_cast<std::uint32_t>(boxes.size());
    boxes.push_back(Box::empty());
  }
  for (std::uint32_t v = 0; v < positions.size(); ++v) {
    const std::uint32_t box = box_of[parts.lowest(v)];
    if (box != kNone) boxes[box] = boxes[box].united({positions[v], positions[v]});
  }
  std::vector<double> extents_m;
  extents_m.reserve(vertices.size());
  for (const std::uint32_t v : vertices) {
    const Box& box = boxes[box_of[parts.lowest(v)]];
    extents_m.push_back((box.high - box.low).maxCoeff());
  }
  return extents_m;
}

}  // namespace palpate
