// The two frames of a block, against a decoder that knows only the format.

#include "engine/recording/block_codec.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <map>
#include <string>
#include <vector>
#include <zstd.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::Random;

std::vector<RecordedTick> random_rows(std::size_t count, std::int64_t first, Random& random) {
  std::vector<RecordedTick> rows(count);
  for (std::size_t i = 0; i < count; ++i) {
    auto* bytes = reinterpret_cast<unsigned char*>(&rows[i]);
    for (std::size_t b = 0; b < sizeof(RecordedTick); ++b) {
      bytes[b] = static_cast<unsigned char>(random.uniform(0, 256));
    }
    rows[i].record.tick = static_cast<std::uint64_t>(first) + i;
    rows[i].record.proxy_scene_m[0] = std::bit_cast<double>(0x7ff0dead0000beefULL);  // a NaN
    rows[i].record.proxy_scene_m[1] = -0.0;
  }
  return rows;
}

std::vector<std::byte> copy(std::span<const std::byte> bytes) {
  return {bytes.begin(), bytes.end()};
}

std::vector<std::byte> frame(const std::vector<char>& bytes, bool has_checksum, bool has_size) {
  ZSTD_CCtx* context = ZSTD_createCCtx();
  ZSTD_CCtx_setParameter(context, ZSTD_c_checksumFlag, has_checksum ? 1 : 0);
  ZSTD_CCtx_setParameter(context, ZSTD_c_contentSizeFlag, has_size ? 1 : 0);
  std::vector<std::byte> out(ZSTD_compressBound(bytes.size()));
  out.resize(ZSTD_compress2(context, out.data(), out.size(), bytes.data(), bytes.size()));
  ZSTD_freeCCtx(context);
  return out;
}

// All columns of a frame, as numbers of 64 bits, by FORMAT.md and the column table alone.
std::map<std::string, std::vector<std::uint64_t>> decoded(std::span<const std::byte> whole,
                                                          std::size_t ticks) {
  std::vector<unsigned char> plain(ZSTD_getFrameContentSize(whole.data(), whole.size()));
  EXPECT_EQ(ZSTD_decompress(plain.data(), plain.size(), whole.data(), whole.size()), plain.size());
  std::map<std::string, std::vector<std::uint64_t>> columns;
  std::size_t at = 0;
  for (const auto& column : nlohmann::json::parse(recorded_columns_json())) {
    const std::string type = column["type"];
    const auto bytes = static_cast<std::size_t>(type[2] - '0');
    std::vector<std::uint64_t> numbers(ticks);
    for (std::size_t b = 0; b < bytes; ++b) {
      for (std::size_t i = 0; i < ticks; ++i) {
        numbers[i] |= std::uint64_t{plain.at(at++)} << (8 * b);
      }
    }
    columns[column["name"]] = numbers;
  }
  EXPECT_EQ(at, plain.size());
  return columns;
}

TEST(BlockCodec, KeepsEveryBitForADecoderThatKnowsOnlyTheFormat) {
  Random random(5);
  BlockEncoder encoder;
  for (const std::size_t count : {1u, 2u, 250u, 1024u}) {
    const auto rows = random_rows(count, 1000, random);
    const auto columns = decoded(encoder.columns(rows), count);
    ASSERT_EQ(columns.size(), recorded_columns().size());
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_EQ(columns.at("tick")[i], 1000 + i);
      EXPECT_EQ(columns.at("proxy_scene_m_x")[i], 0x7ff0dead0000beefULL);
      EXPECT_EQ(columns.at("proxy_scene_m_y")[i], std::bit_cast<std::uint64_t>(-0.0));
      EXPECT_EQ(columns.at("o_after_m_z")[i],
                std::bit_cast<std::uint64_t>(rows[i].record.o_after_m[2]));
      EXPECT_EQ(columns.at("q_before_w")[i],
                std::bit_cast<std::uint64_t>(rows[i].record.q_before_wxyz[0]));
      EXPECT_EQ(columns.at("faults")[i], rows[i].record.faults);
      EXPECT_EQ(columns.at("contact")[i], rows[i].record.contact);
      EXPECT_EQ(columns.at("sample_m_y")[i],
                std::bit_cast<std::uint64_t>(rows[i].reading.sample_m[1]));
      EXPECT_EQ(columns.at("due_ns")[i], static_cast<std::uint64_t>(rows[i].reading.due_ns));
      EXPECT_EQ(columns.at("is_valid")[i], rows[i].reading.is_valid);
    }
  }
}

TEST(BlockCodec, DecodesWhatItEncoded) {
  Random random(6);
  BlockEncoder encoder;
  BlockDecoder decoder;
  const auto rows = random_rows(700, 40, random);
  std::vector<std::byte> inputs;
  std::vector<InputHeader> headers;
  for (std::uint32_t row = 0; row < 700; row += 7) {
    const InputHeader header{row, static_cast<std::uint16_t>(InputKind::kBodyPose), 56, row + 1};
    headers.push_back(header);
    const auto* bytes = reinterpret_cast<const std::byte*>(&header);
    inputs.insert(inputs.end(), bytes, bytes + sizeof header);
    inputs.insert(inputs.end(), 56, std::byte{static_cast<unsigned char>(row)});
  }
  const auto columns_frame = copy(encoder.columns(rows));
  const auto inputs_frame = copy(encoder.inputs(inputs));
  const auto content = decoder.decode(40, 700, columns_frame, inputs_frame);
  ASSERT_TRUE(content) << content.error().to_string();
  ASSERT_EQ(content->rows.size(), rows.size());
  EXPECT_EQ(std::memcmp(content->rows.data(), rows.data(), rows.size() * sizeof rows[0]), 0);
  ASSERT_EQ(content->inputs.size(), headers.size());
  for (std::size_t i = 0; i < headers.size(); ++i) {
    EXPECT_EQ(content->inputs[i].row, headers[i].row);
    EXPECT_EQ(content->inputs[i].input.handle, headers[i].handle);
    ASSERT_EQ(content->inputs[i].input.bytes.size(), 56u);
    EXPECT_EQ(content->inputs[i].input.bytes[55],
              std::byte{static_cast<unsigned char>(headers[i].row)});
  }
}

