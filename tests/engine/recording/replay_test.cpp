// A recorded session is computed again to the bit.

#include <cstring>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/recording/block_walk.h"
#include "engine/recording/recording_check.h"
#include "engine/recording/recording_file.h"
#include "engine/recording/recording_replay.h"
#include "engine/session/run_setting.h"
#include "geometry/index/simd.h"
#include "tests/engine/recording/scenario.h"
#include "tests/helpers/gltf_builder.h"
#include "tests/helpers/soak.h"

namespace palpate {
namespace {

using test::in_soak_or_else;
using test::Scenario;
using test::TemporaryFolder;
using test::TickKeeper;

// kSetting replaces these kinds.
bool is_of_earlier_versions(InputKind kind) {
  return kind == InputKind::kA4 || kind == InputKind::kForce || kind == InputKind::kCoupling;
}

// One minute, or ten, at 1 kHz.
std::uint64_t scenario_ticks() {
  return in_soak_or_else<std::uint64_t>(600'000, 60'000);
}

// A recording of the scenario.
struct Recorded {
  explicit Recorded(std::uint64_t ticks)
      : scenario(31, {.ticks = ticks}),
        scene_file(folder.write("scenario.glb", "any bytes")),
        path(folder.path("scenario.palpate")),
        given(test::recorded_scenario(scenario, scene_file, path)) {}

  Result<ReplayOutcome> replay(const ReplayOptions& options = {}) const {
    const auto reader = RecordingReader::open(path);
    EXPECT_TRUE(reader) << reader.error().to_string();
    return replay_recording(*reader, test::session_in(*reader), scenario.scene(), options);
  }

