#pragma once

// A file that appears only when it is complete.

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "geometry/base/result.h"

namespace palpate {

// The file appears under its name when finish() succeeds, replacing its predecessor. Until then the
// text is in memory and in a temporary file beside it, whose name ends with ".part" and which the
// destructor removes. A temporary file that a killed process has left is removed when the same file
// is next created. A path that is not a regular file (a pipe, a terminal) is written to directly.
// Not for the haptic thread: it does I/O. One thread owns it.
class WholeFile {
 public:
  // An error if the file cannot be created.
  static Result<WholeFile> create(const std::string& path);

  WholeFile(WholeFile&&) noexcept;
  WholeFile& operator=(WholeFile&&) noexcept;
  ~WholeFile();  // without finish(): removes the temporary file

  // finish() reports a failure to write. Text added after finish() is discarded.
  void add(std::string_view text);

  // An error if any byte could not be written; the previous file is then unchanged. Call it once.
  std::optional<Error> finish();

 private:
  class Output;
  explicit WholeFile(std::unique_ptr<Output> output);

  std::unique_ptr<Output> output_;  // null after finish()
};

}  // namespace palpate
