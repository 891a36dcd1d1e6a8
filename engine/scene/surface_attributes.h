#pragma once

// What surfaces keep of their triangles for effects: made from meshes, images and their indices.
// Load time only.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <span>
#include <tuple>
#include <vector>

#include "geometry/base/result.h"
#include "geometry/index/stretch.h"
#include "geometry/index/surface_index.h"
#include "geometry/mesh/height_map.h"
#include "geometry/mesh/surface_mesh.h"
#include "haptics/effects/face_point.h"
#include "io/scene_description.h"

namespace palpate {

// The faces of a mesh by material. The description without its positions, which a mesh has.
class MeshParts {
 public:
  // Takes what it needs of the description. Triangles are kept only beside texture coordinates.
  MeshParts(const WeldedSurface& surface, MeshDescription&& description);

  // The distinct materials of faces; without any face, or any declaration, one of them: none. A
  // part is a place in here.
  const std::vector<std::optional<std::uint32_t>>& materials() const { return materials_; }
  std::size_t part_of_face(std::size_t face) const;  // logarithmic in the primitives
  std::optional<std::uint32_t> haptic_material() const { return haptic_material_; }
  std::size_t memory_bytes() const;

  // Texture coordinates of a face's corners in its own order; see MeshDescription.
  bool has_texture_uv() const { return !texture_uv_.empty(); }
  bool has_friction_uv() const { return !friction_uv_.empty(); }
  CornerCoordinates texture_uv(std::uint32_t source_triangle) const;
  CornerCoordinates friction_uv(std::uint32_t source_triangle) const;
  void drop_uv();  // once they are no longer needed

 private:
  struct FaceRun {
    std::uint32_t first_face;
    std::uint32_t part;
  };

  std::vector<std::optional<std::uint32_t>> materials_;
  std::vector<FaceRun> runs_;  // in rising order; each lasts until the next begins
  std::optional<std::uint32_t> haptic_material_;
  std::vector<Triangle> triangles_;
  std::vector<std::array<double, 2>> texture_uv_;
  std::vector<std::array<double, 2>> friction_uv_;
};

// A surface as effects see it.
struct PartedSurface {
  const SurfaceMesh* mesh;
  const MeshParts* parts;
  AffineMap map_index_mesh;
  const SurfaceIndex* index;
  const Stretch* stretch = nullptr;  // if the body frame is not that of the index

  // Attributes are those of the body frame.
  AffineMap map_body_mesh() const {
    if (!stretch) return map_index_mesh;
    const Mat3& linear = stretch->linear_body_index();
    return {linear * map_index_mesh.linear, linear * map_index_mesh.translation_m};
  }
  TriangleGeometry triangle(std::uint32_t slot) const {
    return stretch ? stretch->triangle(index->triangle(slot)) : index->triangle(slot);
  }
  std::size_t slot_count() const { return index->pack_count() * TrianglePack::kLanes; }
};

// What is asked for. crease_angles_rad: of each part; none where it is not shaded.
struct AttributeNeeds {
  std::vector<std::optional<double>> crease_angles_rad;
  bool texture_uv = false;
  bool friction_uv = false;

  bool is_of_parts_alone() const {
    return !texture_uv && !friction_uv &&
           std::none_of(crease_angles_rad.begin(), crease_angles_rad.end(),
                        [](const auto& angle) { return angle.has_value(); });
  }
};

SurfaceAttributes surface_attributes(const PartedSurface& surface, const AttributeNeeds& needs);
std::size_t memory_bytes(const SurfaceAttributes& attributes);

// The faces of one part alone, in the same frame. At least one.
SurfaceIndex part_index(const PartedSurface& surface, std::size_t part);

// Texels of all height maps of a scene, at most; their pyramids, a third more, are not counted. A
// map takes 16/3 bytes a texel, and one of normals 28 while it is made. One image counts once for
// each map that is made of it.
inline constexpr std::uint64_t kMostMapTexels = std::uint64_t{1} << 25;

// Height maps of the images of a scene, each made once. Values are from 0 to 1: of a grey map the
// mean of red, green and blue; of a normal map the height that it is the slope of, 0 the lowest and
// 1 the highest. So the scale of a normal texture does not set how deep it feels, which the
// material's textureHeight does: a negative scale turns it inside out, 0 makes it flat.
class HeightMapMaker {
 public:
  // Maps go to the end of `maps`, which must outlive this.
  HeightMapMaker(std::span<const ImageDescription> images, std::deque<HeightMap>& maps,
                 std::uint64_t most_texels = kMostMapTexels)
      : images_(images), maps_(maps), most_texels_(most_texels) {}

  // An Error, without an element, if the reference has no pixels (kUnsupported), or if all maps
  // would have more texels than they may (kLimitExceeded; nothing is made).
  Result<const HeightMap*> grey(const TextureReference& reference);
  Result<const HeightMap*> from_normals(const TextureReference& reference);

 private:
  Result<const HeightMap*> make(const TextureReference& reference, bool is_normal_map);

  // Image, wraps, whether it is a normal map, and then the sign of its scale.
  using Key = std::tuple<std::uint32_t, TextureWrap, TextureWrap, bool, int>;

  std::span<const ImageDescription> images_;
  std::deque<HeightMap>& maps_;
  std::uint64_t most_texels_;
  std::uint64_t texels_ = 0;  // of those that are made
  std::map<Key, const HeightMap*> made_;
};

}  // namespace palpate
