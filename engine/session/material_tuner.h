#pragma once

// Changes material parameters during a session.

#include <array>
#include <atomic>
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

// Passes parameter values from an application to the haptic thread.
//
//     MaterialTuner tuner(scene);
//     const auto friction = tuner.add("wood", "dynamicFriction");  // before the session starts
//     HapticSession session(loop, device, {.changes = {&tuner}});
//     ...
//     tuner.set(*friction, 0.2);                                   // at any time, from one thread
//
// Values set before the session starts apply from the first tick on. A tuner serves one session.
class MaterialTuner final : public BeforeTick {
 public:
  // The scene must outlive the tuner.
  explicit MaterialTuner(const Scene& scene) : scene_(&scene) {}

  // Makes a parameter of a material adjustable and returns its handle. The handle changes the
  // parameter in all materials of this name and in all their combinations with physics and haptic
  // materials. Returns an error if the material or the key does not exist, if the material does not
  // declare the effect of the key, or if the value is fixed when the scene is compiled
  // (creaseAngle, solid). Allocates: call it before the session starts.
  Result<std::size_t> add(const std::string& material, const std::string& key);

  // Sets a value. Its unit is the unit of the key in a file; the value of a choice is the index of
  // the choice. Returns an error and changes nothing if the value is out of range or contradicts
  // the last values of the other parameters of the effect. Only one thread at a time may call
  // set(), even if the handles differ. Wait-free, except that an error allocates.
  std::optional<Error> set(std::size_t handle, double value);

  // Whether the haptic thread has not yet applied what was set. The thread that calls set() may
  // call it.
  bool is_pending() const;

  // Called on the haptic thread before a tick.
  void before_tick(double time_s, LoopChanges loop) noexcept override;

 private:
  static constexpr std::size_t kMostBytes = 64;

  // The parameters of one call of the effect program, as bytes that can be copied.
  struct Values {
    std::uint64_t number = 0;  // counts the calls of set()
    alignas(double) std::array<std::byte, kMostBytes> bytes{};
  };
  struct Mailbox {
    SnapshotRing<Values> values;
    std::atomic<std::uint64_t> applied{0};  // last Values::number that the haptic thread applied
  };
  struct Block {
    std::uint32_t call;
    std::uint16_t effect;
    Values set;  // last values of the application
    std::unique_ptr<Mailbox> mailbox;
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
