#include "engine/report/text_file.h"

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <system_error>

#include "engine/report/write_error.h"

namespace palpate {
Result<std::string> write_text_file(const std::string& path, std::string_view text) {
  errno = 0;
  std::FILE* const file = std::fopen(path.c_str(), "wb");
  if (!file) return write_error(path, errno);
  int failure = std::fwrite(text.data(), 1, text.size(), file) == text.size() ? 0 : errno;
  // fclose() writes the buffered text, so a full disk may be reported only here.
  if (std::fclose(file) != 0 && failure == 0) failure = errno;
  if (failure == 0) return path;
  std::error_code ignored;
  if (std::filesystem::is_regular_file(path, ignored)) std::filesystem::remove(path, ignored);
  return write_error(path, failure);
}

}  // namespace palpate
