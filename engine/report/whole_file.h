#pragma once

// A file that is there when it is whole.

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "geometry/base/result.h"

namespace palpate {

// The file appears under its name when finish() succeeds, replacing what was there; until then the
// text is in memory and in a file ".part" beside it that goes with this object; one that a killed
// process has left goes with the next file of that name. What is no regular file (a pipe, a
// terminal) is written to directly. Not for the haptic thread: it does I/O. One thread owns it.
class WholeFile {
 public:
  // Fails where the file could not be created.
  static Result<WholeFile> create(const std::string& path);

  WholeFile(WholeFile&&) noexcept;
  WholeFile& operator=(WholeFile&&) noexcept;
  ~WholeFile();  // without finish(): leaves nothing behind

  // A failure to write shows in finish(). Text after finish() is dropped.
  void add(std::string_view text);

  // Fails if any byte could not be written, and then leaves whatever had the file's name as it was.
  // To be called once.
  std::optional<Error> finish();

 private:
  class Output;
  explicit WholeFile(std::unique_ptr<Output> output);

  std::unique_ptr<Output> output_;  // null after finish()
};

}  // namespace palpate
