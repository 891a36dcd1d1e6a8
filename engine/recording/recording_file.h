#pragma once

// Writes the database of a recording.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "engine/recording/recording_meta.h"
#include "engine/recording/recording_schema.h"
#include "geometry/base/result.h"

namespace palpate {

// One recording while it is written. Does I/O; not for the haptic thread. One thread at a time may
// use it.
//
// The database uses a write-ahead log. It locks the file for itself, so that SQLite needs no
// shared memory: a mapped file on a disk that disappears would end the process by SIGBUS. After
// the death of the process, all committed transactions are in the file or in its log.
class RecordingFile {
 public:
  // Creates the file with its tables and `meta`. Returns an error if the file exists or cannot be
  // created; nothing is left then. file_system: SQLite's name of a file system layer, for tests;
  // null: the usual one. log_pages: the length of
  // the log at which it is copied into the file; 0: only at the end. version: of the format.
  static Result<RecordingFile> create(const std::string& path, const RecordingMeta& meta,
                                      const char* file_system = nullptr, int log_pages = 0,
                                      int version = kRecordingVersion);

  RecordingFile(RecordingFile&&) noexcept;
  RecordingFile& operator=(RecordingFile&&) noexcept;
  ~RecordingFile();  // leaves a recording without ending, as a crash does

  // Each of the following functions returns an error if the disk is full, the file is gone or an
  // operation fails. What was committed stays readable. If is_full(), smaller transactions may
  // still fit, after rollback(), and the ending does; otherwise the recording has ended.
  std::optional<Error> begin();
  // Replaces a block that begins with the same tick.
  std::optional<Error> add_block(std::int64_t first_tick, std::int64_t ticks,
                                 std::span<const std::byte> columns,
                                 std::span<const std::byte> inputs);
  std::optional<Error> add_event(std::int64_t tick, double time_s, const std::string& kind,
                                 const std::string& detail);
  std::optional<Error> set_meta(const RecordingMeta& meta);
  // Takes disk space for the transaction and for the rows behind it before anything is written.
  std::optional<Error> commit();
  // Takes the space that commit() takes. False if the disk lacks it.
  bool fits();
  // Undoes the open transaction, if there is one.
  void rollback();
  // The last error was a lack of disk space, or a limit of it.
  bool is_full() const;

  // Writes the ending. Disk space was kept for it. Call it once, outside of a transaction; only
  // close() may follow.
  std::optional<Error> add_ending(std::int64_t ticks, std::int64_t dropped, const std::string& why);
  // Makes the file one plain file without a log. False if the disk has no space for that: the log
  // then stays a part of the recording.
  bool close();

 private:
  struct State;
  explicit RecordingFile(std::unique_ptr<State> state);

  std::unique_ptr<State> state_;
};

}  // namespace palpate
