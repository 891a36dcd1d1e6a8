#include "engine/recording/recording_reader.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <string_view>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>
#include <utility>
#include <zstd.h>

#include "engine/recording/read_only_files.h"
#include "engine/recording/recording_schema.h"
#include "engine/recording/sqlite_handles.h"
#include "geometry/base/file_roles.h"
#include "geometry/base/printable.h"
#include "io/open_error.h"

namespace palpate {
namespace {

constexpr std::string_view kMagic("SQLite format 3", 16);  // with the zero behind it
constexpr std::size_t kHeaderBytes = 100;
constexpr std::size_t kJournalAt = 18;  // the file format write version
constexpr unsigned char kHasLog = 2;    // write-ahead log
constexpr std::size_t kVersionAt = 60;
constexpr std::size_t kApplicationAt = 68;

// Longer than any value of a recording: an inputs frame of kMostBlockInputBytes that cannot be
// compressed.
constexpr int kMostValueBytes = static_cast<int>(kMostBlockInputBytes) + (1 << 20);
constexpr int kMostSqlBytes = 4096;
constexpr std::size_t kMostMetaRows = 20000;
constexpr std::size_t kMostMetaBytes = std::size_t{4} << 20;
// SQLite's own steps for one row of a result: a few; a row at the end of a long search: hundreds.
constexpr int kStepsBetweenChecks = 1000;
constexpr int kMostChecks = 100;

class ReadDescriptor {
 public:
  explicit ReadDescriptor(const std::string& path)
      : descriptor_(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC | O_NOCTTY)) {}
  ~ReadDescriptor() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  ReadDescriptor(const ReadDescriptor&) = delete;
  ReadDescriptor& operator=(const ReadDescriptor&) = delete;
  int get() const { return descriptor_; }

 private:
  int descriptor_;
};

using Header = std::array<unsigned char, kHeaderBytes>;

bool read_header(int descriptor, Header& header) {
  const ssize_t got = ::pread(descriptor, header.data(), header.size(), 0);
  return got == static_cast<ssize_t>(header.size()) &&
         std::memcmp(header.data(), kMagic.data(), kMagic.size()) == 0;
}

bool is_ours(const Header& header) {
  return big_endian(&header[kApplicationAt], 4) == kRecordingApplication;
}

// SQLite's locks lie in these bytes. Only a process that has the file open for writing locks them.
bool is_locked(int descriptor) {
  constexpr off_t kPendingByte = 0x40000000;
  constexpr off_t kLockBytes = 512;
  struct flock lock {};
  lock.l_type = F_RDLCK;
  lock.l_whence = SEEK_SET;
  lock.l_start = kPendingByte;
  lock.l_len = kLockBytes;
  return ::fcntl(descriptor, F_GETLK, &lock) == 0 && lock.l_type != F_UNLCK;
}

std::uint64_t size_of(const std::string& path) {
  struct stat status {};
  return ::stat(path.c_str(), &status) == 0 ? static_cast<std::uint64_t>(status.st_size) : 0;
}

// The log lies beside the file itself, not beside a link to it.
std::string resolved(const std::string& path) {
  std::error_code failed;
  const auto file = std::filesystem::canonical(path, failed);
  return failed ? path : file.string();
}

// is_plain: SQLite ignores logs and journals.
std::string uri_of(const std::string& path, bool is_plain) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string uri = "file:";
  for (const char c : path) {
    const auto byte = static_cast<unsigned char>(c);
    uri += '%';
    uri += kDigits[byte >> 4];
    uri += kDigits[byte & 15];
  }
  return uri + (is_plain ? "?immutable=1" : "");
}

std::string text_at(sqlite3_stmt* statement, int column) {
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement, column));
  const int bytes = sqlite3_column_bytes(statement, column);
  return text ? std::string(text, static_cast<std::size_t>(bytes)) : std::string();
}

std::vector<std::byte> blob_at(sqlite3_stmt* statement, int column) {
  const auto* bytes = static_cast<const std::byte*>(sqlite3_column_blob(statement, column));
  const int count = sqlite3_column_bytes(statement, column);
  return bytes ? std::vector<std::byte>(bytes, bytes + count) : std::vector<std::byte>();
}

}  // namespace

bool is_recording(const std::string& path) {
  const ReadDescriptor file(path);
  struct stat status {};
  if (file.get() < 0 || ::fstat(file.get(), &status) != 0 || !S_ISREG(status.st_mode)) return false;
  Header header;
  return read_header(file.get(), header) && is_ours(header);
}

