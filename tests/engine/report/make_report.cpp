// make_report accuracy FOLDER: writes a report of made-up data, for viewing and for the tests in a
// browser.

#include <cstdio>
#include <string>
#include <string_view>

#include "tests/engine/report/sample_reports.h"

namespace {

struct Sample {
  std::string_view name;
  bool (*write)(const std::string& folder);
};

constexpr Sample kSamples[] = {{"accuracy", palpate::test::write_accuracy_sample}};

}  // namespace

int main(int argc, char** argv) {
  for (const Sample& sample : kSamples) {
    if (argc == 3 && argv[1] == sample.name) return sample.write(argv[2]) ? 0 : 1;
  }
  std::fprintf(stderr, "usage: make_report accuracy FOLDER\n");
  return 2;
}
