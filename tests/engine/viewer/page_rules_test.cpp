// What the server of `view` believes: tokens, hosts, and the JSON of a page.

#include <set>
#include <string>

#include <gtest/gtest.h>

#include "engine/viewer/http_rules.h"
#include "engine/viewer/page_request.h"
#include "engine/viewer/token.h"

namespace palpate::test {
namespace {

TEST(ViewToken, Has32HexadecimalDigitsThatDifferEachTime) {
  std::set<std::string> seen;
  std::set<char> digits;
  for (int i = 0; i < 200; ++i) {
    const Token token = Token::make();
    EXPECT_EQ(token.text().size(), 32u);
    EXPECT_EQ(token.text().find_first_not_of("0123456789abcdef"), std::string::npos);
    seen.insert(token.text());
    digits.insert(token.text().begin(), token.text().end());
  }
  EXPECT_EQ(seen.size(), 200u);
  EXPECT_EQ(digits.size(), 16u);  // all of them among 6,400
}

TEST(ViewToken, EqualsOnlyItself) {
  const Token token = Token::make();
  EXPECT_TRUE(token.equals(token.text()));
  for (std::size_t i = 0; i < token.text().size(); ++i) {
    std::string other = token.text();
    other[i] = other[i] == 'a' ? 'b' : 'a';
    EXPECT_FALSE(token.equals(other)) << i;
  }
  EXPECT_FALSE(token.equals(""));
  EXPECT_FALSE(token.equals(token.text() + std::string(1, '\0')));
  EXPECT_FALSE(token.equals(token.text().substr(1)));
}

TEST(ViewRules, HostNameIsThePartBeforeThePort) {
  EXPECT_EQ(host_name("LocalHost:80"), "localhost");
  EXPECT_EQ(host_name("127.0.0.1"), "127.0.0.1");
  EXPECT_EQ(host_name("[::1]:65535"), "[::1]");
  for (const char* wrong : {"", ":80", "a:", "a:123456", "a:8x", "a b", "a/b", "a@b", "a\"b",
                            "[::1", "[::g]", "::1", "a;b", "a\r\nb", "[]", "a:0", "a:65536"}) {
    EXPECT_EQ(host_name(wrong), std::nullopt) << wrong;
  }
}

TEST(ViewRules, EachLoopbackAddressIsOne) {
  for (const char* own :
       {"127.0.0.1", "127.0.0.2", "127.255.1.9", "::1", "0:0:0:0:0:0:0:1", "::ffff:127.0.0.1"}) {
    EXPECT_TRUE(is_loopback(own)) << own;
  }
  for (const char* other : {"", "0.0.0.0", "128.0.0.1", "126.255.255.255", "::", "::2", "[::1]",
                            "localhost", "127.0.0.1.example", "::ffff:128.0.0.1"}) {
    EXPECT_FALSE(is_loopback(other)) << other;
  }
}

TEST(ViewRules, OriginsAreEqualInEachSpelling) {
  const WebOrigin lab{true, "lab.example", 443};
  for (const char* same : {"https://lab.example", "HTTPS://Lab.Example", "https://lab.example:443",
                           "https://lab.example/", "https://LAB.example:443/"}) {
    EXPECT_EQ(parse_origin(same), lab) << same;
  }
  EXPECT_EQ(lab.text(), "https://lab.example");
  EXPECT_EQ(lab.socket_text(), "wss://lab.example");
  EXPECT_EQ(parse_origin("http://lab.example:8080")->text(), "http://lab.example:8080");
  EXPECT_EQ(parse_origin("http://lab.example:443")->socket_text(), "ws://lab.example:443");
  EXPECT_EQ(parse_origin("https://[2001:DB8:0:0::1]:8443")->text(), "https://[2001:db8::1]:8443");
  for (const char* other : {"http://lab.example", "https://lab.example:80", "https://lab.exampl",
                            "https://x.lab.example", "https://lab.example:4430"}) {
    EXPECT_NE(parse_origin(other), lab) << other;
  }
  for (const char* wrong : {"",
                            "null",
                            "*",
                            "lab.example",
                            "//lab.example",
                            "https:lab.example",
                            "https://",
                            "https:///",
                            "https://lab.example//",
                            "https://lab.example/lab",
                            "https://lab.example?x",
                            "https://a@b",
                            "https://lab.example:",
                            "https://lab.example:0",
                            "https://lab.example:65536",
                            "https://lab.example:+1",
                            "https://*.example",
                            "wss://lab.example",
                            "file:///x",
                            "https://[::1",
                            "https://[::g]",
                            "https://::1",
                            " https://lab.example",
                            "https://lab.example ",
                            "https://l\u00e4b.example",
                            "https://a,https://b"}) {
    EXPECT_EQ(parse_origin(wrong), std::nullopt) << wrong;
  }
}

TEST(ViewRules, GzipIsUsedWhereItIsAccepted) {
  for (const char* yes : {"gzip", "br, gzip", "GZIP;q=0.5", "deflate,gzip;q=1.0"}) {
    EXPECT_TRUE(accepts_gzip(yes)) << yes;
  }
  for (const char* no : {"", "br", "gzip;q=0", "gzip;q=0.0", "xgzip", "identity"}) {
    EXPECT_FALSE(accepts_gzip(no)) << no;
  }
}

PageRequest parsed(const std::string& text) {
  std::optional<std::uint64_t> id;
  const auto request = parse_request(text, id);
  EXPECT_TRUE(request.ok()) << text << (request.ok() ? "" : request.error().to_string());
  return request.ok() ? *request : PageRequest{};
}

std::string problem(const std::string& text) {
  std::optional<std::uint64_t> id;
  const auto request = parse_request(text, id);
  return request.ok() ? "" : request.error().to_string();
}

TEST(PageRequests, AreReadWithTheirValues) {
  EXPECT_EQ(parsed(R"({"type":"token","token":"abc"})").token, "abc");
  const PageRequest number = parsed(R"({"name":"stiffness","value":2e3,"type":"set","id":7})");
  EXPECT_EQ(number.kind, PageRequest::Kind::kSet);
  EXPECT_EQ(number.id, 7u);
  EXPECT_EQ(number.name, "stiffness");
  EXPECT_EQ(std::get<double>(number.value), 2000.0);
  using Axes = std::vector<std::array<double, 3>>;
  EXPECT_EQ(
      std::get<Axes>(parsed(R"({"type":"set","name":"axes","value":[[1,0,0],[0,0,-1]]})").value),
      (Axes{{1, 0, 0}, {0, 0, -1}}));
  EXPECT_EQ(std::get<Axes>(parsed(R"({"type":"set","name":"axes","value":[]})").value), Axes{});
  EXPECT_EQ(std::get<std::string>(parsed(R"({"type":"set","name":"force","value":"full"})").value),
            "full");
  EXPECT_EQ(std::get<bool>(parsed(R"({"type":"pause","value":true,"id":1})").value), true);
  EXPECT_EQ(parsed(R"({"type":"start"})").id, std::nullopt);
  EXPECT_EQ(parsed(R"({"type":"stay","id":6})").kind, PageRequest::Kind::kStay);
}

TEST(PageRequests, MayBeNestedEightDeepAndNoDeeper) {
  const auto nested = [](int depth) {
    return "{\"type\":\"set\",\"id\":1,\"name\":\"[{\\\"[\",\"value\":" +
           std::string(static_cast<std::size_t>(depth - 1), '[') +
           std::string(static_cast<std::size_t>(depth - 1), ']') + "}";
  };
  EXPECT_EQ(problem(nested(8)).find("nested"), std::string::npos);
  EXPECT_NE(problem(nested(9)).find("nested deeper than 8"), std::string::npos);
  EXPECT_EQ(problem(R"({"type":"token","token":"[[[[[[[[[[[[[["})"), "");
}

TEST(PageRequests, TellTheIdOfAWrongRequest) {
  std::optional<std::uint64_t> id;
  EXPECT_FALSE(parse_request(R"({"type":"what","id":12})", id).ok());
  EXPECT_EQ(id, 12u);
  EXPECT_FALSE(parse_request("{", id).ok());
  EXPECT_EQ(id, std::nullopt);
}

}  // namespace
}  // namespace palpate::test
