#pragma once

// Where a page comes from: the origin of RFC 6454, as a browser states it. Pure functions.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace palpate {

inline constexpr std::uint16_t kPortOfHttp = 80;
inline constexpr std::uint16_t kPortOfHttps = 443;

// The letters of ASCII in lower case.
std::string lower_case(std::string_view text);

// A host and a port that is not there if the text states none.
struct WebHost {
  std::string name;  // in lower case; an IPv6 address in its shortest form, in brackets
  std::optional<std::uint16_t> port;
};

// Reads the value of a Host header. No value: it is not a host.
std::optional<WebHost> parse_host(std::string_view text);

struct WebOrigin {
  bool is_secure = false;  // https, not http
  std::string host;        // as WebHost::name
  std::uint16_t port = 0;  // that of the scheme if the text states none
  bool operator==(const WebOrigin&) const = default;

  // As a browser writes it: without the scheme's own port.
  std::string text() const;
  // The same for a WebSocket: ws:// or wss://.
  std::string socket_text() const;
};

// Reads http://HOST[:PORT] or https://HOST[:PORT], with at most one slash behind it; the case of
// the letters does not matter. No value: anything else, `null` among it.
std::optional<WebOrigin> parse_origin(std::string_view text);

}  // namespace palpate
