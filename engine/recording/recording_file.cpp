#include "engine/recording/recording_file.h"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

#include "engine/recording/log_space.h"
#include "engine/recording/recording_schema.h"
#include "engine/recording/sqlite_handles.h"
#include "engine/report/output_lock.h"

namespace palpate {
namespace {

constexpr std::uint64_t kPageBytes = 4096;
// The file format of SQLite's log.
constexpr std::uint64_t kLogHeaderBytes = 32;
constexpr std::uint64_t kFrameBytes = kPageBytes + 24;
// What a transaction changes beside the pages of its rows: the first page of the file, the list of
// free pages, and for each of two tables the last leaf and the pages above it.
constexpr std::uint64_t kPagesPerTransaction = 12;
// Kept behind each transaction, for the last events and for the ending, which change a few pages
// and one page.
constexpr std::uint64_t kKeptPages = 8;

// Of a recording without ticks, and of its log.
constexpr std::uint64_t kPagesOfEmpty = 16;

// Of a short row, beside its texts.
constexpr std::uint64_t kBytesOfNumbers = 32;

// The pages of short rows of this length together, one of which may be new in the tree. A page
// holds at least half of its bytes after it was split.
std::uint64_t pages_of(std::uint64_t bytes) {
  return 2 + bytes / (kPageBytes / 2);
}
// The same for a long row, whose pages behind the first are full.
std::uint64_t pages_of_block(std::uint64_t bytes) {
  constexpr std::uint64_t kBytesOfLink = 4;
  return 2 + bytes / (kPageBytes - kBytesOfLink);
}

// A name like ":memory:" must be a file.
std::string file_name(const std::string& path) {
  return path.starts_with('/') ? path : "./" + path;
}

// Creates an empty file, unless one exists.
std::optional<Error> create_empty(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor >= 0) {
    ::close(descriptor);
    return std::nullopt;
  }
  const bool exists = errno == EEXIST;
  const std::string problem = exists ? "exists; expected the name of a new file"
                                     : std::string("cannot be created: ") + std::strerror(errno);
  return Error{ErrorCode::kFileUnwritable, path, "", problem,
               exists ? "remove the file or choose another name" : ""};
}

void remove_all(const std::string& path) {
  for (const char* ending : {"-wal", "-journal", ""}) ::unlink((path + ending).c_str());
}

// A limit of the size of files or of a user's space acts like a full disk.
bool is_of_full_disk(int reason) {
  return reason == ENOSPC || reason == EFBIG || reason == EDQUOT;
}

bool bind_value(sqlite3_stmt* statement, int index, const MetaValue& value) {
  if (const auto* integer = std::get_if<std::int64_t>(&value)) {
    return sqlite3_bind_int64(statement, index, *integer) == SQLITE_OK;
  }
  if (const auto* number = std::get_if<double>(&value)) {
    return sqlite3_bind_double(statement, index, *number) == SQLITE_OK;
  }
  const auto& text = std::get<std::string>(value);
  return sqlite3_bind_text(statement, index, text.data(), static_cast<int>(text.size()),
                           SQLITE_TRANSIENT) == SQLITE_OK;
}

bool bind_value(sqlite3_stmt* statement, int index, std::span<const std::byte> bytes) {
  return sqlite3_bind_blob64(statement, index, bytes.data(), bytes.size(), SQLITE_STATIC) ==
         SQLITE_OK;
}

}  // namespace

struct RecordingFile::State {
  std::string path;
  int version = kRecordingVersion;
  OutputLock folder;  // of the file
  ino_t inode = 0;
  Database database;
  Statement block, event, meta;
  int log_pages = 0;
  LogSpace log;
  std::uint64_t frames = 0;       // of the log
  std::uint64_t dirty_pages = 0;  // that the open transaction changes at most, without short rows
  std::uint64_t row_bytes = 0;    // of its short rows
  bool is_full = false;

