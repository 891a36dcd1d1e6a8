#pragma once

// Filters untrusted text (names in files, arguments) for output on one line of a document or
// terminal.

#include <array>
#include <cstddef>
#include <ostream>
#include <streambuf>
#include <string>
#include <string_view>

namespace palpate {

// Returns the text with a space in place of each control character, line end, bidirectional control
// and invisible character, and with "?" in place of each byte that is not part of valid UTF-8.
//
// The invisible characters are the soft hyphen, zero-width characters, fillers, U+FEFF and the tags
// U+E0000 to U+E007F. With these characters, two different names could look alike, or a name could
// contain hidden text. Variation selectors are kept, because they select the glyph of the
// preceding character.
std::string printable(std::string_view text);

// A stream buffer that filters text like printable() but keeps line ends. Does not allocate.
class PrintableBuffer final : public std::streambuf {
 public:
  explicit PrintableBuffer(std::streambuf* to) : to_(to) {}
  // Ends the output. An incomplete character at the end is replaced like invalid UTF-8.
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
  std::array<char, 4> held_;  // the first bytes of an incomplete character
  std::size_t held_count_ = 0;
};

// While this object lives, all text written to a stream is filtered by a PrintableBuffer, so that a
// name in a file cannot send control sequences to a terminal. Code that writes a name must still
// call printable(), because the stream keeps the line ends of a name.
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
