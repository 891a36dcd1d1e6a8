#pragma once

// The interface of haptic effects. An effect adds a property, such as friction or texture, to a
// surface or to a whole scene.
//
// Each effect is a struct in a header of its own, and both have its name: the effect "wood_grain"
// would be WoodGrainEffect. friction.h is a good example:
//
//     struct DragEffect {
//       static constexpr std::string_view kName = "drag";
//       static constexpr EffectStage kStage = EffectStage::kForceAdd;
//       static constexpr std::uint32_t kNeeds = kNeedsContact | kNeedsVelocity;
//       struct Parameters { double drag_Ns_per_m = 0.0; };  // doubles and pointers, as in State
//       struct State {};  // of one material in one loop; copied as bytes, so it has no Vec3
//       static constexpr ParameterKey kKeys[] = {...};      // the parameters' names in files
//       static const char* contradiction(const Parameters&) noexcept;  // a problem, or null
//       static bool apply(const Parameters&, State&, EffectTick&) noexcept;  // true if active
//       // with kNeedsPlace only (EffectDistance):
//       static double distance_m(const Parameters&, const State&, const EffectTick&) noexcept;
//     };
//
// CMake's list PALPATE_EFFECTS names the effects to build. The scene compiler writes one table per
// material, with the effects that the material declares, ordered by stage and then by that list. A
// tick runs only the tables of the materials it touches. An effect that no surface declares is in
// no table.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "geometry/base/types.h"
#include "haptics/effects/face_point.h"
#include "haptics/effects/virtual_coupling.h"
#include "haptics/proxy/friction_cone.h"
#include "haptics/proxy/work.h"

namespace palpate {

class LiveWorld;

// The stage of a tick in which an effect runs. Effects of one stage run in the order of
// PALPATE_EFFECTS.
enum class EffectStage : std::uint8_t {
  kSurface,       // sets the height, the slope and the normal of the surface
  kProxy,         // sets the friction that holds the proxy
  kForceMap,      // sets the spring and the damper that map the lag to a force
  kForceAdd,      // adds forces in contact
  kSurroundings,  // adds forces with or without contact
};
inline constexpr std::size_t kEffectStageCount = 5;

// The inputs that an effect needs. A tick computes the inputs of the union of these needs over all
// effects of the scene, and no others.
enum EffectNeed : std::uint32_t {
  kNeedsNothing = 0,
  kNeedsContact = 1u << 0,       // runs the tables of the materials in contact
  kNeedsStickSlip = 1u << 1,     // runs the god-object with friction
  kNeedsSurroundings = 1u << 2,  // runs the table of the surroundings
  kNeedsVelocity = 1u << 3,      // EffectTick::velocity_m_per_s
  // The remaining needs matter only while a scene is compiled:
  kNeedsCornerNormals = 1u << 4,  // FacePoint::corner_normals
  kNeedsTextureMap = 1u << 5,     // FacePoint::texture_uv, Parameters::map
  kNeedsFrictionMap = 1u << 6,    // FacePoint::friction_uv, Parameters::map, if the file has a map
  kNeedsPlace = 1u << 7,          // surroundings: active only near an object, and sets quiet_m
};
// The needs that matter in a tick.
inline constexpr std::uint32_t kTickNeeds =
    kNeedsContact | kNeedsStickSlip | kNeedsSurroundings | kNeedsVelocity;

// A face that the proxy touches: its body and its material.
struct Touch {
  std::uint32_t body = 0;
  std::uint32_t material = 0;  // number of the material in the effect program
  Vec3 normal = Vec3::Zero();  // unit, of the unshaded face; solver frame
};

// The inputs and outputs of an effect. Solver frame, SI units.
struct EffectTick {
  // Inputs. In the stages before kSurroundings they describe one contact and its material. In
  // kProxy only `face` and `normal` are set, because the proxy is still moving.
  double dt_s = 0.0;
  double ticks = 0.0;                    // number of good ticks before this one
  double steady_ticks = 0.0;             // the last of them, in a row, of the same dt
  double time_s = 0.0;                   // of this tick
  Vec3 proxy_m = Vec3::Zero();           // equals the device point without contact
  double radius_m = 0.0;                 // of the proxy
  Vec3 velocity_m_per_s = Vec3::Zero();  // of the device point; zero if unknown
  double longest_dt_s = 0.0;             // the longer of this tick's dt and the previous tick's;
                                         // measured times: this tick's
  bool has_measured_times = false;       // HapticLoop::use_measured_times()
  bool slid = false;                     // the proxy moved along the touched surface; often
                                         // true as well in the tick in which it comes there
  Vec3 normal = Vec3::Zero();            // unit contact normal; from kForceAdd on, the rendered one
  double share = 1.0;                    // this material's share of the contact force, (0, 1]
  FacePoint face;
  const LiveWorld* world = nullptr;
  // In kSurroundings: counts the searches of the effects and limits them. Null: no limit.
  WorkMeter* work = nullptr;
  std::span<const Touch> touches = {};  // in kSurroundings: all faces that the proxy touches

