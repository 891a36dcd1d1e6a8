#include "engine/accuracy/accuracy_csv.h"

#include "engine/report/csv.h"

namespace palpate {
namespace {

// Appends fields to a line that ends with this object.
class Line {
 public:
  explicit Line(CsvLines& lines) : lines_(lines) {}
  ~Line() { lines_.end_line(); }
  Line(const Line&) = delete;
  Line& operator=(const Line&) = delete;

  template <typename Value>
  Line& operator<<(const Value& value) {
    lines_.add(value);
    return *this;
  }
  Line& skip(int fields) {
    lines_.skip(fields);
    return *this;
  }

 private:
  CsvLines& lines_;
};

// From error_median to failure.
void put_measured(Line& line, const Knob& knob, const LevelResult& level, double floor) {
  if (level.was_measured()) {
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

void put_levels(CsvLines& out, const KnobResult& result) {
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

void put_presets(CsvLines& out, const KnobResult& result) {
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

std::string accuracy_csv(std::span<const KnobResult> results) {
  CsvLines out(kAccuracyColumns);
  for (const KnobResult& result : results) {
    put_levels(out, result);
    put_presets(out, result);
  }
  return out.text();
}

}  // namespace palpate
