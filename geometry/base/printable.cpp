#include "geometry/base/printable.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace palpate {
namespace {

constexpr char32_t kLargest = 0x10FFFF;
constexpr char32_t kFirstSurrogate = 0xD800;
constexpr char32_t kLastSurrogate = 0xDFFF;
// The noncharacters at the end of the basic plane: XML does not allow them.
constexpr char32_t kFirstNoncharacter = 0xFFFE;
constexpr char32_t kLastNoncharacter = 0xFFFF;

bool is_continuation(char c) {
  return (static_cast<std::uint8_t>(c) & 0xC0) == 0x80;
}

// The length in bytes of a UTF-8 sequence, from its first byte; 0 if no sequence begins with it.
std::size_t announced_length(std::uint8_t first) {
  if (first < 0x80) return 1;
  if (first >= 0xC2 && first < 0xE0) return 2;
  if (first >= 0xE0 && first < 0xF0) return 3;
  if (first >= 0xF0 && first < 0xF5) return 4;
  return 0;
}

// The first character of a text that is not empty. `length` covers the whole character, the
// available bytes of an unfinished character, or one byte of a broken sequence.
struct Front {
  enum class Kind { kShown, kControl, kBroken, kUnfinished };
  Kind kind;
  std::size_t length;  // bytes
};

bool is_between(char32_t code, char32_t first, char32_t last) {
  return code >= first && code <= last;
}

// Characters without a glyph that can hide a text or a difference between two texts: the soft
// hyphen, fillers, joiners, zero-width characters, the byte order mark, and tags, which can spell
// whole sentences. They are a subset of Unicode's property Default_Ignorable_Code_Point; variation
// selectors are not included.
bool is_invisible(char32_t code) {
  return code == 0x00AD || code == 0x034F || is_between(code, 0x115F, 0x1160) ||
         is_between(code, 0x17B4, 0x17B5) || code == 0x180E || is_between(code, 0x200B, 0x200F) ||
         is_between(code, 0x2060, 0x206F) || code == 0x3164 || code == 0xFEFF || code == 0xFFA0 ||
         is_between(code, 0xE0000, 0xE00FF);
}

// Control characters (C0, DEL, C1), line and paragraph separators, bidirectional controls
// (Unicode's property Bidi_Control), which can make a text display as a different text, and
// invisible characters.
bool is_control(char32_t code) {
  return code < 0x20 || is_between(code, 0x7F, 0x9F) || code == 0x061C ||
         is_between(code, 0x2028, 0x202E) || is_invisible(code);
}

Front front_of(std::string_view text) {
  constexpr std::uint8_t kPayload[] = {0, 0x7F, 0x1F, 0x0F, 0x07};
  constexpr char32_t kSmallest[] = {0, 0, 0x80, 0x800, 0x10000};
  const auto first = static_cast<std::uint8_t>(text.front());
  const std::size_t length = announced_length(first);
  if (length == 0) return {Front::Kind::kBroken, 1};
  char32_t code = first & kPayload[length];
  for (std::size_t i = 1; i < length; ++i) {
    if (i == text.size()) return {Front::Kind::kUnfinished, i};
    if (!is_continuation(text[i])) return {Front::Kind::kBroken, 1};
    code = (code << 6) | (static_cast<std::uint8_t>(text[i]) & 0x3F);
  }
  const bool is_broken = code < kSmallest[length] || code > kLargest ||
                         is_between(code, kFirstSurrogate, kLastSurrogate) ||
                         is_between(code, kFirstNoncharacter, kLastNoncharacter);
  if (is_broken) return {Front::Kind::kBroken, 1};
  return {is_control(code) ? Front::Kind::kControl : Front::Kind::kShown, length};
}

// The output for a character: the character itself, or its replacement.
std::string_view shown(std::string_view text, const Front& front) {
  if (front.kind == Front::Kind::kShown) return text.substr(0, front.length);
  return front.kind == Front::Kind::kControl ? " " : "?";
}

// Most texts contain only plain characters.
bool is_plain(char c) {
  return (c >= ' ' && c <= '~') || c == '\n';
}

}  // namespace

std::string printable(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    Front front = front_of(text);
    if (front.kind == Front::Kind::kUnfinished) front = {Front::Kind::kBroken, 1};
    out += shown(text, front);
    text.remove_prefix(front.length);
  }
  return out;
}

PrintableBuffer::int_type PrintableBuffer::overflow(int_type c) {
  if (traits_type::eq_int_type(c, traits_type::eof())) return traits_type::not_eof(c);
  const char one = traits_type::to_char_type(c);
  return put({&one, 1}) ? c : traits_type::eof();
}

std::streamsize PrintableBuffer::xsputn(const char* text, std::streamsize size) {
  return put({text, static_cast<std::size_t>(size)}) ? size : 0;
}

bool PrintableBuffer::put_raw(std::string_view text) {
  const auto size = static_cast<std::streamsize>(text.size());
  return to_->sputn(text.data(), size) == size;
}

bool PrintableBuffer::put(std::string_view text) {
  while (!text.empty()) {
    if (held_count_ == 0 && is_plain(text.front())) {
      const auto* const end = std::find_if_not(text.begin(), text.end(), is_plain);
      const auto length = static_cast<std::size_t>(end - text.begin());
      if (!put_raw(text.substr(0, length))) return false;
      text.remove_prefix(length);
      continue;
    }
    held_[held_count_++] = text.front();
    text.remove_prefix(1);
    if (!put_held(false)) return false;
  }
  return true;
}

// Writes the complete characters of the held bytes. For a broken sequence, only its first byte is
// replaced: the following held bytes may begin another character.
bool PrintableBuffer::put_held(bool is_last) {
  while (held_count_ > 0) {
    const std::string_view held(held_.data(), held_count_);
    Front front = front_of(held);
    if (front.kind == Front::Kind::kUnfinished) {
      if (!is_last) return true;
      front = {Front::Kind::kBroken, 1};
    }
    const bool is_done = held.front() == '\n' ? put_raw("\n") : put_raw(shown(held, front));
    std::copy(held_.begin() + front.length, held_.begin() + held_count_, held_.begin());
    held_count_ -= front.length;
    if (!is_done) return false;
  }
  return true;
}

PrintableStream::PrintableStream(std::ostream& stream)
    : stream_(stream), unfiltered_(stream.rdbuf()), buffer_(unfiltered_) {
  stream_.rdbuf(&buffer_);
}

PrintableStream::~PrintableStream() {
  buffer_.finish();
  const auto state = stream_.rdstate();
  stream_.rdbuf(unfiltered_);  // clears the state
  stream_.clear(state);
}

}  // namespace palpate
