#pragma once

// The record of one tick of haptic rendering: the sample, the contact that was found and the force
// that was commanded. This header depends only on the standard library.

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <type_traits>

namespace palpate {

// The state of a contact under friction, kept from tick to tick (Harwin and Melder 2002).
enum class FrictionState : std::uint16_t {
  kNone,  // no contact, or no touched surface has friction
  // The contact keeps its place until the tangential lag exceeds the static limit. Every new
  // contact starts in this state.
  kSticks,
  // The contact slides until the tangential lag falls below the dynamic limit. Until then the state
  // stays kSlides, even while the hand is at rest.
  kSlides
};

// Fault bits of a tick. A fault never stops the loop: rendering continues with the next good
// sample. The upper 16 bits are 0 and reserved.
enum Fault : std::uint32_t {
  kFaultNone = 0,
  kFaultNonFiniteSample = 1u << 0,  // the position is NaN or infinite: zero force
  kFaultBadTimeStep = 1u << 1,      // dt is not a valid time step (is_time_step): zero force
  // The solver reached its limit of steps or of work. The proxy is feasible, but more steps might
  // have moved it nearer to the goal. Its force is commanded nevertheless.
  kFaultSolverCapped = 1u << 2,
  // The position moved farther than the scene's size and faster than a hand can: zero force.
  kFaultJump = 1u << 3,
  kFaultBodyHeld = 1u << 4,  // a moving body was stopped by a proxy that could not give way
  // A new pose of a body was ignored: the body does not exist, the pose is not rigid or too far
  // away, or too many bodies move.
  kFaultBadBodyPose = 1u << 5,
  kFaultNonFiniteForce = 1u << 6,  // the computed force was not finite: zero force
  kFaultFarSample = 1u << 7,       // the position is farther than farthest_sample_m(): zero force
  kFaultBadSettings = 1u << 8,     // reserved: no tick has it; recordings of older versions may
  kFaultInvalidSample = 1u << 9,   // the device marked the sample as invalid: zero force
  kFaultBadActuation = 1u << 10,   // new motor axes were ignored: they need other sensed axes
  // The work of magnets and media reached its limit. The nearest were computed; the force is
  // commanded.
  kFaultEffectsCapped = 1u << 11
};
inline constexpr int kFaultCount = 12;
inline constexpr std::array<std::string_view, kFaultCount> kFaultNames = {
    "non_finite_sample", "bad_time_step",  "solver_capped",    "jump",
    "body_held",         "bad_body_pose",  "non_finite_force", "far_sample",
    "bad_settings",      "invalid_sample", "bad_actuation",    "effects_capped"};
static_assert(kFaultCount <= 16);

// The rules of the safety governor that acted on the force of a tick, as bits of
// TickRecord::rules. haptics/safety_governor.h defines each rule.
enum GovernorRule : std::uint32_t {
  kRuleBadSample = 1u << 0,  // a motor's force is zero because the sample is bad
  kRuleMotors = 1u << 1,     // the motors cannot push a part of the force, which was dropped
  kRulePeak = 1u << 2,       // a motor would have exceeded its peak force
  kRuleClamp = 1u << 3,      // the force would have exceeded the largest force
  kRuleSlew = 1u << 4,       // the force would have grown too fast
  kRuleSpeed = 1u << 5,      // the device moved too fast: a trip
  kRuleStale = 1u << 6,      // the newest sample is too old: zero force
  kRuleOrder = 1u << 7,      // a sample older than the last one was ignored
  kRuleLate = 1u << 8,       // the tick came too late: zero force
  kRuleWorkspace = 1u << 9,  // the device is outside its workspace
  kRuleEase = 1u << 10,      // the force returns after an interruption
  kRuleStart = 1u << 11,     // the force waits for a calm hand, or begins to grow
  kRuleTripped = 1u << 12,   // no force until rearm(), but for kRuleRelease
  kRuleDamping = 1u << 13,   // the passivity controller has damped the motion
  kRuleSoft = 1u << 14,      // damping did not suffice: the contact is less stiff
  kRuleRestart = 1u << 15,   // the spring starts from what the hand has put in
  kRuleHeat = 1u << 16,      // a motor is too warm for the force
  kRuleRelease = 1u << 17    // after a trip, the force that resists the motion falls
};
inline constexpr int kGovernorRuleCount = 18;
inline constexpr std::array<std::string_view, kGovernorRuleCount> kGovernorRuleNames = {
    "bad_sample", "motors", "peak",  "clamp",   "slew",    "speed", "stale",   "order", "late",
    "workspace",  "ease",   "start", "tripped", "damping", "soft",  "restart", "heat",  "release"};
static_assert(kGovernorRuleCount <= 32);

// Each of these faults means that a tick has no usable position or time step. The sample of such a
// tick must not be evaluated.
inline constexpr std::uint32_t kFaultsWithoutSample = kFaultNonFiniteSample | kFaultBadTimeStep |
                                                      kFaultFarSample | kFaultBadSettings |
                                                      kFaultInvalidSample;

// A tick with one of these faults keeps the state of the tick before it and commands zero force.
inline constexpr std::uint32_t kFaultsWithoutForce = kFaultsWithoutSample | kFaultJump;

// What TickRecord::body and TickRecord::material contain in place of a number.
inline constexpr std::int32_t kNothingTouched = -1;
inline constexpr std::int32_t kTouchUnknown = -2;  // in a recording older than the member

// The bits of TickRecord::touch: an event for sounds and logs. Only the ticks in which something
// begins or ends have one.
//
// A tick touches if it is in contact (TickRecord::contact) and has none of kFaultsWithoutForce. A
// touch begins in a tick that touches and that is the first one or follows a tick that does not
// touch; it ends in a tick that does not touch and follows one that does. Therefore both alternate
// in the records of a loop, and a touch begins first. A bad sample ends a touch; it begins again in
// the next good tick in contact. A paused session runs no tick, so that a touch lasts through a
// pause. A change from one body to another without a tick between them changes `body` only.
enum TouchEvent : std::uint16_t { kTouchBegan = 1u << 0, kTouchEnded = 1u << 1 };

// The record of one tick. All fields describe the state before the elementary rotation of that
// tick; only q_after and o_after describe the state after it. The struct holds plain numbers
// without padding, so that its bytes can be copied to a file or to another program. Quaternions are
// stored in the order w, x, y, z and rotate vectors from the scene frame to the device frame.
//
// HapticLoop leaves the fields marked "session" at 0; HapticSession sets them, `rules` by its
// governor.
struct TickRecord {
  std::uint64_t tick = 0;        // the number of the tick, from 0 on
  double time_s = 0.0;           // the sum of all valid dt after the first tick
  double device_m[3] = {};       // the sensed position
  double goal_scene_m[3] = {};   // the device point in the scene
  double proxy_scene_m[3] = {};  // the proxy; equals the goal without contact
  double normal_scene[3] = {};   // unit, after the effects; zero: no contact, or normals cancel
  double full_force_device_N[3] = {};      // before the projection onto the actuated axes
  double force_device_N[3] = {};           // commanded, acting on the hand
  double q_before_wxyz[4] = {1, 0, 0, 0};  // the rotation of T_device_scene during this tick
  double o_before_m[3] = {};               // the scene's origin during this tick
  double q_after_wxyz[4] = {1, 0, 0, 0};   // the rotation after A4 has turned, for the display
  double o_after_m[3] = {};                // the scene's origin after A4 has turned
  // The contact angle between the normal and the actuated axes, [0, pi/2]; 0: no contact.
  double alpha_rad = 0.0;
  double rotation_rad = 0.0;          // the angle by which A4 turns the scene after this tick
  std::int64_t step_ns = 0;           // session: computing time of the loop
  std::int64_t late_ns = 0;           // session: start minus due time; 0 if ticks are not scheduled
  std::uint32_t faults = kFaultNone;  // bits of Fault
  std::uint32_t effects = 0;          // bit n: effect n of compiled_effects() was active
  std::uint32_t iterations = 0;       // the number of solver steps
  std::uint16_t contact = 0;          // 1 in contact, else 0
  FrictionState friction = FrictionState::kNone;  // the state of the contact under friction
  std::uint32_t rules = 0;                        // session: bits of GovernorRule
  // The body, an index into Scene::objects(), of the contact that bears the largest share of the
  // lag from the goal to the proxy (bearing_parts in haptics/proxy/plane_projection.h). Of equal
  // shares, the one with the lowest body counts, then the one with the lowest material.
  // Scene::body_name() and material_name() turn both numbers into names. kNothingTouched (-1): the
  // tick does not touch (TouchEvent), no face holds the proxy in a capped tick, or the face has no
  // material. kTouchUnknown (-2): the recording is older than the member.
  std::int32_t body = kNothingTouched;
  std::int32_t material = kNothingTouched;  // of the same contact: an index into Scene::materials()
  // The number of contacts, which are the faces that hold the proxy: at most 3. 0 if `body` is
  // kNothingTouched.
  std::uint16_t contacts = 0;
  std::uint16_t touch = 0;  // bits of TouchEvent
};

enum class FieldType : std::uint8_t { kUint64, kInt64, kDouble, kUint32, kUint16, kInt32 };

// Describes one member of TickRecord to code that writes, reads or displays records.
struct RecordField {
  std::string_view name;
  FieldType type;
  std::size_t count;       // how many numbers the member has
  std::string_view unit;   // "1": dimensionless
  std::string_view frame;  // "device", "scene", "device from scene" for a rotation, or ""
  std::size_t offset;      // in bytes
  // The column's name in a trace; a vector's columns append "_x", "_y", "_z" (and "_w") to it.
  std::string_view column;
  bool is_of_session;  // measured by a clock of HapticSession; HapticLoop leaves the member at 0
  std::size_t bytes;   // size of the member
};

namespace record_table {

template <typename Number>
constexpr FieldType type_of() {
  if constexpr (std::is_same_v<Number, double>) return FieldType::kDouble;
  if constexpr (std::is_same_v<Number, std::uint64_t>) return FieldType::kUint64;
  if constexpr (std::is_same_v<Number, std::int64_t>) return FieldType::kInt64;
  if constexpr (std::is_same_v<Number, std::uint32_t>) return FieldType::kUint32;
  if constexpr (std::is_same_v<Number, std::int32_t>) return FieldType::kInt32;
  if constexpr (sizeof(Number) == sizeof(std::uint16_t)) return FieldType::kUint16;
}

template <typename Member>
constexpr RecordField field(std::string_view name, std::string_view unit, std::string_view frame,
                            std::size_t offset, std::string_view column, bool of_session = false) {
  using Number = std::remove_all_extents_t<Member>;
  return {
      name,       type_of<Number>(), sizeof(Member) / sizeof(Number), unit, frame, offset, column,
      of_session, sizeof(Member)};
}

}  // namespace record_table

// The members in the order of their offsets.
#define PALPATE_FIELD(name, ...) record_table::field<decltype(TickRecord::name)>(#name, __VA_ARGS__)
#define PALPATE_AT(name) offsetof(TickRecord, name)
inline constexpr std::array kRecordFields = {
    PALPATE_FIELD(tick, "1", "", PALPATE_AT(tick), "tick"),
    PALPATE_FIELD(time_s, "s", "", PALPATE_AT(time_s), "t"),
    PALPATE_FIELD(device_m, "m", "device", PALPATE_AT(device_m), "device"),
    PALPATE_FIELD(goal_scene_m, "m", "scene", PALPATE_AT(goal_scene_m), "goal"),
    PALPATE_FIELD(proxy_scene_m, "m", "scene", PALPATE_AT(proxy_scene_m), "proxy"),
    PALPATE_FIELD(normal_scene, "1", "scene", PALPATE_AT(normal_scene), "normal"),
    PALPATE_FIELD(full_force_device_N, "N", "device", PALPATE_AT(full_force_device_N),
                  "full_force"),
    PALPATE_FIELD(force_device_N, "N", "device", PALPATE_AT(force_device_N), "force"),
    PALPATE_FIELD(q_before_wxyz, "1", "device from scene", PALPATE_AT(q_before_wxyz), "q"),
    PALPATE_FIELD(o_before_m, "m", "device", PALPATE_AT(o_before_m), "o"),
    PALPATE_FIELD(q_after_wxyz, "1", "device from scene", PALPATE_AT(q_after_wxyz), "q_after"),
    PALPATE_FIELD(o_after_m, "m", "device", PALPATE_AT(o_after_m), "o_after"),
    PALPATE_FIELD(alpha_rad, "rad", "", PALPATE_AT(alpha_rad), "alpha_deg"),
    PALPATE_FIELD(rotation_rad, "rad", "", PALPATE_AT(rotation_rad), "rotation_deg"),
    PALPATE_FIELD(step_ns, "ns", "", PALPATE_AT(step_ns), "step_ns", true),
    PALPATE_FIELD(late_ns, "ns", "", PALPATE_AT(late_ns), "late_ns", true),
    PALPATE_FIELD(faults, "1", "", PALPATE_AT(faults), "faults"),
    PALPATE_FIELD(effects, "1", "", PALPATE_AT(effects), "effects"),
    PALPATE_FIELD(iterations, "1", "", PALPATE_AT(iterations), "iterations"),
    PALPATE_FIELD(contact, "1", "", PALPATE_AT(contact), "contact"),
    PALPATE_FIELD(friction, "1", "", PALPATE_AT(friction), "friction"),
    PALPATE_FIELD(rules, "1", "", PALPATE_AT(rules), "rules"),
    PALPATE_FIELD(body, "1", "", PALPATE_AT(body), "body"),
    PALPATE_FIELD(material, "1", "", PALPATE_AT(material), "material"),
    PALPATE_FIELD(contacts, "1", "", PALPATE_AT(contacts), "contacts"),
    PALPATE_FIELD(touch, "1", "", PALPATE_AT(touch), "touch"),
};
#undef PALPATE_FIELD
#undef PALPATE_AT

namespace record_table {

// True if the fields cover every byte of the record exactly once, in order.
constexpr bool covers_record() {
  std::size_t next = 0;
  for (const RecordField& field : kRecordFields) {
    if (field.offset != next) return false;
    next += field.bytes;
  }
  return next == sizeof(TickRecord);
}

}  // namespace record_table

static_assert(record_table::covers_record());
static_assert(sizeof(TickRecord) == 336 && alignof(TickRecord) == 8);
static_assert(std::is_trivially_copyable_v<TickRecord> && std::is_standard_layout_v<TickRecord>);

}  // namespace palpate
