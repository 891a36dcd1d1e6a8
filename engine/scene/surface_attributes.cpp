#include "engine/scene/surface_attributes.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "geometry/base/memory_breakdown.h"
#include "geometry/index/crease_normals.h"
#include "geometry/mesh/height_from_normals.h"
#include "palpate/record.h"

namespace palpate {
namespace {

// The first face whose source is this triangle or a later one.
std::uint32_t first_face_from(const WeldedSurface& surface, std::uint32_t triangle) {
  std::uint32_t low = 0;
  auto high = static_cast<std::uint32_t>(surface.face_count());
  while (low < high) {
    const std::uint32_t middle = low + (high - low) / 2;
    if (surface.source_triangle(middle) < triangle) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return low;
}

CornerCoordinates corners_of(const Triangle& triangle,
                             const std::vector<std::array<double, 2>>& uv) {
  return {uv[triangle[0]], uv[triangle[1]], uv[triangle[2]]};
}

// The coordinates at the corners of a piece of the triangle. Coordinates are linear in a triangle.
CornerCoordinates of_piece(const CornerCoordinates& uv, const FacePiece* piece) {
  if (!piece) return uv;
  CornerCoordinates corners;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto [second, third] = piece->corners[i];
    for (std::size_t k = 0; k < 2; ++k) {
      corners[i][k] = uv[0][k] + second * (uv[1][k] - uv[0][k]) + third * (uv[2][k] - uv[0][k]);
    }
  }
  return corners;
}

// Corner normals by face, for the shaded parts.
std::vector<CornerNormals> shaded_normals(const PartedSurface& surface,
                                          const AttributeNeeds& needs) {
  std::vector<CornerNormals> normals(surface.mesh->face_count());
  std::vector<double> angles;
  for (const auto& angle : needs.crease_angles_rad) {
    if (angle) angles.push_back(*angle);
  }
  std::sort(angles.begin(), angles.end());
  angles.erase(std::unique(angles.begin(), angles.end()), angles.end());
  for (const double angle : angles) {
    const auto of_angle = crease_normals(*surface.mesh, surface.map_body_mesh(), angle);
    for (std::size_t f = 0; f < normals.size(); ++f) {
      const auto wanted = needs.crease_angles_rad[surface.parts->part_of_face(f)];
      if (wanted && *wanted == angle) normals[f] = of_angle[f];
    }
  }
  return normals;
}

// An index exchanges the corners b and c of mirrored triangles.
CornerCoordinates in_index_order(CornerCoordinates corners, bool is_mirrored) {
  if (is_mirrored) std::swap(corners[1], corners[2]);
  return corners;
}

std::vector<float> grey_values(const ImageDescription& image) {
  std::vector<float> values(std::size_t{image.width} * image.height);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::uint32_t sum =
        std::uint32_t{image.rgb[3 * i]} + image.rgb[3 * i + 1] + image.rgb[3 * i + 2];
    values[i] = static_cast<float>(sum / (3.0 * 65535.0));
  }
  return values;
}

std::vector<TexelSlope> slopes_of(const ImageDescription& image, double scale) {
  std::vector<std::array<std::uint16_t, 3>> pixels(std::size_t{image.width} * image.height);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    std::copy_n(image.rgb.begin() + static_cast<std::ptrdiff_t>(3 * i), 3, pixels[i].begin());
  }
  return slopes_from_normal_map(pixels, scale);
}

// Heights are proportional to the scale; after normalisation only its sign matters: -1, 0 or 1.
std::vector<float> normalised_heights(const ImageDescription& image, int scale_sign) {
  std::vector<float> heights =
      heights_from_slopes(image.width, image.height, slopes_of(image, scale_sign));
  const auto [low, high] = std::minmax_element(heights.begin(), heights.end());
  const float lowest = *low;
  const float range = *high - lowest;
  // A flat map has the height 1 everywhere: it leaves the surface unchanged.
  for (float& h : heights) h = range > 0.0f ? (h - lowest) / range : 1.0f;
  return heights;
}

int sign_of(double value) {
  return (value > 0.0) - (value < 0.0);
}