struct RecordingReader::State {
  std::string path;
  std::uint64_t bytes = 0;
  bool has_log = false;
  bool lacks_log = false;
  int version = kRecordingVersion;
  Database database;
  int checks = 0;  // of the running statement

  Error error(std::string problem, std::string hint = "") const {
    return {ErrorCode::kInvalidContent, path, "", printable(problem), std::move(hint)};
  }
  Error sqlite_error() const {
    return error("cannot be read: " + sqlite_problem(database.get()),
                 "`palpate recording repair` copies what is left");
  }
  std::optional<Error> open();
  std::optional<Error> limit();
  std::optional<Error> check_tables();
  std::optional<Error> read_meta(RecordingMeta& meta);
  // Null: sqlite_error().
  Statement prepared(const char* sql) {
    checks = 0;
    return prepare(database.get(), sql);
  }
  int step(const Statement& statement) {
    checks = 0;
    return sqlite3_step(statement.get());
  }
  static int check_progress(void* state) {
    return ++static_cast<State*>(state)->checks > kMostChecks ? 1 : 0;
  }
};

std::optional<Error> RecordingReader::State::open() {
  const ReadDescriptor file(path);
  if (file.get() < 0) return open_error(path, errno);
  struct stat status {};
  if (::fstat(file.get(), &status) != 0 || !S_ISREG(status.st_mode)) {
    return error("is not a regular file");
  }
  Header header;
  if (!read_header(file.get(), header) || !is_ours(header)) {
    return error("is not a recording; expected a file that `--record` has written");
  }
  const std::uint32_t stated = big_endian(&header[kVersionAt], 4);
  if (stated < 1 || stated > kRecordingVersion) {
    return error("has the format version " + std::to_string(stated) + "; expected 1 to " +
                 std::to_string(kRecordingVersion));
  }
  version = static_cast<int>(stated);
  if (is_locked(file.get())) {
    return error("is being recorded", "wait until the recording has ended");
  }
  // A closed recording is one plain file. SQLite would use any log beside it.
  const bool may_have_log = header[kJournalAt] == kHasLog;
  const std::string name = resolved(path);
  const std::uint64_t log_bytes = may_have_log ? size_of(name + "-wal") : 0;
  has_log = log_bytes > 0;
  std::error_code ignored;
  lacks_log = may_have_log && !std::filesystem::exists(name + "-wal", ignored);
  bytes = static_cast<std::uint64_t>(status.st_size) + log_bytes;
  sqlite3* opened = nullptr;
  const int code = sqlite3_open_v2(
      uri_of(name, !may_have_log).c_str(), &opened,
      SQLITE_OPEN_READONLY | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_PRIVATECACHE | SQLITE_OPEN_URI,
      read_only_files());
  database.reset(opened);
  if (code != SQLITE_OK) return sqlite_error();
  if (auto failed = limit()) return failed;
  return check_tables();
}

// The limits of everything that SQLite does with this file.
std::optional<Error> RecordingReader::State::limit() {
  sqlite3* db = database.get();
  int ignored = 0;
  sqlite3_db_config(db, SQLITE_DBCONFIG_DEFENSIVE, 1, &ignored);
  sqlite3_db_config(db, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, &ignored);
  sqlite3_db_config(db, SQLITE_DBCONFIG_ENABLE_TRIGGER, 0, &ignored);
  sqlite3_db_config(db, SQLITE_DBCONFIG_ENABLE_VIEW, 0, &ignored);
  sqlite3_limit(db, SQLITE_LIMIT_LENGTH, kMostValueBytes);
  sqlite3_limit(db, SQLITE_LIMIT_SQL_LENGTH, kMostSqlBytes);
  sqlite3_limit(db, SQLITE_LIMIT_COLUMN, 16);
  sqlite3_limit(db, SQLITE_LIMIT_EXPR_DEPTH, 20);
  sqlite3_limit(db, SQLITE_LIMIT_COMPOUND_SELECT, 2);
  sqlite3_limit(db, SQLITE_LIMIT_VDBE_OP, 10000);
  sqlite3_limit(db, SQLITE_LIMIT_FUNCTION_ARG, 8);
  sqlite3_limit(db, SQLITE_LIMIT_ATTACHED, 0);
  sqlite3_limit(db, SQLITE_LIMIT_TRIGGER_DEPTH, 1);
  sqlite3_progress_handler(db, kStepsBetweenChecks, check_progress, this);
  // The index of a log lies in this process only under an exclusive lock. 2 MiB of pages.
  if (sqlite3_exec(db,
                   "PRAGMA locking_mode=EXCLUSIVE; PRAGMA mmap_size=0; PRAGMA cache_size=-2048; "
                   "PRAGMA cell_size_check=ON; PRAGMA temp_store=MEMORY; PRAGMA query_only=ON",
                   nullptr, nullptr, nullptr) != SQLITE_OK) {
    return sqlite_error();
  }
  return std::nullopt;
}

