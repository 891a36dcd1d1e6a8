// Writes the seeds of the fuzz target: make_fuzz_seeds FOLDER.

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <utility>

#include "tests/helpers/compressed_seeds.h"
#include "tests/helpers/gltf_seeds.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: make_fuzz_seeds FOLDER\n");
    return 2;
  }
  const std::filesystem::path folder(argv[1]);
  std::filesystem::create_directories(folder);
  auto seeds = palpate::test::gltf_seeds();
  for (auto& seed : palpate::test::compressed_gltf_seeds()) seeds.push_back(std::move(seed));
  for (const auto& [name, bytes] : seeds) {
    std::ofstream file(folder / name, std::ios::binary);
    file << bytes;
    if (!file.flush()) {
      std::fprintf(stderr, "cannot write %s\n", (folder / name).c_str());
      return 1;
    }
  }
  return 0;
}
