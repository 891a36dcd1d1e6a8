#include "engine/recording/recording_replay.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <memory>
#include <span>
#include <system_error>
#include <utility>

#include "engine/recording/block_walk.h"
#include "engine/recording/recorded_tick.h"
#include "engine/rig/rig.h"
#include "haptics/check_settings.h"
#include "haptics/effects/effect_program.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

// A device that senses what the recorded one sensed.
class RecordedDevice final : public Device {
 public:
  // has_all_motors: every sensed axis has a motor, whatever was recorded.
  RecordedDevice(DeviceDescription description, bool has_all_motors)
      : description_(std::move(description)), has_all_motors_(has_all_motors) {
    if (has_all_motors_) give_all_motors(description_, description_.sensed_axes);
  }

  void set_row(const TickReading& reading, bool asks_for_trip) {
    std::copy_n(reading.sample_m, 3, sample_.position_m.begin());
    sample_.buttons = reading.buttons;
    sample_.sequence = reading.sequence;
    sample_.time_ns = reading.sample_ns;
    sample_.is_valid = reading.is_valid != 0;
    sample_.asks_for_trip = asks_for_trip;
  }
  void set_motors(std::span<const std::byte> bytes) {
    if (has_all_motors_) return;
    motor_count_ = bytes.size() / sizeof(MotorDescription);
    const auto target = std::as_writable_bytes(std::span(motors_).first(motor_count_));
    std::copy_n(bytes.begin(), target.size(), target.begin());
  }

  const DeviceDescription& description() const noexcept override { return description_; }
  DeviceSample read(double) noexcept override { return sample_; }
  void command(const DeviceCommand&) noexcept override {}
  std::span<const MotorDescription> motors_now() const noexcept override {
    return std::span(motors_).first(motor_count_);
  }

 private:
  DeviceDescription description_;
  DeviceSample sample_;
  std::array<MotorDescription, 3> motors_{};
  std::size_t motor_count_ = 0;
  bool has_all_motors_;
};

// The parameters of a call of the effect program.
struct CallParameters {
  std::uint16_t effect = 0;
  std::size_t count = 0;  // of bytes
  alignas(std::max_align_t) std::array<std::byte, 128> bytes{};
  std::span<const std::byte> span() const { return std::span(bytes).first(count); }
};

// The scene's parameters with the numbers of an input. No value: the scene has no such call, or its
// effect has another number of keys.
std::optional<CallParameters> parameters_of(const TickInput& input, const ContactWorld& world) {
  if (!world.effects || input.handle >= world.effects->calls.size()) return std::nullopt;
  const EffectCall& call = world.effects->calls[input.handle];
  const EffectType& effect = compiled_effects()[call.effect];
  CallParameters parameters{call.effect, effect.parameter_bytes, {}};
  if (input.bytes.size() != effect.keys.size() * sizeof(double)) return std::nullopt;
  if (parameters.count > parameters.bytes.size()) return std::nullopt;
  std::copy_n(world.effects->parameters.begin() + call.parameters, parameters.count,
              parameters.bytes.begin());
  std::size_t at = 0;
  for (const ParameterKey& key : effect.keys) {
    std::memcpy(parameters.bytes.data() + key.offset, input.bytes.data() + at, sizeof(double));
    at += sizeof(double);
  }
  return parameters;
}

// Makes the recorded changes of a tick.
class RecordedChanges final : public BeforeTick {
 public:
  explicit RecordedChanges(const ContactWorld& world) : world_(world) {}
  void set_inputs(std::span<const TickInput> inputs) { inputs_ = inputs; }
  void before_tick(double, LoopChanges changes) noexcept override {
    for (const TickInput& input : inputs_) {
      if (input.kind != InputKind::kEffectParameters) {
        changes.make(input);
      } else if (const auto parameters = parameters_of(input, world_)) {
        changes.set_effect_parameters(input.handle, parameters->effect, parameters->span());
      }
    }
  }

 private:
  const ContactWorld& world_;
  std::span<const TickInput> inputs_;
};

// Counts the ticks in which each effect was active.
void count_effects(const TickRecord& record, std::array<std::uint64_t, kMostEffects>& ticks) {
  for (std::size_t i = 0; i < ticks.size(); ++i) ticks[i] += record.effects >> i & 1u;
}

