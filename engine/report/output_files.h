#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "geometry/base/result.h"

namespace palpate {

// The files of one command in one folder, which appear there together or not at all.
//
// They are written into a hidden folder beside their place, so that a command that fails, or is
// killed, leaves what was there as it was; a hidden folder that a killed one has left is removed by
// the next command. Of the names that belong to the command, those that it has not written this
// time are removed when the others are moved into place: an old result never stands beside a new
// one. Nothing else in the folder is touched. A link that has such a name is replaced, and what it
// leads to stays as it is.
//
// Not for the haptic thread: it does I/O. One thread owns an object.
class OutputFiles {
 public:
  // Makes the folder with all above it. names: those that belong to the command. An error if the
  // folder cannot be made or written to, or if something that is no file has one of the names.
  static Result<OutputFiles> create(const std::string& folder, std::vector<std::string> names);

  OutputFiles(OutputFiles&&) noexcept;
  OutputFiles& operator=(OutputFiles&&) noexcept;
  // Without move_into_place(): leaves nothing behind, not even a folder that create() made.
  ~OutputFiles();

  // Where to write the file that will have this name, which is one of those that belong.
  std::string path(const std::string& name) const;

  // An error of writing such a file, under the path that the file was to have.
  Error in_place(Error error) const;

  // An error leaves, or puts back, what was there. To be called once.
  std::optional<Error> move_into_place();

 private:
  struct State;
  explicit OutputFiles(std::unique_ptr<State> state);

  std::unique_ptr<State> state_;
};

}  // namespace palpate
