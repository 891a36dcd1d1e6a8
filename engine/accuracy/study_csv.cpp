#include "engine/accuracy/study_csv.h"

#include <array>
#include <charconv>
#include <concepts>

#include "engine/report/text_file.h"

namespace palpate {
namespace {

constexpr int kSignificantDigits = 17;  // enough to give every double back

// One line. Fields are appended in the order of kStudyColumns.
class Line {
 public:
  explicit Line(std::string& out) : out_(out) {}
  ~Line() { out_.back() = '\n'; }
  Line(const Line&) = delete;
  Line& operator=(const Line&) = delete;

  Line& operator<<(std::string_view text) { return raw(csv_field(text)); }
  Line& operator<<(double value) {
    std::array<char, 32> text;
    const auto end = std::to_chars(text.data(), text.data() + text.size(), value,
                                   std::chars_format::general, kSignificantDigits);
    return raw({text.data(), end.ptr});
  }
  Line& operator<<(std::integral auto value) { return raw(std::to_string(value)); }
  Line& operator<<(bool flag) { return raw(flag ? "1" : "0"); }
  Line& skip(int count) {
    while (count-- > 0) raw("");
    return *this;
  }

 private:
  Line& raw(std::string_view text) {
    out_ += text;
    out_ += ',';
    return *this;
  }

  std::string& out_;
};

bool was_measured(const LevelResult& level) {
  return level.repeats > level.failures;
}

// From error_median to failure.
void put_measured(Line& line, const Knob& knob, const LevelResult& level, double floor) {
  if (was_measured(level)) {
    line << level.error.median << level.error.low << level.error.high << knob.error.unit
         << level.raw_error << floor << level.at_floor << level.time.median << level.time.low
         << level.time.high << knob.time.unit << level.iterations;
  } else {
    line.skip(3) << knob.error.unit;
    line.skip(1) << floor;
    line.skip(4) << knob.time.unit;
    line.skip(1);
  }
  line << level.ticks << level.repeats << level.failures << level.failure;
}

bool is(const LevelPlace& place, std::size_t method, std::size_t level) {
  return place.method == method && place.level == level;
}

void put_levels(std::string& out, const KnobResult& result) {
  const Knob& knob = result.knob;
  const LevelPlace usual{knob.default_method, knob.default_level};
  for (std::size_t m = 0; m < result.methods.size(); ++m) {
    const MethodResult& method = result.methods[m];
    for (std::size_t l = 0; l < method.levels.size(); ++l) {
      const LevelResult& level = method.levels[l];
      Line line(out);
      line << knob.name << method.name << level.label << level.value << knob.level.unit;
      put_measured(line, knob, level, method.floor);
      line << level.on_front << (result.recommended && is(*result.recommended, m, l))
           << is(usual, m, l);
      line.skip(1);
    }
  }
}

void put_presets(std::string& out, const KnobResult& result) {
  const Knob& knob = result.knob;
  const double floor = result.methods[knob.default_method].floor;
  for (const LevelResult& preset : result.presets) {
    Line line(out);
    line << knob.name;
    line.skip(3) << knob.level.unit;
    put_measured(line, knob, preset, floor);
    line.skip(3) << preset.label;
  }
}

}  // namespace

std::string csv_field(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + "\"";
}

std::string study_csv(std::span<const KnobResult> results) {
  std::string out = std::string(kStudyColumns) + "\n";
  for (const KnobResult& result : results) {
    put_levels(out, result);
    put_presets(out, result);
  }
  return out;
}

Result<std::string> write_study_csv(std::span<const KnobResult> results, const std::string& path) {
  return write_text_file(path, study_csv(results));
}

}  // namespace palpate