MapWrap map_wrap(TextureWrap wrap) {
  switch (wrap) {
    case TextureWrap::kClamp:
      return MapWrap::kClamp;
    case TextureWrap::kMirror:
      return MapWrap::kMirror;
    case TextureWrap::kRepeat:
      break;
  }
  return MapWrap::kRepeat;
}

}  // namespace

MeshParts::MeshParts(const WeldedSurface& surface, MeshDescription&& description)
    : haptic_material_(description.haptic_material),
      texture_uv_(std::move(description.texture_uv)),
      friction_uv_(std::move(description.friction_uv)) {
  if (has_texture_uv() || has_friction_uv()) triangles_ = std::move(description.triangles);
  std::map<std::optional<std::uint32_t>, std::uint32_t> parts;
  std::vector<MaterialRun> runs = std::move(description.material_runs);
  if (!runs.empty() && runs.front().first_triangle > 0) runs.insert(runs.begin(), MaterialRun{});
  for (std::size_t r = 0; r < runs.size(); ++r) {
    const std::uint32_t first = first_face_from(surface, runs[r].first_triangle);
    const std::size_t end = r + 1 < runs.size()
                                ? first_face_from(surface, runs[r + 1].first_triangle)
                                : surface.face_count();
    if (first == end) continue;  // cleaning removed all its triangles
    const auto [part, is_new] =
        parts.emplace(runs[r].material, static_cast<std::uint32_t>(materials_.size()));
    if (is_new) materials_.push_back(runs[r].material);
    runs_.push_back({first, part->second});
  }
  if (materials_.empty()) materials_.emplace_back();
}

std::size_t MeshParts::part_of_face(std::size_t face) const {
  if (materials_.size() == 1) return 0;
  const auto next =
      std::upper_bound(runs_.begin(), runs_.end(), face,
                       [](std::size_t f, const FaceRun& run) { return f < run.first_face; });
  return next == runs_.begin() ? 0 : std::prev(next)->part;
}

std::vector<FaceMaterialRun> MeshParts::face_materials() const {
  const auto number_of = [&](std::size_t part) {
    return materials_[part] ? static_cast<std::int32_t>(*materials_[part]) : kNothingTouched;
  };
  if (materials_.size() == 1) return {{0, number_of(0)}};
  std::vector<FaceMaterialRun> runs;
  runs.reserve(runs_.size());
  for (const FaceRun& run : runs_) runs.push_back({run.first_face, number_of(run.part)});
  return runs;
}

std::vector<std::uint32_t> MeshParts::first_triangles(const WeldedSurface& surface) const {
  std::vector<std::uint32_t> triangles;
  triangles.reserve(runs_.size());
  for (const FaceRun& run : runs_) triangles.push_back(surface.source_triangle(run.first_face));
  return triangles;
}

void MeshParts::follow(const WeldedSurface& changed,
                       std::span<const std::uint32_t> first_triangles) {
  for (std::size_t r = 0; r < runs_.size(); ++r) {
    runs_[r].first_face = first_face_from(changed, first_triangles[r]);
  }
}

std::size_t MeshParts::memory_bytes() const {
  return bytes_of(materials_) + bytes_of(runs_) + bytes_of(triangles_) + bytes_of(texture_uv_) +
         bytes_of(friction_uv_);
}

CornerCoordinates MeshParts::texture_uv(std::uint32_t source_triangle,
                                        const FacePiece* piece) const {
  return of_piece(corners_of(triangles_[source_triangle], texture_uv_), piece);
}

CornerCoordinates MeshParts::friction_uv(std::uint32_t source_triangle,
                                         const FacePiece* piece) const {
  return of_piece(corners_of(triangles_[source_triangle], friction_uv_), piece);
}

void MeshParts::drop_uv() {
  triangles_ = {};
  texture_uv_ = {};
  friction_uv_ = {};
}

