#pragma once

// Records a session while it runs.

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "engine/recording/recording_meta.h"
#include "engine/session/tick_sink.h"
#include "geometry/base/result.h"

namespace palpate {

struct RecorderSettings {
  double rate_Hz = 1000.0;  // of the ticks
  // Ticks run as fast as possible. A full ring makes the session wait in place of dropping ticks,
  // and equal sessions give equal blocks.
  bool virtual_time = false;
  // SQLite's name of a file system layer, for tests; null: the usual one.
  const char* file_system = nullptr;
  // Of the rings. At the usual values, the disk may stand still for 8 s.
  double seconds = 8.0;
  std::size_t input_bytes = std::size_t{16} << 20;
};

// What a recording has become.
struct RecordingResult {
  std::string path;
  std::uint64_t ticks = 0;     // in the file
  std::uint64_t dropped = 0;   // ticks for which a ring had no space
  std::uint64_t bytes = 0;     // of the file and of a log that stays
  std::optional<Error> error;  // why the recording ended before the session
  // The disk has no space to copy the log, PATH-wal, into the file. It is a part of the recording.
  bool has_log = false;
};

// The reason in the ending of a recording that ended before its session because its disk was full.
inline constexpr const char* kDiskFull = "disk full";

// Writes one session into one file. The owner of a session creates a recorder, passes it to the
// session as SessionParts::sink, and calls finish() after the last tick.
//
// The haptic thread copies each tick into rings that are allocated and touched by create(), and
// never waits (except in virtual time). A thread of the recorder compresses and writes, one
// transaction every 250 ms. If the disk is full or the file cannot be written, the recording ends
// and the session goes on. A full disk keeps all ticks that fit, and the ending kDiskFull, whose
// space was taken before.
class Recorder final : public TickSink {
 public:
  // Creates the file. Returns an error if it exists or cannot be created, or if memory is missing.
  static Result<std::unique_ptr<Recorder>> create(const std::string& path,
                                                  const RecordingMeta& meta,
                                                  const RecorderSettings& settings);
  ~Recorder() override;  // finishes with the reason "abandoned"
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  void on_start(const SessionFacts& facts) noexcept override;
  void on_input(const TickInput& input) noexcept override;
  void on_tick(const TickRecord& record, const TickReading& reading) noexcept override;
  void on_trip(const GovernorTrip& trip) noexcept override;
  void on_late(LateCause cause, const TickCost& cost) noexcept override;

  // Adds a row to the table of events, of the first tick or of the newest one. Any thread but the
  // haptic one may call it before finish(). Throws std::bad_alloc.
  enum class EventTime : std::uint8_t { kStart, kNow };
  void add_event(const std::string& kind, const std::string& detail, EventTime time);

  // Writes all that was handed over, and the ending, unless the disk was full before. why: "end",
  // or what ended the session. Call it once, after the last tick, on the owner's thread.
  RecordingResult finish(const std::string& why);

  // The recording has ended because of an error. Any thread may call it.
  bool has_failed() const noexcept { return has_failed_.load(std::memory_order_acquire); }
  // What the recording has ended of; no value while it goes on. Any thread may call it before
  // finish().
  std::optional<std::string> failure() const;
  // The number of ticks that were dropped so far. Any thread may call it.
  std::uint64_t dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }

 private:
  struct State;
  explicit Recorder(std::unique_ptr<State> state);

  void drop_tick() noexcept;
  bool wait_for_space() const noexcept;
  void run() noexcept;
  void write();

  std::unique_ptr<State> state_;
  bool waits_;  // in virtual time
  bool is_tick_lost_ = false;
  std::uint64_t tick_ = 0;  // the last one
  double time_s_ = 0.0;
  std::atomic<bool> has_failed_{false};
  std::atomic<std::uint64_t> dropped_{0};
  std::thread thread_;
};

}  // namespace palpate