// A block of version 1 has no columns of what is touched, and the rules in the upper half of the
// faults.
TEST(BlockCodec, ReadsABlockOfVersion1) {
  Random random(8);
  const auto rows = random_rows(100, 0, random);
  std::string plain;
  for (const auto& column : nlohmann::json::parse(recorded_columns_json(1))) {
    const auto found =
        std::find_if(recorded_columns().begin(), recorded_columns().end(),
                     [&](const RecordColumn& c) { return c.name == column["name"]; });
    ASSERT_NE(found, recorded_columns().end());
    for (std::size_t b = 0; b < found->bytes; ++b) {
      for (const RecordedTick& row : rows) {
        plain += reinterpret_cast<const char*>(&row)[found->offset + b];
      }
    }
  }
  ASSERT_EQ(plain.size(), rows.size() * 408);
  const auto columns = frame(std::vector<char>(plain.begin(), plain.end()), true, true);
  BlockEncoder encoder;
  BlockDecoder decoder;
  const auto inputs = copy(encoder.inputs({}));
  EXPECT_FALSE(decoder.decode(0, 100, columns, inputs)) << "not a block of this version";
  const auto content = decoder.decode(0, 100, columns, inputs, 1);
  ASSERT_TRUE(content) << content.error().to_string();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    RecordedTick expected = rows[i];
    expected.record.faults = rows[i].record.faults & 0xffff;
    expected.record.rules = rows[i].record.faults >> 16;
    expected.record.body = expected.record.material = kTouchUnknown;
    expected.record.contacts = expected.record.touch = 0;
    ASSERT_EQ(std::memcmp(&content->rows[i], &expected, sizeof expected), 0) << i;
  }
}

TEST(BlockCodec, RefusesWhatIsNoBlock) {
  Random random(7);
  BlockEncoder encoder;
  BlockDecoder decoder;
  const auto rows = random_rows(10, 0, random);
  const auto columns = copy(encoder.columns(rows));
  const auto inputs = copy(encoder.inputs({}));
  ASSERT_TRUE(decoder.decode(0, 10, columns, inputs));
  EXPECT_FALSE(decoder.decode(1, 10, columns, inputs));  // other ticks
  for (const std::int64_t ticks : {-1L, 0L, 9L, 11L, 1025L, 1L << 40}) {
    EXPECT_FALSE(decoder.decode(0, ticks, columns, inputs)) << ticks;
  }
  EXPECT_FALSE(decoder.decode(-1, 10, columns, inputs));
  EXPECT_FALSE(decoder.decode(0, 10, {}, inputs));
  EXPECT_FALSE(decoder.decode(0, 10, columns, {}));
  EXPECT_FALSE(decoder.decode(0, 10, columns, columns));
  for (std::size_t length = 0; length < columns.size(); length += 37) {
    EXPECT_FALSE(decoder.decode(0, 10, std::span(columns).first(length), inputs)) << length;
  }
  auto longer = columns;
  longer.insert(longer.end(), columns.begin(), columns.end());
  EXPECT_FALSE(decoder.decode(0, 10, longer, inputs));
}

// A frame without checksum or without content size, and a bomb.
TEST(BlockCodec, RefusesFramesThatCouldBreakItsLimits) {
  Random random(8);
  BlockEncoder encoder;
  BlockDecoder decoder;
  const auto rows = random_rows(10, 0, random);
  const auto columns = copy(encoder.columns(rows));
  const std::vector<char> none;
  EXPECT_TRUE(decoder.decode(0, 10, columns, frame(none, true, true)));
  EXPECT_FALSE(decoder.decode(0, 10, columns, frame(none, false, true)));
  EXPECT_FALSE(decoder.decode(0, 10, columns, frame(none, true, false)));
  const auto bomb = decoder.decode(0, 10, columns,
                                   frame(std::vector<char>(kMostBlockInputBytes + 1), true, true));
  ASSERT_FALSE(bomb);
  EXPECT_NE(bomb.error().to_string().find("content size"), std::string::npos);
  EXPECT_FALSE(
      decoder.decode(0, 10, frame(std::vector<char>(4241), true, true), frame(none, true, true)));
}

// Each change of a byte is found, or changes nothing.
TEST(BlockCodec, NeverGivesAWrongRowForAChangedByte) {
  Random random(9);
  BlockEncoder encoder;
  BlockDecoder decoder;
  auto rows = random_rows(20, 0, random);
  for (RecordedTick& row : rows) row.record.o_after_m[0] = 1.0;  // something to compress
  const auto columns = copy(encoder.columns(rows));
  const auto inputs = copy(encoder.inputs({}));
  int found = 0;
  for (int n = 0; n < 20'000; ++n) {
    auto changed = columns;
    const auto at =
        static_cast<std::size_t>(random.uniform(0, static_cast<double>(changed.size())));
    changed[at] ^= std::byte{static_cast<unsigned char>(random.uniform(1, 256))};
    const auto content = decoder.decode(0, 20, changed, inputs);
    if (!content) {
      ++found;
      continue;
    }
    ASSERT_EQ(std::memcmp(content->rows.data(), rows.data(), rows.size() * sizeof rows[0]), 0)
        << at;
  }
  EXPECT_GT(found, 19'000);
}

}  // namespace
}  // namespace palpate
