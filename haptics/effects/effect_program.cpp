#include "haptics/effects/effect_program.h"

#include <algorithm>
#include <utility>

namespace palpate {
namespace {

constexpr std::size_t kAlignment = alignof(double);

std::size_t aligned(std::size_t bytes) {
  return (bytes + kAlignment - 1) / kAlignment * kAlignment;
}

}  // namespace

EffectProgramBuilder::EffectProgramBuilder() {
  program.materials.emplace_back();
}

EffectCall EffectProgramBuilder::call_of(const Entry& entry) {
  const EffectType& type = compiled_effects()[entry.effect];
  EffectCall call{type.apply, entry.effect, static_cast<std::uint32_t>(program.parameters.size()),
                  static_cast<std::uint32_t>(program.state_bytes)};
  program.parameters.insert(program.parameters.end(), entry.parameters.begin(),
                            entry.parameters.end());
  program.parameters.resize(aligned(program.parameters.size()));
  program.state_bytes = aligned(program.state_bytes + type.state_bytes);
  program.needs |= type.needs;
  return call;
}

std::uint32_t EffectProgramBuilder::add_material(std::span<const Entry> entries) {
  const auto types = compiled_effects();
  std::vector<Entry> sorted(entries.begin(), entries.end());
  std::stable_sort(sorted.begin(), sorted.end(), [&](const Entry& a, const Entry& b) {
    if (types[a.effect].stage != types[b.effect].stage) {
      return types[a.effect].stage < types[b.effect].stage;
    }
    return a.effect < b.effect;
  });
  EffectMaterial material;
  for (const Entry& entry : sorted) {
    const EffectStage stage = types[entry.effect].stage;
    if (stage == EffectStage::kSurroundings) {
      add_surroundings(entry);
      continue;
    }
    EffectTable& table = material.tables[static_cast<std::size_t>(stage)];
    if (table.count == 0) table.first = static_cast<std::uint32_t>(program.calls.size());
    program.calls.push_back(call_of(entry));
    ++table.count;
    material.without_effects = false;
  }
  program.materials.push_back(material);
  return static_cast<std::uint32_t>(program.materials.size() - 1);
}

void EffectProgramBuilder::add_surroundings(const Entry& entry) {
  const bool is_everywhere = (compiled_effects()[entry.effect].needs & kNeedsPlace) == 0;
  (is_everywhere ? everywhere_ : places_).push_back(call_of(entry));
}

EffectProgram EffectProgramBuilder::finish() && {
  for (const auto& [calls, table] :
       {std::pair(&everywhere_, &program.everywhere), std::pair(&places_, &program.places)}) {
    *table = {static_cast<std::uint32_t>(program.calls.size()),
              static_cast<std::uint32_t>(calls->size())};
    program.calls.insert(program.calls.end(), calls->begin(), calls->end());
  }
  return std::move(program);
}

}  // namespace palpate
