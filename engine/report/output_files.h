#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "geometry/base/result.h"

namespace palpate {

// The result files of one command in one folder. All files appear there together, or none does.
//
// The files are first written into a hidden folder inside this folder. If the command fails, or is
// killed while it writes, previous results remain unchanged; the next command that
// succeeds removes a hidden folder that a killed command has left. Moving the files into place also
// removes every file that has one of the command's names and was not written this time, so that the
// folder never contains old results beside new ones. If the command is killed during this move,
// some files may be missing. Those that are present are complete, and the file with the last of the
// names is present only if all others are. Other files in the folder are not touched. A link with
// one of the names is replaced; its target is unchanged. No name may belong to an input of the
// program (file_roles.h), also not through a link.
//
// As long as an object lives, other processes are kept out of the folder (OutputLock).
//
// Not for the haptic thread, because it does I/O. Only one thread may use an object.
class OutputFiles {
 public:
  // Creates the folder and its parents. names: all file names that the command may write. Returns
  // an error if the folder cannot be created or written to, if another process has it, or if one of
  // the names belongs to an input or to something other than a file.
  static Result<OutputFiles> create(const std::string& folder, std::vector<std::string> names);

  OutputFiles(OutputFiles&&) noexcept;
  OutputFiles& operator=(OutputFiles&&) noexcept;
  // If move_into_place() has not been called: removes the hidden folder, and the folders that
  // create() made.
  ~OutputFiles();

  // For a command that a signal may end at once before it has results: pause() removes the hidden
  // folder, and resume() makes it again. No file may be written between the two calls.
  void pause();
  std::optional<Error> resume();

  // The path at which to write the file of this name, which must be one of the names of create().
  std::string path(const std::string& name) const;

  // The hidden folder, for another program that writes files of these names.
  std::string hidden_folder() const;

  // error: an error from writing one of these files. Returns this error with the file's final path
  // instead of its path in the hidden folder.
  Error in_place(Error error) const;

  // Moves the files into place. If this fails, the previous files are kept or restored. Call it
  // once.
  std::optional<Error> move_into_place();

 private:
  struct State;
  explicit OutputFiles(std::unique_ptr<State> state);

  std::unique_ptr<State> state_;
};

}  // namespace palpate
