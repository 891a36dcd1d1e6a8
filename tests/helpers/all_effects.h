#pragma once

// A scene that declares every effect, with a second body without effects. Tests require that each
// compiled effect becomes active in it: a new effect needs an entry, and kEntries counts it.

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "geometry/index/crease_normals.h"
#include "haptics/effects/damping.h"
#include "haptics/effects/gravity.h"
#include "haptics/effects/magnet.h"
#include "haptics/effects/restitution.h"
#include "haptics/effects/shading.h"
#include "haptics/effects/stiffness.h"
#include "haptics/effects/texture.h"
#include "haptics/effects/vibration.h"
#include "haptics/effects/viscosity.h"
#include "tests/haptics/proxy/body_hand.h"

namespace palpate::test {

struct AllEffects {
  // Local frame: body 0, a sphere with all effects; body 1, a plate without effects.
  static constexpr double kRadius_m = 0.05;
  static constexpr double kRange_m = 0.01;  // range of the magnet
  static constexpr double kPlate_m = -0.2;  // z of the plate
  static Soup sphere() { return soup_of(icosphere(3, kRadius_m)); }
  static Soup plate() {
    Soup soup = square_soup(0.1);
    for (Vec3& p : soup.positions) p.z() += kPlate_m;
    return soup;
  }

  // order: permutes the entries. with_gravity: adds gravity to the surroundings.
  static void add_to(BodyHand& hand, std::vector<std::size_t> order = {},
                     bool with_gravity = true) {
    EffectProgram& program = hand.effects.builder.program;
    const SurfaceIndex& index = hand.index(0);
    std::vector<float> values(64 * 64);
    for (std::size_t i = 0; i < values.size(); ++i) {
      values[i] = static_cast<float>(0.5 + 0.5 * std::sin(0.2 * static_cast<double>(i % 64)) *
                                               std::cos(0.3 * static_cast<double>(i / 64)));
    }
    program.maps.push_back(
        HeightMap::build(64, 64, std::move(values), MapWrap::kMirror, MapWrap::kMirror));
    const Soup soup = sphere();
    const SurfaceMesh mesh = SurfaceMesh::build(soup.positions, soup.triangles);
    const std::vector<CornerNormals> normals = crease_normals(mesh, {}, 1.0);
    SurfaceAttributes attributes;
    for_each_slot(index, [&](std::uint32_t slot) {
      const TriangleGeometry& t = index.triangle(slot);
      const CornerCoordinates corners = {{{20 * t.a.x(), 20 * t.a.y()},
                                          {20 * t.b.x(), 20 * t.b.y()},
                                          {20 * t.c.x(), 20 * t.c.y()}}};
      attributes.texture_uv.push_back(UvMap::over(t, corners));
      attributes.corner_normals.push_back(normals[index.face(slot)]);
    });
    attributes.friction_uv = attributes.texture_uv;
    program.magnets.push_back({0, static_cast<std::uint32_t>(program.materials.size()), &index});
    MediumRegion medium;
    medium.shape = MediumRegion::Shape::kThrough;
    medium.index = &index;
    medium.p_region_solver = {hand.pose().rotation.conjugate().toRotationMatrix(),
                              hand.pose().rotation.conjugate() * Vec3(-hand.pose().translation_m)};
    program.media.push_back(medium);  // unreachable: the sphere is solid
    medium.shape = MediumRegion::Shape::kSphere;
    medium.half_m.x() = kRadius_m + 0.5 * kRange_m;
    program.media.push_back(medium);
    const HeightMap* map = &program.maps.back();
    std::vector<EffectProgramBuilder::Entry> entries = {
        effect_entry<StiffnessEffect>({800.0}),
        effect_entry<DampingEffect>({1.5}),
        effect_entry<FrictionEffect>({0.6, 0.4, map}),
        effect_entry<TextureEffect>({2e-4, map}),
        effect_entry<ShadingEffect>({57.0}),
        effect_entry<VibrationEffect>({80.0, 0.1, 1.0}),
        effect_entry<RestitutionEffect>({0.5, 0.05, 0.005}),
        effect_entry<MagnetEffect>({0.5, kRange_m, &program.magnets.back()}),
        effect_entry<ViscosityEffect>({2.0, &program.media.back()}),
        effect_entry<ViscosityEffect>({3.0, &program.media.front()})};
    if (!order.empty()) {
      std::vector<EffectProgramBuilder::Entry> permuted;
      for (const std::size_t i : order) permuted.push_back(entries[i]);
      entries = permuted;
    }
    hand.effects.add_body(entries, std::move(attributes));
    hand.effects.add_body_without_effects();
    if (with_gravity) {
      hand.effects.builder.add_surroundings(
          effect_entry<GravityEffect>({0.05, {0, 0, -9.81}, {0.1, 0, 0}}));
    }
  }
  static constexpr std::size_t kEntries = 10;
};

// A device path around the sphere, into it and away from it, at various speeds.
class Wander {
 public:
  Wander(Random& random, double least_m, double most_m)
      : random_(&random), least_m_(least_m), most_m_(most_m) {
    p_ = most_m * random.unit_vector();
  }
  const Vec3& next() {
    if (random_->index(60) == 0) {
      radius_m_ = random_->uniform(least_m_, most_m_);
      pace_m_ = std::pow(10.0, random_->uniform(-5.0, -3.0));
      heading_ = random_->unit_vector();
    }
    const Vec3 out = p_.normalized();
    p_ += pace_m_ * (heading_ - heading_.dot(out) * out) + 0.1 * (radius_m_ - p_.norm()) * out;
    if (random_->index(2)) p_ += 0.1 * pace_m_ * random_->unit_vector();
    return p_;
  }

 private:
  Random* random_;
  double least_m_, most_m_;
  double radius_m_ = 0.05;
  double pace_m_ = 1e-4;
  Vec3 heading_ = Vec3::UnitX();
  Vec3 p_;
};

}  // namespace palpate::test
