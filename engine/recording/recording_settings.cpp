#include "engine/recording/recording_settings.h"

#include <cmath>
#include <filesystem>
#include <limits>
#include <system_error>
#include <type_traits>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/recording/recorded_tick.h"
#include "engine/recording/sha256.h"
#include "engine/session/live_setting.h"
#include "engine/session/run_setting.h"
#include "haptics/effects/effect.h"
#include "io/gltf/file.h"
#include "io/gltf/limits.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMostFiles = 4096;

// An enumeration with its last value.
template <typename Enum>
struct Choice {
  Enum& value;
  Enum last;
};

// A word among others, by its place.
struct RecordedWord {
  std::size_t value;
  std::size_t last;

  bool operator==(const RecordedWord&) const = default;
};

// The settings with their keys. `visit` writes them or reads them, so that both use the same keys.
template <typename Visit>
void visit_vector(const std::string& key, Vec3& v, Visit& visit) {
  visit(key + "_x", v.x());
  visit(key + "_y", v.y());
  visit(key + "_z", v.z());
}

// The keys exist only for a strategy that is more than force and A4.
constexpr const char* kStrategyKey = "strategy";

template <typename Visit>
void visit_anticipation(AnticipationSettings& s, Visit& visit) {
  visit("strategy.range_m", s.range_m);
  visit("strategy.least_approach_m_per_s", s.least_approach_m_per_s);
}

template <typename Visit>
void visit_setup(RecordedSetup& s, Visit& visit) {
  visit("scene.path", s.scene_path);
  visit("scene.node", s.scene.node);
  visit("scene.pose", s.scene.pose);
  visit("scene.scale", s.scene.scale);
  visit("scene.proxy_radius_m", s.scene.proxy_radius_m);
  visit("dt_s", s.dt_s);
  visit("virtual_time", s.virtual_time);
}

template <typename Visit>
void visit_device(DeviceDescription& d, Visit& visit) {
  const auto box = [&](const std::string& key, std::array<double, 3>& v) {
    visit(key + "_x", v[0]);
    visit(key + "_y", v[1]);
    visit(key + "_z", v[2]);
  };
  visit("device.name", d.name);
  visit("device.sensed_axes", d.sensed_axes);
  visit("device.motor_count", d.motor_count);
  for (std::size_t i = 0; i < d.motors.size(); ++i) {
    const std::string key = "device.motor_" + std::to_string(i);
    box(key + ".direction", d.motors[i].direction_device);
    visit(key + ".peak_force_N", d.motors[i].peak_force_N);
    visit(key + ".continuous_force_N", d.motors[i].continuous_force_N);
  }
  visit("device.moves_motors", d.moves_motors);
  visit("device.peak_force_N", d.peak_force_N);
  box("device.workspace_low_m", d.workspace_low_m);
  box("device.workspace_high_m", d.workspace_high_m);
  visit("device.mass_kg", d.mass_kg);
  visit("device.damping_Ns_per_m", d.damping_Ns_per_m);
  visit("device.coulomb_friction_N", d.coulomb_friction_N);
  visit("device.encoder_quantum_m", d.encoder_quantum_m);
  visit("device.rate_Hz", d.rate_Hz);
  visit("device.when_host_is_silent",
        Choice<HostSilence>{d.when_host_is_silent, HostSilence::kZeroForce});
}

class MetaWriter {
 public:
  explicit MetaWriter(RecordingMeta& meta) : meta_(meta) {}
  void operator()(const std::string& key, const std::string& text) { meta_[key] = text; }
  template <typename Number>
  void operator()(const std::string& key, const Number& number) {
    if constexpr (std::is_same_v<Number, double>) {
      meta_[key] = number;
    } else {
      meta_[key] = static_cast<std::int64_t>(number);
    }
  }
  template <typename Enum>
  void operator()(const std::string& key, const Choice<Enum>& choice) {
    meta_[key] = static_cast<std::int64_t>(choice.value);
  }
  void operator()(const std::string& key, const RecordedWord& word) {
    meta_[key] = static_cast<std::int64_t>(word.value);
  }

