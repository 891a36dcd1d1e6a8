#pragma once

// The options that select, scale and pose a scene, and the functions that load the scene.

#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "engine/scene/scene.h"
#include "engine/session/run_setup.h"
#include "geometry/base/result.h"

namespace palpate {

// The arguments of the options, unchanged.
struct SceneOptions {
  std::string path;
  std::string node;
  std::string listed_scene;  // a number or a name; empty: the file's default scene
  bool feels_hidden = false;
  std::optional<double> scale;
  std::optional<double> fit_size_m;
  bool fits_workspace = false;  // --fit auto: scale to the workspace if the scene does not fit
  std::string pose;             // "NAME@SECONDS"; empty: rest pose
  std::optional<double> close_gaps_m;
  std::vector<std::string> materials;  // "NAME.key=value" each
  std::string max_memory;              // "500M"; empty: half of the free memory
  bool is_quiet = false;               // load_scene() writes no line, as for a trial of advice
};

void add_scene(CLI::App& app, SceneOptions& scene, bool is_required = true);

// Checks the options. An error names the option.
Result<SceneSettings> scene_settings_of(const SceneOptions& options, double proxy_radius_m);

// Checks the options and loads the scene. An error names the option. With --close-gaps, writes a
// line about what was joined to the standard error.
Result<Scene> load_scene(const SceneOptions& options, double proxy_radius_m,
                         bool measures_gaps = false);

// Loads the scene of the options with the settings that scene_settings_of() has made of them.
Result<Scene> load_scene(const SceneOptions& options, const SceneSettings& settings);
// Returns an error if an effect of the scene needs a higher tick rate.
Result<Scene> load_scene(const SceneOptions& options, const SceneSettings& settings,
                         double rate_Hz);

// Checks the options and loads the scene for a session. Also returns an error if an effect needs a
// higher tick rate, for example a vibration whose frequency is half of the tick rate or more.
Result<Scene> load_scene(const SceneOptions& options, const RunSettings& run);

}  // namespace palpate
