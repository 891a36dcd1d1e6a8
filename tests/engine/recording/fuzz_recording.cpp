// libFuzzer's target: recordings of an attacker. The first byte chooses what the rest is: the
// frames of a block, the content of these frames, changes of the bytes of a file, changes of the
// settings, or the rows and inputs of a recording that is replayed. Whatever they are, the result
// must be a value within its documented range, or an Error of one printable line.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <unistd.h>
#include <vector>
#include <zstd.h>

#include "engine/recording/block_codec.h"
#include "engine/recording/recording_check.h"
#include "engine/recording/recording_file.h"
#include "engine/recording/recording_replay.h"
#include "engine/recording/recording_settings.h"

namespace palpate {
namespace {

using Bytes = std::span<const std::byte>;

void require(bool holds) {
  if (!holds) std::abort();
}

void require_printable_line(const Error& error) {
  const std::string text = error.to_string();
  require(!text.empty() && std::all_of(text.begin(), text.end(),
                                       [](char c) { return static_cast<unsigned char>(c) >= 32; }));
}

// Takes numbers off the front; zeros where nothing is left.
template <typename T>
T take(Bytes& bytes) {
  T value{};
  const std::size_t count = std::min(sizeof value, bytes.size());
  std::memcpy(&value, bytes.data(), count);
  bytes = bytes.subspan(count);
  return value;
}

// What an attacker changes.
struct Base {
  Scene scene = std::move(*Scene::load(PALPATE_MODELS_DIR "/effect_friction.glb"));
  DeviceDescription device;
  RecordingMeta meta;
  std::string path;
  std::string bytes;  // of a closed recording

  Base() {
    path = std::filesystem::temp_directory_path() /
           ("fuzz_recording_" + std::to_string(::getpid()) + ".palpate");
    RecordedSetup setup;
    setup.scene_path = PALPATE_MODELS_DIR "/effect_friction.glb";
    meta = *meta_of(scene, setup);
    for (auto& [key, value] : meta_of({device, 2.0, true})) meta[key] = value;
    write(std::vector<RecordedTick>(40), {});
    std::ifstream file(path, std::ios::binary);
    bytes.assign(std::istreambuf_iterator<char>(file), {});
  }
  ~Base() { std::filesystem::remove(path); }

