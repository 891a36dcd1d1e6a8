#include "io/text_lines.h"

#include <cerrno>
#include <filesystem>
#include <system_error>
#include <utility>

#include "io/open_error.h"

namespace palpate {
namespace {

constexpr std::size_t kBlockBytes = 1u << 16;

// The name of an encoding other than UTF-8, by the first bytes of a text of digits and letters.
std::string_view foreign_encoding(std::string_view bytes) {
  using namespace std::string_view_literals;
  if (bytes.starts_with("\xff\xfe\0\0"sv) || bytes.starts_with("\0\0\xfe\xff"sv)) return "UTF-32";
  if (bytes.starts_with("\xff\xfe"sv) || bytes.starts_with("\xfe\xff"sv)) return "UTF-16";
  // Without a mark: one byte of each of the first two letters is 0.
  if (bytes.size() < 4) return {};
  const auto is_zero = [&](std::size_t i) { return bytes[i] == '\0'; };
  if (!is_zero(0) && is_zero(1) && !is_zero(2) && is_zero(3)) return "UTF-16";
  if (is_zero(0) && !is_zero(1) && is_zero(2) && !is_zero(3)) return "UTF-16";
  return {};
}

}  // namespace

TextLines::TextLines(const std::string& path, std::ifstream file)
    : path_(path), file_(std::move(file)), block_(kBlockBytes) {}

Result<TextLines> TextLines::open(const std::string& path, std::string expected) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) return open_error(path, EISDIR, expected);
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) return open_error(path, errno != 0 ? errno : EIO, expected);
  return TextLines(path, std::move(file));
}

bool TextLines::fail(std::string element, std::string problem, std::string hint) {
  error_ = Error{ErrorCode::kInvalidContent, path_, std::move(element), std::move(problem),
                 std::move(hint)};
  return false;
}

bool TextLines::fill() {
  next_ = 0;
  file_.read(block_.data(), static_cast<std::streamsize>(block_.size()));
  end_ = static_cast<std::size_t>(file_.gcount());
  return end_ > 0;
}

int TextLines::take() {
  if (next_ == end_ && !fill()) return -1;
  return static_cast<unsigned char>(block_[next_++]);
}

// Looks at the first bytes.
bool TextLines::begin() {
  fill();
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  const std::string_view bytes(block_.data(), end_);
  if (bytes.starts_with(kByteOrderMark)) next_ = kByteOrderMark.size();
  const std::string_view encoding = foreign_encoding(bytes);
  if (encoding.empty()) return true;
  return fail("", "is text in " + std::string(encoding) + "; expected UTF-8 or ASCII",
              "save the file as UTF-8, or convert it with iconv");
}

bool TextLines::next() {
  if (error_ || (number_ == 0 && !begin())) return false;
  line_.clear();
  is_whole_ = false;
  ++number_;
  for (int c = take(); c >= 0; c = take()) {
    if (c == '\n' || c == '\r') {
      is_whole_ = true;
      if (c == '\n') return true;
      if (take() != '\n' && end_ > 0) --next_;
      return true;
    }
    if (line_.size() == kMostBytes) {
      return fail("line " + std::to_string(number_),
                  "is longer than " + std::to_string(kMostBytes) + " bytes",
                  "write one position on each line");
    }
    line_ += static_cast<char>(c);
  }
  if (file_.bad()) {
    error_ = Error{ErrorCode::kFileUnreadable, path_, "", "cannot be read to the end", ""};
    return false;
  }
  return !line_.empty();
}

}  // namespace palpate