  // reason: the system's, or one that says nothing of a full disk.
  Error full_error(int reason) const {
    std::string problem = "cannot be written: the disk is full";
    if (is_of_full_disk(reason)) problem += std::string(": ") + std::strerror(reason);
    return {ErrorCode::kFileUnwritable, path, "", std::move(problem),
            "free disk space, or record on another disk"};
  }
  Error error() {
    const int code = sqlite3_errcode(database.get());
    const int system = sqlite3_system_errno(database.get());
    is_full =
        (code & 0xff) == SQLITE_FULL || ((code & 0xff) == SQLITE_IOERR && is_of_full_disk(system));
    if (is_full) return full_error(system);
    return {ErrorCode::kFileUnwritable, path, "",
            "cannot be written: " + sqlite_problem(database.get()), ""};
  }
  std::optional<Error> run(const char* sql) {
    if (sqlite3_exec(database.get(), sql, nullptr, nullptr, nullptr) == SQLITE_OK) {
      return std::nullopt;
    }
    return error();
  }
  // Runs a statement whose values are bound.
  std::optional<Error> step(const Statement& statement, bool is_bound) {
    if (!is_bound || sqlite3_step(statement.get()) != SQLITE_DONE) {
      Error failed = error();
      sqlite3_reset(statement.get());
      return failed;
    }
    sqlite3_reset(statement.get());
    return std::nullopt;
  }
  // A removed file can be written to without an error, but nobody would ever read it.
  std::optional<Error> check_place() const {
    struct stat now {};
    if (::stat(path.c_str(), &now) == 0 && now.st_ino == inode) return std::nullopt;
    return Error{ErrorCode::kFileUnwritable, path, "", "was removed or replaced", ""};
  }
  // Takes disk space for the open transaction and `kept` pages behind it.
  std::optional<Error> reserve(std::uint64_t kept) {
    const std::uint64_t pages = frames + dirty_pages + pages_of(row_bytes) + kept;
    const int failed = log.reserve(kLogHeaderBytes + pages * kFrameBytes);
    if (failed == 0) return std::nullopt;
    is_full = is_of_full_disk(failed);
    if (is_full) return full_error(failed);
    return Error{ErrorCode::kFileUnwritable, path, "",
                 std::string("cannot be written: ") + std::strerror(failed), ""};
  }
  std::optional<Error> commit(std::uint64_t kept) {
    if (auto failed = check_place()) return failed;
    if (auto failed = reserve(kept)) return failed;
    return run("COMMIT");
  }
  // Copies a long log into the file; the next transaction then begins the log again. If that fails,
  // the log grows on.
  void copy_long_log() {
    if (log_pages <= 0 || frames < static_cast<std::uint64_t>(log_pages)) return;
    int in_log = 0, copied = 0;
    const int code = sqlite3_wal_checkpoint_v2(database.get(), nullptr, SQLITE_CHECKPOINT_PASSIVE,
                                               &in_log, &copied);
    if (code == SQLITE_OK && in_log == copied) frames = 0;
  }
  std::optional<Error> check_space() const;
  std::optional<Error> open(const char* file_system);
  std::optional<Error> make_tables();
};

// Before SQLite writes: its errors do not always have the system's reason.
std::optional<Error> RecordingFile::State::check_space() const {
  LogSpace space(path);
  const int failed = space.reserve(kPagesOfEmpty * kPageBytes);
  space.cut(0);
  if (!is_of_full_disk(failed)) return std::nullopt;
  return full_error(failed);
}

std::optional<Error> RecordingFile::State::open(const char* file_system) {
  struct stat created {};
  if (::stat(path.c_str(), &created) != 0) return error();
  inode = created.st_ino;
  sqlite3* opened = nullptr;
  const int code = sqlite3_open_v2(
      file_name(path).c_str(), &opened,
      SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_PRIVATECACHE, file_system);
  database.reset(opened);
  if (code != SQLITE_OK) return error();
  sqlite3_extended_result_codes(opened, 1);
  // The lock must be exclusive before the log is first used. Commits are not synchronised with the
  // disk: they must survive the death of the process, not of the machine.
  // Pages are written by commits only, whose space is taken before.
  if (auto failed = run("PRAGMA page_size=4096; PRAGMA mmap_size=0; PRAGMA temp_store=MEMORY; "
                        "PRAGMA cache_spill=OFF; "
                        "PRAGMA locking_mode=EXCLUSIVE; PRAGMA journal_mode=WAL; "
                        "PRAGMA synchronous=NORMAL")) {
    return failed;
  }
  return make_tables();
}

std::optional<Error> RecordingFile::State::make_tables() {
  if (auto failed = run("BEGIN")) return failed;
  const std::string marks = "PRAGMA application_id=" + std::to_string(kRecordingApplication) +
                            "; PRAGMA user_version=" + std::to_string(version);
  if (auto failed = run(marks.c_str())) return failed;
  for (const RecordingTable& table : kRecordingTables) {
    if (auto failed = run(table.sql)) return failed;
  }
  if (auto failed = run("COMMIT")) return failed;
  block = prepare(database.get(), "INSERT OR REPLACE INTO block VALUES (?, ?, ?, ?)");
  event = prepare(database.get(), "INSERT INTO event VALUES (?, ?, ?, ?)");
  meta = prepare(database.get(), "INSERT OR REPLACE INTO meta VALUES (?, ?)");
  if (!block || !event || !meta) return error();
  return std::nullopt;
}

RecordingFile::RecordingFile(std::unique_ptr<State> state) : state_(std::move(state)) {}
RecordingFile::RecordingFile(RecordingFile&&) noexcept = default;
RecordingFile& RecordingFile::operator=(RecordingFile&&) noexcept = default;
RecordingFile::~RecordingFile() = default;

