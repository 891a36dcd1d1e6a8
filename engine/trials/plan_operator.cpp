#include "engine/trials/plan_operator.h"

#include <filesystem>
#include <string_view>
#include <utility>
#include <vector>

#include "geometry/base/quoted.h"

namespace palpate {

void read_plan_operator(ObjectReader& reader, const std::string& folder, OperatorFile& person) {
  std::string name;
  reader.text("operator", name, ObjectReader::Key::kRequired, kMostProseBytes);
  if (!reader.ok()) return;
  const bool is_shipped = !shipped_operator_text(name).empty();
  auto file = load_operator(is_shipped ? name : (std::filesystem::path(folder) / name).string());
  if (file) {
    person = std::move(*file);
    return;
  }
  if (file.error().code != ErrorCode::kFileNotFound) return reader.fail(file.error());
  std::vector<std::string_view> words(kShippedOperators.begin(), kShippedOperators.end());
  words.emplace_back("the path of an operator file");
  reader.fail({ErrorCode::kInvalidContent, "", reader.element_of("operator"),
               "is " + in_quotes(name) + "; expected " + joined_words(words),
               "there is no such file in the folder of the plan"});
}

}  // namespace palpate
