#pragma once

// What one tick of haptic rendering was given, found and commanded. Needs the standard library
// alone.

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <type_traits>

namespace palpate {

// What a contact does under friction, from tick to tick (Harwin and Melder 2002).
enum class FrictionState : std::uint16_t {
  kNone,    // no contact, or with nothing that has friction
  kSticks,  // as every new contact
  kSlides   // also while the hand stands still: until its lag falls below that of the cone
};

// Fault bits of a tick. A fault never stops the loop; the next good sample carries on. The upper 16
// bits are those of a governor between loop and device.
enum Fault : std::uint32_t {
  kFaultNone = 0,
  kFaultNonFiniteSample = 1u << 0,  // NaN or infinite: zero force
  kFaultBadTimeStep = 1u << 1,      // no time step (is_time_step): zero force
  kFaultSolverCapped = 1u << 2,     // the proxy is feasible but may not be nearest; force is given
  kFaultJump = 1u << 3,         // farther than the scene is large, faster than a hand: zero force
  kFaultBodyHeld = 1u << 4,     // a body waits: the proxy is in its way and cannot give way
  kFaultBadBodyPose = 1u << 5,  // a pose was no pose, or far off, or one too many: not taken
  kFaultNonFiniteForce = 1u << 6,  // what came out is no force: zero force
  kFaultFarSample = 1u << 7,       // finite, but beyond farthest_sample_m(): zero force
  kFaultBadSettings = 1u << 8,     // check_settings() has an Error: zero force in every tick
  kFaultInvalidSample = 1u << 9,   // the device says that it has not sensed it: zero force
  kFaultBadActuation = 1u << 10    // motors were to change the plane of motion: not taken
};
inline constexpr int kFaultCount = 11;
inline constexpr std::array<std::string_view, kFaultCount> kFaultNames = {
    "non_finite_sample", "bad_time_step",  "solver_capped",    "jump",
    "body_held",         "bad_body_pose",  "non_finite_force", "far_sample",
    "bad_settings",      "invalid_sample", "bad_actuation"};
inline constexpr int kFirstGovernorFault = 16;
static_assert(kFaultCount <= kFirstGovernorFault);

// Faults of a tick that has no place or time: what was sensed is to count nowhere.
inline constexpr std::uint32_t kFaultsWithoutSample = kFaultNonFiniteSample | kFaultBadTimeStep |
                                                      kFaultFarSample | kFaultBadSettings |
                                                      kFaultInvalidSample;

// Faults for which a tick holds the last state and commands no force.
inline constexpr std::uint32_t kFaultsWithoutForce = kFaultsWithoutSample | kFaultJump;

// One instant: everything is as it was before the elementary rotation of that tick, but for the
// pose "after". Plain numbers, without padding, so that it can be copied as bits, to a file or to
// another program. A quaternion turns scene into device, w first.
//
// A bare HapticLoop leaves what is marked "session" at 0; HapticSession fills it.
struct TickRecord {
  std::uint64_t tick = 0;
  double time_s = 0.0;           // sum of the good dt before this tick
  double device_m[3] = {};       // device frame, as sensed
  double goal_scene_m[3] = {};   // the device point
  double proxy_scene_m[3] = {};  // equals goal off contact
  double normal_scene[3] = {};   // unit, as felt; zero off contact or where planes cancel
  double full_force_device_N[3] = {};
  double force_device_N[3] = {};           // commanded, acting on the hand
  double q_before_wxyz[4] = {1, 0, 0, 0};  // T_device_scene: how the scene was felt in this tick
  double o_before_m[3] = {};
  double q_after_wxyz[4] = {1, 0, 0, 0};  // likewise after the rotation: what a display shows
  double o_after_m[3] = {};
  double alpha_rad = 0.0;     // normal to actuated axes, [0, pi/2]; 0 off contact
  double rotation_rad = 0.0;  // by which A4 turns the scene after this tick
  std::int64_t step_ns = 0;   // session: computing time of the loop
  std::int64_t late_ns = 0;   // session: since the tick was due; 0 where nothing is due
  std::uint32_t faults = kFaultNone;
  std::uint32_t effects = 0;     // felt in this tick, a bit each by number in compiled_effects()
  std::uint32_t iterations = 0;  // of the solver
  std::uint16_t contact = 0;     // 1 or 0
  FrictionState friction = FrictionState::kNone;  // of the contact, in this tick
};

enum class FieldType : std::uint8_t { kUint64, kInt64, kDouble, kUint32, kUint16 };

// One member of TickRecord, for whoever writes, reads or shows it.
struct RecordField {
  std::string_view name;
  FieldType type;
  std::size_t count;        // of numbers
  std::string_view unit;    // "1" for none
  std::string_view frame;   // "device", "scene", both for a pose, or none
  std::size_t offset;       // bytes
  std::string_view column;  // of a trace: the name, or its stem, before "_x", "_y", "_z" or "_w"
  bool is_of_session;       // a bare loop leaves it at 0
  std::size_t bytes;        // of all its numbers
};

namespace record_table {

template <typename Number>
constexpr FieldType type_of() {
  if constexpr (std::is_same_v<Number, double>) return FieldType::kDouble;
  if constexpr (std::is_same_v<Number, std::uint64_t>) return FieldType::kUint64;
  if constexpr (std::is_same_v<Number, std::int64_t>) return FieldType::kInt64;
  if constexpr (std::is_same_v<Number, std::uint32_t>) return FieldType::kUint32;
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

// In the order of the bytes.
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
};
#undef PALPATE_FIELD
#undef PALPATE_AT

namespace record_table {

// Whether the fields cover the record from its first byte to its last, each once.
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
static_assert(sizeof(TickRecord) <= 320 && alignof(TickRecord) == 8);
static_assert(std::is_trivially_copyable_v<TickRecord> && std::is_standard_layout_v<TickRecord>);

}  // namespace palpate
