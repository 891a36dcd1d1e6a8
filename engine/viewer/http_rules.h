#pragma once

// Which requests the server of `view` answers, and with which headers. Pure functions.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/viewer/token.h"
#include "engine/viewer/web_origin.h"

namespace palpate {

// What the server has. No folder is served: a target is compared whole, with its query; only that
// of the page may be any.
enum class Resource : std::uint8_t { kPage, kScript, kStyle, kIcon, kScene, kFullScene, kLive };

// True for what only a holder of the token receives.
constexpr bool is_secret(Resource resource) {
  return resource == Resource::kScene || resource == Resource::kFullScene;
}

// The parts of a request that decide. A header that occurs twice is listed twice.
struct HttpHead {
  std::string_view method;
  std::string_view target;
  std::vector<std::string_view> hosts;
  std::vector<std::string_view> origins;
  std::vector<std::string_view> authorizations;
  std::vector<std::string_view> tokens;  // Palpate-Token
  bool upgrades = false;                 // a WebSocket handshake
  bool is_same_origin = false;           // the browser says so: Sec-Fetch-Site
};

// Under which names a browser may reach the server, besides localhost and loopback addresses.
struct AllowedNames {
  // Host names without a port (host_name), for a page of http:// and this Host.
  std::vector<std::string> hosts = {};
  // Origins of a page that a reverse proxy serves. Their hosts are allowed, too: a proxy passes the
  // Host of the browser, or puts that of its upstream.
  std::vector<WebOrigin> origins = {};
};

struct HttpVerdict {
  int status = 200;
  Resource resource = Resource::kPage;  // if the status is 200
  std::string_view reason;              // one line for the client, otherwise
};

// The header in which a page sends its token for the scene. `Authorization` is left to a proxy that
// asks for a password.
inline constexpr std::string_view kTokenHeader = "Palpate-Token";

// Judges a request:
// - The Host must be a loopback name (localhost, [::1], 127.0.0.1 or another address of its net,
//   which no foreign name can pretend to be), a name in allowed.hosts or the
//   host of one of allowed.origins, with any port, because a forwarded port differs. This stops a
//   foreign name that resolves to this machine. Otherwise 403.
// - The Origin must be one of allowed.origins, or http:// and that Host unless only allowed.origins
//   names it; only a plain request may lack it. Otherwise 403: the request comes from a foreign
//   page. The files of the page are also given to a page that the browser calls same-origin: behind
//   a proxy that nobody has named, the page then says so. What a proxy adds (Forwarded,
//   X-Forwarded-Host) counts for nothing, because anybody can send it.
// - Only GET and HEAD (405), and only the seven names (404).
// - The scene requires one of the tokens in kTokenHeader or as `Authorization: Bearer` (401). /live
//   requires a handshake (426), which is a GET; its token is the first message.
HttpVerdict judge(const HttpHead& head, std::span<const Token> tokens, const AllowedNames& allowed);

// True for an IP address that only this machine reaches: 127.0.0.0/8 and ::1. [::1] is not one.
bool is_loopback(std::string_view address);

// The part of a Host header before the port, in lower case. No value: not a host.
std::optional<std::string> host_name(std::string_view host);

// The headers of every answer. host: a Host that judge() accepted; empty: none, so that the policy
// allows no connection but to `origins`.
std::vector<std::pair<std::string, std::string>> safety_headers(
    std::string_view host, const std::vector<WebOrigin>& origins = {});

// True if a request may begin with this byte: a method does. A handshake of TLS does not.
bool may_begin_request(char first);

// True if the value of an Accept-Encoding header names gzip and does not refuse it.
bool accepts_gzip(std::string_view accept_encoding);

}  // namespace palpate
