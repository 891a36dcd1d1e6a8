#pragma once

// What a haptic loop did, tick by tick, written as a table.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "geometry/base/result.h"
#include "geometry/base/types.h"

namespace palpate {

inline constexpr std::string_view kTraceColumns =
    "tick,t,device_x,device_y,device_z,goal_x,goal_y,goal_z,proxy_x,proxy_y,proxy_z,"
    "normal_x,normal_y,normal_z,force_x,force_y,force_z,contact,alpha_deg,"
    "q_w,q_x,q_y,q_z,o_x,o_y,o_z,friction,faults,step_ns";

// One line of a trace: one instant, before the elementary rotation of that tick.
struct TraceRow {
  std::uint64_t tick = 0;
  double time_s = 0.0;
  Vec3 device_m = Vec3::Zero();  // device frame
  Vec3 goal_scene_m = Vec3::Zero();
  Vec3 proxy_scene_m = Vec3::Zero();
  Vec3 normal_scene = Vec3::Zero();
  Vec3 force_device_N = Vec3::Zero();
  bool contact = false;
  double alpha_deg = 0.0;              // contact normal to actuated axes
  RigidTransform T_device_scene{};     // q and o
  std::string_view friction = "none";  // or "sticks", "slides": at most kMaxFrictionBytes
  // Names joined by "+", empty for none: letters and underscores, at most kMaxFaultBytes.
  std::string faults{};
  std::int64_t step_ns = 0;  // computing time of the tick
};

// What is longer is cut off.
inline constexpr std::size_t kMaxFrictionBytes = 16;
inline constexpr std::size_t kMaxFaultBytes = 512;

// Writes a trace: kTraceColumns, then a line for each row. Numbers have 17 significant digits,
// which give back the same double; decimals have a point in every locale; nan, inf and -inf stand
// for themselves, so the same rows give the same bytes.
//
// The file appears under its name when finish() succeeds, replacing what was there; until then the
// lines are in memory and in a file ".part" beside it that goes with the writer; one that a killed
// process has left goes with the next writer of that name. What is no regular file (a pipe, a
// terminal) is written to directly. Not for the haptic thread: it does I/O. One thread owns a
// writer.
class TraceWriter {
 public:
  // Fails where the file could not be created.
  static Result<TraceWriter> create(const std::string& path);

  TraceWriter(TraceWriter&&) noexcept;
  TraceWriter& operator=(TraceWriter&&) noexcept;
  ~TraceWriter();  // without finish(): leaves nothing behind

  // A failure to write shows in finish(). Rows after finish() are dropped.
  void add(const TraceRow& row);

  // Returns the number of rows; fails if any byte could not be written, and then leaves whatever
  // had the file's name as it was. To be called once.
  Result<std::size_t> finish();

 private:
  class Output;
  explicit TraceWriter(std::unique_ptr<Output> output);

  std::unique_ptr<Output> output_;  // null after finish()
  std::size_t row_count_ = 0;
};

}  // namespace palpate