 private:
  RecordingMeta& meta_;
};

class MetaReader {
 public:
  explicit MetaReader(const RecordingMeta& meta) : meta_(meta) {}

  void operator()(const std::string& key, std::string& text) {
    if (const auto* value = get<std::string>(key, "a text")) text = *value;
  }
  void operator()(const std::string& key, double& number) {
    if (const auto* value = get<double>(key, "a number")) number = *value;
  }
  void operator()(const std::string& key, bool& flag) {
    if (const auto value = integer(key, 0, 1)) flag = *value != 0;
  }
  template <typename Integer>
  void operator()(const std::string& key, Integer& number) {
    using Limits = std::numeric_limits<Integer>;
    if (const auto value = integer(key, Limits::min(), Limits::max())) {
      number = static_cast<Integer>(*value);
    }
  }
  template <typename Enum>
  void operator()(const std::string& key, const Choice<Enum>& choice) {
    if (const auto value = integer(key, 0, static_cast<std::int64_t>(choice.last))) {
      choice.value = static_cast<Enum>(*value);
    }
  }

  void operator()(const std::string& key, RecordedWord& word) {
    if (const auto value = integer(key, 0, static_cast<std::int64_t>(word.last))) {
      word.value = static_cast<std::size_t>(*value);
    }
  }

  std::optional<std::int64_t> integer(const std::string& key, std::int64_t least,
                                      std::int64_t most) {
    const auto* value = get<std::int64_t>(key, "an integer");
    if (!value) return std::nullopt;
    if (*value >= least && *value <= most) return *value;
    fail(key, "is " + std::to_string(*value) + "; expected " + std::to_string(least) + " to " +
                  std::to_string(most));
    return std::nullopt;
  }
  bool has(const std::string& key) const { return meta_.contains(key); }
  void fail(const std::string& key, std::string problem) {
    if (!error_) error_ = Error{ErrorCode::kInvalidContent, "", key, std::move(problem), ""};
  }
  const std::optional<Error>& error() const { return error_; }

 private:
  template <typename Value>
  const Value* get(const std::string& key, const char* expected) {
    const auto found = meta_.find(key);
    if (found == meta_.end()) {
      fail(key, std::string("is missing; expected ") + expected);
      return nullptr;
    }
    const Value* value = std::get_if<Value>(&found->second);
    if (!value) fail(key, std::string("has another type; expected ") + expected);
    return value;
  }

  const RecordingMeta& meta_;
  std::optional<Error> error_;
};

// Recordings of before have neither key: their scenes were loaded without joining what meets within
// the rounding of the file, and must be loaded like that again.
constexpr const char* kJoinsKey = "scene.joins_within_rounding";
constexpr const char* kGapsKey = "scene.close_gaps_m";

void write_joins(const SceneSettings& scene, MetaWriter& writer) {
  writer(kJoinsKey, scene.joins_within_rounding);
  if (scene.close_gaps_m > 0.0) writer(kGapsKey, scene.close_gaps_m);
}

void read_joins(MetaReader& reader, SceneSettings& scene) {
  scene.joins_within_rounding = false;
  if (reader.has(kJoinsKey)) reader(kJoinsKey, scene.joins_within_rounding);
  if (!reader.has(kGapsKey)) return;
  reader(kGapsKey, scene.close_gaps_m);
  if (!(scene.close_gaps_m > 0.0) || !std::isfinite(scene.close_gaps_m)) {
    reader.fail(kGapsKey, "is not above 0");
  }
}

// Recordings of before do not have the key: hidden nodes were felt.
constexpr const char* kHiddenKey = "scene.feels_hidden";
constexpr const char* kListedSceneKey = "scene.listed_scene";

