#pragma once

// What a scene calls for, compiled: tables of effects that a tick runs from front to back.

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

// One line of a table.
struct EffectCall {
  EffectFunction apply;
  std::uint16_t effect;      // its number in compiled_effects()
  std::uint32_t parameters;  // where they begin, in bytes
  std::uint32_t state;       // likewise
};

// A table: some consecutive calls.
struct EffectTable {
  std::uint32_t first = 0;
  std::uint32_t count = 0;
};

// The tables of one material, by stage.
struct EffectMaterial {
  std::array<EffectTable, kEffectStageCount> tables;
  bool without_effects = true;  // none of its tables has a line that contact runs
};

// The surface of one body: which material its parts have.
struct EffectBody {
  const SurfaceAttributes* attributes = nullptr;  // null: all of it is bare
  std::uint32_t first_material = 0;               // of part 0, in EffectProgram::material_of_part
};

// What the effects of a scene are, and all that they refer to. Immutable once it is compiled: each
// loop has its own copy of the parameters, and states of its own. Pointers into the deques stay
// valid while things are added, and when the program is moved.
struct EffectProgram {
  std::vector<EffectCall> calls;
  std::vector<EffectMaterial> materials;  // 0 is bare
  std::vector<EffectBody> bodies;         // as the world's
  std::vector<std::uint32_t> material_of_part;
  EffectTable everywhere;  // of the surroundings: not bound to a place
  EffectTable places;      // of the surroundings: felt within some distance of something
  std::vector<std::byte> parameters;
  std::size_t state_bytes = 0;
  std::uint32_t needs = kNeedsNothing;

  std::deque<SurfaceAttributes> attributes;
  std::deque<HeightMap> maps;
  std::deque<MagneticSurface> magnets;
  std::deque<MediumRegion> media;
  std::deque<SurfaceIndex> indices;  // of magnets and media that are no bodies

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

// Writes a program. Parameters are those of the effect, as bytes.
class EffectProgramBuilder {
 public:
  // The effects of a material; stages are sorted out here. Their order does not matter.
  struct Entry {
    std::uint16_t effect;
    std::vector<std::byte> parameters;
  };

  EffectProgramBuilder();

  // Returns its number, the first is 1. Entries of kSurroundings go to the surroundings.
  std::uint32_t add_material(std::span<const Entry> entries);
  void add_surroundings(const Entry& entry);
  // Ends the program: calls for the surroundings are put behind those of the materials.
  EffectProgram finish() &&;

  EffectProgram program;  // to be filled with what its entries refer to

 private:
  EffectCall call_of(const Entry& entry);

  std::vector<EffectCall> everywhere_;
  std::vector<EffectCall> places_;
};

}  // namespace palpate
