#include "engine/viewer/http_rules.h"

#include <algorithm>
#include <array>
#include <boost/asio/ip/address.hpp>

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

constexpr std::string_view kBearer = "Bearer ";

enum class HostKind : std::uint8_t { kForeign, kOwn, kOfProxy };

std::string_view without_brackets(std::string_view host) {
  return host.starts_with('[') ? host.substr(1, host.size() - 2) : host;
}

HostKind kind_of(const WebHost& host, const AllowedNames& allowed) {
  const auto is_name = [&](std::string_view name) { return host_name(name) == host.name; };
  if (host.name == "localhost" || is_loopback(without_brackets(host.name)) ||
      std::any_of(allowed.hosts.begin(), allowed.hosts.end(), is_name)) {
    return HostKind::kOwn;
  }
  const bool is_of_proxy = std::any_of(allowed.origins.begin(), allowed.origins.end(),
                                       [&](const WebOrigin& o) { return o.host == host.name; });
  return is_of_proxy ? HostKind::kOfProxy : HostKind::kForeign;
}

bool is_own_page(const HttpHead& head, const WebHost& host, HostKind kind,
                 const AllowedNames& allowed) {
  if (head.origins.empty()) return !head.upgrades;
  if (head.origins.size() != 1) return false;
  const auto origin = parse_origin(head.origins.front());
  if (!origin) return false;
  const auto& origins = allowed.origins;
  if (std::find(origins.begin(), origins.end(), *origin) != origins.end()) return true;
  const WebOrigin own{false, host.name, host.port.value_or(kPortOfHttp)};
  return kind == HostKind::kOwn && *origin == own;
}

bool has_token(const HttpHead& head, std::span<const Token> tokens) {
  if (!head.tokens.empty()) {
    return head.tokens.size() == 1 && place_of(head.tokens.front(), tokens);
  }
  return head.authorizations.size() == 1 && head.authorizations.front().starts_with(kBearer) &&
         place_of(head.authorizations.front().substr(kBearer.size()), tokens);
}

}  // namespace

bool is_loopback(std::string_view address) {
  namespace ip = boost::asio::ip;
  boost::system::error_code error;
  const auto parsed = ip::make_address(std::string(address), error);
  if (error) return false;
  const bool is_mapped = parsed.is_v6() && parsed.to_v6().is_v4_mapped();
  return is_mapped ? ip::make_address_v4(ip::v4_mapped, parsed.to_v6()).is_loopback()
                   : parsed.is_loopback();
}

std::optional<std::string> host_name(std::string_view host) {
  auto parsed = parse_host(host);
  if (!parsed) return std::nullopt;
  return std::move(parsed->name);
}

HttpVerdict judge(const HttpHead& head, std::span<const Token> tokens,
                  const AllowedNames& allowed) {
  const auto refused = [](int status, std::string_view reason) {
    return HttpVerdict{status, Resource::kPage, reason};
  };
  const auto host = head.hosts.size() == 1 ? parse_host(head.hosts.front()) : std::nullopt;
  const HostKind kind = host ? kind_of(*host, allowed) : HostKind::kForeign;
  if (kind == HostKind::kForeign) {
    return refused(403, "the Host is not a loopback name (--allow-host permits others)");
  }
  const std::string_view target = head.target.starts_with("/?") ? "/" : head.target;
  const auto found = std::find_if(kTargets.begin(), kTargets.end(),
                                  [&](const auto& t) { return t.first == target; });
  const bool is_get = head.method == "GET" || (head.method == "HEAD" && !head.upgrades);
  const bool is_public = found != kTargets.end() && is_get && !head.upgrades &&
                         found->second != Resource::kLive && !is_secret(found->second);
  if (!is_own_page(head, *host, kind, allowed) && !(is_public && head.is_same_origin)) {
    return refused(403, "the Origin is not this server (--allow-origin permits that of a proxy)");
  }
  if (!is_get) return refused(405, "only GET and HEAD are answered");
  if (found == kTargets.end()) return refused(404, "nothing has this name");
  const Resource resource = found->second;
  if (resource == Resource::kLive && !head.upgrades) {
    return refused(426, "/live is a WebSocket");
  }
  if (resource != Resource::kLive && head.upgrades) return refused(404, "only /live upgrades");
  if (is_secret(resource) && !has_token(head, tokens)) {
    return refused(401, "the token is missing or wrong");
  }
  return {200, resource, ""};
}

std::vector<std::pair<std::string, std::string>> safety_headers(
    std::string_view host, const std::vector<WebOrigin>& origins) {
  std::string policy =
      "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'";
  if (!host.empty()) policy += " ws://" + std::string(host);
  // Not every browser counts wss:// of the page's host as 'self'.
  for (const WebOrigin& origin : origins) policy += " " + origin.socket_text();
  policy += "; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
  return {{"Content-Security-Policy", std::move(policy)},
          {"X-Content-Type-Options", "nosniff"},
          {"Referrer-Policy", "no-referrer"},
          {"Cross-Origin-Resource-Policy", "same-origin"},
          {"Cross-Origin-Opener-Policy", "same-origin"},
          {"Cache-Control", "no-store"}};
}

bool may_begin_request(char first) {
  return first > ' ' && first <= '~';
}

bool accepts_gzip(std::string_view accept_encoding) {
  while (!accept_encoding.empty()) {
    const std::size_t comma = accept_encoding.find(',');
    std::string coding = lower_case(accept_encoding.substr(0, comma));
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