  void write(std::vector<RecordedTick> rows, Bytes inputs) const {
    std::filesystem::remove(path);
    auto file = RecordingFile::create(path, meta);
    BlockEncoder encoder;
    const auto columns = encoder.columns(rows);
    require(file && !file->begin() &&
            !file->add_block(0, static_cast<std::int64_t>(rows.size()), columns,
                             encoder.inputs(inputs)) &&
            !file->commit() &&
            !file->add_ending(static_cast<std::int64_t>(rows.size()), 0, "end") && file->close());
  }
};

const Base& base() {
  static const Base made;
  return made;
}

std::vector<std::byte> frame_of(Bytes bytes) {
  std::vector<std::byte> frame(ZSTD_compressBound(bytes.size()));
  ZSTD_CCtx* const context = ZSTD_createCCtx();
  ZSTD_CCtx_setParameter(context, ZSTD_c_checksumFlag, 1);
  frame.resize(ZSTD_compress2(context, frame.data(), frame.size(), bytes.data(), bytes.size()));
  ZSTD_freeCCtx(context);
  return frame;
}

void decode_version(int version, std::int64_t first_tick, std::int64_t ticks, Bytes columns,
                    Bytes inputs) {
  BlockDecoder decoder;
  const auto content = decoder.decode(first_tick, ticks, columns, inputs, version);
  if (!content) return require_printable_line(content.error());
  require(first_tick >= 0 && static_cast<std::int64_t>(content->rows.size()) == ticks);
  for (const BlockInput& input : content->inputs) {
    require(input.row < content->rows.size());
    require(static_cast<std::size_t>(input.input.kind) < kInputKinds.size());
    const auto& facts = kInputKinds[static_cast<std::size_t>(input.input.kind)];
    require(input.input.bytes.size() >= facts.least_bytes &&
            input.input.bytes.size() <= facts.most_bytes);
  }
}

void decode(std::int64_t first_tick, std::int64_t ticks, Bytes columns, Bytes inputs) {
  for (int version = 1; version <= kRecordingVersion; ++version) {
    decode_version(version, first_tick, ticks, columns, inputs);
  }
}

void decode_frames(Bytes bytes) {
  const auto first_tick = take<std::int64_t>(bytes);
  const auto ticks = take<std::int64_t>(bytes);
  const std::size_t columns = std::min<std::size_t>(take<std::uint16_t>(bytes), bytes.size());
  decode(first_tick, ticks, bytes.first(columns), bytes.subspan(columns));
}

// Frames whose lengths and checksums are right.
void decode_content(Bytes bytes) {
  const std::size_t ticks = 1 + take<std::uint8_t>(bytes) % 4;
  std::vector<std::byte> columns(ticks * sizeof(RecordedTick));
  const std::size_t given = std::min(columns.size(), bytes.size());
  std::copy_n(bytes.begin(), given, columns.begin());
  decode(0, static_cast<std::int64_t>(ticks), frame_of(columns), frame_of(bytes.subspan(given)));
}

// Reads all of the file as `palpate recording` does.
void read_file() {
  const auto reader = RecordingReader::open(base().path);
  if (!reader) return require_printable_line(reader.error());
  const auto meta = reader->meta();
  if (!meta) {
    require_printable_line(meta.error());
  } else if (const auto session = session_of(*meta); !session) {
    require_printable_line(session.error());
  }
  const auto check = check_recording(*reader);
  if (!check) return require_printable_line(check.error());
  require(check->problems.size() <= RecordingCheck::kMostListed);
  for (const std::string& problem : check->problems) {
    require_printable_line({ErrorCode::kInvalidContent, "", "", problem, ""});
  }
  (void)reader->events(100);
}

void read_changed_file(Bytes bytes) {
  std::string changed = base().bytes;
  changed.resize(changed.size() - take<std::uint16_t>(bytes) % changed.size());
  while (!bytes.empty() && !changed.empty()) {
    const auto at = take<std::uint32_t>(bytes);
    changed[at % changed.size()] = static_cast<char>(take<std::uint8_t>(bytes));
  }
  std::ofstream(base().path, std::ios::binary) << changed;
  read_file();
}

void read_changed_settings(Bytes bytes) {
  RecordingMeta meta = base().meta;
  while (!bytes.empty()) {
    const auto entry = std::next(meta.begin(), take<std::uint8_t>(bytes) % meta.size());
    switch (take<std::uint8_t>(bytes) % 4) {
      case 0:
        entry->second = take<std::int64_t>(bytes);
        break;
      case 1:
        entry->second = take<double>(bytes);
        break;
      case 2: {
        const std::size_t length = std::min<std::size_t>(take<std::uint8_t>(bytes), bytes.size());
        entry->second = std::string(reinterpret_cast<const char*>(bytes.data()), length);
        bytes = bytes.subspan(length);
        break;
      }
      default:
        meta.erase(entry);
        if (meta.empty()) return;
    }
  }
  const auto session = session_of(meta);
  if (!session) require_printable_line(session.error());
}

// Rows and inputs of any content, with the settings of a usual session.
void replay(Bytes bytes) {
  std::vector<RecordedTick> rows(1 + take<std::uint8_t>(bytes) % 8);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i].record.tick = i;
    rows[i].reading.dt_s = 1e-3;
    rows[i].reading.is_valid = 1;
    rows[i].reading.sequence = i + 1;
  }
  const std::size_t changes = take<std::uint8_t>(bytes) % 32;
  for (std::size_t n = 0; n < changes; ++n) {
    RecordedTick& row = rows[take<std::uint8_t>(bytes) % rows.size()];
    const std::size_t word = take<std::uint8_t>(bytes) % (sizeof row / 8);
    const auto value = take<std::uint64_t>(bytes);
    std::memcpy(reinterpret_cast<std::byte*>(&row) + 8 * word, &value, sizeof value);
  }
  base().write(rows, bytes);
  const auto reader = RecordingReader::open(base().path);
  if (!reader) return require_printable_line(reader.error());
  const auto session = session_of(base().meta);
  require(session.ok());
  ReplayOptions options;
  if (changes % 2 == 0) options.change = ReplayChange{};  // runs to the end
  const auto outcome = replay_recording(*reader, *session, base().scene, options);
  if (!outcome) return require_printable_line(outcome.error());
  require(outcome->proved <= rows.size());
}

}  // namespace
}  // namespace palpate

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const auto rest = std::as_bytes(std::span(data + 1, size - 1));
  switch (data[0] % 5) {
    case 0:
      palpate::decode_frames(rest);
      break;
    case 1:
      palpate::decode_content(rest);
      break;
    case 2:
      palpate::read_changed_file(rest);
      break;
    case 3:
      palpate::read_changed_settings(rest);
      break;
    default:
      palpate::replay(rest);
  }
  return 0;
}