// No view, trigger or index, and no table but ours.
std::optional<Error> RecordingReader::State::check_tables() {
  const Statement all = prepared("SELECT type, name, sql FROM sqlite_schema");
  if (!all) return sqlite_error();
  std::array<bool, kRecordingTables.size()> is_there{};
  int code = step(all);
  for (; code == SQLITE_ROW; code = step(all)) {
    const std::string type = text_at(all.get(), 0);
    const std::string name = text_at(all.get(), 1);
    const std::string sql = text_at(all.get(), 2);
    bool is_known = false;
    for (std::size_t i = 0; i < kRecordingTables.size(); ++i) {
      const RecordingTable& table = kRecordingTables[i];
      if (type != "table" || name != table.name || sql != table.sql || is_there[i]) continue;
      is_known = is_there[i] = true;
    }
    if (!is_known) {
      return error("has the " + type.substr(0, 20) + " \"" + name.substr(0, 60) +
                   "\"; expected the tables of a recording only");
    }
  }
  if (code != SQLITE_DONE) return sqlite_error();
  for (std::size_t i = 0; i < is_there.size(); ++i) {
    if (!is_there[i]) {
      return error("has no table \"" + std::string(kRecordingTables[i].name) + "\" of a recording");
    }
  }
  return std::nullopt;
}

RecordingReader::RecordingReader(std::unique_ptr<State> state) : state_(std::move(state)) {}
RecordingReader::RecordingReader(RecordingReader&&) noexcept = default;
RecordingReader& RecordingReader::operator=(RecordingReader&&) noexcept = default;
RecordingReader::~RecordingReader() = default;

Result<RecordingReader> RecordingReader::open(const std::string& path) {
  for (const char* const ending : {"", "-wal"}) {  // the recording, and the log beside it
    if (auto error = add_input(path + ending)) return *error;
  }
  RecordingReader reader(std::make_unique<State>());
  reader.state_->path = path;
  if (auto error = reader.state_->open()) return *error;
  return reader;
}

// Reads rows until the end or an error, which is returned.
std::optional<Error> RecordingReader::State::read_meta(RecordingMeta& meta) {
  const Statement rows = prepared("SELECT key, value FROM meta");
  if (!rows) return sqlite_error();
  std::size_t length = 0;
  int code = step(rows);
  for (; code == SQLITE_ROW; code = step(rows)) {
    const std::string key = text_at(rows.get(), 0);
    length += key.size() + static_cast<std::size_t>(sqlite3_column_bytes(rows.get(), 1));
    if (meta.size() == kMostMetaRows || length > kMostMetaBytes) {
      return error("has more settings than a recording");
    }
    switch (sqlite3_column_type(rows.get(), 1)) {
      case SQLITE_INTEGER:
        meta[key] = static_cast<std::int64_t>(sqlite3_column_int64(rows.get(), 1));
        break;
      case SQLITE_FLOAT:
        meta[key] = sqlite3_column_double(rows.get(), 1);
        break;
      case SQLITE_TEXT:
        meta[key] = text_at(rows.get(), 1);
        break;
      default:
        return error("has a setting that is neither number nor text: " + key.substr(0, 60));
    }
  }
  if (code != SQLITE_DONE) return sqlite_error();
  return std::nullopt;
}

Result<RecordingMeta> RecordingReader::meta() const {
  RecordingMeta meta;
  if (auto error = state_->read_meta(meta)) return *error;
  return meta;
}

RecordingMeta RecordingReader::readable_meta() const {
  RecordingMeta meta;
  state_->read_meta(meta);
  return meta;
}

Result<std::optional<RecordedEnding>> RecordingReader::ending() const {
  const Statement row = state_->prepared("SELECT ticks, dropped, why FROM ending LIMIT 1");
  if (!row) return state_->sqlite_error();
  const int code = state_->step(row);
  if (code == SQLITE_DONE) return std::optional<RecordedEnding>();
  if (code != SQLITE_ROW) return state_->sqlite_error();
  return std::optional<RecordedEnding>({sqlite3_column_int64(row.get(), 0),
                                        sqlite3_column_int64(row.get(), 1),
                                        printable(text_at(row.get(), 2).substr(0, 200))});
}

