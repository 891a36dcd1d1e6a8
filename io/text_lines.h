#pragma once

// Reads a text file line by line, with a bounded line.

#include <cstddef>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/base/result.h"

namespace palpate {

// A line ends with LF, CRLF or CR. A byte order mark of UTF-8 at the beginning is skipped. UTF-16
// and UTF-32 are errors that name the encoding. One thread owns a reader.
class TextLines {
 public:
  // Longer than any line of numbers and a comment; prevents reading a binary file as a whole.
  static constexpr std::size_t kMostBytes = 1u << 16;

  // expected: what the file should be, for the hint of an error.
  static Result<TextLines> open(const std::string& path, std::string expected);

  // Reads the next line, without its end. The text is valid until the next call. False at the end
  // of the file, and after an error: see error().
  bool next();
  std::string_view line() const { return line_; }
  std::size_t number() const { return number_; }  // from 1
  bool is_whole() const { return is_whole_; }     // the line ended with LF, CRLF or CR
  const std::optional<Error>& error() const { return error_; }

 private:
  TextLines(const std::string& path, std::ifstream file);
  // The next byte, or -1 at the end.
  int take();
  bool fill();
  bool begin();
  bool fail(std::string element, std::string problem, std::string hint);

  std::string path_;
  std::ifstream file_;
  std::vector<char> block_;
  std::size_t next_ = 0;
  std::size_t end_ = 0;
  std::string line_;
  std::size_t number_ = 0;
  bool is_whole_ = false;
  std::optional<Error> error_;
};

}  // namespace palpate