void write_choice(const SceneSettings& scene, MetaWriter& writer) {
  writer(kHiddenKey, scene.feels_hidden);
  if (!scene.listed_scene.empty()) writer(kListedSceneKey, scene.listed_scene);
}

void read_choice(MetaReader& reader, SceneSettings& scene) {
  scene.feels_hidden = true;
  if (reader.has(kHiddenKey)) reader(kHiddenKey, scene.feels_hidden);
  if (reader.has(kListedSceneKey)) reader(kListedSceneKey, scene.listed_scene);
}

// Recordings of before, and of sessions without the option, do not have the key.
constexpr const char* kUnstableKey = "allow_unstable";

void write_unstable(const RecordedSetup& setup, MetaWriter& writer) {
  if (!setup.allow_unstable.empty()) writer(kUnstableKey, setup.allow_unstable);
}

void read_unstable(MetaReader& reader, RecordedSetup& setup) {
  if (reader.has(kUnstableKey)) reader(kUnstableKey, setup.allow_unstable);
}

template <class Place>
constexpr bool is_number =
    std::is_same_v<Place, SettingPlace<bool>> || std::is_same_v<Place, SettingPlace<double>> ||
    std::is_same_v<Place, SettingPlace<int>> || std::is_same_v<Place, SettingPlace<std::int64_t>>;

// Calls use() with the value of a setting: a number, a flag, or the place of a word.
template <class Use>
void visit_value(const RunSetting& setting, HapticSettings& settings, Use use) {
  std::visit(
      [&](const auto& place) {
        using Place = std::decay_t<decltype(place)>;
        if constexpr (std::is_same_v<Place, SettingChoice>) {
          RecordedWord word{place.get(settings), place.words.size() - 1};
          use(word);
          place.put(settings, word.value);
        } else if constexpr (is_number<Place>) {
          use(place.in_haptics(settings));
        }
      },
      setting.value);
}

bool is_default(const RunSetting& setting, HapticSettings settings) {
  HapticSettings defaults;
  bool is_same = false;
  visit_value(setting, settings, [&](auto& value) {
    visit_value(setting, defaults, [&](auto& usual) {
      if constexpr (std::is_same_v<decltype(value), decltype(usual)>) is_same = value == usual;
    });
  });
  return is_same;
}

// is_for_all: the settings that all recordings have; otherwise those that came later.
bool is_recorded(const RunSetting& setting, bool is_for_all) {
  return (setting.recorded.turn > 0) == is_for_all;
}

void write_haptics(HapticSettings& settings, RunSettingTable table, MetaWriter& writer) {
  for (const RunSetting* setting : by_recorded_turn(table)) {
    if (is_recorded(*setting, false) && is_default(*setting, settings)) continue;
    visit_value(*setting, settings,
                [&](const auto& value) { writer(setting->recorded.name, value); });
  }
}

void read_haptics(MetaReader& reader, RunSettingTable table, bool is_for_all,
                  HapticSettings& settings) {
  for (const RunSetting* setting : by_recorded_turn(table)) {
    if (!is_recorded(*setting, is_for_all)) continue;
    if (!is_for_all && !reader.has(setting->recorded.name)) continue;
    visit_value(*setting, settings, [&](auto& value) { reader(setting->recorded.name, value); });
  }
}

// After all other settings: forward is for one motor and the corrected Table 1.
void check_recorded_align(MetaReader& reader, const RecordedSetup& setup) {
  const A4Settings& a4 = setup.haptics.a4;
  const auto error = check_align(a4.align, a4.table1, setup.actuation.actuators());
  if (error) reader.fail("a4.align", error->problem);
}

// Recordings of before the rule had a number do not have the key.
constexpr const char* kCountingKey = "proxy.counting";

void write_counting(const Accuracy& accuracy, MetaWriter& writer) {
  writer(kCountingKey, static_cast<std::int64_t>(accuracy.counting));
}

