#pragma once

// The effects of a scene in compiled form: tables of effect calls that a tick runs from front to
// back.

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "geometry/mesh/height_map.h"
#include "haptics/effects/effect.h"
#include "haptics/effects/magnet.h"
#include "haptics/effects/viscosity.h"

namespace palpate {

// One entry of a table: an effect with its parameters and its state.
struct EffectCall {
  EffectFunction apply;
  std::uint16_t effect;      // its number in compiled_effects()
  std::uint32_t parameters;  // their offset in bytes
  std::uint32_t state;       // offset of the effect's state in bytes
};

// A table: a range of consecutive calls.
struct EffectTable {
  std::uint32_t first = 0;
  std::uint32_t count = 0;
};

// The tables of one material, by stage.
struct EffectMaterial {
  std::array<EffectTable, kEffectStageCount> tables;
  bool without_effects = true;  // no table has an entry that runs in contact
};

// The materials of one body's surface.
struct EffectBody {
  const SurfaceAttributes* attributes = nullptr;  // null: the body has no effects
  std::uint32_t first_material = 0;  // position of part 0 in EffectProgram::material_of_part
};

// The effects of a scene and all data that they refer to. Immutable after compilation: each haptic
// loop has its own copy of the parameters and its own states. Pointers into the deques stay valid
// while elements are added and when the program is moved.
struct EffectProgram {
  std::vector<EffectCall> calls;
  std::vector<EffectMaterial> materials;  // material 0 has no effects
  std::vector<EffectBody> bodies;         // in the order of the world's bodies
  std::vector<std::uint32_t> material_of_part;
  EffectTable everywhere;  // surroundings: effects that are active everywhere
  EffectTable places;      // surroundings: effects that are active near an object
  std::vector<std::byte> parameters;
  std::size_t state_bytes = 0;
  std::uint32_t needs = kNeedsNothing;

  std::deque<SurfaceAttributes> attributes;
  std::deque<HeightMap> maps;
  std::deque<MagneticSurface> magnets;
  std::deque<MediumRegion> media;
  std::deque<SurfaceIndex> indices;  // of magnets and media that are not bodies

  std::uint32_t material(std::uint32_t body, std::uint32_t slot) const {
    const EffectBody& b = bodies[body];
    if (!b.attributes) return 0;
    return material_of_part[b.first_material + b.attributes->part_of(slot)];
  }
  std::span<const EffectCall> table(const EffectTable& t) const {
    return std::span(calls).subspan(t.first, t.count);
  }
  std::span<const EffectCall> table(std::uint32_t m, EffectStage stage) const {
    return table(materials[m].tables[static_cast<std::size_t>(stage)]);
  }
};

// Builds an effect program. Not thread-safe.
class EffectProgramBuilder {
 public:
  // An effect of a material, with its Parameters as bytes. The order of entries does not matter:
  // the builder sorts them.
  struct Entry {
    std::uint16_t effect;
    std::vector<std::byte> parameters;
  };

  EffectProgramBuilder();

  // Adds a material and returns its number; the first is 1. Entries of kSurroundings are moved to
  // the surroundings.
  std::uint32_t add_material(std::span<const Entry> entries);
  void add_surroundings(const Entry& entry);
  // Completes the program: appends the calls of the surroundings to those of the materials.
  EffectProgram finish() &&;

  EffectProgram program;  // the caller adds the data that the entries refer to

 private:
  EffectCall call_of(const Entry& entry);

  std::vector<EffectCall> everywhere_;
  std::vector<EffectCall> places_;
};

}  // namespace palpate
