#pragma once

// Reads JSON files that users write: plans and operator files. Any key that is not expected is an
// error, because otherwise a misspelt key would silently leave a default unchanged.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "engine/session/number_range.h"
#include "geometry/base/result.h"

namespace palpate {

// The size of such a file is a few kilobytes. The limit bounds the memory that a hostile file can
// take.
inline constexpr std::uint64_t kMostSettingsBytes = std::uint64_t{1} << 20;
inline constexpr std::size_t kMostNameBytes = 100;
inline constexpr std::size_t kMostProseBytes = 2000;

// Parses the text of a file; a byte order mark at its start is ignored. Errors: a zero byte, deep
// nesting (scan_json), a syntax error, a number beyond the range of a double, a repeated key.
// path: for Error::path.
Result<nlohmann::json> parse_strict_json(std::string_view text, const std::string& path);

// The content of a file of at most most_bytes.
Result<std::string> read_settings_text(const std::string& path,
                                       std::uint64_t most_bytes = kMostSettingsBytes);

// Six digits, as messages show limits: "0.25".
std::string number_text(double value);

// "a number above 0 and at most 100", "a number from 2 to 3", "a finite number"
std::string text_of(const NumberRange& range);

// The error "ELEMENT: is FOUND; expected EXPECTED" for a value of any type.
Error unexpected_value(const std::string& element, const nlohmann::json& found,
                       const std::string& expected, std::string hint = {});

// The values of one JSON object. Each function sets its argument to the value of a key. After the
// first error, further calls do nothing. finish() must be called at the end. If the object has a
// key that no call has asked for, finish() returns an error about this key even after another
// error, because a misspelt key also causes the error of a missing key. Otherwise finish() returns
// the first error.
class ObjectReader {
 public:
  enum class Key : std::uint8_t { kRequired, kOptional };

  // element: the JSON path of the object, "" for the root. The value must outlive the reader.
  ObjectReader(const nlohmann::json& value, std::string element);

  // The value of a key, or null if it is absent or an error has occurred.
  const nlohmann::json* find(const char* key, Key need = Key::kRequired);
  // A text of 1 to most_bytes bytes without control characters.
  void text(const char* key, std::string& value, Key need = Key::kRequired,
            std::size_t most_bytes = kMostNameBytes);
  void flag(const char* key, bool& value, Key need = Key::kRequired);
  void number(const char* key, double& value, const NumberRange& range, Key need = Key::kRequired);
  void number(const char* key, std::optional<double>& value, const NumberRange& range);  // optional
  // A whole number, also in the form 3.0.
  void whole(const char* key, std::uint64_t& value, std::uint64_t least, std::uint64_t most,
             Key need = Key::kRequired);
  void whole(const char* key, int& value, int least, int most, Key need = Key::kRequired);
  // A list of this many numbers.
  void numbers(const char* key, std::vector<double>& values, std::size_t count,
               Key need = Key::kRequired);
  // One of a few words; value becomes its index.
  void choice(const char* key, std::size_t& value, const std::vector<std::string_view>& words,
              Key need = Key::kRequired);
  // A list of one or more of these words, none of them twice; values become their indices.
  void choices(const char* key, std::vector<std::size_t>& values,
               const std::vector<std::string_view>& words);

  std::string element_of(const std::string& key) const { return element_ + "/" + key; }
  void fail(Error error);
  bool ok() const { return !error_; }
  std::optional<Error> finish();

 private:
  const nlohmann::json& object_;
  std::string element_;
  std::vector<std::string> asked_;
  std::optional<Error> error_;
};

// "a, b or c"
std::string joined_words(const std::vector<std::string_view>& words);

}  // namespace palpate