// Keeps the tick that the session computes.
class ComputedTick final : public TickSink {
 public:
  void on_start(const SessionFacts&) noexcept override {}
  void on_input(const TickInput&) noexcept override {}
  void on_tick(const TickRecord& record, const TickReading& reading) noexcept override {
    row.record = record;
    row.reading = reading;
  }
  void on_trip(const GovernorTrip& trip) noexcept override { summary.add(trip); }
  void on_late(LateCause, const TickCost&) noexcept override {}

  RecordedTick row;
  SummaryAccumulator summary;
};

// Compares what a recording of this version states.
std::optional<ReplayDifference> first_difference(const RecordedTick& recorded,
                                                 const RecordedTick& computed, int version) {
  const auto* a = reinterpret_cast<const std::byte*>(&recorded);
  const auto* b = reinterpret_cast<const std::byte*>(&computed);
  for (const RecordColumn& column : recorded_columns()) {
    if (column.source != ColumnSource::kComputed || !is_recorded(column, version)) continue;
    if (std::memcmp(a + column.offset, b + column.offset, column.bytes) == 0) continue;
    return ReplayDifference{recorded.record.tick, column.name, column_text(column, recorded),
                            column_text(column, computed)};
  }
  return std::nullopt;
}

// Checks what HapticLoop requires of its callers: a file may be hostile.
class InputRules {
 public:
  InputRules(const Scene& scene, const HapticSettings& settings)
      : world_(scene.world()), scale_(scene.statistics().scale), settings_(settings) {}

  // What is wrong; null if nothing is.
  const char* problem(const TickInput& input) {
    switch (input.kind) {
      case InputKind::kEffectParameters:
        return problem_of_parameters(input);
      case InputKind::kA4:
      case InputKind::kForce:
      case InputKind::kCoupling:
      case InputKind::kSetting:
        return problem_of_settings(input);
      case InputKind::kMotors:
        return input.bytes.size() == input.handle * sizeof(MotorDescription) ? nullptr
                                                                             : "a number of motors";
      default:
        return nullptr;
    }
  }

 private:
  const char* problem_of_settings(const TickInput& input) {
    const char* const problem = input.kind == InputKind::kForce      ? "an unknown force"
                                : input.kind == InputKind::kCoupling ? "a stiffness or damping"
                                                                     : "a setting";
    const LiveChanges changes(input);
    if (changes.all().empty()) return problem;
    for (const LiveChange& change : changes.all()) {
      const LiveSetting& setting = kLiveSettings[change.setting];
      // A loop with a strategy ignores a change of what belongs to the strategy.
      if (setting.is_of_strategy && settings_.strategy) continue;
      setting.put(settings_, change.value);
    }
    return check_settings(world_, settings_) ? problem : nullptr;
  }

  const char* problem_of_parameters(const TickInput& input) const {
    constexpr const char* kWrong = "parameters of an effect";
    const auto parameters = parameters_of(input, world_);
    if (!parameters) return kWrong;
    const EffectType& effect = compiled_effects()[parameters->effect];
    if (effect.contradiction(parameters->bytes.data())) return kWrong;
    for (const ParameterKey& key : effect.keys) {
      double number = 0.0;
      std::memcpy(&number, parameters->bytes.data() + key.offset, sizeof number);
      const double unit = key.scales_as_length ? scale_ : 1.0;
      if (!(number >= key.least * unit && number <= key.most * unit)) return kWrong;
      if (key.kind == ParameterKey::Kind::kChoice && number != 0.0 && number != 1.0) return kWrong;
    }
    return nullptr;
  }

  const ContactWorld& world_;
  double scale_;
  HapticSettings settings_;  // with the changes so far
};

// Sums and differences of times must not overflow.
bool has_absurd_time(const RecordedTick& row) {
  constexpr std::int64_t kMost_ns = std::int64_t{1} << 60;  // 36 years
  const auto is_absurd = [](std::int64_t ns) { return ns < -kMost_ns || ns > kMost_ns; };
  return is_absurd(row.reading.due_ns) || is_absurd(row.reading.sample_ns) ||
         is_absurd(row.record.late_ns);
}

// An input of stiffness and damping, of an earlier version, is ignored if one of them is.
bool is_ignored(const TickInput& input, const ReplayChange& change) {
  if (input.kind == InputKind::kEffectParameters) return change.ignores_effects;
  const LiveChanges changes(input);
  return std::any_of(changes.all().begin(), changes.all().end(),
                     [&](const LiveChange& c) { return change.ignores[c.setting]; });
}

// One replay.
class Replayer {
 public:
  Replayer(const RecordedSession& recorded, const Scene& scene, const ReplayOptions& options)
      : options_(options),
        rules_(scene, recorded.setup.haptics),
        device_(recorded.device, options.change && options.change->has_all_motors),
        changes_(scene.world()) {}

