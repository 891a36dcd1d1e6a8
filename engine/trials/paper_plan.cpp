#include "engine/trials/paper_plan.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <system_error>
#include <vector>

#include <nlohmann/json.hpp>

#include "engine/trials/shipped_files.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

constexpr std::array<const char*, 4> kObjectFiles = {"star.glb", "labyrinth.glb",
                                                     "inverted_labyrinth.glb", "lock.glb"};

bool has_objects(const fs::path& folder) {
  return std::all_of(kObjectFiles.begin(), kObjectFiles.end(), [&](const char* name) {
    std::error_code failed;
    return fs::is_regular_file(folder / name, failed);
  });
}

// A path from one folder to another, or nothing if the system does not find the target by it.
std::string path_between(const fs::path& from, const fs::path& to) {
  std::error_code failed;
  // By the names alone, which fails if `from` is a link to a folder elsewhere.
  const fs::path here = fs::absolute(from, failed).lexically_normal();
  const fs::path by_names = fs::absolute(to, failed).lexically_normal().lexically_relative(here);
  // Without links.
  const fs::path by_places = fs::relative(to, from, failed);
  for (const fs::path& path : {by_names, by_places}) {
    if (!path.empty() && has_objects(from / path)) return path.generic_string();
  }
  return fs::absolute(to, failed).lexically_normal().generic_string();
}

// The text of a shipped file, in which the names of the objects' files begin with this folder.
std::string with_folder(std::string text, const std::string& objects_folder) {
  if (objects_folder.empty()) return text;
  for (const char* const name : kObjectFiles) {
    const std::string plain = nlohmann::json(name).dump();
    const std::string full = nlohmann::json((fs::path(objects_folder) / name).generic_string())
                                 .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    const std::size_t at = text.find(plain);
    if (at != std::string::npos) text.replace(at, plain.size(), full);
  }
  return text;
}

// The path from a folder to the models.
Result<std::string> models_from(const std::string& folder) {
  const auto models = models_folder();
  if (!models) return models.error();
  return path_between(folder.empty() ? "." : folder, *models);
}

}  // namespace

Result<std::string> models_folder() {
  std::vector<fs::path> candidates = {"models"};
  std::error_code failed;
  fs::path folder = fs::read_symlink("/proc/self/exe", failed).parent_path();
  constexpr int kMostAbove = 4;
  for (int above = 0; !failed && above <= kMostAbove; ++above) {
    candidates.push_back(folder / "models");
    folder = folder.parent_path();
  }
  for (const fs::path& candidate : candidates) {
    if (has_objects(candidate)) return candidate.string();
  }
  return Error{ErrorCode::kFileNotFound, "models", "",
               "cannot be found; expected a folder with star.glb, labyrinth.glb, "
               "inverted_labyrinth.glb and lock.glb",
               "run the program in the folder of the project"};
}

bool is_shipped_plan(std::string_view name) {
  return std::find(kShippedPlans.begin(), kShippedPlans.end(), name) != kShippedPlans.end();
}

std::string shipped_plan_text(std::string_view name, const std::string& objects_folder) {
  const std::string_view text = name == kShippedPlans[1]   ? shipped_paper_live()
                                : name == kShippedPlans[2] ? shipped_paper_live_mouse()
                                                           : shipped_paper();
  return with_folder(std::string(text), objects_folder);
}

std::string shipped_sweep_text(const std::string& objects_folder) {
  return with_folder(std::string(shipped_sweep()), objects_folder);
}

Result<std::string> shipped_plan_for(std::string_view name, const std::string& folder) {
  const auto models = models_from(folder);
  if (!models) return models.error();
  return shipped_plan_text(name, *models);
}

Result<std::string> shipped_sweep_for(const std::string& folder) {
  const auto models = models_from(folder);
  if (!models) return models.error();
  return shipped_sweep_text(*models);
}

}  // namespace palpate
