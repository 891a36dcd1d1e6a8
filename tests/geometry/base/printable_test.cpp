// Untrusted text, filtered for one line of a terminal.

#include "geometry/base/printable.h"

#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/helpers/random.h"

namespace palpate {
namespace {

// The filtered output of a text that is written in several parts.
std::string through_stream(const std::string& text, test::Random& random) {
  std::ostringstream stream;
  {
    const PrintableStream filter(stream);
    for (std::size_t begin = 0; begin < text.size();) {
      const std::size_t size = 1 + random.index(5);
      const std::string part = text.substr(begin, size);
      if (random.index(2) == 0) {
        stream << part;
      } else {
        for (const char c : part) stream.put(c);
      }
      if (random.index(4) == 0) stream.flush();
      begin += size;
    }
  }
  stream << "\x1b";  // the stream is restored
  std::string out = stream.str();
  EXPECT_EQ(out.back(), '\x1b');
  out.pop_back();
  return out;
}

TEST(Printable, ReplacesControlAndBidirectionalCharactersBySpaces) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"\x1b[31mred\x1b[0m", " [31mred [0m"},
      {"a\nb\rc\td\x07\x08\x7f", "a b c d   "},
      {std::string("a\0b", 3), "a b"},
      {"\u0085\u009b", "  "},
      {"\u202egnp.exe\u202c", " gnp.exe "},
      {"\u2066x\u2067y\u2068z\u2069", " x y z "},
      {"\u200e\u200f\u061c\u2028\u2029", "     "},
      {"\u2027\u202f\u00a0", "\u2027\u202f\u00a0"},
      {"\u00e4\u6f22\U0001f600\ufe0f\U000e0100", "\u00e4\u6f22\U0001f600\ufe0f\U000e0100"},
      // Invisible characters, which can hide a text.
      {"a\u00adb\u200bc\u200cd\u200de\u2060f\u2064g\u2065h\u206ai\ufeffj", "a b c d e f g h i j"},
      {"\u034f\u115f\u1160\u17b4\u180e\u3164\uffa0", "       "},
      {"a\U000e0000\U000e0041\U000e007fb", "a   b"},
      {"\xff\xfe \xc3", "?? ?"},
      {"\xc3\xc3\xa4", "?\u00e4"},
      {"\xf0\x9f\x98", "???"},
      {"\xe2\x80\x1b[0m", "?? [0m"},
      {"\xed\xa0\x80 \xc0\x80 \xf4\x90\x80\x80", "??? ?? ????"}};
  test::Random random(31);
  for (const auto& [text, expected] : cases) {
    EXPECT_EQ(printable(text), expected) << text;
    std::string in_lines = expected;
    if (text.starts_with("a\n")) in_lines[1] = '\n';
    for (int i = 0; i < 20; ++i) EXPECT_EQ(through_stream(text, random), in_lines) << text;
  }
}

TEST(Printable, FiltersAStreamLikeAText) {
  test::Random random(32);
  for (int round = 0; round < 2000; ++round) {
    std::string text;
    for (std::size_t n = random.index(40); n > 0; --n) {
      // Bytes that start or continue a character, and other bytes.
      static const std::string kBytes = "\x1b\xe2\x80\xae\xc2\x85\xf0\x9f\x98\x80 a\xff\xed\xa0";
      text += random.index(8) == 0 ? static_cast<char>(random.index(256))
                                   : kBytes[random.index(kBytes.size())];
    }
    std::string out = through_stream(text, random);
    for (char& c : out) c = c == '\n' ? ' ' : c;
    EXPECT_EQ(out, printable(text));
    EXPECT_EQ(printable(out), out);
  }
}

TEST(Printable, ReportsAStreamThatCannotBeWritten) {
  struct Full final : std::streambuf {
    int sync() override { return -1; }
  } full;
  std::ostream stream(&full);
  {
    const PrintableStream filter(stream);
    stream << "text" << std::flush;
    EXPECT_FALSE(stream);
  }
  EXPECT_FALSE(stream);
}

}  // namespace
}  // namespace palpate
