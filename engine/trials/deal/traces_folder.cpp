#include "engine/trials/deal/traces_folder.h"

#include <filesystem>
#include <string_view>
#include <system_error>
#include <vector>

#include "engine/trials/deal/participant_run.h"

namespace palpate {

namespace fs = std::filesystem;

std::string traces_folder_of(const std::string& run_folder) {
  return (fs::path(run_folder) / "traces").string();
}

void remove_traces(const std::string& run_folder) {
  std::vector<fs::path> traces;
  std::error_code failed;
  for (const std::string_view following : kFollowingNames) {
    const fs::path persons = fs::path(traces_folder_of(run_folder)) / following;
    for (fs::recursive_directory_iterator file(persons, failed), end; !failed && file != end;
         file.increment(failed)) {
      if (is_trace_name(file->path().filename().string())) traces.push_back(file->path());
    }
  }
  for (const fs::path& trace : traces) fs::remove(trace, failed);
}

}  // namespace palpate
