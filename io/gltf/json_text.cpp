#include "io/gltf/json_text.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>

#include <nlohmann/json.hpp>

#include "geometry/base/memory_reserve.h"
#include "io/gltf/data_uris.h"
#include "io/gltf/error.h"
#include "io/gltf/json_spaces.h"

namespace palpate {
namespace {

using Json = nlohmann::json;

// The largest number of repeated keys that are listed, so that other warnings remain visible.
constexpr std::size_t kMostListed = 20;

// Receives the parser's events and builds the document. The library's own builder silently replaces
// the value of a repeated key.
class DocumentBuilder {
 public:
  explicit DocumentBuilder(std::vector<std::string>& warnings) : warnings_(warnings) {}

  Json take() { return std::move(root_); }
  const std::string& problem() const { return problem_; }
  std::size_t unlisted_duplicates() const {
    return duplicates_ - std::min(duplicates_, kMostListed);
  }

  bool null() { return put(nullptr); }
  bool boolean(bool value) { return put(value); }
  bool number_integer(Json::number_integer_t value) { return put(value); }
  bool number_unsigned(Json::number_unsigned_t value) { return put(value); }
  bool number_float(Json::number_float_t value, const std::string&) { return put(value); }
  bool string(std::string& value) { return put(std::move(value)); }
  bool binary(Json::binary_t&) { return false; }  // text has no binary values
  bool start_object(std::size_t) { return open(Json::value_t::object); }
  bool start_array(std::size_t) { return open(Json::value_t::array); }
  bool end_object() { return close(); }
  bool end_array() { return close(); }

  bool key(std::string& name) {
    auto& entries = open_.back().value->get_ref<Json::object_t&>();
    const auto [entry, is_new] = entries.try_emplace(std::move(name));
    open_.back().key = &entry->first;
    slot_ = &entry->second;
    if (!is_new && ++duplicates_ <= kMostListed) {
      warnings_.push_back(path() + ": is present more than once; the last value is used");
    }
    return true;
  }

  bool parse_error(std::size_t, const std::string&, const Json::exception& exception) {
    problem_ = exception.what();
    return false;
  }

 private:
  // An object or array that is still open. It does not move in memory, because no later element is
  // added to its parent while it is open.
  struct Open {
    Json* value = nullptr;
    const std::string* key = nullptr;  // the last key of an object
  };

  template <typename Value>
  bool put(Value&& value) {
    place() = std::forward<Value>(value);
    return true;
  }

  bool open(Json::value_t type) {
    Json& value = place();
    value = Json(type);
    open_.push_back({&value, nullptr});
    return true;
  }

  bool close() {
    open_.pop_back();
    return true;
  }

  // The place of the next value.
  Json& place() {
    expect_no_shortage();
    if (open_.empty()) return root_;
    Json& parent = *open_.back().value;
    return parent.is_array() ? parent.get_ref<Json::array_t&>().emplace_back() : *slot_;
  }

  // "/nodes/7/mesh"
  std::string path() const {
    std::string text;
    for (const Open& level : open_) {
      text += "/" + (level.key != nullptr ? shortened(*level.key)
                                          : std::to_string(level.value->size() - 1));
    }
    return text;
  }

  std::vector<std::string>& warnings_;
  Json root_;
  std::vector<Open> open_;
  Json* slot_ = nullptr;  // of the last key
  std::size_t duplicates_ = 0;
  std::string problem_;
};

// The parts that the parser need not examine, ascending. marks: of the data, for the replacements.
std::vector<JsonReplacement> replacements_of(const JsonScan& scan,
                                             const std::vector<std::string>& marks) {
  std::vector<JsonReplacement> replacements;
  replacements.reserve(scan.long_spaces.size() + marks.size());
  for (const JsonTextPart& part : scan.long_spaces) replacements.push_back({part, {}});
  for (std::size_t i = 0; i < marks.size(); ++i) {
    replacements.push_back({scan.long_data[i], marks[i]});
  }
  std::inplace_merge(replacements.begin(),
                     replacements.end() - static_cast<std::ptrdiff_t>(marks.size()),
                     replacements.end(), [](const JsonReplacement& a, const JsonReplacement& b) {
                       return a.part.begin < b.part.begin;
                     });
  return replacements;
}

}  // namespace

Result<Json> parse_gltf_json(std::string_view text, const JsonScan& scan,
                             std::vector<std::string>& warnings) {
  if (text.starts_with("\xEF\xBB\xBF")) {  // the parser would ignore it
    return gltf_invalid("JSON", "begins with a second byte order mark; expected {");
  }
  // The parser treats a zero byte as the end.
  const std::size_t end = text.find('\0');
  if (text.find_first_not_of('\0', std::min(end, text.size())) != text.npos) {
    return gltf_invalid("JSON", "byte " + std::to_string(end) + " is zero; expected text");
  }
  std::vector<std::string> marks;
  marks.reserve(scan.long_data.size());
  while (marks.size() < scan.long_data.size()) marks.push_back(GltfDataUris::mark(marks.size()));
  const std::vector<JsonReplacement> replacements = replacements_of(scan, marks);
  DocumentBuilder builder(warnings);
  const bool is_parsed = replacements.empty()
                             ? Json::sax_parse(text, &builder)
                             : Json::sax_parse(JsonTextIterator(text, 0, replacements),
                                               JsonTextIterator(text, text.size(), {}), &builder);
  if (!is_parsed) {
    return gltf_invalid(
        "JSON", builder.problem().substr(0, 200),
        replacements.empty()
            ? ""
            : "lines and columns are counted without long runs of spaces and data of URIs");
  }
  if (const std::size_t others = builder.unlisted_duplicates(); others > 0) {
    warnings.push_back("JSON: " + std::to_string(others) +
                       " further keys are present more than once; the last value of each is used");
  }
  return builder.take();
}

}  // namespace palpate
