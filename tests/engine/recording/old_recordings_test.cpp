// Recordings of earlier versions, in the folder data: a simulated hand with A4, a pantograph behind
// a simulated board while the scene's node moves, and the scenario, with moved nodes, changed
// materials and each kind of input. They must be computed again to the bit by every later version.

#include <string>
#include <variant>
#include <vector>
#include <zstd.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/recording/block_walk.h"
#include "engine/recording/recording_check.h"
#include "engine/recording/recording_replay.h"
#include "tests/engine/recording/scenario.h"
#include "tests/helpers/gltf_builder.h"

namespace palpate {
namespace {

struct OldRecording {
  std::string name;
  std::uint64_t ticks;
  bool is_scenario;  // its scene is that of test::Scenario, not a file
};

class OldRecordings : public testing::TestWithParam<OldRecording> {};

TEST_P(OldRecordings, AreComputedAgainToTheBit) {
  const OldRecording& old = GetParam();
  const std::string folder = PALPATE_OLD_RECORDINGS "/";
  const auto reader = RecordingReader::open(folder + old.name + ".palpate");
  ASSERT_TRUE(reader) << reader.error().to_string();
  const RecordedSession session = test::session_in(*reader);
  const test::Scenario scenario(1);
  const auto loaded =
      old.is_scenario ? Result<Scene>(Error{}) : load_recorded_scene(session, folder + "star.glb");
  ASSERT_TRUE(old.is_scenario || loaded) << loaded.error().to_string();
  const auto outcome =
      replay_recording(*reader, session, old.is_scenario ? scenario.scene() : *loaded);
  ASSERT_TRUE(outcome) << outcome.error().to_string();
  EXPECT_FALSE(outcome->difference)
      << outcome->difference->tick << " " << outcome->difference->column;
  EXPECT_EQ(outcome->stopped.value_or(""), "");
  EXPECT_EQ(outcome->proved, old.ticks);
  EXPECT_GT(outcome->recorded.contact_ticks, old.ticks / 10);
}

// The numbers of one column of a block, by the table that the recording itself holds.
std::vector<std::uint64_t> column_of(const RecordingReader& reader, const RecordedBlock& block,
                                     const std::string& name) {
  std::vector<unsigned char> plain(
      ZSTD_getFrameContentSize(block.columns.data(), block.columns.size()));
  EXPECT_EQ(ZSTD_decompress(plain.data(), plain.size(), block.columns.data(), block.columns.size()),
            plain.size());
  const auto meta = reader.meta();
  std::size_t at = 0;
  const auto ticks = static_cast<std::size_t>(block.ticks);
  std::vector<std::uint64_t> numbers(ticks);
  for (const auto& column : nlohmann::json::parse(std::get<std::string>(meta->at("columns")))) {
    const std::string type = column["type"];
    const auto bytes = static_cast<std::size_t>(type[2] - '0');
    if (column["name"] == name) {
      for (std::size_t b = 0; b < bytes; ++b) {
        for (std::size_t i = 0; i < ticks; ++i) {
          numbers[i] |= std::uint64_t{plain.at(at + b * ticks + i)} << (8 * b);
        }
      }
      return numbers;
    }
    at += bytes * ticks;
  }
  ADD_FAILURE() << name;
  return numbers;
}

TEST_P(OldRecordings, HaveTheirRulesInTheFaultsAndDoNotSayWhatIsTouched) {
  const auto reader =
      RecordingReader::open(PALPATE_OLD_RECORDINGS "/" + GetParam().name + ".palpate");
  ASSERT_TRUE(reader);
  EXPECT_EQ(reader->version(), 1);
  BlockWalk walk(*reader);
  std::uint32_t all_rules = 0;
  for (WalkStep step = walk.next(); step.kind != WalkStep::Kind::kEnd; step = walk.next()) {
    ASSERT_EQ(step.kind, WalkStep::Kind::kBlock);
    const auto faults = column_of(*reader, step.frames, "faults");
    const auto contact = column_of(*reader, step.frames, "contact");
    for (std::size_t i = 0; i < faults.size(); ++i) {
      const TickRecord& record = step.content.rows[i].record;
      ASSERT_EQ(record.faults, faults[i] & 0xffff);
      ASSERT_EQ(record.rules, faults[i] >> 16);
      ASSERT_EQ(record.contact, contact[i]);
      ASSERT_EQ(record.body, kTouchUnknown);
      ASSERT_EQ(record.material, kTouchUnknown);
      ASSERT_EQ(record.contacts, 0);
      ASSERT_EQ(record.touch, 0);
      all_rules |= record.rules;
    }
  }
  EXPECT_EQ(all_rules != 0, GetParam().name != "hand") << "no rule acts on a simulated hand";
}

TEST_P(OldRecordings, KeepTheirVersionWhenTheyAreRepaired) {
  const test::TemporaryFolder folder;
  const std::string to = folder.path("repaired.palpate");
  const auto reader =
      RecordingReader::open(PALPATE_OLD_RECORDINGS "/" + GetParam().name + ".palpate");
  ASSERT_TRUE(reader);
  ASSERT_TRUE(repair_recording(*reader, to));
  const auto repaired = RecordingReader::open(to);
  ASSERT_TRUE(repaired) << repaired.error().to_string();
  EXPECT_EQ(repaired->version(), 1);
  const auto check = check_recording(*repaired);
  ASSERT_TRUE(check);
  EXPECT_EQ(check->ticks, GetParam().ticks);
  EXPECT_TRUE(check->is_whole());
  EXPECT_EQ(test::session_in(*repaired).version, 1);
}

INSTANTIATE_TEST_SUITE_P(Of0Point1, OldRecordings,
                         testing::Values(OldRecording{"hand", 2000, false},
                                         OldRecording{"device", 1452, false},
                                         OldRecording{"nodes", 400, true}),
                         [](const auto& instance) { return instance.param.name; });

}  // namespace
}  // namespace palpate
