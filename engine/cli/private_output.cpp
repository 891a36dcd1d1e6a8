#include "engine/cli/private_output.h"

#include <sys/stat.h>
#include <unistd.h>

namespace palpate {
namespace {

constexpr mode_t kOthers = S_IRWXG | S_IRWXO;

}  // namespace

std::optional<std::string> make_output_private() {
  struct stat file {};
  if (::fstat(STDOUT_FILENO, &file) != 0) return std::nullopt;
  if (!S_ISREG(file.st_mode) && !S_ISFIFO(file.st_mode)) return std::nullopt;
  const bool was_open = (file.st_mode & kOthers) != 0;
  const bool is_own = file.st_uid == ::geteuid();
  if (!was_open && is_own) return std::nullopt;
  // Some file systems keep no modes, and say that they have changed them.
  const bool is_private =
      !was_open || (::fchmod(STDOUT_FILENO, file.st_mode & S_IRWXU) == 0 &&
                    ::fstat(STDOUT_FILENO, &file) == 0 && (file.st_mode & kOthers) == 0);
  if (!is_private) {
    return "stdout is a file that others can read, and with it the address and its token; write it "
           "to a private file";
  }
  if (!is_own) {
    return "stdout is a file of another user, who can read the address and its token there";
  }
  return "stdout is a file that others could read; it is now only yours, because the address holds "
         "a secret";
}

}  // namespace palpate
