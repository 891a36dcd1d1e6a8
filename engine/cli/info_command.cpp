// The subcommand `info`: describes a scene.

#include <iostream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "engine/cli/all_commands.h"
#include "engine/cli/command_help.h"
#include "engine/cli/command_output.h"
#include "engine/cli/report.h"
#include "engine/cli/scene_options.h"
#include "engine/scene/node_tree.h"

namespace palpate {
namespace {

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
  SceneOptions scene_;
  bool list_ = false;
  bool json_ = false;
};

int InfoCommand::run(const std::vector<std::string>&) {
  const Result<Scene> scene = load_scene(scene_, 0.0);
  if (!scene) return refuse(scene.error());
  if (json_) {
    print(list_ ? tree_json(*scene) : scene_json(*scene));
  } else {
    std::cout << (list_ ? scene_.path + "\n" + tree_text(scene->tree())
                        : scene_text(scene_.path, *scene));
  }
  return finish_output();
}

}  // namespace

std::unique_ptr<Command> make_info_command() {
  return std::make_unique<InfoCommand>();
}

}  // namespace palpate
