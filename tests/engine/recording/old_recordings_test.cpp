// Recordings of earlier versions, in the folder data: a simulated hand with A4, a pantograph behind
// a simulated board while the scene's node moves, and the scenario, with moved nodes, changed
// materials and each kind of input. They must be computed again to the bit by every later version.

#include <string>

#include <gtest/gtest.h>

#include "engine/recording/recording_replay.h"
#include "tests/engine/recording/scenario.h"

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

INSTANTIATE_TEST_SUITE_P(Of0Point1, OldRecordings,
                         testing::Values(OldRecording{"hand", 2000, false},
                                         OldRecording{"device", 1452, false},
                                         OldRecording{"nodes", 400, true}),
                         [](const auto& instance) { return instance.param.name; });

}  // namespace
}  // namespace palpate