  // The recorded inputs move the nodes: the rig needs no scene.
  std::optional<Error> run(const RecordingReader& reader, const RecordedSession& recorded,
                           const Scene& scene) {
    const RecordedSetup& setup = recorded.setup;
    RunSetup run{setup.actuation, setup.haptics, setup.dt_s, {}, recorded.max_force_N};
    run.governor = recorded.governor;
    auto rig = Rig::create(
        scene.world(), run, device_,
        {.changes = {&changes_}, .sink = &computed_, .takes_motors = recorded.takes_motors});
    if (!rig) return rig.error();
    rig_ = std::move(*rig);
    rig_->session().start();
    version_ = reader.version();
    BlockWalk walk(reader);
    for (WalkStep step = walk.next(); step.kind != WalkStep::Kind::kEnd; step = walk.next()) {
      if (step.kind != WalkStep::Kind::kBlock) {
        outcome_.stopped = step.error->element + ": " + step.error->problem;
        break;
      }
      if (step.missing > 0) {
        outcome_.stopped = std::to_string(step.missing) + " ticks are missing before tick " +
                           std::to_string(step.first_tick);
        break;
      }
      if (auto error = run_block(step.content)) return error;
      if (outcome_.difference) break;
      if (options_.progress) options_.progress(walk.share());
    }
    rig_->session().stop();
    return std::nullopt;
  }

  ReplayOutcome finish() {
    outcome_.recorded = recorded_summary_.finish({});
    outcome_.computed = computed_.summary.finish({});
    outcome_.recorded.effect_ticks = recorded_effects_;
    outcome_.computed.effect_ticks = computed_effects_;
    return std::move(outcome_);
  }

 private:
  std::optional<Error> run_block(const BlockContent& block) {
    auto input = block.inputs.begin();
    std::vector<TickInput> inputs;
    for (std::uint32_t i = 0; i < block.rows.size() && !outcome_.difference; ++i) {
      inputs.clear();
      for (; input != block.inputs.end() && input->row == i; ++input)
        inputs.push_back(input->input);
      const RecordedTick& row = block.rows[i];
      if (const char* problem = run_tick(row, inputs)) {
        return Error{ErrorCode::kInvalidContent, "", "tick " + std::to_string(row.record.tick),
                     std::string("has an input with ") + problem + " that the scene has not", ""};
      }
    }
    return std::nullopt;
  }

  // Null, or what is wrong with an input.
  const char* run_tick(const RecordedTick& row, std::vector<TickInput>& inputs) {
    if (has_absurd_time(row)) return "a time";
    bool asks_for_trip = false;
    std::size_t kept = 0;
    for (const TickInput input : inputs) {
      if (options_.left_out == input.kind) continue;
      if (const char* problem = rules_.problem(input)) return problem;
      if (options_.change && is_ignored(input, *options_.change)) {
        ++outcome_.ignored_inputs;
        continue;
      }
      if (!take_session_input(input, asks_for_trip)) inputs[kept++] = input;
    }
    changes_.set_inputs(std::span<const TickInput>(inputs).first(kept));
    device_.set_row(row.reading, asks_for_trip);
    const std::int64_t late_ns = row.record.late_ns;
    const std::int64_t now_ns = row.reading.due_ns + late_ns;
    rig_->session().tick(row.reading.dt_s, late_ns, now_ns);
    if (!options_.change) outcome_.difference = first_difference(row, computed_.row, version_);
    if (outcome_.difference) return nullptr;
    ++outcome_.proved;
    recorded_summary_.add(row.record);
    count_effects(row.record, recorded_effects_);
    count_effects(computed_.row.record, computed_effects_);
    const bool is_tripped = (row.record.rules & kRuleTripped) != 0;
    if (is_tripped && !was_tripped_) {
      GovernorTrip trip;
      trip.tick = row.record.tick;
      trip.time_s = row.record.time_s;
      recorded_summary_.add(trip);
    }
    was_tripped_ = is_tripped;
    computed_.summary.add(computed_.row.record);
    return nullptr;
  }

  // False for a change of the loop.
  bool take_session_input(const TickInput& input, bool& asks_for_trip) {
    switch (input.kind) {
      case InputKind::kMotors:
        device_.set_motors(input.bytes);
        return true;
      case InputKind::kRearm:
        rig_->session().rearm();
        return true;
      case InputKind::kTrip:
        asks_for_trip = true;
        return true;
      case InputKind::kPause: {
        std::uint64_t ticks = 0;
        std::memcpy(&ticks, input.bytes.data(), sizeof ticks);
        rig_->session().skip_paused(ticks);
        return true;
      }
      default:
        return false;
    }
  }

