#pragma once

// Errors as values. No exception crosses a public function of Palpate.

#include <cassert>
#include <string>
#include <utility>
#include <variant>

namespace palpate {

enum class ErrorCode {
  kFileNotFound,
  kFileUnreadable,
  kFileUnwritable,
  kNotGltf,         // neither a GLB container nor JSON that is a glTF asset
  kUnsupported,     // valid, but needs a feature that this build does not support
  kInvalidContent,  // breaks a rule of its format
  kLimitExceeded,   // within its format's rules, beyond this program's documented limits
  kOutOfMemory,     // the system refused memory; a limit of this program gives kLimitExceeded
  kEmptyScene,      // no triangle with area
  kInvalidArgument,
};

// An error: where it occurred, what was found, what was expected and what to do, each in a few
// words.
struct Error {
  ErrorCode code = ErrorCode::kInvalidArgument;
  std::string path;     // the file, as the caller named it; empty if none
  std::string element;  // JSON path ("/accessors/3/count"), line number or option; may be empty
  std::string problem;  // what was found and what was expected
  std::string hint;     // what the user can do; may be empty

  // One line, without a newline: "path: element: problem (hint)".
  std::string to_string() const {
    std::string line;
    for (const std::string* part : {&path, &element}) {
      if (!part->empty()) line += *part + ": ";
    }
    line += problem;
    if (!hint.empty()) line += " (" + hint + ")";
    for (char& c : line) {
      if (c == '\n' || c == '\r') c = ' ';
    }
    return line;
  }
};

// An Error for an argument, setting or option that the caller passed; `element` names it.
inline Error invalid_argument(std::string element, std::string problem, std::string hint = "") {
  return {ErrorCode::kInvalidArgument, "", std::move(element), std::move(problem), std::move(hint)};
}

// A value of type T, or the Error that prevented the value.
template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value) : content_(std::move(value)) {}      // NOLINT(google-explicit-constructor)
  Result(Error error) : content_(std::move(error)) {}  // NOLINT(google-explicit-constructor)

  bool ok() const { return std::holds_alternative<T>(content_); }
  explicit operator bool() const { return ok(); }

  // Requires ok().
  T& value() {
    assert(ok());
    return std::get<T>(content_);
  }
  const T& value() const {
    assert(ok());
    return std::get<T>(content_);
  }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }
  T& operator*() { return value(); }
  const T& operator*() const { return value(); }

  // Requires !ok().
  const Error& error() const {
    assert(!ok());
    return std::get<Error>(content_);
  }

 private:
  std::variant<T, Error> content_;
};

}  // namespace palpate
