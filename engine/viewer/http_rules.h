#pragma once

// Which requests the server of `view` answers, and with which headers. Pure functions.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/viewer/token.h"

namespace palpate {

// What the server has. No folder is served: a target is compared whole, with its query.
enum class Resource : std::uint8_t { kPage, kScript, kStyle, kIcon, kScene, kFullScene, kLive };

// The parts of a request that decide. A header that occurs twice is listed twice.
struct HttpHead {
  std::string_view method;
  std::string_view target;
  std::vector<std::string_view> hosts;
  std::vector<std::string_view> origins;
  std::vector<std::string_view> authorizations;
  bool upgrades = false;  // a WebSocket handshake
};

struct HttpVerdict {
  int status = 200;
  Resource resource = Resource::kPage;  // if the status is 200
  std::string_view reason;              // one line for the client, otherwise
};

// Judges a request:
// - The Host must be a loopback name (localhost, 127.0.0.1, [::1]) or a name in allowed_hosts, with
//   any port, because a forwarded port differs. This stops a foreign name that resolves to this
//   machine. Otherwise 403.
// - The Origin must be http:// and that Host; only a plain GET may lack it. Otherwise 403: the
//   request comes from a foreign page.
// - Only GET (405), and only the seven names (404).
// - The scene requires the token as `Authorization: Bearer` (401). /live requires a handshake
// (426);
//   its token is the first message.
HttpVerdict judge(const HttpHead& head, const Token& token,
                  const std::vector<std::string>& allowed_hosts);

// The part of a Host header before the port, in lower case. No value: not a host.
std::optional<std::string> host_name(std::string_view host);

// The headers of every answer. host: a Host that judge() accepted; empty: none, so that the policy
// allows no connection.
std::vector<std::pair<std::string, std::string>> safety_headers(std::string_view host);

// True if the value of an Accept-Encoding header names gzip and does not refuse it.
bool accepts_gzip(std::string_view accept_encoding);

}  // namespace palpate