Result<RecordingFile> RecordingFile::create(const std::string& path, const RecordingMeta& meta,
                                            const char* file_system, int log_pages, int version) {
  auto folder = OutputLock::take_for_file(path);
  if (!folder) return folder.error();
  if (auto error = create_empty(path)) return *error;
  RecordingFile file(std::make_unique<State>());
  file.state_->path = path;
  file.state_->version = version;
  file.state_->folder = std::move(*folder);
  auto error = file.state_->check_space();
  if (!error) error = file.state_->open(file_system);
  file.state_->log_pages = log_pages;
  if (!error) {
    file.state_->log = LogSpace(path + "-wal");
    // In place of SQLite's own hook, which copies a long log.
    sqlite3_wal_hook(
        file.state_->database.get(),
        [](void* state, sqlite3*, const char*, int frames) {
          static_cast<State*>(state)->frames = static_cast<std::uint64_t>(frames);
          return SQLITE_OK;
        },
        file.state_.get());
    error = file.begin();
  }
  if (!error) error = file.set_meta(meta);
  if (!error) error = file.state_->run("COMMIT");
  // The file itself, not its log alone, says from here on that it is a recording.
  if (!error) error = file.state_->run("PRAGMA wal_checkpoint(TRUNCATE)");
  if (!error) {
    file.state_->frames = 0;
    file.state_->dirty_pages = 0;
    file.state_->row_bytes = 0;
    error = file.state_->reserve(kKeptPages);
  }
  if (!error) return file;
  file.state_.reset();
  remove_all(path);
  return *error;
}

std::optional<Error> RecordingFile::begin() {
  state_->dirty_pages = kPagesPerTransaction;
  state_->row_bytes = 0;
  return state_->run("BEGIN IMMEDIATE");
}

std::optional<Error> RecordingFile::commit() {
  if (auto error = state_->commit(kKeptPages)) return error;
  state_->copy_long_log();
  return std::nullopt;
}

bool RecordingFile::fits() {
  return !state_->reserve(kKeptPages);
}

void RecordingFile::rollback() {
  if (sqlite3_get_autocommit(state_->database.get()) == 0) {
    sqlite3_exec(state_->database.get(), "ROLLBACK", nullptr, nullptr, nullptr);
  }
}

bool RecordingFile::is_full() const {
  return state_->is_full;
}

std::optional<Error> RecordingFile::add_block(std::int64_t first_tick, std::int64_t ticks,
                                              std::span<const std::byte> columns,
                                              std::span<const std::byte> inputs) {
  state_->dirty_pages += pages_of_block(columns.size() + inputs.size());
  sqlite3_stmt* statement = state_->block.get();
  const bool is_bound = sqlite3_bind_int64(statement, 1, first_tick) == SQLITE_OK &&
                        sqlite3_bind_int64(statement, 2, ticks) == SQLITE_OK &&
                        bind_value(statement, 3, columns) && bind_value(statement, 4, inputs);
  return state_->step(state_->block, is_bound);
}

std::optional<Error> RecordingFile::add_event(std::int64_t tick, double time_s,
                                              const std::string& kind, const std::string& detail) {
  state_->row_bytes += kind.size() + detail.size() + kBytesOfNumbers;
  sqlite3_stmt* statement = state_->event.get();
  const bool is_bound = sqlite3_bind_int64(statement, 1, tick) == SQLITE_OK &&
                        sqlite3_bind_double(statement, 2, time_s) == SQLITE_OK &&
                        bind_value(statement, 3, MetaValue(kind)) &&
                        bind_value(statement, 4, MetaValue(detail));
  return state_->step(state_->event, is_bound);
}

std::optional<Error> RecordingFile::set_meta(const RecordingMeta& meta) {
  for (const auto& [key, value] : meta) {
    const auto* text = std::get_if<std::string>(&value);
    state_->row_bytes += key.size() + (text ? text->size() : 0) + kBytesOfNumbers;
    sqlite3_stmt* statement = state_->meta.get();
    const bool is_bound =
        bind_value(statement, 1, MetaValue(key)) && bind_value(statement, 2, value);
    if (auto error = state_->step(state_->meta, is_bound)) return error;
  }
  return std::nullopt;
}

std::optional<Error> RecordingFile::add_ending(std::int64_t ticks, std::int64_t dropped,
                                               const std::string& why) {
  const Statement ending = prepare(state_->database.get(), "INSERT INTO ending VALUES (?, ?, ?)");
  if (!ending) return state_->error();
  if (auto error = begin()) return error;
  const bool is_bound = sqlite3_bind_int64(ending.get(), 1, ticks) == SQLITE_OK &&
                        sqlite3_bind_int64(ending.get(), 2, dropped) == SQLITE_OK &&
                        bind_value(ending.get(), 3, MetaValue(why));
  if (auto error = state_->step(ending, is_bound)) return error;
  // The space was kept by the transaction before; another program cannot have taken it.
  if (auto error = state_->check_place()) return error;
  return state_->run("COMMIT");
}

bool RecordingFile::close() {
  // Statements must not be open when the log is removed.
  state_->block.reset();
  state_->event.reset();
  state_->meta.reset();
  state_->log.cut(kLogHeaderBytes + state_->frames * kFrameBytes);
  const bool is_plain =
      !state_->run("PRAGMA wal_checkpoint(TRUNCATE); PRAGMA journal_mode=DELETE").has_value();
  state_.reset();
  return is_plain;
}

}  // namespace palpate