// A rule that this build does not know is refused by its number.
void read_counting(MetaReader& reader, Accuracy& accuracy) {
  accuracy.counting = CountingRule::kFirst;
  if (!reader.has(kCountingKey)) return;
  const auto rule = reader.integer(kCountingKey, static_cast<std::int64_t>(CountingRule::kFirst),
                                   static_cast<std::int64_t>(CountingRule::kSecond));
  if (rule) accuracy.counting = static_cast<CountingRule>(*rule);
}

void write_strategy(HapticSettings& settings, MetaWriter& writer) {
  if (!settings.strategy) return;
  writer(kStrategyKey, name_of(*settings.strategy));
  visit_anticipation(settings.anticipation, writer);
}

// A strategy that this build does not know is refused by name.
void read_strategy(MetaReader& reader, HapticSettings& settings) {
  if (!reader.has(kStrategyKey)) return;
  std::string name;
  reader(kStrategyKey, name);
  visit_anticipation(settings.anticipation, reader);
  const auto strategy = parse_strategy(name);
  if (!strategy) return reader.fail(kStrategyKey, strategy.error().problem);
  if (strategy->type->make_step) settings.strategy = *strategy;
}

std::string effects_text() {
  std::string names;
  for (const EffectType& effect : compiled_effects()) {
    names += (names.empty() ? "" : " ") + std::string(effect.name);
  }
  return names;
}

std::string inputs_json() {
  nlohmann::ordered_json settings = nlohmann::ordered_json::array();
  for (const LiveSetting& setting : kLiveSettings) {
    settings.push_back({{"number", setting.number}, {"name", setting.name}});
    const std::string_view unit = setting.of_run().unit;
    if (!unit.empty()) settings.back()["unit"] = unit;
    if (!setting.words().empty()) settings.back()["choices"] = setting.words();
  }
  nlohmann::ordered_json kinds = nlohmann::ordered_json::array();
  for (const InputKindFacts& facts : kInputKinds) {
    kinds.push_back({{"kind", static_cast<int>(facts.kind)},
                     {"name", facts.name},
                     {"handle", facts.handle},
                     {"bytes", facts.bytes}});
    if (facts.kind == InputKind::kSetting) kinds.back()["settings"] = settings;
  }
  return kinds.dump();
}

std::string overrides_json(const std::vector<MaterialOverride>& overrides) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const MaterialOverride& o : overrides) list.push_back({o.material, o.key, o.value});
  return list.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::vector<MaterialOverride> overrides_of(const std::string& key, const std::string& text,
                                           MetaReader& reader) {
  const auto list = nlohmann::json::parse(text, nullptr, false);
  std::vector<MaterialOverride> overrides;
  const bool is_list = list.is_array();
  for (std::size_t i = 0; is_list && i < list.size(); ++i) {
    const auto& o = list[i];
    if (!o.is_array() || o.size() != 3 || !o[0].is_string() || !o[1].is_string() ||
        !o[2].is_string()) {
      break;
    }
    overrides.push_back({o[0], o[1], o[2]});
  }
  if (!is_list || overrides.size() != list.size()) {
    reader.fail(key, "is no list of a material, a key and a value each");
  }
  return overrides;
}

Result<RecordedFile> recorded_file(const std::string& path, std::string name) {
  const auto bytes = read_regular_file(path, kMaxGltfFileBytes);
  if (!bytes) return bytes.error();
  return RecordedFile{std::move(name), bytes->size(), sha256_hex(bytes->span())};
}

// The actuation is stored as the numbers of its basis.
void write_actuation(const ActuationModel& actuation, MetaWriter& writer) {
  writer("actuation.sensors", actuation.sensors());
  writer("actuation.actuators", actuation.actuators());
  for (int i = 0; i < 3; ++i) {
    Vec3 axis = actuation.actuated_axis(i);
    visit_vector("actuation.axis_" + std::to_string(i), axis, writer);
  }
}

