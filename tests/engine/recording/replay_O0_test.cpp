// A recording of the optimised program is computed again to the bit by geometry and haptics that
// were compiled without optimisation. Needs PALPATE_WRITE_SCENARIO, the path of the optimised
// program.

#include <cstdlib>
#include <string>

#include <gtest/gtest.h>

#include "engine/recording/recording_replay.h"
#include "tests/engine/recording/scenario.h"
#include "tests/helpers/gltf_builder.h"
#include "tests/helpers/soak.h"

namespace palpate {
namespace {

TEST(ReplayWithoutOptimisation, GivesEveryBitOfTheOptimisedProgram) {
  const test::TemporaryFolder folder;
  const auto ticks = test::in_soak_or_else<std::uint64_t>(600'000, 20'000);
  const std::string command =
      std::string(PALPATE_WRITE_SCENARIO) + " " + folder.path() + " " + std::to_string(ticks);
  ASSERT_EQ(std::system(command.c_str()), 0);
  const auto reader = RecordingReader::open(folder.path("a.palpate"));
  ASSERT_TRUE(reader) << reader.error().to_string();
  const test::Scenario scenario(17);
  const auto outcome = replay_recording(*reader, test::session_in(*reader), scenario.scene());
  ASSERT_TRUE(outcome) << outcome.error().to_string();
  EXPECT_FALSE(outcome->difference)
      << "tick " << outcome->difference->tick << " " << outcome->difference->column << " "
      << outcome->difference->recorded << " " << outcome->difference->computed;
  EXPECT_EQ(outcome->proved, ticks);
}

}  // namespace
}  // namespace palpate
