#include "engine/session/run_setting.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <sstream>

#include "engine/session/live_setting.h"

// The name and the place of a member of HapticSettings and RunSettings.
#define HAPTIC(member) #member, in_haptics([](auto& s) -> auto& { return s.member; })
#define RUN(member) #member, in_run([](RunSettings & s) -> auto& { return s.member; })
#define CHOICE(member, words) \
#member, choice_in_haptics( \
               [](auto& s) -> auto& { return s.member; }, words)

namespace palpate {
namespace {

constexpr std::array<std::string_view, 3> kPresets = {"fast", "balanced", "exact"};
constexpr std::array<std::string_view, 3> kForceModeNames = {"none", "actuated", "full"};
constexpr std::array<std::string_view, 3> kEstimators = {"difference", "line", "adaptive"};
constexpr std::array<std::string_view, 2> kTable1Forms = {"corrected", "printed"};
constexpr std::array<std::string_view, 2> kStepRules = {"exact", "paper"};
constexpr std::array<std::string_view, 2> kAlignments = {"nearest", "forward"};
constexpr std::array<std::string_view, 2> kNarrowPhases = {"float", "double"};

// The work budget tells the presets apart.
constexpr SettingChoice kAccuracy = {
    kPresets,
    [](const HapticSettings& s) {
      const auto is_set = [&](std::string_view name) {
        return accuracy_preset(name)->work_budget == s.god_object.accuracy.work_budget;
      };
      return static_cast<std::size_t>(std::find_if(kPresets.begin(), kPresets.end(), is_set) -
                                      kPresets.begin());
    },
    [](HapticSettings& s, std::size_t preset) {
      s.god_object.accuracy = *accuracy_preset(kPresets[preset]);
    }};

using enum SettingGroup;

constexpr RunSetting setting(std::string_view field, SettingValuePlace value,
                             std::string_view option, SettingGroup group, NumberRange range,
                             std::string_view meaning, std::string_view unit = {},
                             std::string_view note = {}, PlanKey plan = {},
                             RecordedKey recorded = {}) {
  return {field, value, option, group, range, meaning, unit, note, plan, recorded};
}

constexpr RunSetting recorded_only(std::string_view field, SettingValuePlace value,
                                   RecordedKey key) {
  return {.field = field, .value = value, .recorded = key};
}

// In the order of the help.
constexpr RunSetting kSettings[] = {
    setting("initial_pose", OwnSetting{.is_haptic = true}, "--place", kScene, {},
            "pose of the scene in the device frame, \"x y z qw qx qy qz\"", "", "", {"place", 15}),
    setting(
        "moves", OwnSetting{}, "--move", kScene, {},
        "NODE=\"vx vy vz wx wy wz\": move the node at constant velocity, m/s and rad/s along and "
        "about the axes of the scene; may be repeated"),

    setting(RUN(sensors), "--sensors", kDevice, {2, 3},
            "number of sensed axes, 2 or 3: the first of A1 A2 A3", "", "", {"sensors", 1, true}),
    setting(RUN(actuators), "--actuators", kDevice, {0, 3},
            "number of actuated axes: the first of A1 A2 A3", "", "", {"actuators", 3}),
    setting("actuated_axes", OwnSetting{}, "--actuated-axes", kDevice, {},
            "actuated directions in place of --actuators, device frame, such as \"0 0 1; 1 0 0\"",
            "", "", {"actuated_axes", 2}),
    setting(CHOICE(force, kForceModeNames), "--force", kDevice, {},
            "the commanded force: none, its part along the actuated axes, or all of it", "", "", {},
            {"force", 13}),
    setting(RUN(max_force_N), "--max-force", kDevice, kAboveZero, "largest force", "N",
            "; a longer force is shortened and keeps its direction [the device's peak force]",
            {"max_force_N", 10}),
    setting(RUN(rate_Hz), "--rate", kDevice, {1.0 / kLongestTick_s}, "ticks per second", "Hz", "",
            {"rate_Hz", 4, true, kAboveZero}),
    setting(RUN(plane_height_m), "--plane-height", kDevice, {},
            "with 2 sensors: height of the sensed plane A1 A2 along A3", "m",
            " [0; `run`: the middle of the object, or the nearest height with a contour]",
            {"plane_height_m", 14}),
    setting(RUN(encoder_quantum_m), "--encoder-quantum", kDevice, kAboveZero,
            "step of the device's encoders", "m", "; required by the adaptive estimator",
            {"encoder_quantum_m", 9}),
    setting("device.workspace", OwnSetting{}, "--workspace", kWorkspace, kAboveZero,
            "extent of the device's workspace along each axis", "m", "; a longer path is flagged",
            {"workspace_m", 18}),
    setting(RUN(device.mass_kg), "--device-mass", kMechanics, kAboveZero,
            "mass of the device at its tip", "kg", "", {"device_mass_kg", 19}),
    setting(RUN(device.damping_Ns_per_m), "--device-damping", kMechanics, kZeroOrMore,
            "viscous damping of the device", "N s/m", "", {"device_damping_Ns_per_m", 20}),
    setting(RUN(device.coulomb_friction_N), "--device-friction", kMechanics, kZeroOrMore,
            "Coulomb friction of the device", "N", "", {"device_friction_N", 21}),

    setting(
        "energy_budgets", OwnSetting{}, "--energy-budget", kMotors, {},
        "what a source of energy (motors, nodes, vibration, restitution, magnet, gravity, other) "
        "may give the hand by design: SOURCE=MJ,W or SOURCE=MJ, at most 1000 mJ at once and 1 W "
        "for ever; may be repeated"),

    setting(HAPTIC(coupling.stiffness_N_per_m), "--stiffness", kTouch, kZeroOrMore,
            "stiffness of the coupling for surfaces that state none", "N/m", "",
            {"stiffness_N_per_m", 5, true}, {"coupling.stiffness_N_per_m", 8}),
    setting(HAPTIC(coupling.damping_Ns_per_m), "--damping", kTouch, kZeroOrMore,
            "damping of the coupling for surfaces that state none", "N s/m", "",
            {"damping_Ns_per_m", 6, true}, {"coupling.damping_Ns_per_m", 9}),
    setting(HAPTIC(god_object.radius_m), "--radius", kTouch, kZeroOrMore, "radius of the proxy",
            "m", "; 0 is a point", {"radius_m", 13}, {"proxy.radius_m", 1}),
    setting("god_object.accuracy", kAccuracy, "--accuracy", kTouch, {},
            "accuracy of the proxy: fast (few steps, no certificate), balanced, or exact", "", "",
            {"accuracy", 11}),
    setting(
        "work_budget", OwnSetting{}, "--work-budget", kTouch, {1, 1e12},
        "largest work of a tick, in units of at most 23 ns; auto: measured at the start, so that "
        "the proxy and the effects take at most half of a tick of --rate [5000, 20000 or 160000 "
        "for --accuracy fast, balanced or exact]",
        "", "", {"work_budget", 12}),
    setting(CHOICE(coupling.velocity.method, kEstimators), "--velocity-estimator", kTouch, {},
            "velocity for the damper: difference over the window, line fitted to the window, or "
            "adaptive: the longest window whose positions are on a line within an encoder's step",
            "", "", {"velocity_estimator", 7}, {"coupling.velocity_method", 10}),
    setting(HAPTIC(coupling.velocity.window_ticks), "--velocity-window", kTouch,
            {1, VelocityEstimator::kMostTicks},
            "window of the damper's velocity, 1 to 63 ticks: a longer window has less noise and "
            "more lag",
            "ticks", "", {"velocity_window_ticks", 8}, {"coupling.velocity_window_ticks", 11}),

    setting(CHOICE(a4.table1, kTable1Forms), "--table1", kRotation, {},
            "theoretical rotation: Table 1 of the paper, corrected or as printed", "", "",
            {"table1", 16}, {"a4.table1", 15}),
    setting(CHOICE(a4.step, kStepRules), "--a4-step", kRotation, {},
            "elementary rotation: exact solution of the speed profile, or the paper's S dt", "", "",
            {"a4_step", 17}, {"a4.step", 16}),
    setting(
        CHOICE(a4.align, kAlignments), "--align", kRotation, {},
        "with one motor: turn the normal to the nearer end of its line, or forward to the first "
        "actuated axis, by up to 180 deg",
        "", "", {}, {"a4.align"}),

    setting(HAPTIC(measures_effects), "--effect-times", kOutput, {},
            "measure each effect's share of the tick time; measuring lengthens ticks", "", "", {},
            {"measures_effects", 28}),

    // No option sets one of these alone.
    recorded_only(HAPTIC(a4.enabled), {"a4.enabled", 14}),
    recorded_only(HAPTIC(god_object.accuracy.iterations), {"proxy.iterations", 2}),
    recorded_only(HAPTIC(god_object.accuracy.tolerance), {"proxy.tolerance", 3}),
    recorded_only(CHOICE(god_object.accuracy.narrow_phase, kNarrowPhases),
                  {"proxy.narrow_phase", 4}),
    recorded_only(HAPTIC(god_object.accuracy.reuse_candidates), {"proxy.reuse_candidates", 5}),
    recorded_only(HAPTIC(god_object.accuracy.certify), {"proxy.certify", 6}),
    recorded_only(HAPTIC(god_object.accuracy.work_budget), {"proxy.work_budget", 7}),
    recorded_only(HAPTIC(coupling.velocity.encoder_quantum_m), {"coupling.encoder_quantum_m", 12}),
    recorded_only(HAPTIC(a4.profile.speed_at_zero_rad_per_s), {"a4.speed_at_zero_rad_per_s", 17}),
    recorded_only(HAPTIC(a4.profile.speed_at_knee_rad_per_s), {"a4.speed_at_knee_rad_per_s", 18}),
    recorded_only(HAPTIC(a4.profile.knee_rad), {"a4.knee_rad", 19}),
    recorded_only(HAPTIC(plane_height_m), {"plane_height_m", 20}),
    recorded_only(HAPTIC(initial_pose.rotation.w()), {"initial_pose.q_w", 21}),
    recorded_only(HAPTIC(initial_pose.rotation.x()), {"initial_pose.q_x", 22}),
    recorded_only(HAPTIC(initial_pose.rotation.y()), {"initial_pose.q_y", 23}),
    recorded_only(HAPTIC(initial_pose.rotation.z()), {"initial_pose.q_z", 24}),
    recorded_only(HAPTIC(initial_pose.translation_m.x()), {"initial_pose.o_m_x", 25}),
    recorded_only(HAPTIC(initial_pose.translation_m.y()), {"initial_pose.o_m_y", 26}),
    recorded_only(HAPTIC(initial_pose.translation_m.z()), {"initial_pose.o_m_z", 27}),
};

// By the places in kLiveSettings. A field that no line has does not compile.
constexpr auto kSettingsOfLive = [] {
  std::array<const RunSetting*, kLiveSettings.size()> found{};
  for (std::size_t i = 0; i < found.size(); ++i) {
    found[i] = std::begin(kSettings);
    while (found[i]->field != kLiveSettings[i].field) ++found[i];
  }
  return found;
}();

// The settings with this key, by its turn; turn 0 is the last one.
template <class KeyOf>
std::vector<const RunSetting*> by_turn(RunSettingTable table, KeyOf key_of) {
  std::vector<const RunSetting*> rows;
  for (const RunSetting& setting : table) {
    if (key_of(setting).name) rows.push_back(&setting);
  }
  const auto turn = [&](const RunSetting* setting) {
    const int stated = key_of(*setting).turn;
    return stated > 0 ? stated : std::numeric_limits<int>::max();
  };
  std::stable_sort(rows.begin(), rows.end(),
                   [&](const RunSetting* a, const RunSetting* b) { return turn(a) < turn(b); });
  return rows;
}

}  // namespace

bool RunSetting::is_haptic() const {
  return std::visit(
      [](const auto& place) {
        using Place = std::decay_t<decltype(place)>;
        if constexpr (std::is_same_v<Place, OwnSetting>) return place.is_haptic;
        if constexpr (std::is_same_v<Place, SettingChoice>) return true;
        if constexpr (requires { place.in_haptics; }) return place.in_haptics != nullptr;
      },
      value);
}

RunSettingTable run_settings() {
  return kSettings;
}

const RunSetting& run_setting(std::string_view option) {
  return *std::find_if(std::begin(kSettings), std::end(kSettings),
                       [&](const RunSetting& setting) { return setting.option == option; });
}

const RunSetting& run_setting_with(std::uint32_t live_number) noexcept {
  std::size_t i = 0;
  while (kLiveSettings[i].number != live_number) ++i;
  return *kSettingsOfLive[i];
}

std::vector<const RunSetting*> by_plan_turn(RunSettingTable table) {
  return by_turn(table, [](const RunSetting& setting) { return setting.plan; });
}

std::vector<const RunSetting*> by_recorded_turn(RunSettingTable table) {
  return by_turn(table, [](const RunSetting& setting) { return setting.recorded; });
}

std::string help_of(const RunSetting& setting, const std::string& usual) {
  const bool is_whole = std::holds_alternative<SettingPlace<int>>(setting.value) ||
                        std::holds_alternative<SettingPlace<std::optional<int>>>(setting.value);
  std::string help(setting.meaning);
  if (!setting.unit.empty() && !is_whole) help += ", " + std::string(setting.unit);
  if (!usual.empty()) help += " [" + usual + "]";
  return help.append(setting.note);
}

std::optional<Error> check_range(const RunSetting& setting, double value) {
  const NumberRange range = setting.plan.range.value_or(setting.range);
  if (std::isfinite(value) && range.contains(value)) return std::nullopt;
  std::ostringstream text;
  text << "is " << value << "; expected a finite number";
  if (std::isfinite(range.least)) text << (range.is_least_out ? " > " : " >= ") << range.least;
  if (std::isfinite(range.most)) text << " and <= " << range.most;
  return invalid_argument(std::string(setting.field), text.str());
}

std::optional<Error> check_range(const RunSetting& setting, int value) {
  if (setting.range.contains(value)) return std::nullopt;
  std::ostringstream text;
  text << "is " << value << (setting.unit.empty() ? "" : " ") << setting.unit << "; expected "
       << setting.range.least << " to " << setting.range.most;
  return invalid_argument(std::string(setting.field), text.str());
}

}  // namespace palpate
