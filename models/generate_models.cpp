// generate_models OUTPUT_DIR: regenerates the model files of this folder.

#include <cstdio>
#include <string>

#include "models/glb_writer.h"
#include "models/model_files.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: generate_models OUTPUT_DIR\n");
    return 2;
  }
  const auto files = palpate::model_files();
  if (!files) {
    std::fprintf(stderr, "generate_models: %s\n", files.error().to_string().c_str());
    return 1;
  }
  for (const palpate::ModelFile& file : *files) {
    const std::string path = std::string(argv[1]) + "/" + file.file_name;
    const auto written = palpate::write_file(path, file.bytes);
    if (!written) {
      std::fprintf(stderr, "generate_models: %s\n", written.error().to_string().c_str());
      return 1;
    }
    std::printf("%s: %zu bytes\n", path.c_str(), *written);
  }
  return 0;
}
