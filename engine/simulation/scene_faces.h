#pragma once

// The faces of a scene in their places: one by one, across their edges, and drawn at random.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "engine/scene/scene.h"

namespace palpate {

// Numbers from 0 up to 1, the same for the same seed.
class UniformRandom {
 public:
  explicit UniformRandom(std::uint64_t seed) : random_(seed) {}
  double uniform() { return static_cast<double>(random_() >> 11) * 0x1p-53; }

 private:
  std::mt19937_64 random_;
};

// A face of a node, scene frame.
struct SceneFace {
  std::uint32_t object = 0;
  std::uint32_t face = 0;
  std::array<OpenMesh::HalfedgeHandle, 3> edges;  // edge k from corner k to corner k + 1
  std::array<Vec3, 3> corners_m;
  Vec3 winding;  // unit, by which the corners run counter-clockwise; zero if there is no area
  Vec3 normal;   // outward: the same, or its opposite in a node that is mirrored
};

class SceneFaceReader {
 public:
  explicit SceneFaceReader(const Scene& scene) : scene_(scene) {}

  SceneFace read(std::uint32_t object, std::uint32_t face) const;

  // Across edge k; nothing at a boundary of the surface.
  std::optional<SceneFace> across(const SceneFace& face, std::size_t k) const;

 private:
  const Scene& scene_;
};

// Of so many faces at most the areas are added up: of every n-th where there are more.
inline constexpr std::size_t kMostWeighed = std::size_t{1} << 20;

// Random faces, uniform by area.
class SceneFaceSampler {
 public:
  SceneFaceSampler(const Scene& scene, UniformRandom& random);

  bool is_empty() const { return area_up_to_.empty(); }

  // Of a scene that is not empty.
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
