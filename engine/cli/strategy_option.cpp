#include "engine/cli/strategy_option.h"

#include "engine/cli/command_help.h"
#include "haptics/strategies/haptic_settings.h"

namespace palpate {

void add_strategy(CLI::App& app, std::optional<Strategy>& strategy) {
  const auto read = [&strategy](const std::string& text) {
    const auto parsed = parse_strategy(text);
    if (!parsed) {
      const Error& error = parsed.error();
      throw CLI::ValidationError(
          "--strategy", error.problem + (error.hint.empty() ? "" : " (" + error.hint + ")"));
    }
    strategy = *parsed;
  };
  app.add_option_function<std::string>(
         "--strategy", read,
         "technique for missing motors, in place of --force and --a4: " + strategy_names_for_help())
      ->type_name("NAME")
      ->group(kA4Group);
}

std::optional<Error> check_strategy_options(
    const std::function<bool(const std::string&)>& is_given) {
  if (!is_given("--strategy")) return std::nullopt;
  for (const char* option : {"--force", "--a4"}) {
    if (!is_given(option)) continue;
    return invalid_argument("--strategy",
                            "is given beside " + std::string(option) + "; expected one of the two",
                            "a strategy states the force and A4");
  }
  return std::nullopt;
}

bool has_a4(const Strategy& strategy) {
  HapticSettings settings;
  set_strategy(strategy, settings);
  return settings.a4.enabled;
}

std::optional<Error> check_motors(const std::optional<Strategy>& strategy,
                                  const DeviceDescription& device) {
  if (!strategy || strategy->type->force != ForceMode::kFull ||
      device.motor_count >= device.sensed_axes) {
    return std::nullopt;
  }
  return invalid_argument(
      "--strategy",
      "is " + name_of(*strategy) + "; expected another one for a device with " +
          std::to_string(device.sensed_axes) + " sensors and " +
          std::to_string(device.motor_count) + (device.motor_count == 1 ? " motor" : " motors"),
      name_of(*strategy) + " is a reference; mask and a4 use the motors that there are");
}

}  // namespace palpate