SurfaceAttributes surface_attributes(const PartedSurface& surface, const AttributeNeeds& needs) {
  SurfaceAttributes attributes;
  const MeshParts& parts = *surface.parts;
  const std::size_t slots = surface.slot_count();
  const bool is_mirrored = surface.map_body_mesh().linear.determinant() < 0.0;
  const bool is_shaded = std::any_of(needs.crease_angles_rad.begin(), needs.crease_angles_rad.end(),
                                     [](const auto& angle) { return angle.has_value(); });
  std::vector<CornerNormals> normals;
  if (is_shaded) normals = shaded_normals(surface, needs);
  if (parts.materials().size() > 1) attributes.part.resize(slots);
  if (is_shaded) attributes.corner_normals.resize(slots);
  if (needs.texture_uv) attributes.texture_uv.resize(slots);
  if (needs.friction_uv) attributes.friction_uv.resize(slots);
  for (std::uint32_t slot = 0; slot < slots; ++slot) {
    const std::uint32_t face = surface.index->face(slot);
    if (!attributes.part.empty()) {
      attributes.part[slot] = static_cast<std::uint16_t>(parts.part_of_face(face));
    }
    if (is_shaded) attributes.corner_normals[slot] = normals[face];
    if (!needs.texture_uv && !needs.friction_uv) continue;
    const std::uint32_t source = surface.mesh->source_triangle(face);
    const FacePiece* piece = surface.mesh->piece(face);
    if (needs.texture_uv) {
      attributes.texture_uv[slot] = UvMap::over(
          surface.triangle(slot), in_index_order(parts.texture_uv(source, piece), is_mirrored));
    }
    if (needs.friction_uv) {
      attributes.friction_uv[slot] = UvMap::over(
          surface.triangle(slot), in_index_order(parts.friction_uv(source, piece), is_mirrored));
    }
  }
  return attributes;
}

std::size_t memory_bytes(const SurfaceAttributes& attributes) {
  return sizeof attributes + bytes_of(attributes.part) + bytes_of(attributes.corner_normals) +
         bytes_of(attributes.texture_uv) + bytes_of(attributes.friction_uv);
}

SurfaceIndex part_index(const PartedSurface& surface, std::size_t part) {
  std::vector<Vec3> positions;
  std::vector<Triangle> triangles;
  for (std::size_t f = 0; f < surface.mesh->face_count(); ++f) {
    if (surface.parts->part_of_face(f) != part) continue;
    const auto first = static_cast<std::uint32_t>(positions.size());
    for (const std::uint32_t v : surface.mesh->face(f)) {
      positions.push_back(surface.mesh->welded_positions()[v]);
    }
    triangles.push_back({first, first + 1, first + 2});
  }
  const WeldedSurface welded(std::move(positions), std::move(triangles));
  return SurfaceIndex(MappedFaces{welded.positions(), welded.faces(), surface.map_index_mesh});
}

Result<const HeightMap*> HeightMapMaker::grey(const TextureReference& reference) {
  return make(reference, false);
}

Result<const HeightMap*> HeightMapMaker::from_normals(const TextureReference& reference) {
  return make(reference, true);
}

Result<const HeightMap*> HeightMapMaker::make(const TextureReference& reference,
                                              bool is_normal_map) {
  const ImageDescription* image = reference.pixels && *reference.pixels < images_.size()
                                      ? &images_[*reference.pixels]
                                      : nullptr;
  if (!image || image->width == 0 || image->height == 0 ||
      image->rgb.size() != std::size_t{3} * image->width * image->height) {
    return Error{ErrorCode::kUnsupported, "", "",
                 "texture " + std::to_string(reference.texture) +
                     " has no image that can be read; expected PNG or JPEG",
                 "replace the image"};
  }
  const int sign = is_normal_map ? sign_of(reference.scale) : 1;
  const Key key{*reference.pixels, reference.wrap_u, reference.wrap_v, is_normal_map, sign};
  const auto known = made_.find(key);
  if (known != made_.end()) return known->second;
  const std::uint64_t texels = std::uint64_t{image->width} * image->height;
  if (texels > most_texels_ - texels_) {
    return Error{ErrorCode::kLimitExceeded, "", "",
                 "texture " + std::to_string(reference.texture) + " of " +
                     std::to_string(image->width) + " x " + std::to_string(image->height) +
                     " texels raises the height maps of the scene to more than " +
                     std::to_string(most_texels_) + " texels",
                 "use smaller images, or only one wrap mode for each image"};
  }
  texels_ += texels;
  maps_.push_back(
      HeightMap::build(image->width, image->height,
                       is_normal_map ? normalised_heights(*image, sign) : grey_values(*image),
                       map_wrap(reference.wrap_u), map_wrap(reference.wrap_v)));
  made_.emplace(key, &maps_.back());
  return &maps_.back();
}

}  // namespace palpate
