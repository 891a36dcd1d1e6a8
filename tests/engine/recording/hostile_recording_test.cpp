// Recordings that were cut, changed, or made by an attacker.

#include <algorithm>
#include <cctype>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <malloc.h>
#include <map>
#include <sqlite3.h>
#include <string>
#include <vector>
#include <zstd.h>

#include <gtest/gtest.h>

#include "engine/recording/block_codec.h"
#include "engine/recording/recording_check.h"
#include "engine/recording/recording_file.h"
#include "engine/recording/recording_reader.h"
#include "engine/recording/recording_settings.h"
#include "tests/helpers/gltf_builder.h"
#include "tests/helpers/random.h"
#include "tests/helpers/sanitizers.h"
#include "tests/helpers/soak.h"

namespace palpate {
namespace {

using test::Random;
using test::TemporaryFolder;

using Bytes = std::vector<std::byte>;

// Files with random bytes, in a short run. AddressSanitizer slows each several times, and the
// fuzzer of recordings changes files under it as well.
constexpr int kChangedFiles = test::kHasAddressSanitizer ? 50 : 150;

struct Frames {
  std::int64_t ticks = 0;
  Bytes columns, inputs;
  auto operator<=>(const Frames&) const = default;
};
using Blocks = std::map<std::int64_t, Frames>;

std::string whole_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

RecordedTick random_row(std::uint64_t tick, Random& random) {
  RecordedTick row;
  row.record.tick = tick;
  for (double& number : row.record.goal_scene_m) number = random.uniform(0, 1);
  for (double& number : row.record.proxy_scene_m) number = random.uniform(0, 1);
  return row;
}

// A closed recording of `blocks` blocks of different lengths. Returns the blocks.
Blocks make_recording(const std::string& path, int blocks, Random& random) {
  RecordingMeta meta;
  for (int n = 0; n < 200; ++n) meta["key " + std::to_string(n)] = random.uniform(0, 1);
  auto file = RecordingFile::create(path, meta);
  EXPECT_TRUE(file) << file.error().to_string();
  EXPECT_FALSE(file->begin());
  BlockEncoder encoder;
  Blocks made;
  std::int64_t tick = 0;
  for (int n = 0; n < blocks; ++n) {
    const auto ticks = static_cast<std::int64_t>(1 + random.index(n % 5 == 0 ? 3 : 60));
    std::vector<RecordedTick> rows;
    for (std::int64_t i = 0; i < ticks; ++i) {
      rows.push_back(random_row(static_cast<std::uint64_t>(tick + i), random));
    }
    const auto columns = encoder.columns(rows);
    const auto inputs = encoder.inputs({});
    EXPECT_FALSE(file->add_block(tick, ticks, columns, inputs));
    made[tick] = {ticks, {columns.begin(), columns.end()}, {inputs.begin(), inputs.end()}};
    tick += ticks;
  }
  EXPECT_FALSE(file->commit());
  EXPECT_FALSE(file->add_ending(tick, 0, "end"));
  EXPECT_TRUE(file->close());
  return made;
}

// The blocks that SQLite itself still finds by their keys, unchanged; the oracle of repair.
// A file whose schema is broken is refused; is_cut: SQLite reads what is left of a file that was
// cut only if the schema is writable, and then ignores a broken schema.
Blocks reachable(const std::string& path, const Blocks& made, bool is_cut) {
  Blocks found;
  sqlite3* database = nullptr;
  sqlite3_open_v2(path.c_str(), &database, SQLITE_OPEN_READONLY, nullptr);
  sqlite3_exec(database, "PRAGMA cell_size_check=ON", nullptr, nullptr, nullptr);
  if (is_cut) sqlite3_exec(database, "PRAGMA writable_schema=ON", nullptr, nullptr, nullptr);
  for (const auto& [first, frames] : made) {
    sqlite3_stmt* row = nullptr;
    sqlite3_prepare_v2(database, "SELECT ticks, columns, inputs FROM block WHERE first_tick = ?",
                       -1, &row, nullptr);
    if (!row) continue;
    sqlite3_bind_int64(row, 1, first);
    if (sqlite3_step(row) == SQLITE_ROW) {
      const auto blob = [&](int column) {
        const auto* bytes = static_cast<const std::byte*>(sqlite3_column_blob(row, column));
        return bytes ? Bytes(bytes, bytes + sqlite3_column_bytes(row, column)) : Bytes();
      };
      const Frames read{sqlite3_column_int64(row, 0), blob(1), blob(2)};
      if (read == frames) found[first] = read;
    }
    sqlite3_finalize(row);
  }
  sqlite3_close(database);
  return found;
}

void expect_one_printable_line(const Error& error) {
  const std::string text = error.to_string();
  EXPECT_FALSE(text.empty());
  EXPECT_TRUE(std::all_of(text.begin(), text.end(), [](unsigned char c) { return c >= 32; }))
      << text;
}

// Repairs a broken file and compares the copy with what SQLite reaches.
void expect_repaired(const TemporaryFolder& folder, const std::string& path, const Blocks& made,
                     std::size_t& reached) {
  const std::string before = whole_file(path);
  const std::string to = folder.path("repaired.palpate");
  std::filesystem::remove(to);
  const auto reader = RecordingReader::open(path);
  Blocks repaired;
  std::string refusal;
  if (!reader) {
    expect_one_printable_line(reader.error());
    refusal = reader.error().to_string();
  } else {
    const auto check = repair_recording(*reader, to);
    ASSERT_TRUE(check) << check.error().to_string();
    const auto copy = RecordingReader::open(to);
    ASSERT_TRUE(copy) << copy.error().to_string();
    const auto copy_check = check_recording(*copy);
    ASSERT_TRUE(copy_check) << copy_check.error().to_string();
    EXPECT_EQ(copy_check->problem_count, 0u);
    for (const auto& [first, frames] : made) {
      const auto next = copy->next_block(first);
      ASSERT_TRUE(next);
      if (!*next || **next != first) continue;
      const auto block = copy->block(first);
      ASSERT_TRUE(block);
      repaired[first] = {block->ticks, block->columns, block->inputs};
    }
    EXPECT_EQ(repaired.size(), copy_check->blocks);  // no other block
  }
  const Blocks expected = reachable(path, made, reader.ok());
  EXPECT_EQ(repaired.size(), expected.size()) << refusal;
  EXPECT_TRUE(repaired == expected);
  EXPECT_EQ(whole_file(path), before) << "the original was changed";
  reached += expected.size();
}

TEST(HostileRecording, CutAtEvery4KiBIsRepairedAsFarAsSqliteReaches) {
  const TemporaryFolder folder;
  Random random(11);
  const std::string whole = folder.path("whole.palpate");
  const Blocks made = make_recording(whole, test::in_soak_or_else(400, 60), random);
  const std::string bytes = whole_file(whole);
  std::size_t cuts = 0, reached = 0;
  for (std::size_t length = 0; length < bytes.size(); length += 4096, ++cuts) {
    expect_repaired(folder, folder.write("cut.palpate", bytes.substr(0, length)), made, reached);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(cuts, 20u);
  EXPECT_GT(reached, made.size()) << "the cuts left nothing to repair";
}

TEST(HostileRecording, WithRandomBytesIsRepairedAsFarAsSqliteReaches) {
  const TemporaryFolder folder;
  Random random(12);
  const std::string whole = folder.path("whole.palpate");
  const Blocks made = make_recording(whole, 60, random);
  const std::string bytes = whole_file(whole);
  const int files = test::in_soak_or_else(5'000, kChangedFiles);
  std::size_t reached = 0;
  for (int n = 0; n < files; ++n) {
    std::string changed = bytes;
    for (std::uint64_t k = 0; k <= random.index(30); ++k) {
      changed[random.index(changed.size())] = static_cast<char>(random.index(256));
    }
    expect_repaired(folder, folder.write("changed.palpate", changed), made, reached);
    if (HasFailure()) {
      ADD_FAILURE() << "file " << n;
      return;
    }
  }
}

// A database as an attacker makes it.
class AttackersFile {
 public:
  explicit AttackersFile(const std::string& path) : path_(path) {
    sqlite3_open(path.c_str(), &database_);
    run("PRAGMA writable_schema=ON");
  }
  ~AttackersFile() { sqlite3_close(database_); }
  AttackersFile(const AttackersFile&) = delete;
  AttackersFile& operator=(const AttackersFile&) = delete;
  void run(const std::string& sql) {
    char* problem = nullptr;
    EXPECT_EQ(sqlite3_exec(database_, sql.c_str(), nullptr, nullptr, &problem), SQLITE_OK)
        << sql << ": " << problem;
    sqlite3_free(problem);
  }
  void set_block(std::int64_t first, std::int64_t ticks, const Bytes& columns,
                 const Bytes& inputs) {
    sqlite3_stmt* row = nullptr;
    sqlite3_prepare_v2(database_, "INSERT OR REPLACE INTO block VALUES (?, ?, ?, ?)", -1, &row,
                       nullptr);
    sqlite3_bind_int64(row, 1, first);
    sqlite3_bind_int64(row, 2, ticks);
    const auto bind_bytes = [row](int column, const Bytes& bytes) {
      sqlite3_bind_blob(row, column, bytes.empty() ? "" : static_cast<const void*>(bytes.data()),
                        static_cast<int>(bytes.size()), SQLITE_STATIC);
    };
    bind_bytes(3, columns);
    bind_bytes(4, inputs);
    EXPECT_EQ(sqlite3_step(row), SQLITE_DONE);
    sqlite3_finalize(row);
  }

 private:
  std::string path_;
  sqlite3* database_ = nullptr;
};

double cpu_s() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

// The growth of the process's memory, in bytes, at its highest since the construction.
class PeakMemory {
 public:
  PeakMemory() {
    ::malloc_trim(0);  // else freed memory could be used again without growth
    std::ofstream("/proc/self/clear_refs") << "5";  // begins a new peak
    before_ = peak();
  }
  std::uint64_t growth() const { return peak() - before_; }

 private:
  static std::uint64_t peak() {
    std::ifstream status("/proc/self/status");
    std::string word;
    while (status >> word && word != "VmHWM:") {
    }
    std::uint64_t kilobytes = 0;
    status >> kilobytes;
    return 1024 * kilobytes;
  }
  std::uint64_t before_ = 0;
};

// Opens, checks and reads everything, which must end soon, in errors of one printable line.
// Returns whether anything was wrong.
bool is_refused(const std::string& path) {
  const double before_s = cpu_s();
  const PeakMemory memory;
  bool is_wrong = false;
  const auto reader = RecordingReader::open(path);
  if (!reader) {
    expect_one_printable_line(reader.error());
    is_wrong = true;
  } else {
    const auto meta = reader->meta();
    if (!meta) {
      expect_one_printable_line(meta.error());
    } else if (const auto session = session_of(*meta); !session) {
      expect_one_printable_line(session.error());
    }
    const auto check = check_recording(*reader);
    if (!check) expect_one_printable_line(check.error());
    is_wrong = !meta || !check || !check->is_whole();
    (void)reader->events(1000);
  }
  EXPECT_LT(cpu_s() - before_s, 10.0) << path;
  if (!test::kHasSanitizer) {  // a sanitizer takes memory itself
    EXPECT_LE(memory.growth(), (std::uint64_t{64} << 20) + 40 * std::filesystem::file_size(path))
        << path;
  }
  return is_wrong;
}

TEST(HostileRecording, WithOtherTablesViewsOrTriggersIsRefused) {
  const TemporaryFolder folder;
  Random random(13);
  const char* attacks[] = {
      "CREATE VIEW v AS SELECT * FROM block",
      "CREATE TRIGGER t AFTER INSERT ON block BEGIN DELETE FROM block; END",
      "CREATE INDEX i ON event (tick)",
      "CREATE TABLE extra (x)",
      "DROP TABLE ending",
      "ALTER TABLE event ADD COLUMN more TEXT",
      "CREATE TABLE \"\x1b[31m; DROP TABLE block; --\n\" (x)",
      "DROP TABLE block; CREATE VIEW block AS SELECT 1 AS first_tick, 2 AS ticks, x'00' AS "
      "columns, "
      "x'00' AS inputs",
      "UPDATE sqlite_schema SET sql = 'CREATE TABLE block (first_tick INTEGER PRIMARY KEY, ticks, "
      "columns DEFAULT (randomblob(1000000000)), inputs)' WHERE name = 'block'",
      "UPDATE sqlite_schema SET rootpage = 1 WHERE name = 'block'",
      "UPDATE sqlite_schema SET rootpage = 999999 WHERE name = 'block'",
      "UPDATE sqlite_schema SET sql = 'garbage(' WHERE name = 'meta'",
      "PRAGMA user_version = 3",
      "PRAGMA application_id = 7",
  };
  for (const char* attack : attacks) {
    const std::string path = folder.path("attack.palpate");
    std::filesystem::remove(path);
    make_recording(path, 5, random);
    EXPECT_FALSE(is_refused(path));
    {
      AttackersFile file(path);
      file.run(attack);
    }
    EXPECT_TRUE(is_refused(path)) << attack;
  }
}

Bytes frame_of(const std::vector<char>& bytes) {
  ZSTD_CCtx* context = ZSTD_createCCtx();
  ZSTD_CCtx_setParameter(context, ZSTD_c_checksumFlag, 1);
  Bytes out(ZSTD_compressBound(bytes.size()));
  out.resize(ZSTD_compress2(context, out.data(), out.size(), bytes.data(), bytes.size()));
  ZSTD_freeCCtx(context);
  return out;
}

TEST(HostileRecording, WithBlocksThatAreNoneIsFoundOut) {
  const TemporaryFolder folder;
  Random random(14);
  const Bytes bomb = frame_of(std::vector<char>(std::size_t{300} << 20));
  // As many switches of A4 as a block may have.
  std::vector<char> switches(kMostBlockInputBytes / sizeof(InputHeader) * sizeof(InputHeader));
  for (std::size_t at = 0; at < switches.size(); at += sizeof(InputHeader)) {
    const InputHeader header{0, static_cast<std::uint16_t>(InputKind::kA4), 0, 1};
    std::memcpy(switches.data() + at, &header, sizeof header);
  }
  const Bytes largest_inputs = frame_of(switches);
  BlockEncoder encoder;
  std::vector<RecordedTick> rows{random_row(0, random)};
  const auto good = encoder.columns(rows);
  const Bytes one_row(good.begin(), good.end());
  const auto none = encoder.inputs({});
  const Bytes no_inputs(none.begin(), none.end());
  const std::function<void(AttackersFile&)> attacks[] = {
      [&](AttackersFile& f) { f.set_block(100'000, 1024, bomb, no_inputs); },
      [&](AttackersFile& f) { f.set_block(100'000, 1, one_row, bomb); },
      [&](AttackersFile& f) { f.set_block(100'000, 1LL << 60, one_row, no_inputs); },
      [&](AttackersFile& f) { f.set_block(-5, 1, one_row, no_inputs); },
      [&](AttackersFile& f) { f.set_block(INT64_MAX, 1, one_row, no_inputs); },
      [&](AttackersFile& f) { f.set_block(INT64_MIN, -1, {}, {}); },
      [&](AttackersFile& f) { f.set_block(2, 1, one_row, no_inputs); },
      // Each block is within its limits; together they are too much.
      [&](AttackersFile& f) {
        f.run("BEGIN");
        for (int n = 0; n < 2'000; ++n) f.set_block(100'000 + n, 1, one_row, largest_inputs);
        f.run("COMMIT");
      },
      [&](AttackersFile& f) { f.run("INSERT INTO ending VALUES (9223372036854775807, 5, 'x')"); },
      [&](AttackersFile& f) { f.run("INSERT INTO meta VALUES ('x', NULL)"); },
      [&](AttackersFile& f) { f.run("INSERT INTO meta VALUES ('x', zeroblob(9000000))"); },
  };
  int n = 0;
  for (const auto& attack : attacks) {
    const std::string path = folder.path("attack.palpate");
    std::filesystem::remove(path);
    make_recording(path, 5, random);
    {
      AttackersFile file(path);
      if (n == 8) file.run("DELETE FROM ending");
      attack(file);
    }
    EXPECT_TRUE(is_refused(path)) << n;
    ++n;
  }
}

// Overflow pages and branches of the tree that lead back to themselves.
TEST(HostileRecording, WithEndlessChainsOfPagesEnds) {
  const TemporaryFolder folder;
  Random random(15);
  const std::string whole = folder.path("whole.palpate");
  make_recording(whole, 60, random);
  const std::string bytes = whole_file(whole);
  const std::size_t pages = bytes.size() / 4096;
  const int files = test::in_soak_or_else(3'000, 60);
  int refused = 0;
  for (int n = 0; n < files; ++n) {
    std::string changed = bytes;
    for (std::size_t page = 1; page < pages; ++page) {
      if (random.uniform(0, 1) > 0.3) continue;
      // The first four bytes of an overflow page are its successor, and bytes 8 to 11 of a branch
      // its last child.
      const std::size_t at = page * 4096 + (random.uniform(0, 1) < 0.5 ? 0 : 8);
      const auto to = static_cast<std::uint32_t>(
          random.uniform(0, 1) < 0.5 ? page + 1 : 1 + random.index(pages));
      for (int k = 0; k < 4; ++k) {
        changed[at + static_cast<std::size_t>(k)] = static_cast<char>(to >> (24 - 8 * k));
      }
    }
    refused += is_refused(folder.write("changed.palpate", changed)) ? 1 : 0;
    if (HasFailure()) return;
  }
  EXPECT_GT(refused, files / 2);
}

// Every value of the settings is checked: none may crash, and each error names its key.
TEST(HostileRecording, WithFuzzedSettingsIsRefusedOrHasValidOnes) {
  Random random(16);
  const auto device = DeviceDescription{.name = "d"};
  const RecordingMeta facts = meta_of({device, 2.0, true});
  EXPECT_FALSE(session_of(facts));
  const auto scene = Scene::load(PALPATE_MODELS_DIR "/star.glb");
  ASSERT_TRUE(scene);
  RecordedSetup setup;
  setup.scene_path = PALPATE_MODELS_DIR "/star.glb";
  RecordingMeta whole = *meta_of(*scene, setup);
  for (const auto& [key, value] : facts) whole[key] = value;
  ASSERT_TRUE(session_of(whole)) << session_of(whole).error().to_string();
  int refused = 0;
  const int files = test::in_soak_or_else(200'000, 5'000);
  for (int n = 0; n < files; ++n) {
    RecordingMeta meta = whole;
    for (std::uint64_t k = 0; k <= random.index(2); ++k) {
      auto& value =
          std::next(meta.begin(), static_cast<std::ptrdiff_t>(random.index(meta.size())))->second;
      switch (random.index(3)) {
        case 0:
          value = static_cast<std::int64_t>(random.index(5)) - 2;
          break;
        case 1:
          value = random.normal() * 1e300;
          break;
        default:
          value = std::string("\x1b[2J\n\xff");
          break;
      }
    }
    const auto session = session_of(meta);
    if (session) continue;
    ++refused;
    expect_one_printable_line(session.error());
  }
  EXPECT_GT(refused, files / 10);
  EXPECT_LT(refused, files);
}

}  // namespace
}  // namespace palpate
