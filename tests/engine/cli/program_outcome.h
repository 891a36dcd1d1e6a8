#pragma once

// What a run of the program comes to, and what it leaves in files.

#include <fstream>
#include <iterator>
#include <string>

namespace palpate::test {

struct Outcome {
  int exit_code = -1;  // -1: ended by a signal
  std::string out;
  std::string err;
};

inline std::string content_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace palpate::test
