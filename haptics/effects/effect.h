#pragma once

// What an effect is: something a surface or a scene makes felt beyond bare contact.
//
// An effect is a struct in a header of its own (friction.h is a good one to begin with):
//
//     struct DragEffect {
//       static constexpr std::string_view kName = "drag";
//       static constexpr EffectStage kStage = EffectStage::kForceAdd;
//       static constexpr std::uint32_t kNeeds = kNeedsContact | kNeedsVelocity;
//       struct Parameters { double drag_Ns_per_m = 0.0; };  // doubles and pointers
//       struct State {};                                    // of one material in one loop
//       static constexpr ParameterKey kKeys[] = {...};      // what files call the parameters
//       static const char* contradiction(const Parameters&) noexcept;  // null if there is none
//       static bool apply(const Parameters&, State&, EffectTick&) noexcept;  // whether it is felt
//     };
//
// CMake's list PALPATE_EFFECTS names those that are built. Compiling a scene writes, for each
// material, a table of those it calls for, ordered by stage and then by that list; a tick runs the
// tables of what it touches. An effect that no surface calls for is in no table.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "geometry/base/types.h"
#include "haptics/effects/face_point.h"
#include "haptics/effects/virtual_coupling.h"
#include "haptics/proxy/friction_cone.h"

namespace palpate {

class LiveWorld;

// When in a tick an effect has its say. Within a stage, the order is that of PALPATE_EFFECTS.
enum class EffectStage : std::uint8_t {
  kSurface,       // where the surface is and which way it faces
  kProxy,         // what holds the proxy on it
  kForceMap,      // what force the proxy's lag makes
  kForceAdd,      // what is added to it in contact
  kSurroundings,  // what is added with or without contact
};
inline constexpr std::size_t kEffectStageCount = 5;

// What effects ask for. The union over a scene selects the step that its ticks run, so what no
// effect asks for is not computed.
enum EffectNeed : std::uint32_t {
  kNeedsNothing = 0,
  kNeedsContact = 1u << 0,       // the tables of the materials in contact are run
  kNeedsStickSlip = 1u << 1,     // the god-object that friction holds
  kNeedsSurroundings = 1u << 2,  // the table of the surroundings is run
  kNeedsVelocity = 1u << 3,      // EffectTick::velocity_m_per_s
  // The following count when a scene is compiled:
  kNeedsCornerNormals = 1u << 4,  // FacePoint::corner_normals
  kNeedsTextureMap = 1u << 5,     // FacePoint::texture_uv, Parameters::map
  kNeedsFrictionMap = 1u << 6,    // FacePoint::friction_uv, Parameters::map: if there is one
  kNeedsPlace = 1u << 7,          // of the surroundings: felt near something, tells quiet_m
};
// Those that select a step.
inline constexpr std::uint32_t kStepNeeds =
    kNeedsContact | kNeedsStickSlip | kNeedsSurroundings | kNeedsVelocity;

// A body that is touched, and by what it is felt.
struct Touch {
  std::uint32_t body = 0;
  std::uint32_t material = 0;  // of the effect program
  Vec3 normal = Vec3::Zero();  // unit, of the face itself; solver frame
};

// What an effect reads and writes. Solver frame, SI units.
struct EffectTick {
  // Read. In the stages before kSurroundings, of one contact and its material. In kProxy, `face`
  // and `normal` alone: the proxy is still on its way.
  double dt_s = 0.0;
  double ticks = 0.0;                    // good ones before this one
  Vec3 proxy_m = Vec3::Zero();           // equals the device point off contact
  double radius_m = 0.0;                 // of the proxy
  Vec3 velocity_m_per_s = Vec3::Zero();  // of the device point; zero where it is not known
  double longest_dt_s = 0.0;             // of this tick and the one before
  bool slid = false;                     // the proxy moved along what it touches
  Vec3 normal = Vec3::Zero();            // unit, of the contact; as felt from kForceAdd on
  double share = 1.0;                    // of the contact force that this material bears, (0, 1]
  FacePoint face;
  const LiveWorld* world = nullptr;
  std::span<const Touch> touches = {};  // for kSurroundings: all that the proxy touches

  // Written by kSurface. A surface is moved by height_m along its normal, whose slope over the
  // surface is the tangential vector `slope` (no unit).
  Vec3 rendered_normal = Vec3::Zero();  // unit; `normal` to begin with
  double height_m = 0.0;                // <= 0, so that the contact begins where the proxy meets it
  Vec3 slope = Vec3::Zero();
  // Written by kProxy.
  FrictionCone cone;
  // Written by kForceMap; those of the loop to begin with.
  CouplingSettings coupling;
  // Written by kForceAdd and kSurroundings: on the hand.
  Vec3 force_N = Vec3::Zero();
  // Written by kSurroundings when not felt: how far the proxy can move before it may be.
  double quiet_m = 0.0;
};

// A number that files can set.
struct ParameterKey {
  enum class Kind : std::uint8_t {
    kNumber,
    kChoice,  // a text; the number is its place in choices
  };
  enum class Role : std::uint8_t {
    kCallsFor,  // the effect is called for if this is given and not zero
    kRequired,  // must be given where the effect is called for
    kOptional,  // otherwise has the value that Parameters begin with
  };
  std::string_view key;   // "staticFriction"
  std::string_view unit;  // "N/m"; "" for none
  double least;
  double most;
  std::size_t offset;  // in bytes, of a double in Parameters
  Role role = Role::kOptional;
  std::string_view what = "";     // it is, in a few words
  bool scales_as_length = false;  // with the scene
  bool least_is_excluded = false;
  Kind kind = Kind::kNumber;
  std::array<std::string_view, 2> choices = {};
};

// Whether it is felt in this tick. parameters and state: the effect's own.
using EffectFunction = bool (*)(const std::byte* parameters, std::byte* state,
                                EffectTick& tick) noexcept;

// An effect as the rest of the engine sees it.
struct EffectType {
  std::string_view name;
  EffectStage stage;
  std::uint32_t needs;
  std::size_t parameter_bytes;
  std::size_t state_bytes;
  void (*begin_parameters)(std::byte* parameters) noexcept;  // writes those that it begins with
  void (*begin_state)(std::byte* state) noexcept;
  std::span<const ParameterKey> keys;
  const char* (*contradiction)(const std::byte* parameters) noexcept;
  EffectFunction apply;
};

// Those that are built, in the order of PALPATE_EFFECTS: at most kMostEffects. An effect's number
// is its place here.
std::span<const EffectType> compiled_effects() noexcept;
inline constexpr std::size_t kMostEffects = 32;

}  // namespace palpate
