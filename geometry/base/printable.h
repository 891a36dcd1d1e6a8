#pragma once

// Text that comes from outside (names in files, arguments), made fit for one line of a document or
// a terminal.

#include <array>
#include <cstddef>
#include <ostream>
#include <streambuf>
#include <string>
#include <string_view>

namespace palpate {

// The same text, with a space for each control character, end of a line, change of the direction of
// writing and invisible character that can hide a text (soft hyphen, signs of zero width, fillers,
// U+FEFF, and the tags U+E0000 to U+E007F: two names that look alike would differ by them, or say
// what nobody reads), and "?" for each byte that is not part of valid UTF-8. Variation selectors
// stay: they choose how the character before them looks.
std::string printable(std::string_view text);

// Passes on what is written to it likewise, but for ends of lines. Allocates nothing.
class PrintableBuffer final : public std::streambuf {
 public:
  explicit PrintableBuffer(std::streambuf* to) : to_(to) {}
  // What has begun as a character ends here.
  void finish() { put_held(true); }

 protected:
  int_type overflow(int_type c) override;
  std::streamsize xsputn(const char* text, std::streamsize size) override;
  int sync() override { return to_->pubsync(); }

 private:
  bool put_raw(std::string_view text);
  bool put(std::string_view text);
  bool put_held(bool is_last);

  std::streambuf* to_;
  std::array<char, 4> held_;  // the beginning of a character
  std::size_t held_count_ = 0;
};

// While it lives, nothing but printable text gets out of a stream, whoever writes to it: no name in
// a file commands a terminal. The names in a line must be printable() all the same, which takes the
// ends of lines out of them.
class PrintableStream {
 public:
  explicit PrintableStream(std::ostream& stream);
  ~PrintableStream();
  PrintableStream(const PrintableStream&) = delete;
  PrintableStream& operator=(const PrintableStream&) = delete;

 private:
  std::ostream& stream_;
  std::streambuf* unfiltered_;
  PrintableBuffer buffer_;
};

}  // namespace palpate
