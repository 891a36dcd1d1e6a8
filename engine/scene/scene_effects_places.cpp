// Compiles the effects that depend on the position of the proxy and not on a contact: magnets,
// media and the fields of the scene.

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

#include "engine/scene/entry_parameters.h"
#include "engine/scene/merged_report.h"
#include "engine/scene/scene_effects.h"
#include "geometry/base/decompositions.h"
#include "geometry/index/inside.h"
#include "haptics/effects/gravity.h"
#include "haptics/effects/magnet.h"
#include "haptics/effects/viscosity.h"

namespace palpate {
namespace {

using Entry = EffectProgramBuilder::Entry;

AffineMap map_index_solver(const EffectSurface& surface) {
  const Quat to_body = surface.T_solver_body.rotation.conjugate();
  AffineMap map{to_body.toRotationMatrix(), -(to_body * surface.T_solver_body.translation_m)};
  const double units_per_metre = 1.0 / surface.metres_per_unit;
  map.linear *= units_per_metre;
  map.translation_m *= units_per_metre;
  if (const Stretch* stretch = surface.surface.stretch) {
    for (int k = 0; k < 3; ++k) map.linear.col(k) = stretch->to_index(Vec3(map.linear.col(k)));
    map.translation_m = stretch->to_index(map.translation_m);
  }
  return map;
}

double largest_stretch(const Mat3& linear) {
  return singular_values(linear)[0];
}

}  // namespace

// --- Magnets -------------------------------------------------------------------------------------

SceneEffects::MaybeError SceneEffects::add_magnets(const EffectSurfaces& bodies) {
  for (std::uint32_t b = 0; b < bodies.count; ++b) {
    const EffectSurface body = bodies.at(b);
    const auto& combinations = material_sets_[body.material_set].combinations;
    for (std::size_t part = 0; part < combinations.size(); ++part) {
      Combination& c = combinations_[combinations[part]];
      const Entry* magnet = c.effects.entry(MagnetEffect::kName);
      if (!magnet) continue;
      auto& magnets = builder_.program.magnets;
      if (magnets.size() == kMostMagnets) {
        return place_error(
            body, c, MagnetEffect::kKeys[0].key,
            "the scene has more than " + std::to_string(kMostMagnets) + " magnetic surfaces",
            "load a part of it with `SceneSettings::node`");
      }
      magnets.push_back({b, c.program_material, magnet_index(body, part)});
      Entry entry = *magnet;
      auto parameters = read_parameters<MagnetEffect::Parameters>(entry);
      parameters.surface = &magnets.back();
      write_parameters(parameters, entry);
      add_place(entry, &c);
    }
  }
  return std::nullopt;
}

// The index of the faces of one part. Surfaces that share the index of all parts share it as well.
const SurfaceIndex* SceneEffects::magnet_index(const EffectSurface& body, std::size_t part) {
  if (body.surface.parts->materials().size() == 1) return body.surface.index;
  const SurfaceIndex*& index = index_of_part_[{body.surface.index, part}];
  if (!index) {
    auto& indices = builder_.program.indices;
    indices.push_back(part_index(body.surface, part));
    index = &indices.back();
  }
  return index;
}

// --- Media ---------------------------------------------------------------------------------------

Error SceneEffects::place_error(const EffectSurface& surface, const Combination& c,
                                std::string_view key, const std::string& problem,
                                const std::string& hint) const {
  std::string element = material_of(c).element;
  for (const HonouredParameter& h : c.effects.report.honoured) {
    if (h.key == key) element = h.element;
  }
  return {ErrorCode::kInvalidContent, "", element,
          "material \"" + name_of(c) + "\", node \"" + std::string(surface.node) + "\": " + problem,
          hint};
}

// The overrides that remove the medium of a material; a material without a medium must be solid.
std::string SceneEffects::without_medium(const Combination& c) const {
  const auto argument = [&](std::string_view key, const char* value) {
    return "`SceneSettings::overrides` \"" + name_of(c) + "." + std::string(key) + "=" + value +
           "\"";
  };
  const std::string none = argument(ViscosityEffect::kKeys[0].key, "0");
  return c.effects.is_solid ? none : none + " " + argument(kSolidKey, "true");
}

SceneEffects::MaybeError SceneEffects::check_medium_surface(const EffectSurface& surface,
                                                            const Combination& c) {
  const std::string_view key = ViscosityEffect::kKeys[0].key;
  if (surface.surface.parts->materials().size() > 1) {
    return place_error(surface, c, key,
                       "its mesh has several materials; viscosity needs one material for all faces",
                       "split the mesh by material");
  }
  const SurfaceMesh& mesh = *surface.surface.mesh;
  const auto known = is_closed_.find(&mesh);
  const bool closed =
      known != is_closed_.end() ? known->second : (is_closed_[&mesh] = is_closed(mesh));
  if (closed) return std::nullopt;
  const std::size_t boundary = mesh.report().boundary_edges;
  return place_error(surface, c, key,
                     boundary > 0
                         ? "its surface is open: " + std::to_string(boundary) +
                               " boundary edges; viscosity needs a closed surface"
                         : std::string("its surface is not closed: an edge has an odd number of "
                                       "faces; viscosity needs a closed surface"),
                     "close the surface, or load it without the medium: " + without_medium(c));
}

SceneEffects::MaybeError SceneEffects::add_body_media(const EffectSurfaces& bodies) {
  for (std::uint32_t b = 0; b < bodies.count; ++b) {
    const EffectSurface body = bodies.at(b);
    for (const std::size_t i : material_sets_[body.material_set].combinations) {
      Combination& c = combinations_[i];
      const Entry* viscosity = c.effects.entry(ViscosityEffect::kName);
      if (!viscosity) continue;
      if (auto error = check_medium_surface(body, c)) return error;
      MediumRegion region;
      region.shape = MediumRegion::Shape::kInside;
      region.body = b;
      if (auto error = add_medium(*viscosity, region, &c)) return error;
    }
  }
  return std::nullopt;
}

SceneEffects::MaybeError SceneEffects::add_through_media(const EffectSurfaces& media) {
  for (std::size_t m = 0; m < media.count; ++m) {
    const EffectSurface surface = media.at(m);
    Combination& c = combinations_[material_sets_[surface.material_set].combinations.front()];
    if (auto error = check_medium_surface(surface, c)) return error;
    MediumRegion region;
    region.shape = MediumRegion::Shape::kThrough;
    region.p_region_solver = map_index_solver(surface);
    region.least_scale = 1.0 / largest_stretch(region.p_region_solver.linear);
    region.index = surface.surface.index;
    if (auto error = add_medium(*c.effects.entry(ViscosityEffect::kName), region, &c)) return error;
  }
  return std::nullopt;
}

SceneEffects::MaybeError SceneEffects::add_medium(const Entry& entry, const MediumRegion& region,
                                                  Combination* owner) {
  auto& media = builder_.program.media;
  if (media.size() == kMostMedia) {
    return limit_error("scene", "has more than " + std::to_string(kMostMedia) +
                                    " regions with viscosity, the limit");
  }
  media.push_back(region);
  Entry with_region = entry;
  auto parameters = read_parameters<ViscosityEffect::Parameters>(entry);
  parameters.region = &media.back();
  write_parameters(parameters, with_region);
  add_place(with_region, owner);
  return std::nullopt;
}

// --- Surroundings --------------------------------------------------------------------------------

// Counts the calls of surroundings, so that the calls of a material can be found later.
void SceneEffects::add_place(const Entry& entry, Combination* owner) {
  builder_.add_surroundings(entry);
  if (owner) owner->places.push_back(place_count_);
  ++place_count_;
}

SceneEffects::MaybeError SceneEffects::add_surroundings(const Vec3& anchor_scene_m) {
  const MaterialDescription& scene = *declarations_.scene_parameters;
  auto fields = scene_fields(scene);
  if (!fields) return fields.error();
  report_.scene = {scene.name, scene.element, {}, std::move(fields->report)};
  if (fields->gravity) {
    Entry entry{*effect_number(GravityEffect::kName), {}};
    write_parameters(*fields->gravity, entry);
    builder_.add_surroundings(entry);
    report_.scene.effects = {std::string(GravityEffect::kName)};
    report_.effects = report_.scene.effects;
  }
  for (const RegionDescription& region : declarations_.regions) {
    auto medium = node_medium(region, anchor_scene_m);
    if (!medium) return medium.error();
    report_.regions.push_back({region.name, region.element, {}, std::move(medium->report)});
    if (medium->viscosity_Ns_per_m == 0.0) continue;
    Entry entry{*effect_number(ViscosityEffect::kName), {}};
    write_parameters(ViscosityEffect::Parameters{medium->viscosity_Ns_per_m, nullptr}, entry);
    if (auto error = add_medium(entry, medium->region, nullptr)) return error;
    report_.regions.back().effects = {std::string(ViscosityEffect::kName)};
    merge_names(report_.regions.back().effects, report_.effects);
  }
  return std::nullopt;
}

}  // namespace palpate