  const ReplayOptions& options_;
  InputRules rules_;
  RecordedDevice device_;
  RecordedChanges changes_;
  ComputedTick computed_;
  std::unique_ptr<Rig> rig_;
  ReplayOutcome outcome_;
  SummaryAccumulator recorded_summary_;
  std::array<std::uint64_t, kMostEffects> recorded_effects_{};
  std::array<std::uint64_t, kMostEffects> computed_effects_{};
  bool was_tripped_ = false;
  int version_ = kRecordingVersion;  // of the recording
};

std::optional<Error> check_session(const RecordedSession& session, int version,
                                   const Scene& scene) {
  if (session.version != version) {
    return Error{ErrorCode::kInvalidContent, "", "columns",
                 "are those of the format version " + std::to_string(session.version) +
                     "; expected those of version " + std::to_string(version),
                 ""};
  }
  if (const DelayInterval& delay = session.device.delay; !is_delay(delay)) {
    return Error{ErrorCode::kInvalidContent, "", "device.delay_s",
                 "is " + std::to_string(delay.least_s) + " to " + std::to_string(delay.most_s) +
                     "; expected an interval within 0 to 1 s",
                 ""};
  }
  if (auto error = check_settings(scene.world(), session.setup.haptics)) return error;
  const int motors = session.device.motor_count;
  if (motors < 0 || motors > static_cast<int>(session.device.motors.size())) {
    return Error{ErrorCode::kInvalidContent, "", "device.motor_count",
                 "is " + std::to_string(motors) + "; expected 0 to 3", ""};
  }
  if (session.device.sensed_axes != session.setup.actuation.sensors()) {
    return Error{
        ErrorCode::kInvalidContent, "", "device.sensed_axes",
        "is " + std::to_string(session.device.sensed_axes) + "; expected the number of sensors",
        ""};
  }
  return std::nullopt;
}

}  // namespace

Result<ReplayOutcome> replay_recording(const RecordingReader& reader,
                                       const RecordedSession& session, const Scene& scene,
                                       const ReplayOptions& options) {
  const auto in_file = [&](Error error) {
    error.path = reader.path();
    return error;
  };
  if (auto error = check_session(session, reader.version(), scene)) return in_file(*error);
  auto ending = reader.ending();
  if (!ending) return ending.error();
  const auto replayer = std::make_unique<Replayer>(session, scene, options);
  if (auto error = replayer->run(reader, session, scene)) return in_file(*error);
  ReplayOutcome outcome = replayer->finish();
  outcome.ending = std::move(*ending);
  // A recording that was closed states how many ticks it has.
  if (!outcome.stopped && !outcome.difference && outcome.ending) {
    const auto stated = outcome.ending->ticks;
    if (stated < 0 || static_cast<std::uint64_t>(stated) != outcome.proved) {
      outcome.stopped = "the ending states " + std::to_string(stated) +
                        " ticks; the recording has " + std::to_string(outcome.proved);
    }
  }
  return outcome;
}

Result<Scene> load_recorded_scene(const RecordedSession& session, const std::string& moved) {
  std::error_code failed;
  std::string path = moved.empty() ? session.setup.scene_path : moved;
  if (moved.empty() && !fs::exists(path, failed)) path = session.scene_place;
  const auto changed = [](const std::string& file) {
    return Error{ErrorCode::kInvalidContent, file, "",
                 "differs from the file that was recorded; the recording needs the same bytes",
                 "state where the recorded scene is with --scene"};
  };
  auto scene = Scene::load(path, session.setup.scene);
  if (!scene) return scene;
  const auto files = files_of(*scene, path);
  if (!files) return files.error();
  for (std::size_t i = 0; i < files->size(); ++i) {
    const RecordedFile& now = (*files)[i];
    const auto recorded =
        i == 0 ? session.files.begin()
               : std::find_if(session.files.begin() + 1, session.files.end(),
                              [&](const RecordedFile& f) { return f.name == now.name; });
    const bool is_same = recorded != session.files.end() && recorded->bytes == now.bytes &&
                         recorded->sha256 == now.sha256;
    if (!is_same) return changed(i == 0 ? path : now.name);
  }
  return scene;
}

}  // namespace palpate