  TemporaryFolder folder;
  Scenario scenario;
  std::string scene_file;
  std::string path;
  TickKeeper given;
};

std::string text_of(const ReplayOutcome& outcome) {
  std::string text = outcome.stopped.value_or("");
  if (const auto& d = outcome.difference) {
    text +=
        "tick " + std::to_string(d->tick) + " " + d->column + " " + d->recorded + " " + d->computed;
  }
  return text;
}

TEST(Replay, GivesEveryBitAgainInEachSimdWidth) {
  const Recorded recorded(scenario_ticks());
  // The scenario has what it promises.
  for (const InputKindFacts& facts : kInputKinds) {
    const std::uint64_t count = recorded.given.inputs[static_cast<std::size_t>(facts.kind)];
    EXPECT_EQ(count > 5, !is_of_earlier_versions(facts.kind)) << facts.name << ": " << count;
  }
  for (const std::uint64_t count : recorded.given.settings) EXPECT_GT(count, 5u);
  EXPECT_GT(recorded.given.trips, 5u);
  std::uint64_t in_contact = 0, forces = 0, faults = 0;
  for (const RecordedTick& row : recorded.given.rows) {
    in_contact += row.record.contact;
    forces += row.record.force_device_N[0] != 0.0 ? 1 : 0;
    faults += (row.record.faults & kFaultsWithoutForce) != 0 ? 1 : 0;
  }
  EXPECT_GT(in_contact, recorded.given.rows.size() / 10);
  EXPECT_GT(forces, recorded.given.rows.size() / 100);
  EXPECT_GT(faults, 20u);
  for (const SimdLevel level : {SimdLevel::kBaseline, SimdLevel::kAvx2, SimdLevel::kAvx512}) {
    limit_simd_level(level);
    const auto outcome = recorded.replay();
    ASSERT_TRUE(outcome) << outcome.error().to_string();
    EXPECT_EQ(text_of(*outcome), "");
    EXPECT_EQ(outcome->proved, recorded.given.rows.size());
    ASSERT_TRUE(outcome->ending);
    EXPECT_EQ(outcome->ending->why, "end");
  }
  limit_simd_level(SimdLevel::kAvx512);
}

// A recording holds the work budget and the rule of counting. One without a rule is of an earlier
// version; a rule that this version does not know is refused.
TEST(Replay, TakesTheRuleOfCountingFromTheRecording) {
  const Recorded recorded(100);
  const auto reader = RecordingReader::open(recorded.path);
  ASSERT_TRUE(reader);
  RecordingMeta meta = *reader->meta();
  const auto rule = [&] {
    const auto session = session_of(meta);
    EXPECT_TRUE(session) << session.error().to_string();
    return session->setup.haptics.god_object.accuracy.counting;
  };
  EXPECT_EQ(rule(), CountingRule::kSecond);
  EXPECT_EQ(std::get<std::int64_t>(meta.at("proxy.work_budget")), Accuracy{}.work_budget);
  meta["proxy.counting"] = std::int64_t{1};
  EXPECT_EQ(rule(), CountingRule::kFirst);
  meta.erase("proxy.counting");
  EXPECT_EQ(rule(), CountingRule::kFirst);
  for (const std::int64_t unknown : {0, 3, 259}) {
    meta["proxy.counting"] = unknown;
    const auto session = session_of(meta);
    ASSERT_FALSE(session) << unknown;
    EXPECT_EQ(session.error().element, "proxy.counting");
  }
}

// A recorder that left out one kind of input would be found out, for each line of the table.
TEST(Replay, FindsOutARecorderThatLeavesOutAnyKindOfInput) {
  const Recorded recorded(20'000);
  for (const InputKindFacts& kind : kInputKinds) {
    if (is_of_earlier_versions(kind.kind)) continue;
    const auto outcome = recorded.replay({.left_out = kind.kind});
    ASSERT_TRUE(outcome) << outcome.error().to_string();
    EXPECT_TRUE(outcome->difference) << kind.name;
    EXPECT_LT(outcome->proved, recorded.given.rows.size()) << kind.name;
  }
}

// Copies a recording, with one bit of one column of one tick changed.
void change_bit(const std::string& from, const std::string& to, std::uint64_t tick,
                const RecordColumn& column) {
  const auto reader = RecordingReader::open(from);
  ASSERT_TRUE(reader);
  const auto meta = reader->meta();
  ASSERT_TRUE(meta);
  auto file = RecordingFile::create(to, *meta);
  ASSERT_TRUE(file);
  ASSERT_FALSE(file->begin());
  BlockEncoder encoder;
  BlockWalk walk(*reader);
  for (WalkStep step = walk.next(); step.kind == WalkStep::Kind::kBlock; step = walk.next()) {
    for (RecordedTick& row : step.content.rows) {
      if (row.record.tick == tick) reinterpret_cast<unsigned char*>(&row)[column.offset] ^= 1;
    }
    ASSERT_FALSE(file->add_block(step.first_tick, step.frames.ticks,
                                 encoder.columns(step.content.rows), step.frames.inputs));
  }
  ASSERT_FALSE(file->commit());
  ASSERT_FALSE(file->add_ending(1, 0, "end"));
  EXPECT_TRUE(file->close());
}

// Only computed columns are compared, and the first difference has its tick, its column and both
// values. (A changed tick number is a broken block.)
TEST(Replay, NamesTheFirstTickAndColumnThatDiffer) {
  const Recorded recorded(3'000);
  constexpr std::uint64_t kTick = 1'500;
  int copies = 0;
  for (const RecordColumn& column : recorded_columns()) {
    if (column.source == ColumnSource::kRead || column.name == "tick" || column.name == "late_ns") {
      continue;
    }
    const std::string copy = recorded.folder.path(std::to_string(copies++));
    change_bit(recorded.path, copy, kTick, column);
    const auto reader = RecordingReader::open(copy);
    ASSERT_TRUE(reader) << reader.error().to_string();
    const auto outcome =
        replay_recording(*reader, test::session_in(*reader), recorded.scenario.scene());
    ASSERT_TRUE(outcome) << outcome.error().to_string();
    if (column.source == ColumnSource::kMeasured) {
      EXPECT_FALSE(outcome->difference) << column.name;
      continue;
    }
    ASSERT_TRUE(outcome->difference) << column.name;
    EXPECT_EQ(outcome->difference->tick, kTick);
    EXPECT_EQ(outcome->difference->column, column.name);
    EXPECT_NE(outcome->difference->recorded, outcome->difference->computed);
    EXPECT_EQ(outcome->difference->computed, column_text(column, recorded.given.rows[kTick]));
    EXPECT_EQ(outcome->proved, kTick);
  }
  EXPECT_GT(copies, 40);
}

TEST(Replay, StopsAtAGap) {
  const Recorded recorded(4'000);
  const std::string copy = recorded.folder.path("copy.palpate");
  {
    const auto reader = RecordingReader::open(recorded.path);
    ASSERT_TRUE(reader);
    auto file = RecordingFile::create(copy, *reader->meta());
    ASSERT_TRUE(file);
    ASSERT_FALSE(file->begin());
    BlockWalk walk(*reader);
    for (WalkStep step = walk.next(); step.kind == WalkStep::Kind::kBlock; step = walk.next()) {
      if (step.first_tick == 1024) continue;
      ASSERT_FALSE(file->add_block(step.first_tick, step.frames.ticks, step.frames.columns,
                                   step.frames.inputs));
    }
    ASSERT_FALSE(file->commit());
  }
  const auto reader = RecordingReader::open(copy);
  ASSERT_TRUE(reader) << reader.error().to_string();
  const auto outcome =
      replay_recording(*reader, test::session_in(*reader), recorded.scenario.scene());
  ASSERT_TRUE(outcome) << outcome.error().to_string();
  EXPECT_EQ(outcome->proved, 1024u);
  EXPECT_FALSE(outcome->difference);
  EXPECT_FALSE(outcome->ending);
  ASSERT_TRUE(outcome->stopped);
  EXPECT_EQ(*outcome->stopped, "1024 ticks are missing before tick 2048");
  const auto check = check_recording(*reader);
  ASSERT_TRUE(check);
  EXPECT_EQ(check->missing, 1024u);
  ASSERT_EQ(check->gaps.size(), 1u);
  EXPECT_EQ(check->gaps[0].first, 1024);
  EXPECT_EQ(check->gaps[0].count, 1024);
}

// Under other settings the same path gives other forces, and recorded switches of what was set are
// counted.
TEST(Replay, AnswersWhatIf) {
  const Recorded recorded(10'000);
  const auto reader = RecordingReader::open(recorded.path);
  ASSERT_TRUE(reader);
  RecordedSession session = test::session_in(*reader);
  session.setup.haptics.a4.enabled = false;
  ReplayChange without_a4;
  without_a4.ignores[live_setting("a4")] = true;
  const auto outcome =
      replay_recording(*reader, session, recorded.scenario.scene(), {.change = without_a4});
  ASSERT_TRUE(outcome) << outcome.error().to_string();
  EXPECT_FALSE(outcome->difference);
  EXPECT_EQ(outcome->ignored_inputs, recorded.given.settings[live_setting("a4")]);
  EXPECT_EQ(outcome->computed.a4_ticks, 0u);
  EXPECT_GT(outcome->recorded.a4_ticks, 0u);
  EXPECT_EQ(outcome->computed.ticks, recorded.given.rows.size());
  EXPECT_EQ(outcome->recorded.ticks, recorded.given.rows.size());
}

// Each line of kLiveSettings: a recording names it, has its changes, and a replay makes or ignores
// them.
TEST(AddedLiveSetting, IsInRecordingsAndTheirReplay) {
  const Recorded recorded(10'000);
  const auto reader = RecordingReader::open(recorded.path);
  ASSERT_TRUE(reader);
  const auto meta = reader->meta();
  ASSERT_TRUE(meta);
  const auto kinds = nlohmann::json::parse(std::get<std::string>(meta->at("input_kinds")));
  const auto& named = kinds.at(static_cast<std::size_t>(InputKind::kSetting)).at("settings");
  ASSERT_EQ(named.size(), kLiveSettings.size());
  for (std::size_t i = 0; i < kLiveSettings.size(); ++i) {
    const LiveSetting& setting = kLiveSettings[i];
    SCOPED_TRACE(setting.name);
    EXPECT_EQ(named[i].at("number"), setting.number);
    EXPECT_EQ(named[i].at("name"), setting.name);
    EXPECT_EQ(named[i].value("unit", ""), setting.of_run().unit);
    EXPECT_EQ(named[i].contains("choices"), !setting.words().empty());
    EXPECT_GT(recorded.given.settings[i], 0u);
    ReplayChange without;
    without.ignores[i] = true;
    const auto outcome = recorded.replay({.change = without});
    ASSERT_TRUE(outcome) << outcome.error().to_string();
    EXPECT_EQ(outcome->ignored_inputs, recorded.given.settings[i]);
  }
}

// A strategy has its own A4 and force: recorded switches of them are none that it refuses.
TEST(Replay, AnswersWhatIfWithAStrategyThatOwnsWhatWasSwitched) {
  const Recorded recorded(10'000);
  const auto reader = RecordingReader::open(recorded.path);
  ASSERT_TRUE(reader);
  for (const std::string name : {"a4-anticipate", "cd"}) {
    RecordedSession session = test::session_in(*reader);
    session.setup.haptics.strategy.reset();
    set_strategy(*parse_strategy(name), session.setup.haptics);
    ReplayChange change;
    change.ignores[live_setting("a4")] = true;
    change.ignores[live_setting("force")] = true;
    const auto outcome =
        replay_recording(*reader, session, recorded.scenario.scene(), {.change = change});
    ASSERT_TRUE(outcome) << name << ": " << outcome.error().to_string();
    EXPECT_EQ(outcome->ignored_inputs, recorded.given.settings[live_setting("a4")] +
                                           recorded.given.settings[live_setting("force")]);
    EXPECT_EQ(outcome->computed.ticks, recorded.given.rows.size());
  }
}

}  // namespace
}  // namespace palpate
