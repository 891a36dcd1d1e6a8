#include "engine/scene/surroundings.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "engine/scene/extras_keys.h"
#include "engine/scene/material_parameters.h"
#include "geometry/base/decompositions.h"

namespace palpate {
namespace {

constexpr ParameterKey key_of(std::string_view key, std::string_view unit, double least,
                              double most, std::string_view what, bool least_is_excluded) {
  ParameterKey k{key, unit, least, most, 0, ParameterKey::Role::kOptional, what};
  k.least_is_excluded = least_is_excluded;
  return k;
}

constexpr ParameterKey kSceneKeys[] = {
    key_of("gravity", "m/s^2", -1000.0, 1000.0, "acceleration of the tool, along the scene's axes",
           false),
    key_of("toolMass", "kg", 0.0, 10.0, "mass of the tool, on which gravity acts", true),
    key_of("constantForce", "N", -100.0, 100.0,
           "force that acts everywhere, along the scene's axes", false)};
constexpr ParameterKey kRegionKeys[] = {
    key_of("size", "m", 0.0, 1000.0, "edge lengths of a box, along the node's axes", true),
    key_of("radius", "m", 0.0, 1000.0, "radius of a sphere", true)};

// Relative tolerance for equal scales along all axes: matrices in files have single precision.
constexpr double kSameScale = 64 * std::numeric_limits<float>::epsilon();

// Reads the parameters of one part of a file, and reports each parameter.
class Declaration {
 public:
  Declaration(std::string owner, const std::vector<MaterialParameter>& parameters,
              MaterialReport& report)
      : owner_(std::move(owner)), parameters_(parameters), report_(report) {}

  const std::string& owner() const { return owner_; }
  const MaterialParameter* find(std::string_view key) const {
    const auto found = std::find_if(parameters_.begin(), parameters_.end(),
                                    [&](const MaterialParameter& p) { return p.key == key; });
    return found == parameters_.end() ? nullptr : &*found;
  }

  Result<double> number(const MaterialParameter& parameter, const ParameterKey& key) const {
    return checked_number(owner_, parameter, key);
  }
  Result<Vec3> vector(const MaterialParameter& parameter, const ParameterKey& key) const {
    const auto* list = std::get_if<std::vector<double>>(&parameter.value);
    const auto fits = [&](double x) {
      return checked_number(owner_, {parameter.key, x, parameter.element}, key).ok();
    };
    if (!list || list->size() != 3 || !std::all_of(list->begin(), list->end(), fits)) {
      return parameter_error(owner_, parameter,
                             "a list of three numbers, each " + expected_text(key));
    }
    return Vec3((*list)[0], (*list)[1], (*list)[2]);
  }

  void report_applied(const MaterialParameter& parameter, std::string_view unit,
                      bool is_off = false) {
    report_.honoured.push_back({parameter.key, parameter.value, std::string(unit),
                                source_of(parameter), parameter.element, is_off});
  }
  // Reports all parameters whose keys are not in the list. owner: of this part of the file.
  void report_others(std::span<const std::string_view> keys, KeyOwner owner) {
    for (const MaterialParameter& p : parameters_) {
      if (std::find(keys.begin(), keys.end(), p.key) != keys.end()) continue;
      report_.not_understood.push_back(
          {p.key, p.value, p.element, extras_keys().why_unknown(p.key, owner)});
    }
  }
  Error error(const MaterialParameter& parameter, std::string problem,
              std::string hint = "") const {
    return {ErrorCode::kInvalidContent, "", parameter.element, owner_ + ": " + std::move(problem),
            std::move(hint)};
  }
  Error not_built(const MaterialParameter& parameter, std::string_view effect) const {
    return not_built_error(owner_, parameter, effect);
  }

