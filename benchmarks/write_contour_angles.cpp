// Measures the contact angles of a hand without delay on the paper's four objects and writes them
// as CSV.
//
// usage: write_contour_angles MODELS_DIR FILE

#include <cstdio>
#include <fstream>
#include <string>

#include "benchmarks/contour_angles.h"

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: write_contour_angles MODELS_DIR FILE\n");
    return 2;
  }
  const auto cases = palpate::bench::measure_contour_angles(argv[1]);
  if (!cases) {
    std::fprintf(stderr, "write_contour_angles: %s\n", cases.error().to_string().c_str());
    return 2;
  }
  std::ofstream file(argv[2], std::ios::binary);
  file << palpate::bench::contour_angles_csv(*cases) << std::flush;
  if (file.good()) return 0;
  std::fprintf(stderr, "write_contour_angles: %s: cannot be written\n", argv[2]);
  return 2;
}