void read_actuation(MetaReader& reader, ActuationModel& actuation) {
  int sensors = 0, actuators = 0;
  std::array<Vec3, 3> basis = {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
  reader("actuation.sensors", sensors);
  reader("actuation.actuators", actuators);
  for (int i = 0; i < 3; ++i) {
    visit_vector("actuation.axis_" + std::to_string(i), basis[static_cast<std::size_t>(i)], reader);
  }
  const auto model = ActuationModel::from_basis(sensors, actuators, basis);
  if (model) {
    actuation = *model;
  } else {
    reader.fail("actuation", "is no model of sensors and actuators");
  }
}

void read_files(MetaReader& reader, std::vector<RecordedFile>& files) {
  const auto count = reader.integer("files", 1, kMostFiles);
  for (std::int64_t i = 0; count && i < *count && !reader.error(); ++i) {
    const std::string key = "file_" + std::to_string(i);
    RecordedFile file;
    std::int64_t bytes = 0;
    reader(key + ".name", file.name);
    reader(key + ".bytes", bytes);
    reader(key + ".sha256", file.sha256);
    file.bytes = static_cast<std::uint64_t>(bytes);
    files.push_back(std::move(file));
  }
}

// "session.energy_budgets.motors_J"
std::string budget_key(std::size_t source, const char* unit) {
  return "session.energy_budgets." + std::string(kEnergySourceNames[source]) + "_" + unit;
}

void write_budgets(const EnergyBudgets& budgets, MetaWriter& writer) {
  for (std::size_t n = 0; n < kEnergySourceCount; ++n) {
    writer(budget_key(n, "J"), budgets.of[n].tank_J);
    writer(budget_key(n, "W"), budgets.of[n].power_W);
  }
}

// Recordings of before have the budgets that were constants then: the initial ones.
void read_budgets(MetaReader& reader, EnergyBudgets& budgets) {
  const auto read = [&](const std::string& key, double& number, double most) {
    reader(key, number);
    if (number >= 0.0 && number <= most) return;
    reader.fail(key, "is " + std::to_string(number) + "; expected 0 to " + std::to_string(most));
  };
  for (std::size_t n = 0; n < kEnergySourceCount; ++n) {
    if (!reader.has(budget_key(n, "J")) && !reader.has(budget_key(n, "W"))) continue;
    read(budget_key(n, "J"), budgets.of[n].tank_J, EnergyBudget::kMost_J);
    read(budget_key(n, "W"), budgets.of[n].power_W, EnergyBudget::kMost_W);
  }
}

// A table that this build would read or compute differently.
void check_table(const char* key, const std::string& ours, MetaReader& reader) {
  std::string theirs;
  reader(key, theirs);
  if (theirs != ours) {
    reader.fail(key, "differ from those of this engine, version " + std::string(engine_version()));
  }
}

}  // namespace

const char* engine_version() {
  return PALPATE_VERSION;
}

Result<std::vector<RecordedFile>> files_of(const Scene& scene, const std::string& path) {
  std::vector<RecordedFile> files;
  auto main = recorded_file(path, fs::path(path).filename().string());
  if (!main) return main.error();
  files.push_back(std::move(*main));
  std::error_code failed;
  const fs::path folder = fs::weakly_canonical(fs::absolute(path, failed).parent_path(), failed);
  for (const std::string& read : scene.statistics().files_read) {
    auto file = recorded_file(read, fs::path(read).lexically_relative(folder).string());
    if (!file) return file.error();
    files.push_back(std::move(*file));
  }
  return files;
}

