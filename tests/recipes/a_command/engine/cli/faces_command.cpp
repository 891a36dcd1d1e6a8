// The subcommand `faces`: counts the triangles of a scene.

#include <iostream>

#include "engine/cli/all_commands.h"
#include "engine/cli/command_help.h"
#include "engine/cli/command_output.h"
#include "engine/cli/scene_options.h"

namespace palpate {
namespace {

class FacesCommand final : public Command {
 public:
  CLI::App* add_to(CLI::App& program) override {
    CLI::App& app = *program.add_subcommand("faces", "count the triangles of a scene");
    set_help(app, "  ./run.sh faces models/gallery.glb\n");
    add_scene(app, scene_, true);
    return &app;
  }
  int run(const std::vector<std::string>&) override {
    const Result<Scene> scene = load_scene(scene_, 0.0, true);
    if (!scene) return refuse(scene.error());
    std::cout << scene->statistics().instanced_triangles << " triangles\n";
    return finish_output();
  }

 private:
  SceneOptions scene_;
};

}  // namespace

std::unique_ptr<Command> make_faces_command() {
  return std::make_unique<FacesCommand>();
}

}  // namespace palpate
