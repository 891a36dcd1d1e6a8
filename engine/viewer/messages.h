#pragma once

// The binary messages between the server of `view` and its page. Numbers are little-endian; floats
// are IEEE 754. Pure functions.
//
// state, 136 bytes, then the record, then 64 bytes a moving body, then two names in UTF-8: of the
// body and of the material that the tick touches; empty if there is none:
//   0 u16 kind 1, 2 u16 version, 4 u32 flags (ViewFlag), 8 u64 sequence of the newest pointer that
//   the tick used, 16 f64[3] target of the hand (device frame, m), 40 f64 when the server encoded
//   the message (s, on a clock of its own), 48 u32 bytes of the record, 52 u32 moving bodies,
//   56 u32 actuated axes, 60 u16 bytes of the body's name, 62 u16 bytes of the material's name,
//   64 f64[3][3] a basis of the actuated span (device frame)
//   a body: 0 u32 number, 4 u32 0, 8 f64[4] q wxyz, 40 f64[3] position m, both T_scene_body
// ticks, 24 bytes, then seven columns of N f32:
//   0 u16 kind 2, 2 u16 version, 4 u32 N, 8 f64 base time s, 16 u32 lost ticks, 20 u32 ticks a
//   group columns: time since the base s, contact angle deg (NaN without contact), depth m,
//   commanded force N, full force N, step us, contact
// pointer, from the page, 40 bytes:
//   0 u16 kind 16, 2 u16 version, 4 u32 buttons (1: holds, 2: the clutch is pressed), 8 u64
//   sequence, 16 f64[3] target (device frame, m)

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/viewer/tick_summary.h"
#include "geometry/base/result.h"
#include "palpate/record.h"

namespace palpate {

inline constexpr int kViewVersion = 4;

enum ViewFlag : std::uint32_t {
  kHandHasTarget = 1u << 0,
  kViewPaused = 1u << 1,
  kHandIsHeld = 1u << 2  // by a page
};

// The state after a tick.
struct ViewState {
  TickRecord record;
  std::uint64_t pointer = 0;  // sequence of the newest pointer message that the tick used; 0: none
  std::array<double, 3> target_m = {};             // device frame
  std::uint32_t flags = 0;                         // ViewFlag bits
  std::uint32_t axis_count = 0;                    // of the actuated span
  std::array<std::array<double, 3>, 3> axes = {};  // its basis, device frame
  // What the tick touches (Scene::body_name, material_name); must outlive the state. A message has
  // at most kMostTouchedNameBytes of each.
  std::string_view body_name, material_name;
};
inline constexpr std::size_t kMostTouchedNameBytes = 256;

// The pose of a moving body, T_scene_body.
struct BodyPose {
  std::uint32_t body = 0;
  std::array<double, 4> q_wxyz = {1, 0, 0, 0};
  std::array<double, 3> o_m = {};
};

// Where a page wants the hand.
struct PointerMessage {
  bool holds = false;
  std::uint64_t sequence = 0;           // > 0
  std::array<double, 3> target_m = {};  // finite, device frame
  bool is_clutched = false;             // the hand is set back; only `experiment live` uses it
};

// now_s: on a clock that runs while the server runs.
void encode_state(const ViewState& state, std::span<const BodyPose> bodies, double now_s,
                  std::string& out);

// rows: in the order of time. Rows of more than kMostChartTicksPerSecond ticks a second are
// thinned: each group of `group` ticks gives two rows, one with the smallest number of each column
// and one with the largest. The angle is that of ticks in contact, if there are any.
void encode_ticks(std::span<const TickSummary> rows, std::uint32_t lost, std::uint32_t group,
                  std::string& out);

// The size of the groups at this rate: 1, or such that a second has at most 2,000 rows.
std::uint32_t thinning_group(double rate_Hz);

// The error names the field of the message.
Result<PointerMessage> decode_pointer(std::string_view bytes);

}  // namespace palpate