  // Outputs of kSurface. The surface is displaced by height_m along its normal; the tangential
  // vector `slope` is the gradient of that height along the surface (dimensionless).
  Vec3 rendered_normal = Vec3::Zero();  // unit; its initial value is `normal`
  double height_m = 0.0;                // <= 0, so that contact begins at the surface of the mesh
  Vec3 slope = Vec3::Zero();
  // Output of kProxy.
  FrictionCone cone;
  // Output of kForceMap; its initial value is the loop's coupling.
  CouplingSettings coupling;
  // Output of kForceAdd and kSurroundings: the force on the hand.
  Vec3 force_N = Vec3::Zero();
  // Output of an inactive kSurroundings effect: a distance that the proxy can move before the
  // effect may become active.
  double quiet_m = 0.0;
  // Output of kSurroundings: a search was left out or cut short because the work is spent.
  bool is_capped = false;
};

// A parameter that files can set.
struct ParameterKey {
  enum class Kind : std::uint8_t {
    kNumber,
    kChoice,  // a text; the value is its index in choices
  };
  enum class Role : std::uint8_t {
    kDeclares,  // a value other than zero declares the effect
    kRequired,  // must be given with the effect; declares an effect that has no kDeclares key
    kOptional,  // its default is the value in a default-constructed Parameters
  };
  std::string_view key;   // "staticFriction"
  std::string_view unit;  // "N/m"; "" if dimensionless
  double least;
  double most;
  std::size_t offset;  // of a double in Parameters, in bytes
  Role role = Role::kOptional;
  std::string_view what = "";     // description, in a few words
  bool scales_as_length = false;  // is multiplied by the scale of the scene
  bool least_is_excluded = false;
  Kind kind = Kind::kNumber;
  std::array<std::string_view, 2> choices = {};
};

// Runs an effect and returns true if the effect is active in this tick. parameters and state: the
// bytes of the effect's Parameters and State.
using EffectFunction = bool (*)(const std::byte* parameters, std::byte* state,
                                EffectTick& tick) noexcept;

// For an effect with kNeedsPlace: a lower bound of the distance of the proxy from the object near
// which the effect acts, m. If the work does not suffice for all places, the nearest come first.
using EffectDistance = double (*)(const std::byte* parameters, const std::byte* state,
                                  const EffectTick& tick) noexcept;

// The type-erased form of an effect, for the rest of the engine.
struct EffectType {
  std::string_view name;
  EffectStage stage;
  std::uint32_t needs;
  std::size_t parameter_bytes;
  std::size_t state_bytes;
  void (*begin_parameters)(std::byte* parameters) noexcept;  // writes the defaults
  void (*begin_state)(std::byte* state) noexcept;
  std::span<const ParameterKey> keys;
  const char* (*contradiction)(const std::byte* parameters) noexcept;
  EffectFunction apply;
  EffectDistance distance_m;  // of an effect with kNeedsPlace; otherwise null
};

// The compiled effects, in the order of PALPATE_EFFECTS; at most kMostEffects. An effect's number
// is its index in this list.
std::span<const EffectType> compiled_effects() noexcept;
inline constexpr std::size_t kMostEffects = 32;

}  // namespace palpate
