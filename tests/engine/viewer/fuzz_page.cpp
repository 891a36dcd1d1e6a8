// libFuzzer's target: what a client of `view` sends. The first byte chooses the parser. For all
// bytes the result must be a value within its documented range, or an Error of one line.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/viewer/http_rules.h"
#include "engine/viewer/messages.h"
#include "engine/viewer/page_request.h"

namespace palpate {
namespace {

void require(bool holds) {
  if (!holds) std::abort();
}

bool is_finite(const SettingValue& value) {
  if (const auto* number = std::get_if<double>(&value)) return std::isfinite(*number);
  if (const auto* axes = std::get_if<std::vector<std::array<double, 3>>>(&value)) {
    for (const auto& axis : *axes) {
      for (const double x : axis) {
        if (!std::isfinite(x)) return false;
      }
    }
    return axes->size() <= kMostAxes;
  }
  return true;
}

void parse_page_request(std::string_view text) {
  std::optional<std::uint64_t> id;
  const auto request = parse_request(text, id);
  if (!request) {
    require(!request.error().to_string().empty());
    require(request.error().to_string().find('\n') == std::string::npos);
    return;
  }
  require(is_finite(request->value));
  require(request->id == id);
}

void parse_pointer(std::string_view bytes) {
  const auto message = decode_pointer(bytes);
  if (!message) return;
  require(bytes.size() == 40 && message->sequence > 0);
  for (const double x : message->target_m) require(std::isfinite(x));
}

// The lines are method, target, Host, Origin, Authorization, Palpate-Token; an empty one is left
// out.
void judge_request(std::string_view text) {
  static const Token token = Token::make();
  std::vector<std::string_view> lines;
  while (lines.size() < 6) {
    const std::size_t end = text.find('\n');
    lines.push_back(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  HttpHead head{lines[0], lines[1], {}, {}, {}, {}, !text.empty()};
  if (!lines[2].empty()) head.hosts.push_back(lines[2]);
  if (!lines[3].empty()) head.origins.push_back(lines[3]);
  if (!lines[4].empty()) head.authorizations.push_back(lines[4]);
  if (!lines[5].empty()) head.tokens.push_back(lines[5]);
  static const AllowedNames allowed{{"desk.example"}, {{true, "lab.example", 443}}};
  const HttpVerdict verdict = judge(head, {&token, 1}, allowed);
  if (verdict.status != 200) return require(!verdict.reason.empty());
  // What is served has a Host that is safe in a header, and is no secret: nobody guesses the token.
  const auto name = host_name(head.hosts.front());
  require(name == "localhost" || name == "127.0.0.1" || name == "[::1]" || name == "desk.example" ||
          name == "lab.example");
  require(verdict.resource != Resource::kScene && verdict.resource != Resource::kFullScene);
  for (const auto& [header, value] : safety_headers(head.hosts.front(), allowed.origins)) {
    require(value.find_first_of("\r\n") == std::string::npos);
  }
  if (!head.origins.empty()) {
    const auto origin = parse_origin(head.origins.front());
    const auto own = parse_origin("http://" + std::string(lines[2]));
    const bool is_own = own && origin == own && *name != "lab.example";
    require(origin && (is_own || *origin == allowed.origins.front()));
    require(parse_origin(origin->text()) == origin);
  }
  require(!head.upgrades || !head.origins.empty());
}

}  // namespace
}  // namespace palpate

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view rest(reinterpret_cast<const char*>(data) + 1, size - 1);
  switch (data[0] % 4) {
    case 0:
      palpate::parse_page_request(rest);
      break;
    case 1:
      palpate::parse_pointer(rest);
      break;
    case 2:
      palpate::judge_request(rest);
      break;
    default:
      palpate::accepts_gzip(rest);
  }
  return 0;
}
