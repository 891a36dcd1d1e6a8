// Records the scenario: FOLDER/a.palpate, FOLDER/scenario.glb (any bytes) and FOLDER/rows, the rows
// that the recorder was handed, one after the other.
//
// usage: write_scenario FOLDER [TICKS]

#include <fstream>
#include <iostream>
#include <string>

#include "tests/engine/recording/scenario.h"

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  const std::string folder = std::string(argv[1]) + "/";
  const std::uint64_t ticks = argc > 2 ? std::stoull(argv[2]) : 3'000;
  std::ofstream(folder + "scenario.glb") << "any bytes";
  palpate::test::Scenario scenario(17, {.ticks = ticks});
  const auto given =
      palpate::test::recorded_scenario(scenario, folder + "scenario.glb", folder + "a.palpate");
  std::ofstream rows(folder + "rows", std::ios::binary);
  rows.write(reinterpret_cast<const char*>(given.rows.data()),
             static_cast<std::streamsize>(given.rows.size() * sizeof given.rows[0]));
  return testing::Test::HasFailure() || !rows.good() ? 1 : 0;
}
