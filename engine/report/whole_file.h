#pragma once

// A file that appears only when it is complete.

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "geometry/base/result.h"

namespace palpate {

// The file appears under its name when finish() succeeds, and replaces its predecessor. Until then,
// the text is in memory and in a temporary file in the same folder. The name of the temporary file
// ends with ".part"; the destructor removes this file. If a killed process has left a temporary
// file, the next create() for the same path removes it. If the path does not denote a regular file
// but, for example, a pipe or a terminal, the text is written directly to this pipe or terminal.
// As long as an object lives, commands that want the folder of the file for themselves are kept out
// of it (OutputLock); a file that is not in a folder of results shares its folder with others.
// Not for the haptic thread, because it does I/O. Only one thread may use an object.
class WholeFile {
 public:
  // Returns an error if the file cannot be created, or if another process has its folder alone.
  static Result<WholeFile> create(const std::string& path);

  WholeFile(WholeFile&&) noexcept;
  WholeFile& operator=(WholeFile&&) noexcept;
  ~WholeFile();  // removes the temporary file if finish() has not been called

  // Adds text to the file. finish() reports write errors. Text added after finish() is discarded.
  void add(std::string_view text);

  // Returns an error if any byte could not be written; the previous file is then unchanged. Call
  // this function once.
  std::optional<Error> finish();

 private:
  class Output;
  explicit WholeFile(std::unique_ptr<Output> output);

  std::unique_ptr<Output> output_;  // null after finish()
};

}  // namespace palpate
