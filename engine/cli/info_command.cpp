// The subcommand `info`: describes a scene.

#include <iostream>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "engine/cli/all_commands.h"
#include "engine/cli/command_help.h"
#include "engine/cli/command_output.h"
#include "engine/cli/scene_options.h"
#include "engine/cli/scene_report.h"
#include "engine/devices/light_device.h"
#include "engine/rig/placed_bounds.h"
#include "engine/rig/workspace.h"
#include "engine/scene/node_tree.h"
#include "io/gltf/reader.h"

namespace palpate {
namespace {

// A hint at --fit auto if `run` with its default device would refuse the size of the scene; else
// empty.
std::string size_hint(const Scene& scene) {
  constexpr int kSensors = 2;  // the default of `run`
  if (scene.objects().empty()) return {};
  const double workspace_m = workspace_extent_m(light_device());
  const Workspace workspace = hand_workspace(kSensors, workspace_m);
  const Box bounds = bounds_in_device(scene, ScenePose{});
  const Vec3& extent_m = scene.statistics().extent_m;
  const double largest_m = extent_m.maxCoeff();
  if (!check_fits(workspace, bounds, largest_m)) return {};
  if (!fitting_size_m(workspace, bounds, largest_m)) return {};
  std::ostringstream text;
  text.precision(3);
  text << "  size: " << extent_m.x() << " x " << extent_m.y() << " x " << extent_m.z()
       << " m; a device's workspace is " << workspace_m << " m: run it with --fit auto\n";
  return text.str();
}

// The nodes of a scene that is empty because they are hidden; no value if none of them is hidden.
std::optional<std::vector<TreeNode>> hidden_tree(const SceneOptions& scene) {
  const auto settings = scene_settings_of(scene, 0.0);
  if (!settings) return std::nullopt;
  ReadOptions options;
  options.pose = settings->pose;
  options.scene = settings->listed_scene;
  options.feels_hidden = settings->feels_hidden;
  options.reads_only_tree = true;
  auto description = read_gltf(scene.path, options);
  if (!description) return std::nullopt;
  if (!settings->node.empty()) {
    const auto node = find_node(description->tree, settings->node);
    if (!node) return std::nullopt;
    keep_subtree(*description, *node);
  }
  if (description->hidden_nodes.count == 0) return std::nullopt;
  return std::move(description->tree);
}

class InfoCommand final : public Command {
 public:
  CLI::App* add_to(CLI::App& program) override {
    CLI::App& app =
        *program.add_subcommand("info", "describe a scene: size, contours, materials, defects");
    set_help(app, "  ./run.sh info models/gallery.glb\n");
    add_scene(app, scene_, true);
    app.add_flag("--list", list_, "print the tree of nodes instead");
    app.add_flag("--json", json_, "print as JSON");
    return &app;
  }
  int run(const std::vector<std::string>& arguments) override;

 private:
  int print_tree(std::span<const TreeNode> tree) const;

  SceneOptions scene_;
  bool list_ = false;
  bool json_ = false;
};

int InfoCommand::run(const std::vector<std::string>&) {
  const Result<Scene> scene = load_scene(scene_, 0.0, true);
  if (list_ && !scene && scene.error().code == ErrorCode::kEmptyScene) {
    const auto tree = hidden_tree(scene_);
    return tree ? print_tree(*tree) : refuse(scene.error());
  }
  if (!scene) return refuse(scene.error());
  if (list_) return print_tree(scene->tree());
  if (json_) {
    print(scene_json(*scene));
  } else {
    std::cout << scene_text(scene_.path, *scene) + size_hint(*scene);
  }
  return finish_output();
}

int InfoCommand::print_tree(std::span<const TreeNode> tree) const {
  if (json_) {
    print(tree_json(tree));
  } else {
    std::cout << scene_.path + "\n" + tree_text(tree);
  }
  return finish_output();
}

}  // namespace

std::unique_ptr<Command> make_info_command() {
  return std::make_unique<InfoCommand>();
}

}  // namespace palpate