Result<std::vector<EventRow>> RecordingReader::events(std::size_t most) const {
  const Statement rows = state_->prepared("SELECT tick, time, kind, detail FROM event");
  if (!rows) return state_->sqlite_error();
  std::vector<EventRow> events;
  int code = SQLITE_DONE;
  while (events.size() < most && (code = state_->step(rows)) == SQLITE_ROW) {
    events.push_back({static_cast<std::uint64_t>(sqlite3_column_int64(rows.get(), 0)),
                      sqlite3_column_double(rows.get(), 1),
                      printable(text_at(rows.get(), 2).substr(0, 60)),
                      printable(text_at(rows.get(), 3).substr(0, 200))});
  }
  if (code != SQLITE_DONE && code != SQLITE_ROW) return state_->sqlite_error();
  return events;
}

Result<std::optional<std::int64_t>> RecordingReader::next_block(std::int64_t first_tick) const {
  const Statement row = state_->prepared(
      "SELECT first_tick FROM block WHERE first_tick >= ? ORDER BY first_tick LIMIT 1");
  if (!row) return state_->sqlite_error();
  sqlite3_bind_int64(row.get(), 1, first_tick);
  const int code = state_->step(row);
  if (code == SQLITE_DONE) return std::optional<std::int64_t>();
  if (code != SQLITE_ROW) return state_->sqlite_error();
  const std::int64_t found = sqlite3_column_int64(row.get(), 0);
  // A broken tree may lead anywhere.
  if (found < first_tick) return state_->error("has blocks that are not in order");
  return std::optional<std::int64_t>(found);
}

Result<std::optional<std::int64_t>> RecordingReader::last_block() const {
  const Statement row =
      state_->prepared("SELECT first_tick FROM block ORDER BY first_tick DESC LIMIT 1");
  if (!row) return state_->sqlite_error();
  const int code = state_->step(row);
  if (code == SQLITE_DONE) return std::optional<std::int64_t>();
  if (code != SQLITE_ROW) return state_->sqlite_error();
  return std::optional<std::int64_t>(sqlite3_column_int64(row.get(), 0));
}

Result<std::int64_t> RecordingReader::block_ticks(std::int64_t first_tick) const {
  const Statement row = state_->prepared("SELECT ticks FROM block WHERE first_tick = ?");
  if (!row) return state_->sqlite_error();
  sqlite3_bind_int64(row.get(), 1, first_tick);
  if (state_->step(row) != SQLITE_ROW) return state_->sqlite_error();
  return sqlite3_column_int64(row.get(), 0);
}

Result<RecordedBlock> RecordingReader::block(std::int64_t first_tick) const {
  const Statement lengths = state_->prepared(
      "SELECT ticks, length(columns), length(inputs) FROM block WHERE first_tick = ?");
  const Statement frames =
      state_->prepared("SELECT columns, inputs FROM block WHERE first_tick = ?");
  if (!lengths || !frames) return state_->sqlite_error();
  sqlite3_bind_int64(lengths.get(), 1, first_tick);
  sqlite3_bind_int64(frames.get(), 1, first_tick);
  if (state_->step(lengths) != SQLITE_ROW) return state_->sqlite_error();
  RecordedBlock block;
  block.first_tick = first_tick;
  block.ticks = sqlite3_column_int64(lengths.get(), 0);
  const auto columns = static_cast<std::uint64_t>(sqlite3_column_int64(lengths.get(), 1));
  const auto inputs = static_cast<std::uint64_t>(sqlite3_column_int64(lengths.get(), 2));
  // Frames longer than the file come from pages that are used several times.
  if (columns > state_->bytes || inputs > state_->bytes ||
      columns > ZSTD_COMPRESSBOUND(kMostBlockTicks * sizeof(RecordedTick))) {
    return state_->error("has a block that is too long, at tick " + std::to_string(first_tick));
  }
  if (state_->step(frames) != SQLITE_ROW) return state_->sqlite_error();
  block.columns = blob_at(frames.get(), 0);
  block.inputs = blob_at(frames.get(), 1);
  return block;
}

std::uint64_t RecordingReader::bytes() const {
  return state_->bytes;
}
bool RecordingReader::has_log() const {
  return state_->has_log;
}

bool RecordingReader::lacks_log() const {
  return state_->lacks_log;
}
int RecordingReader::version() const {
  return state_->version;
}
const std::string& RecordingReader::path() const {
  return state_->path;
}

}  // namespace palpate
