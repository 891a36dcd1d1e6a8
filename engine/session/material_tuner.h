#pragma once

// Materials that an application changes while the hand feels them.

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/devices/snapshot_ring.h"
#include "engine/scene/scene.h"
#include "engine/session/haptic_session.h"
#include "geometry/base/result.h"

namespace palpate {

// Values on their way from an application to the haptic thread.
//
//     MaterialTuner tuner(scene);
//     const auto friction = tuner.add("wood", "dynamicFriction");  // before the session starts
//     HapticSession session(loop, device, {.changes = {&tuner}});
//     ...
//     tuner.set(*friction, 0.2);                                   // at any time, from one thread
//
// What was set before the session starts holds from its first tick on. A tuner serves one session.
class MaterialTuner final : public BeforeTick {
 public:
  // The scene must outlive the tuner.
  explicit MaterialTuner(const Scene& scene) : scene_(&scene) {}

  // Makes a value of a material adjustable, and returns its handle; all materials of this name
  // change together, in whatever combination with others the scene has them. An error if there is
  // no such material or key, if the effect of the key is not compiled into the material, or if the
  // value is built into something else: creaseAngle, solid. Allocates: before the session starts.
  Result<std::size_t> add(const std::string& material, const std::string& key);

  // value: in the unit of the key, as in a file; of a choice, its place. What is out of range, or
  // contradicts another value of the same effect as it was set last, is an Error, and then nothing
  // is changed. Otherwise wait-free; one thread at a time for all handles. (An Error allocates.)
  std::optional<Error> set(std::size_t handle, double value);

  // On the haptic thread, before a tick.
  void before_tick(double time_s, HapticLoop& loop) noexcept override;

 private:
  static constexpr std::size_t kMostBytes = 64;

  // Parameters of one call of the effect program, as bytes that can be copied.
  struct Values {
    std::uint64_t number = 0;  // of sets so far
    alignas(double) std::array<std::byte, kMostBytes> bytes{};
  };
  struct Block {
    std::uint32_t call;
    std::uint16_t effect;
    Values set;               // the application's
    std::uint64_t taken = 0;  // the haptic thread's
    std::unique_ptr<SnapshotRing<Values>> mailbox;
  };
  struct Handle {
    std::string material;
    const ParameterKey* key;
    std::vector<std::size_t> blocks;
  };

  std::size_t block_of(std::uint32_t call);

  const Scene* scene_;
  std::vector<Block> blocks_;
  std::vector<Handle> handles_;
};

}  // namespace palpate
