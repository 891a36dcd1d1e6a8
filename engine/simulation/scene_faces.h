#pragma once

// Access to the faces of a scene: by index, across an edge, and at random.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "engine/scene/scene.h"

namespace palpate {

// Numbers in [0, 1); the same seed gives the same sequence.
class UniformRandom {
 public:
  explicit UniformRandom(std::uint64_t seed) : random_(seed) {}
  double uniform() { return static_cast<double>(random_() >> 11) * 0x1p-53; }

 private:
  std::mt19937_64 random_;
};

// A face of an object, scene frame.
struct SceneFace {
  std::uint32_t object = 0;
  std::uint32_t face = 0;
  std::array<OpenMesh::HalfedgeHandle, 3> edges;  // edge k from corner k to corner k + 1
  std::array<Vec3, 3> corners_m;
  Vec3 winding;  // unit normal about which the corners run counter-clockwise; zero without area
  Vec3 normal;   // outward: equal to winding, or opposite in a mirrored node
};

class SceneFaceReader {
 public:
  explicit SceneFaceReader(const Scene& scene) : scene_(scene) {}

  SceneFace read(std::uint32_t object, std::uint32_t face) const;

  // The neighbour across edge k; no value at a boundary or if the neighbour has no area.
  std::optional<SceneFace> across(const SceneFace& face, std::size_t k) const;

 private:
  const Scene& scene_;
};

// A sampler draws from at most this many faces. If a scene has more faces, the sampler draws only
// from every n-th face.
inline constexpr std::size_t kMostWeighed = std::size_t{1} << 20;

// Draws random faces, each with a probability proportional to its area.
class SceneFaceSampler {
 public:
  SceneFaceSampler(const Scene& scene, UniformRandom& random);

  bool is_empty() const { return area_up_to_.empty(); }

  // Requires !is_empty().
  SceneFace draw();

 private:
  SceneFaceReader faces_;
  UniformRandom& random_;
  std::vector<std::size_t> first_of_object_;
  std::vector<double> area_up_to_;
  std::size_t step_ = 1;
  std::size_t first_ = 0;
};

}  // namespace palpate
