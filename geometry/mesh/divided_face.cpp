#include "geometry/mesh/divided_face.h"

#include <algorithm>
#include <utility>

namespace palpate {
namespace {

// A corner of a part: a vertex with its place in the source triangle.
struct Corner {
  std::uint32_t vertex;
  CornerWeights weights;
};

// A part that may still have corners within its edges. edges[e]: the corners within the edge from
// corner e to the next one, the last of them first.
struct Unfinished {
  std::array<Corner, 3> corners;
  std::array<std::vector<Corner>, 3> edges;
};

Corner between(const Corner& from, const Corner& to, const EdgeDivision& division) {
  Corner corner{division.vertex, {}};
  for (std::size_t k = 0; k < 2; ++k) {
    corner.weights[k] = from.weights[k] + division.along * (to.weights[k] - from.weights[k]);
  }
  return corner;
}

Unfinished with_divisions(const TrianglePart& whole, std::span<const EdgeDivision> divisions) {
  Unfinished part;
  for (std::size_t i = 0; i < 3; ++i) part.corners[i] = {whole.vertices[i], whole.corners[i]};
  for (auto d = divisions.rbegin(); d != divisions.rend(); ++d) {
    const std::size_t e = d->half_edge % 3;
    part.edges[e].push_back(between(part.corners[e], part.corners[(e + 1) % 3], *d));
  }
  return part;
}

// Cuts off the triangle between the opposite corner and the first piece of edge e. The rest keeps
// the other pieces of this edge.
std::pair<Unfinished, Unfinished> cut(Unfinished&& part, std::size_t e) {
  const std::size_t next = (e + 1) % 3;
  const std::size_t last = (e + 2) % 3;
  const Corner middle = part.edges[e].back();
  part.edges[e].pop_back();
  Unfinished first;
  first.corners = {part.corners[last], part.corners[e], middle};
  first.edges[0] = std::move(part.edges[last]);
  Unfinished rest;
  rest.corners = {middle, part.corners[next], part.corners[last]};
  rest.edges[0] = std::move(part.edges[e]);
  rest.edges[1] = std::move(part.edges[next]);
  return {std::move(first), std::move(rest)};
}

}  // namespace

std::vector<TrianglePart> divided(const TrianglePart& whole,
                                  std::span<const EdgeDivision> divisions) {
  std::vector<TrianglePart> parts;
  std::vector<Unfinished> open = {with_divisions(whole, divisions)};
  while (!open.empty()) {
    Unfinished part = std::move(open.back());
    open.pop_back();
    const auto divided_edge = std::find_if(part.edges.begin(), part.edges.end(),
                                           [](const auto& corners) { return !corners.empty(); });
    if (divided_edge == part.edges.end()) {
      const auto& c = part.corners;
      parts.push_back(
          {{c[0].vertex, c[1].vertex, c[2].vertex}, {c[0].weights, c[1].weights, c[2].weights}});
      continue;
    }
    const auto e = static_cast<std::size_t>(divided_edge - part.edges.begin());
    auto [first, rest] = cut(std::move(part), e);
    open.push_back(std::move(rest));
    open.push_back(std::move(first));
  }
  return parts;
}

}  // namespace palpate
