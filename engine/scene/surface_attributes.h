#pragma once

// Attributes of triangles that effects need, computed from meshes, images and indices. For load
// time only.

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
#include "haptics/proxy/face_materials.h"
#include "io/scene_description.h"

namespace palpate {

// The parts of a mesh: faces grouped by material, and their texture coordinates. Contains the data
// of a MeshDescription except the positions, which SurfaceMesh stores.
class MeshParts {
 public:
  // Moves the needed data out of the description. The triangles are kept only if the description
  // has texture coordinates.
  MeshParts(const WeldedSurface& surface, MeshDescription&& description);

  // The distinct materials of the faces. Contains a single element without a value if the mesh has
  // no faces or declares no material. A part is an index into this list.
  const std::vector<std::optional<std::uint32_t>>& materials() const { return materials_; }
  std::size_t part_of_face(std::size_t face) const;  // time: logarithmic in the primitives
  // The materials of the faces, run by run; kNothingTouched for none.
  std::vector<FaceMaterialRun> face_materials() const;
  std::optional<std::uint32_t> haptic_material() const { return haptic_material_; }
  std::size_t memory_bytes() const;

  // Texture coordinates of a face's corners, in the order of its source triangle; see
  // MeshDescription.
  bool has_texture_uv() const { return !texture_uv_.empty(); }
  bool has_friction_uv() const { return !friction_uv_.empty(); }
  // piece: the piece of its source triangle that the face is, or null (SourceTriangles).
  CornerCoordinates texture_uv(std::uint32_t source_triangle, const FacePiece* piece) const;
  CornerCoordinates friction_uv(std::uint32_t source_triangle, const FacePiece* piece) const;
  // The source triangles at which the runs of one part begin, in the surface whose parts these are.
  std::vector<std::uint32_t> first_triangles(const WeldedSurface& surface) const;
  // Follows a change of the surface. first_triangles: of the surface before the change.
  void follow(const WeldedSurface& changed, std::span<const std::uint32_t> first_triangles);
  void drop_uv();  // frees the texture coordinates

 private:
  struct FaceRun {
    std::uint32_t first_face;
    std::uint32_t part;
  };

  std::vector<std::optional<std::uint32_t>> materials_;
  std::vector<FaceRun> runs_;  // in ascending order; each run ends where the next one begins
  std::optional<std::uint32_t> haptic_material_;
  std::vector<Triangle> triangles_;
  std::vector<std::array<double, 2>> texture_uv_;
  std::vector<std::array<double, 2>> friction_uv_;
};

// A surface with its parts and its index.
struct PartedSurface {
  const SurfaceMesh* mesh;
  const MeshParts* parts;
  AffineMap map_index_mesh;
  const SurfaceIndex* index;
  const Stretch* stretch = nullptr;  // null if body frame and index frame are equal

  // Attributes are computed in the body frame.
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

// The attributes that effects need. crease_angles_rad: one element for each part; no value for a
// part without shading.
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

// Builds an index of the faces of one part, in the same index frame. The part has at least one
// face.
SurfaceIndex part_index(const PartedSurface& surface, std::size_t part);

// Limit on the texels of all height maps of a scene, not counting their pyramids, which add a
// third. A map with its pyramid needs 16/3 bytes per texel; the conversion of a normal map
// temporarily needs 28 more bytes per texel. An image counts once for each map made from it.
inline constexpr std::uint64_t kMostMapTexels = std::uint64_t{1} << 25;

// Makes height maps from the images of a scene, each map once. Values range from 0 to 1. The value
// of a grey map is the mean of red, green and blue. A normal map is integrated to heights, of which
// the lowest becomes 0 and the highest 1. Therefore the magnitude of the scale of a normal texture
// does not affect the height, which is the material's textureHeight. A negative scale inverts the
// map, and the scale 0 makes it flat.
class HeightMapMaker {
 public:
  // Appends the maps to `maps`. `images` and `maps` must outlive this object.
  HeightMapMaker(std::span<const ImageDescription> images, std::deque<HeightMap>& maps,
                 std::uint64_t most_texels = kMostMapTexels)
      : images_(images), maps_(maps), most_texels_(most_texels) {}

  // Returns kUnsupported if the referenced texture has no image that can be read. Returns
  // kLimitExceeded, and does not make the map, if the maps would exceed the limit on texels. These
  // errors have no element.
  Result<const HeightMap*> grey(const TextureReference& reference);
  Result<const HeightMap*> from_normals(const TextureReference& reference);

 private:
  Result<const HeightMap*> make(const TextureReference& reference, bool is_normal_map);

  // Image, wrap modes in u and v, whether the image is a normal map, sign of the scale (1 for a
  // grey map).
  using Key = std::tuple<std::uint32_t, TextureWrap, TextureWrap, bool, int>;

  std::span<const ImageDescription> images_;
  std::deque<HeightMap>& maps_;
  std::uint64_t most_texels_;
  std::uint64_t texels_ = 0;  // texels of all maps made so far
  std::map<Key, const HeightMap*> made_;
};

}  // namespace palpate
