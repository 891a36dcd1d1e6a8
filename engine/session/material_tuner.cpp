#include "engine/session/material_tuner.h"

#include <algorithm>
#include <cassert>
#include <cstring>

#include "engine/scene/material_parameters.h"

namespace palpate {
namespace {

// Keys whose values determine corner normals and bodies when a scene is compiled.
constexpr std::string_view kFixedKeys[] = {"creaseAngle", kSolidKey};

const ParameterKey* find_key(std::uint16_t effect, const std::string& key) {
  for (const ParameterKey& k : compiled_effects()[effect].keys) {
    if (k.key == key) return &k;
  }
  return nullptr;
}

Error refused(const std::string& material, const std::string& key, std::string problem) {
  return {ErrorCode::kInvalidArgument, "", material + "." + key, std::move(problem), ""};
}

}  // namespace

Result<std::size_t> MaterialTuner::add(const std::string& material, const std::string& key) {
  if (std::find(std::begin(kFixedKeys), std::end(kFixedKeys), key) != std::end(kFixedKeys)) {
    return refused(material, key,
                   "cannot change during a session: its value is fixed when the scene is compiled");
  }
  Handle handle{material, nullptr, {}};
  bool is_known = false;
  for (const MaterialCalls& m : scene_->material_calls()) {
    if (m.material != material) continue;
    is_known = true;
    for (const std::uint32_t call : m.calls) {
      const ParameterKey* k = find_key(scene_->world().effects->calls[call].effect, key);
      if (!k) continue;
      handle.key = k;
      handle.blocks.push_back(block_of(call));
    }
  }
  if (!is_known) return refused(material, key, "belongs to a material that no surface has");
  if (!handle.key) {
    const auto names = effect_key_names();
    const auto name = std::find_if(names.begin(), names.end(),
                                   [&](const EffectKeyName& n) { return n.key == key; });
    return refused(material, key,
                   name == names.end()
                       ? std::string("is not a key of an effect")
                       : "requires the effect " + std::string(name->effect) +
                             ", which the material does not declare; declare it in the file");
  }
  handles_.push_back(std::move(handle));
  return handles_.size() - 1;
}

std::size_t MaterialTuner::block_of(std::uint32_t call) {
  const auto known = std::find_if(blocks_.begin(), blocks_.end(),
                                  [&](const Block& block) { return block.call == call; });
  if (known != blocks_.end()) return static_cast<std::size_t>(known - blocks_.begin());
  const EffectProgram& program = *scene_->world().effects;
  const std::uint16_t effect = program.calls[call].effect;
  const std::size_t bytes = compiled_effects()[effect].parameter_bytes;
  assert(bytes <= kMostBytes);
  blocks_.push_back({call, effect, {}, std::make_unique<Mailbox>()});
  std::copy_n(program.parameters.begin() + program.calls[call].parameters, bytes,
              blocks_.back().set.bytes.begin());
  return blocks_.size() - 1;
}

std::optional<Error> MaterialTuner::set(std::size_t handle, double value) {
  const Handle& h = handles_[handle];
  const ParameterKey& key = *h.key;
  const bool is_choice = key.kind == ParameterKey::Kind::kChoice;
  const bool is_in_range = value >= key.least && value <= key.most &&
                           !(key.least_is_excluded && value == key.least) &&
                           !(is_choice && value != 0.0 && value != 1.0);
  if (!is_in_range) {
    return parameter_error("material \"" + h.material + "\"",
                           {std::string(key.key), value, h.material + "." + std::string(key.key)},
                           expected_text(key));
  }
  const double number = value * (key.scales_as_length ? scene_->statistics().scale : 1.0);
  const auto changed = [&](const Block& block) {
    auto bytes = block.set.bytes;
    std::memcpy(bytes.data() + key.offset, &number, sizeof number);
    return bytes;
  };
  for (const std::size_t b : h.blocks) {
    alignas(double) const auto bytes = changed(blocks_[b]);
    if (const char* contradiction =
            compiled_effects()[blocks_[b].effect].contradiction(bytes.data())) {
      return refused(h.material, std::string(key.key), contradiction);
    }
  }
  for (const std::size_t b : h.blocks) {
    blocks_[b].set.bytes = changed(blocks_[b]);
    ++blocks_[b].set.number;
    blocks_[b].mailbox->values.publish(blocks_[b].set);
  }
  return std::nullopt;
}

bool MaterialTuner::is_pending() const {
  return std::any_of(blocks_.begin(), blocks_.end(), [](const Block& block) {
    return block.mailbox->applied.load(std::memory_order_acquire) != block.set.number;
  });
}

void MaterialTuner::before_tick(double /*time_s*/, LoopChanges loop) noexcept {
  for (Block& block : blocks_) {
    Values values;
    std::atomic<std::uint64_t>& applied = block.mailbox->applied;
    if (!block.mailbox->values.read(values)) continue;
    if (values.number == applied.load(std::memory_order_relaxed)) continue;
    loop.set_effect_parameters(
        block.call,
        std::span(values.bytes).first(compiled_effects()[block.effect].parameter_bytes));
    applied.store(values.number, std::memory_order_release);
  }
}

}  // namespace palpate
