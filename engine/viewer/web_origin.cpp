#include "engine/viewer/web_origin.h"

#include <algorithm>
#include <arpa/inet.h>
#include <array>
#include <charconv>

namespace palpate {
namespace {

bool is_name_character(char c) {
  return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || c == '-' || c == '.' || c == '_';
}

// Two spellings of an address have the same form.
std::optional<std::string> ipv6_form(std::string_view address) {
  in6_addr bytes{};
  std::array<char, INET6_ADDRSTRLEN> form{};
  if (::inet_pton(AF_INET6, std::string(address).c_str(), &bytes) != 1) return std::nullopt;
  if (::inet_ntop(AF_INET6, &bytes, form.data(), form.size()) == nullptr) return std::nullopt;
  return std::string(form.data());
}

std::optional<std::string> host_form(std::string_view name) {
  if (name.size() > 2 && name.front() == '[' && name.back() == ']') {
    const auto address = ipv6_form(name.substr(1, name.size() - 2));
    return address ? std::optional("[" + *address + "]") : std::nullopt;
  }
  std::string form = lower_case(name);
  if (form.empty() || !std::all_of(form.begin(), form.end(), is_name_character)) {
    return std::nullopt;
  }
  return form;
}

std::optional<std::uint16_t> parse_port(std::string_view digits) {
  constexpr std::size_t kMostDigits = 5;
  std::uint16_t port = 0;
  const char* const end = digits.data() + digits.size();
  const auto [stop, error] = std::from_chars(digits.data(), end, port);
  const bool is_port = digits.size() <= kMostDigits && error == std::errc() && stop == end;
  return is_port && port > 0 ? std::optional(port) : std::nullopt;
}

std::string origin_text(const WebOrigin& origin, std::string_view plain, std::string_view secure) {
  const std::uint16_t usual = origin.is_secure ? kPortOfHttps : kPortOfHttp;
  std::string text = std::string(origin.is_secure ? secure : plain) + "://" + origin.host;
  if (origin.port != usual) text += ":" + std::to_string(origin.port);
  return text;
}

}  // namespace

std::string lower_case(std::string_view text) {
  std::string result(text);
  for (char& c : result) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return result;
}

std::optional<WebHost> parse_host(std::string_view text) {
  WebHost host;
  const std::size_t bracket = text.rfind(']');
  const std::size_t colon = text.find(':', bracket == std::string_view::npos ? 0 : bracket);
  if (colon != std::string_view::npos) {
    host.port = parse_port(text.substr(colon + 1));
    if (!host.port) return std::nullopt;
  }
  auto name = host_form(text.substr(0, colon));
  if (!name) return std::nullopt;
  host.name = std::move(*name);
  return host;
}

std::optional<WebOrigin> parse_origin(std::string_view text) {
  const std::size_t colon = text.find("://");
  if (colon == std::string_view::npos) return std::nullopt;
  const std::string scheme = lower_case(text.substr(0, colon));
  if (scheme != "http" && scheme != "https") return std::nullopt;
  text.remove_prefix(colon + 3);
  if (text.ends_with('/')) text.remove_suffix(1);
  auto host = parse_host(text);
  if (!host) return std::nullopt;
  const bool is_secure = scheme == "https";
  return WebOrigin{is_secure, std::move(host->name),
                   host->port.value_or(is_secure ? kPortOfHttps : kPortOfHttp)};
}

std::string WebOrigin::text() const {
  return origin_text(*this, "http", "https");
}

std::string WebOrigin::socket_text() const {
  return origin_text(*this, "ws", "wss");
}

}  // namespace palpate