 private:
  std::string owner_;
  const std::vector<MaterialParameter>& parameters_;
  MaterialReport& report_;
};

// Reads the weight of the tool. gravity and toolMass must be given together.
std::optional<Error> read_gravity(Declaration& declaration, GravityEffect::Parameters& gravity) {
  const MaterialParameter* acceleration = declaration.find("gravity");
  const MaterialParameter* mass = declaration.find("toolMass");
  if (!acceleration && !mass) return std::nullopt;
  if (!acceleration || !mass) {
    return declaration.error(
        acceleration ? *acceleration : *mass,
        acceleration ? "gravity is given without toolMass; expected " + expected_text(kSceneKeys[1])
                     : "toolMass is given without gravity",
        "give both keys, or neither");
  }
  const auto a = declaration.vector(*acceleration, kSceneKeys[0]);
  if (!a) return a.error();
  const auto m = declaration.number(*mass, kSceneKeys[1]);
  if (!m) return m.error();
  std::copy_n(a->data(), 3, gravity.gravity_m_per_s2);
  gravity.mass_kg = *m;
  const bool is_off = a->isZero(0.0);
  declaration.report_applied(*acceleration, kSceneKeys[0].unit, is_off);
  declaration.report_applied(*mass, kSceneKeys[1].unit, is_off);
  return std::nullopt;
}

std::optional<Error> read_field(Declaration& declaration, GravityEffect::Parameters& gravity) {
  const MaterialParameter* field = declaration.find("constantForce");
  if (!field) return std::nullopt;
  const auto f = declaration.vector(*field, kSceneKeys[2]);
  if (!f) return f.error();
  std::copy_n(f->data(), 3, gravity.field_N);
  declaration.report_applied(*field, kSceneKeys[2].unit, f->isZero(0.0));
  return std::nullopt;
}

// Reads the half extent of the region, in the frame of the node.
Result<Vec3> read_extent(Declaration& declaration, bool is_box, const MaterialParameter& medium) {
  const ParameterKey& wanted = kRegionKeys[is_box ? 0 : 1];
  const ParameterKey& other = kRegionKeys[is_box ? 1 : 0];
  const std::string shape(kMediumShapes[is_box ? 0 : 1]);
  if (const MaterialParameter* wrong = declaration.find(other.key)) {
    return declaration.error(*wrong, "a " + shape + " has no " + std::string(other.key) +
                                         "; expected " + std::string(wanted.key));
  }
  const MaterialParameter* extent = declaration.find(wanted.key);
  if (!extent) {
    return declaration.error(medium, "is a " + shape + " without " + std::string(wanted.key) +
                                         "; expected " + std::string(wanted.key));
  }
  Vec3 half_m = Vec3::Zero();
  if (is_box) {
    const auto size_m = declaration.vector(*extent, wanted);
    if (!size_m) return size_m.error();
    half_m = 0.5 * *size_m;
  } else {
    const auto radius_m = declaration.number(*extent, wanted);
    if (!radius_m) return radius_m.error();
    half_m.x() = *radius_m;
  }
  declaration.report_applied(*extent, wanted.unit);
  return half_m;
}

// Places the region by the transform of its node.
std::optional<Error> place(const RegionDescription& node, const Vec3& anchor_scene_m,
                           const Declaration& declaration, const MaterialParameter& medium,
                           MediumRegion& region) {
  const Vec3 scales = singular_values(node.linear_scene_node);
  const bool is_singular = !node.linear_scene_node.allFinite() || !node.translation_m.allFinite() ||
                           !(scales[2] > 16 * std::numeric_limits<double>::epsilon() * scales[0]);
  if (is_singular) {
    return declaration.error(medium, "its transform is singular, so the medium has no volume",
                             "scale the node by more than 0 along all axes");
  }
  if (region.shape == MediumRegion::Shape::kSphere &&
      scales[0] - scales[2] > kSameScale * scales[0]) {
    return declaration.error(medium,
                             "its transform is uneven or sheared, so its region is not a sphere; "
                             "expected the same scale along all axes",
                             "declare a box, or scale the node evenly");
  }
  const Mat3 linear = node.linear_scene_node.inverse();
  region.p_region_solver = {linear, linear * (anchor_scene_m - node.translation_m)};
  region.least_scale = scales[2];
  return std::nullopt;
}

// Reads the drag coefficient of the medium; 0 means that the medium has no effect.
Result<double> read_viscosity(Declaration& declaration, const MaterialParameter& medium) {
  constexpr const ParameterKey& kViscosity = ViscosityEffect::kKeys[0];
  const MaterialParameter* viscosity = declaration.find(kViscosity.key);
  if (!viscosity) {
    return declaration.error(medium,
                             "has no viscosity; expected viscosity, " + expected_text(kViscosity));
  }
  const auto drag = declaration.number(*viscosity, kViscosity);
  if (!drag) return drag.error();
  if (*drag > 0.0 && !effect_number(ViscosityEffect::kName)) {
    return declaration.not_built(*viscosity, ViscosityEffect::kName);
  }
  declaration.report_applied(*viscosity, kViscosity.unit, *drag == 0.0);
  return *drag;
}

}  // namespace

std::span<const ParameterKey> scene_keys() {
  return kSceneKeys;
}

std::span<const ParameterKey> region_keys() {
  return kRegionKeys;
}

Result<SceneFields> scene_fields(const MaterialDescription& scene_parameters) {
  SceneFields fields;
  Declaration declaration("scene", scene_parameters.parameters, fields.report);
  GravityEffect::Parameters gravity;
  if (auto error = read_gravity(declaration, gravity)) return *error;
  if (auto error = read_field(declaration, gravity)) return *error;
  declaration.report_others(std::array{kSceneKeys[0].key, kSceneKeys[1].key, kSceneKeys[2].key},
                            kOfScene);
  const auto is_nonzero = [](const double(&v)[3]) {
    return v[0] != 0.0 || v[1] != 0.0 || v[2] != 0.0;
  };
  if (!is_nonzero(gravity.gravity_m_per_s2) && !is_nonzero(gravity.field_N)) return fields;
  if (!effect_number(GravityEffect::kName)) {
    const MaterialParameter* field = declaration.find("constantForce");
    return declaration.not_built(field ? *field : *declaration.find("gravity"),
                                 GravityEffect::kName);
  }
  fields.gravity = gravity;
  return fields;
}

Result<NodeMedium> node_medium(const RegionDescription& node, const Vec3& anchor_scene_m) {
  NodeMedium result;
  Declaration declaration("node \"" + node.name + "\"", node.parameters, result.report);
  const MaterialParameter* medium = declaration.find(kMediumKey);
  const MaterialParameter none{std::string(kMediumKey), std::string(), node.element};
  const auto* shape = std::get_if<std::string>(medium ? &medium->value : &none.value);
  const bool is_box = shape && *shape == kMediumShapes[0];
  if (!is_box && !(shape && *shape == kMediumShapes[1])) {
    return parameter_error(declaration.owner(), medium ? *medium : none, "\"box\" or \"sphere\"");
  }
  declaration.report_applied(*medium, "");
  const auto half_m = read_extent(declaration, is_box, *medium);
  if (!half_m) return half_m.error();
  const auto viscosity = read_viscosity(declaration, *medium);
  if (!viscosity) return viscosity.error();
  result.region.shape = is_box ? MediumRegion::Shape::kBox : MediumRegion::Shape::kSphere;
  result.region.half_m = *half_m;
  result.viscosity_Ns_per_m = *viscosity;
  if (auto error = place(node, anchor_scene_m, declaration, *medium, result.region)) return *error;
  declaration.report_others(
      std::array{kMediumKey, kRegionKeys[0].key, kRegionKeys[1].key, ViscosityEffect::kKeys[0].key},
      kOfNode);
  return result;
}

}  // namespace palpate
