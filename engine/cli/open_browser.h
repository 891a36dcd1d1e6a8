#pragma once

// Opens a page with a secret in its address.

#include <memory>
#include <string>

#include "geometry/base/result.h"

namespace palpate {

// Hands the browser (xdg-open) a file that only this user can read and that forwards to the
// address: everybody on the machine can read command lines. The destructor removes the file.
class OpenedBrowser {
 public:
  // Errors: no file can be written, or xdg-open cannot be started.
  static Result<std::unique_ptr<OpenedBrowser>> open(const std::string& address);
  ~OpenedBrowser();
  OpenedBrowser(const OpenedBrowser&) = delete;
  OpenedBrowser& operator=(const OpenedBrowser&) = delete;

 private:
  explicit OpenedBrowser(std::string path) : path_(std::move(path)) {}

  std::string path_;
};

}  // namespace palpate