Result<RecordingMeta> meta_of(const Scene& scene, const RecordedSetup& setup,
                              RunSettingTable table) {
  const auto files = files_of(scene, setup.scene_path);
  if (!files) return files.error();
  RecordingMeta meta;
  MetaWriter writer(meta);
  meta["engine"] = std::string(engine_version());
  meta["build"] = std::string(PALPATE_BUILD) + ", " + __VERSION__;
  meta["columns"] = recorded_columns_json();
  meta["input_kinds"] = inputs_json();
  meta["effects"] = effects_text();
  RecordedSetup copy = setup;
  visit_setup(copy, writer);
  write_haptics(copy.haptics, table, writer);
  write_counting(copy.haptics.god_object.accuracy, writer);
  write_strategy(copy.haptics, writer);
  std::error_code failed;
  meta["scene.place"] = fs::absolute(setup.scene_path, failed).string();
  meta["scene.overrides"] = overrides_json(setup.scene.overrides);
  write_joins(copy.scene, writer);
  write_choice(copy.scene, writer);
  write_unstable(copy, writer);
  write_actuation(setup.actuation, writer);
  writer("files", files->size());
  for (std::size_t i = 0; i < files->size(); ++i) {
    const std::string key = "file_" + std::to_string(i);
    writer(key + ".name", (*files)[i].name);
    writer(key + ".bytes", (*files)[i].bytes);
    writer(key + ".sha256", (*files)[i].sha256);
  }
  return meta;
}

RecordingMeta meta_of(const SessionFacts& facts) {
  RecordingMeta meta;
  MetaWriter writer(meta);
  DeviceDescription device = facts.device;
  visit_device(device, writer);
  if (device.delay.is_known()) {
    writer("device.delay_s", device.delay.least_s);
    writer("device.most_delay_s", device.delay.most_s);
  }
  writer("session.takes_motors", facts.takes_motors);
  if (device.moves_motors && facts.governor.watches_energy) {
    writer("session.energy_rules", true);
    write_budgets(facts.governor.budgets, writer);
  }
  if (facts.max_force_N) writer("session.max_force_N", *facts.max_force_N);
  return meta;
}

Result<RecordedSession> session_of(const RecordingMeta& meta, RunSettingTable table) {
  MetaReader reader(meta);
  RecordedSession session;
  reader("engine", session.engine);
  reader("build", session.build);
  session.version = version_of_columns(meta);
  check_table("columns", recorded_columns_json(session.version), reader);
  check_table("effects", effects_text(), reader);
  visit_setup(session.setup, reader);
  read_haptics(reader, table, true, session.setup.haptics);
  read_counting(reader, session.setup.haptics.god_object.accuracy);
  read_haptics(reader, table, false, session.setup.haptics);
  read_strategy(reader, session.setup.haptics);
  reader("scene.place", session.scene_place);
  std::string overrides;
  reader("scene.overrides", overrides);
  session.setup.scene.overrides = overrides_of("scene.overrides", overrides, reader);
  read_joins(reader, session.setup.scene);
  read_choice(reader, session.setup.scene);
  read_unstable(reader, session.setup);
  read_actuation(reader, session.setup.actuation);
  read_files(reader, session.files);
  if (!reader.has("device.name")) {
    reader.fail("device.name", "is missing; the session had not begun when it ended");
  }
  visit_device(session.device, reader);
  if (reader.has("device.delay_s")) reader("device.delay_s", session.device.delay.least_s);
  // Recordings of before state one delay.
  session.device.delay.most_s = session.device.delay.least_s;
  if (reader.has("device.most_delay_s")) {
    reader("device.most_delay_s", session.device.delay.most_s);
  }
  reader("session.takes_motors", session.takes_motors);
  // Recordings of before are of a governor without these rules.
  session.governor.watches_energy = false;
  if (reader.has("session.energy_rules")) {
    reader("session.energy_rules", session.governor.watches_energy);
  }
  read_budgets(reader, session.governor.budgets);
  if (reader.has("session.max_force_N")) {
    double most_N = 0.0;
    reader("session.max_force_N", most_N);
    session.max_force_N = most_N;
  }
  check_recorded_align(reader, session.setup);
  const double scale = session.setup.scene.scale;
  if (!(scale > 0.0) || !std::isfinite(scale)) reader.fail("scene.scale", "is not above 0");
  if (reader.error()) return *reader.error();
  return session;
}

}  // namespace palpate
