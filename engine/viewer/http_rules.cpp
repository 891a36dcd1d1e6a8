#include "engine/viewer/http_rules.h"

#include <algorithm>
#include <array>

namespace palpate {
namespace {

constexpr std::array<std::pair<std::string_view, Resource>, 7> kTargets = {{
    {"/", Resource::kPage},
    {"/page.js", Resource::kScript},
    {"/page.css", Resource::kStyle},
    {"/icon.svg", Resource::kIcon},
    {"/felt.glb", Resource::kScene},
    {"/felt.glb?full", Resource::kFullScene},
    {"/live", Resource::kLive},
}};

constexpr std::array<std::string_view, 3> kLoopback = {"localhost", "127.0.0.1", "[::1]"};

constexpr std::string_view kBearer = "Bearer ";

char lower(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

std::string lowered(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(), lower);
  return result;
}

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

bool is_name_character(char c) {
  return is_digit(c) || (lower(c) >= 'a' && lower(c) <= 'z') || c == '-' || c == '.' || c == '_';
}

bool is_address_character(char c) {
  return is_digit(c) || (lower(c) >= 'a' && lower(c) <= 'f') || c == ':' || c == '.';
}

bool is_host(std::string_view name) {
  if (name.size() > 2 && name.front() == '[' && name.back() == ']') {
    name = name.substr(1, name.size() - 2);
    return std::all_of(name.begin(), name.end(), is_address_character);
  }
  return !name.empty() && std::all_of(name.begin(), name.end(), is_name_character);
}

bool may_serve(std::string_view host, const std::vector<std::string>& allowed_hosts) {
  const auto name = host_name(host);
  if (!name) return false;
  const auto is_name = [&](std::string_view allowed) { return lowered(allowed) == *name; };
  return std::any_of(kLoopback.begin(), kLoopback.end(), is_name) ||
         std::any_of(allowed_hosts.begin(), allowed_hosts.end(), is_name);
}

bool is_own_page(const HttpHead& head) {
  if (head.origins.empty()) return !head.upgrades;
  constexpr std::string_view kScheme = "http://";
  const std::string_view origin = head.origins.front();
  return head.origins.size() == 1 && origin.starts_with(kScheme) &&
         origin.substr(kScheme.size()) == head.hosts.front();
}

bool has_token(const HttpHead& head, const Token& token) {
  return head.authorizations.size() == 1 && head.authorizations.front().starts_with(kBearer) &&
         token.equals(head.authorizations.front().substr(kBearer.size()));
}

}  // namespace

std::optional<std::string> host_name(std::string_view host) {
  constexpr std::size_t kMostDigits = 5;
  std::string_view name = host;
  const std::size_t bracket = host.rfind(']');
  const std::size_t colon = host.find(':', bracket == std::string_view::npos ? 0 : bracket);
  if (colon != std::string_view::npos) {
    const std::string_view port = host.substr(colon + 1);
    if (port.empty() || port.size() > kMostDigits ||
        !std::all_of(port.begin(), port.end(), is_digit)) {
      return std::nullopt;
    }
    name = host.substr(0, colon);
  }
  if (!is_host(name)) return std::nullopt;
  return lowered(name);
}

HttpVerdict judge(const HttpHead& head, const Token& token,
                  const std::vector<std::string>& allowed_hosts) {
  const auto refused = [](int status, std::string_view reason) {
    return HttpVerdict{status, Resource::kPage, reason};
  };
  if (head.hosts.size() != 1 || !may_serve(head.hosts.front(), allowed_hosts)) {
    return refused(403, "the Host is not a loopback name (--allow-host permits others)");
  }
  if (!is_own_page(head)) return refused(403, "the Origin is not this server");
  if (head.method != "GET") return refused(405, "only GET is answered");
  const auto found = std::find_if(kTargets.begin(), kTargets.end(),
                                  [&](const auto& t) { return t.first == head.target; });
  if (found == kTargets.end()) return refused(404, "nothing has this name");
  const Resource resource = found->second;
  if (resource == Resource::kLive && !head.upgrades) {
    return refused(426, "/live is a WebSocket");
  }
  if (resource != Resource::kLive && head.upgrades) return refused(404, "only /live upgrades");
  const bool is_secret = resource == Resource::kScene || resource == Resource::kFullScene;
  if (is_secret && !has_token(head, token)) return refused(401, "the token is missing or wrong");
  return {200, resource, ""};
}

std::vector<std::pair<std::string, std::string>> safety_headers(std::string_view host) {
  std::string policy =
      "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'";
  if (!host.empty()) policy += " ws://" + std::string(host);
  policy += "; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
  return {{"Content-Security-Policy", std::move(policy)},
          {"X-Content-Type-Options", "nosniff"},
          {"Referrer-Policy", "no-referrer"},
          {"Cross-Origin-Resource-Policy", "same-origin"},
          {"Cross-Origin-Opener-Policy", "same-origin"},
          {"Cache-Control", "no-store"}};
}

bool accepts_gzip(std::string_view accept_encoding) {
  while (!accept_encoding.empty()) {
    const std::size_t comma = accept_encoding.find(',');
    std::string coding = lowered(accept_encoding.substr(0, comma));
    coding.erase(std::remove(coding.begin(), coding.end(), ' '), coding.end());
    if (coding == "gzip" || (coding.starts_with("gzip;q=") &&
                             coding.find_first_of("123456789", 7) != std::string::npos)) {
      return true;
    }
    if (comma == std::string_view::npos) break;
    accept_encoding.remove_prefix(comma + 1);
  }
  return false;
}

}  // namespace palpate
