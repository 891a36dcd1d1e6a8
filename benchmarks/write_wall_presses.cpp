// Presses walls with each named strategy and writes the means as CSV.
//
// usage: write_wall_presses FILE STRATEGY...

#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include "benchmarks/wall_presses.h"

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: write_wall_presses FILE STRATEGY...\n");
    return 2;
  }
  const auto presses = palpate::bench::press_walls(std::vector<std::string>(argv + 2, argv + argc));
  if (!presses) {
    std::fprintf(stderr, "write_wall_presses: %s\n", presses.error().to_string().c_str());
    return 2;
  }
  std::ofstream file(argv[1], std::ios::binary);
  file << palpate::bench::wall_presses_csv(*presses) << std::flush;
  if (file.good()) return 0;
  std::fprintf(stderr, "write_wall_presses: %s: cannot be written\n", argv[1]);
  return 2;
}
