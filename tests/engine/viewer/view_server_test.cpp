// The server of `view` against the clients that it must serve, and against attacks, on real
// sockets.

#include "engine/viewer/view_server.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <sys/resource.h>
#include <thread>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>

#include "tests/engine/viewer/raw_client.h"
#include "tests/engine/viewer/served_model.h"
#include "tests/helpers/sanitizers.h"

namespace palpate::test {
namespace {

using Texts = std::vector<std::string>;

// A page with its token accepted.
class Page : public WebSocketClient {
 public:
  explicit Page(const ServedModel& served) : WebSocketClient(served.port) {
    send_text(served.token_message());
    hello = read_text_with("\"hello\"");
  }
  // The answer to a request with this id.
  std::string answer(const std::string& request, int id) {
    send_text(request);
    return read_text_with("\"answer\",\"id\":" + std::to_string(id) + ",");
  }
  bool is_in_control() const { return hello.find("\"control\":true") != std::string::npos; }

  std::string hello;
};

template <typename Number>
void put(std::string& bytes, Number number) {
  bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
}

std::string pointer_bytes(std::uint64_t sequence, double x, std::uint32_t buttons = 1) {
  std::string bytes;
  put(bytes, std::uint16_t{16});
  put(bytes, static_cast<std::uint16_t>(kViewVersion));
  put(bytes, buttons);
  put(bytes, sequence);
  for (const double number : {x, 0.25, -0.5}) put(bytes, number);
  return bytes;
}

constexpr std::size_t kStateHead = 136;  // messages.h

std::uint64_t pointer_of(const std::string& state) {
  std::uint64_t sequence;
  std::memcpy(&sequence, state.data() + 8, sizeof sequence);
  return sequence;
}

std::uint64_t tick_of(const std::string& state) {
  std::uint64_t tick;
  std::memcpy(&tick, state.data() + kStateHead, sizeof tick);
  return tick;
}

// Waits until the model has seen something; a server works on another thread.
template <typename Condition>
void wait_until(const Condition& condition) {
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (!condition() && std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  ASSERT_TRUE(condition());
}

TEST(ViewServer, ServesThePageToEverybodyAndTheSceneToTheToken) {
  const ServedModel served;
  const auto get = [&](const std::string& target, const std::string& more = "") {
    return answer_to(served.port, get_request(target, served.host, more));
  };
  EXPECT_NE(get("/").find("\r\n\r\n<!doctype html>the page"), std::string::npos);
  EXPECT_NE(get("/page.js").find("\r\n\r\nthe script"), std::string::npos);
  EXPECT_NE(get("/page.css").find("\r\n\r\nthe style"), std::string::npos);
  EXPECT_NE(get("/icon.svg").find("\r\n\r\nthe icon"), std::string::npos);
  EXPECT_EQ(status_of(get("/felt.glb")), 401);
  const std::string bearer = "Authorization: Bearer " + served.token + "\r\n";
  EXPECT_NE(get("/felt.glb", bearer).find("\r\n\r\nthe scene"), std::string::npos);
  EXPECT_NE(get("/felt.glb?full", bearer).find("\r\n\r\nthe full scene"), std::string::npos);
}

TEST(ViewServer, CompressesThePageForABrowserThatAcceptsIt) {
  const ServedModel served;
  const std::string answer =
      answer_to(served.port, get_request("/page.js", served.host, "Accept-Encoding: br, gzip\r\n"));
  EXPECT_NE(answer.find("Content-Encoding: gzip\r\n"), std::string::npos) << answer;
  const std::size_t body = answer.find("\r\n\r\n") + 4;
  EXPECT_EQ(answer.substr(body, 2), "\x1f\x8b");  // the magic number of RFC 1952
}

TEST(ViewServer, StreamsStatesTicksAndStatusAfterTheToken) {
  const ServedModel served;
  Page page(served);
  EXPECT_TRUE(page.is_in_control());
  const std::string first = page.read_binary(1);
  EXPECT_EQ(first.size(), kStateHead + sizeof(TickRecord));
  EXPECT_GT(tick_of(page.read_binary(1)), tick_of(first));
  EXPECT_GT(page.read_binary(2).size(), 24u);
  EXPECT_NE(page.read_text_with("\"status\"").find("\"clients\":1"), std::string::npos);
}

TEST(ViewServer, AnswersAPointerWithTheStateThatUsedIt) {
  ServedModel served;
  Page page(served);
  for (std::uint64_t sequence = 1; sequence <= 20; ++sequence) {
    page.send_binary(pointer_bytes(sequence, 0.125));
    while (pointer_of(page.read_binary(1)) < sequence) {
    }
  }
  const auto pointers = served.model.pointers();
  ASSERT_EQ(pointers.size(), 20u);
  EXPECT_TRUE(pointers[7].holds);
  EXPECT_EQ(pointers[7].sequence, 8u);
  EXPECT_EQ(pointers[7].target_m, (std::array<double, 3>{0.125, 0.25, -0.5}));
}

TEST(ViewServer, CarriesOutRequestsOfThePageInControl) {
  ServedModel served;
  Page page(served);
  EXPECT_EQ(page.answer(R"({"type":"set","id":1,"name":"a4","value":true})", 1),
            R"({"type":"answer","id":1,"ok":true})");
  EXPECT_EQ(page.answer(R"({"type":"set","id":2,"name":"wrong","value":1.5})", 2),
            R"({"type":"answer","id":2,"ok":false,"problem":"wrong: is wrong"})");
  page.answer(R"({"type":"pause","id":3,"value":true})", 3);
  page.answer(R"({"type":"rearm","id":4})", 4);
  page.answer(R"({"type":"start","id":5})", 5);
  const auto requests = served.model.requests();
  ASSERT_EQ(requests.size(), 4u);
  EXPECT_EQ(requests[0].name, "a4");
  EXPECT_EQ(std::get<bool>(requests[0].value), true);
  EXPECT_EQ(requests[1].kind, PageRequest::Kind::kPause);
  EXPECT_EQ(requests[3].kind, PageRequest::Kind::kStart);
}

TEST(ViewServer, GivesControlToTheFirstPageAndHandsItOver) {
  ServedModel served;
  Page first(served);
  Page second(served);
  EXPECT_TRUE(first.is_in_control());
  EXPECT_FALSE(second.is_in_control());
  first.send_binary(pointer_bytes(1, 0.0));
  wait_until([&] { return served.model.pointers().size() == 1; });
  EXPECT_NE(second.answer(R"({"type":"take_control","id":1})", 1).find("\"ok\":true"),
            std::string::npos);
  first.read_text_with("another page has taken control");
  EXPECT_EQ(served.model.let_goes(), 1);
  EXPECT_NE(second.answer(R"({"type":"rearm","id":2})", 2).find("\"ok\":true"), std::string::npos);
  EXPECT_NE(first.answer(R"({"type":"rearm","id":3})", 3).find("\"ok\":false"), std::string::npos);
}

TEST(ViewServer, LetsGoWhenThePageInControlLeaves) {
  ServedModel served;
  {
    Page page(served);
    page.send_binary(pointer_bytes(1, 0.0));
    wait_until([&] { return served.model.pointers().size() == 1; });
  }
  wait_until([&] { return served.model.let_goes() == 1; });
  Page next(served);
  EXPECT_TRUE(next.is_in_control());
}

TEST(ViewServer, PassesControlToTheLongestWatcherWhenThePageLeaves) {
  ServedModel served;
  auto first = std::make_unique<Page>(served);
  auto second = std::make_unique<Page>(served);
  Page third(served);
  first.reset();
  second->read_text_with("the page in control has left; this page is in control now");
  second->read_text_with("\"control\":true");
  EXPECT_EQ(served.model.let_goes(), 1);
  EXPECT_NE(second->answer(R"({"type":"rearm","id":1})", 1).find("\"ok\":true"), std::string::npos);
  EXPECT_NE(third.answer(R"({"type":"rearm","id":1})", 1).find("\"ok\":false"), std::string::npos);
  second->raw.reset();
  third.read_text_with("this page is in control now");
  EXPECT_NE(third.answer(R"({"type":"rearm","id":2})", 2).find("\"ok\":true"), std::string::npos);
}

// The network of the page is gone: it does not answer pings, and no end of its connection arrives.
TEST(ViewServer, PassesControlWhenThePageAnswersNoPing) {
  ServedModel served;
  Page gone(served);
  Page next(served);
  std::optional<WebSocketMessage> message;
  do {
    message = next.read();
    ASSERT_TRUE(message) << "the page that answers was closed, too";
    if (message->opcode == 9) next.raw.send(WebSocketClient::frame(10, message->bytes));
  } while (message->bytes.find("this page is in control now") == std::string::npos);
  EXPECT_NE(gone.read_to_close(), 1000);
  EXPECT_NE(next.answer(R"({"type":"rearm","id":1})", 1).find("\"ok\":true"), std::string::npos);
}

TEST(ViewServer, AnswersHeadAsGetWithoutABody) {
  ServedModel served;
  const std::string bearer = "Authorization: Bearer " + served.token + "\r\n";
  for (const std::string& more : Texts{"", "Accept-Encoding: gzip\r\n", bearer}) {
    for (const char* target : {"/", "/page.js", "/page.css", "/icon.svg", "/felt.glb",
                               "/felt.glb?full", "/live", "/nothing"}) {
      const std::string get = get_request(target, served.host, more);
      const std::string whole = answer_to(served.port, get);
      const std::string head = answer_to(served.port, "HEAD" + get.substr(3));
      EXPECT_EQ(head, whole.substr(0, whole.find("\r\n\r\n") + 4)) << target << more;
      EXPECT_GT(whole.size(), head.size());
    }
  }
}

TEST(ViewServer, AnswersAnOldVersionOfHttpAndEndsEachConnection) {
  ServedModel served;
  for (const std::string& text : Texts{"GET / HTTP/1.0\r\nHost: " + served.host + "\r\n\r\n",
                                       get_request("/", served.host, "Connection: keep-alive\r\n"),
                                       get_request("/", served.host, "Connection: close\r\n")}) {
    const std::string answer = answer_to(served.port, text);
    EXPECT_NE(answer.find("\r\nConnection: close\r\n"), std::string::npos) << answer;
    EXPECT_NE(answer.find("the page"), std::string::npos) << answer;
  }
}

TEST(ViewServer, TellsItsClientsThatItEnds) {
  ServedModel served;
  Page page(served);
  std::thread stopping([&] { served.server->stop(); });
  page.read_text_with("\"kind\":\"end\"");
  EXPECT_EQ(page.read_to_close(), 1001);
  stopping.join();
}

TEST(ViewServer, RefusesATakenPortAndAForeignAddressInOneLine) {
  const ServedModel served;
  RememberingModel model;
  const PageFiles page{"a", "b", "c", "d"};
  const auto taken = ViewServer::listen({.port = served.port}, page, model);
  ASSERT_FALSE(taken.ok());
  EXPECT_EQ(taken.error().to_string(),
            "port: is " + std::to_string(served.port) +
                ", which is taken; expected a free port (choose another one, or 0 for any)");
  const auto foreign = ViewServer::listen({.address = "192.0.2.1"}, page, model);
  ASSERT_FALSE(foreign.ok());
  EXPECT_EQ(foreign.error().element, "listen");
  EXPECT_FALSE(ViewServer::listen({.address = "localhost.example"}, page, model).ok());
}

// Attacks. Each is refused by name or closed, and the server serves the next page.

// A page that the server still serves.
void expect_served(ServedModel& served) {
  Page page(served);
  EXPECT_EQ(page.read_binary(1).size(), kStateHead + sizeof(TickRecord));
}

TEST(ViewAttack, ForeignOriginIsRefused) {
  ServedModel served;
  for (const std::string& origin :
       Texts{"http://evil.example", "https://" + served.host, "null", "http://127.0.0.1:1",
             "http://127.0.0.1", "http://" + served.host + ".evil.example", "file://"}) {
    EXPECT_EQ(status_of(answer_to(served.port,
                                  get_request("/", served.host, "Origin: " + origin + "\r\n"))),
              403)
        << origin;
    EXPECT_EQ(status_of(answer_to(served.port, WebSocketClient::handshake(served.host, origin))),
              403)
        << origin;
  }
  EXPECT_EQ(status_of(answer_to(served.port, WebSocketClient::handshake(served.host, ""))), 403);
  expect_served(served);
}

TEST(ViewAttack, ForeignHostIsRefused) {
  ServedModel served;
  const std::string port = ":" + std::to_string(served.port);
  for (const std::string& host :
       Texts{"evil.example" + port, "127.0.0.1.evil.example", "localhost.evil.example" + port,
             "evil@127.0.0.1", "0.0.0.0", "2130706433", "127.0.0.1:", "127.0.0.1:80:80",
             "127.0.0.1, a", "[::1", ""}) {
    EXPECT_EQ(status_of(answer_to(served.port, get_request("/", host))), 403) << host;
  }
  EXPECT_EQ(status_of(answer_to(served.port, "GET / HTTP/1.1\r\n\r\n")), 403);
  EXPECT_EQ(status_of(answer_to(served.port,
                                get_request("/", served.host, "Host: " + served.host + "\r\n"))),
            403);
  expect_served(served);
}

TEST(ViewServer, AcceptsAForwardedPortAndAllowedHosts) {
  const ServedModel served({.allowed = {.hosts = {"Desk.example"}}});
  for (const std::string& host : Texts{"localhost:4000", "127.0.0.1:9", "[::1]:8080", "LOCALHOST",
                                       "desk.example", "DESK.example:443"}) {
    EXPECT_EQ(status_of(answer_to(served.port, get_request("/", host))), 200) << host;
    const std::string answer =
        answer_to(served.port, get_request("/", host, "Origin: http://" + host + "\r\n"));
    EXPECT_EQ(status_of(answer), 200) << host;
    EXPECT_NE(answer.find("connect-src 'self' ws://" + host + ";"), std::string::npos) << answer;
  }
}

// A reverse proxy passes the browser's Host, or puts its own.
TEST(ViewServer, AcceptsTheOriginOfAProxyThatIsNamed) {
  ServedModel served({.allowed = {.origins = {*parse_origin("https://Lab.example")}}});
  for (const std::string& host : Texts{"lab.example", "lab.example:443", served.host}) {
    RawClient client(served.port);
    client.send(WebSocketClient::handshake(host, "https://lab.example"));
    EXPECT_EQ(status_of(client.read_until("\r\n\r\n").value_or("")), 101) << host;
    for (const char* foreign :
         {"http://lab.example", "https://lab.example:8443", "https://evil.example", "null",
          "https://lab.example.evil.example", "https://lab.example, https://lab.example", ""}) {
      EXPECT_EQ(status_of(answer_to(served.port, WebSocketClient::handshake(host, foreign))), 403)
          << host << " " << foreign;
    }
    const std::string answer = answer_to(served.port, get_request("/", host));
    EXPECT_NE(answer.find(" wss://lab.example;"), std::string::npos) << answer;
  }
  EXPECT_EQ(status_of(answer_to(served.port, get_request("/", "evil.example",
                                                         "X-Forwarded-Host: lab.example\r\n"))),
            403);
  EXPECT_EQ(status_of(answer_to(served.port,
                                WebSocketClient::handshake("evil.example", "https://lab.example"))),
            403);
  expect_served(served);
}

// Behind a proxy that nobody has named, the page comes as far as to say so, and no further.
TEST(ViewServer, GivesOnlyItsFilesToAPageOfAnUnnamedProxy) {
  const ServedModel served;
  const std::string origin = "Origin: https://lab.example\r\n";
  const std::string same = origin + "Sec-Fetch-Site: same-origin\r\n";
  const auto status = [&](const std::string& target, const std::string& more) {
    return status_of(answer_to(served.port, get_request(target, served.host, more)));
  };
  EXPECT_EQ(status("/page.js", same), 200);
  EXPECT_EQ(status("/page.js", origin), 403);
  EXPECT_EQ(status("/page.js", origin + "Sec-Fetch-Site: same-site\r\n"), 403);
  EXPECT_EQ(status("/page.js", same + "Sec-Fetch-Site: same-origin\r\n"), 403);
  EXPECT_EQ(status("/felt.glb", same + "Palpate-Token: " + served.token + "\r\n"), 403);
  EXPECT_EQ(status("/live", same), 403);
  EXPECT_EQ(status_of(answer_to(served.port, "POST /page.js HTTP/1.1\r\nHost: " + served.host +
                                                 "\r\n" + same + "\r\n")),
            403);
  std::string handshake = WebSocketClient::handshake(served.host, "https://lab.example");
  handshake.insert(handshake.size() - 2, "Sec-Fetch-Site: same-origin\r\n");
  EXPECT_EQ(status_of(answer_to(served.port, handshake)), 403);
  EXPECT_EQ(status_of(answer_to(served.port, get_request("/page.js", "evil.example", same))), 403);
}

// A proxy that asks for a password uses Authorization for it.
TEST(ViewServer, TakesTheTokenBesideAPassword) {
  const ServedModel served;
  const auto status = [&](const std::string& more) {
    return status_of(answer_to(served.port, get_request("/felt.glb", served.host, more)));
  };
  const std::string password = "Authorization: Basic cGVyc29uOnBhc3N3b3Jk\r\n";
  const std::string wrong(32, '0');
  EXPECT_EQ(status(password + "Palpate-Token: " + served.token + "\r\n"), 200);
  EXPECT_EQ(status("palpate-token: " + served.token + "\r\n"), 200);
  EXPECT_EQ(status(password), 401);
  EXPECT_EQ(status("Palpate-Token: " + wrong + "\r\n"), 401);
  EXPECT_EQ(
      status("Palpate-Token: " + wrong + "\r\nAuthorization: Bearer " + served.token + "\r\n"),
      401);
  EXPECT_EQ(status("Palpate-Token: " + wrong + "\r\nPalpate-Token: " + served.token + "\r\n"), 401);
}

TEST(ViewAttack, WithoutTokenNothingIsTold) {
  ServedModel served;
  WebSocketClient silent(served.port);
  EXPECT_EQ(silent.read_to_close(), 4408);  // after two seconds; it may try again
  WebSocketClient binary(served.port);
  binary.send_binary(pointer_bytes(1, 0.0));
  EXPECT_EQ(binary.read_to_close(), 4401);
  WebSocketClient setting(served.port);
  setting.send_text(R"({"type":"set","id":1,"name":"a4","value":true})");
  EXPECT_EQ(setting.read_to_close(), 4401);
  EXPECT_TRUE(served.model.requests().empty());
  EXPECT_TRUE(served.model.pointers().empty());
  expect_served(served);
}

TEST(ViewAttack, WrongTokenIsRefused) {
  ServedModel served;
  std::string wrong = served.token;
  wrong.back() = wrong.back() == '0' ? '1' : '0';
  for (const std::string& token :
       Texts{wrong, served.token.substr(1), served.token + "0", std::string()}) {
    WebSocketClient client(served.port);
    client.send_text(R"({"type":"token","token":")" + token + "\"}");
    EXPECT_EQ(client.read_to_close(), 4401) << token;
    const std::string bearer = "Authorization: Bearer " + token + "\r\n";
    EXPECT_EQ(status_of(answer_to(served.port, get_request("/felt.glb", served.host, bearer))),
              401);
  }
  const std::string twice =
      "Authorization: Bearer " + wrong + "\r\nAuthorization: Bearer " + served.token + "\r\n";
  EXPECT_EQ(status_of(answer_to(served.port, get_request("/felt.glb", served.host, twice))), 401);
  WebSocketClient longer(served.port);
  longer.send_text(served.token_message() + std::string(1100, ' '));
  EXPECT_NE(longer.read_to_close(), 1000);
  expect_served(served);
}

TEST(ViewAttack, TokenInAnAddressIsOfNoUse) {
  ServedModel served;
  for (const std::string& target :
       Texts{"/felt.glb?token=" + served.token, "/felt.glb?" + served.token, "/" + served.token,
             "/felt.glb?full&" + served.token, "/live?token=" + served.token}) {
    EXPECT_EQ(status_of(answer_to(served.port, get_request(target, served.host))), 404) << target;
    EXPECT_EQ(status_of(answer_to(served.port, WebSocketClient::handshake(
                                                   served.host, "http://" + served.host, target))),
              404)
        << target;
  }
  expect_served(served);
}

TEST(ViewServer, SaysThatAProcessMayOpenTooFewFiles) {
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  for (const rlim_t files : {100, 143, 144}) {
    rlimit few = before;
    few.rlim_cur = files;
    ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &few), 0);
    const auto problem = ViewServer::files_problem();
    ::setrlimit(RLIMIT_NOFILE, &before);
    EXPECT_EQ(problem.has_value(), files < 144) << files;
    if (problem) {
      EXPECT_NE(problem->find("may open " + std::to_string(files) + " files"), std::string::npos);
    }
  }
}

TEST(ViewServer, IgnoresAQueryOfThePage) {
  ServedModel served;
  for (const std::string& target : Texts{"/?x=1", "/?", "/?" + served.token, "/?/../x?y"}) {
    EXPECT_NE(answer_to(served.port, get_request(target, served.host)).find("the page"),
              std::string::npos)
        << target;
  }
}

// The client ends its half only: the next page need not wait until the connection ends.
TEST(ViewServer, PassesControlWhenThePageInControlBeginsToClose) {
  ServedModel served;
  Page leaving(served);
  Page next(served);
  leaving.send_close();
  next.read_text_with("the page in control has left; this page is in control now");
  // The first status after it still counts both: the connection has not ended.
  EXPECT_NE(next.read_text_with("\"status\"").find("\"clients\":2"), std::string::npos);
}

TEST(ViewAttack, WatcherChangesNothing) {
  ServedModel served;
  Page owner(served);
  Page watcher(served);
  const std::string refusal =
      watcher.answer(R"({"type":"set","id":9,"name":"a4","value":true})", 9);
  EXPECT_NE(refusal.find("another page is in control"), std::string::npos) << refusal;
  for (const char* request : {R"({"type":"pause","id":9,"value":true})",
                              R"({"type":"rearm","id":9})", R"({"type":"start","id":9})"}) {
    EXPECT_NE(watcher.answer(request, 9).find("\"ok\":false"), std::string::npos);
  }
  watcher.send_binary(pointer_bytes(1, 0.0));
  owner.answer(R"({"type":"rearm","id":1})", 1);
  watcher.answer(R"({"type":"rearm","id":10})", 10);  // after the pointer
  EXPECT_TRUE(served.model.pointers().empty());
  EXPECT_EQ(served.model.requests().size(), 1u);
}

TEST(ViewAttack, TraversalFindsNothing) {
  ServedModel served;
  for (const std::string& target :
       Texts{"/../etc/passwd", "/..%2fetc%2fpasswd", "/%2e%2e/%2e%2e/etc/passwd", "//etc/passwd",
             "/./page.js", "/page.js/", "/page.js%00", "/page.js?", "/PAGE.JS", "/page.js#x",
             "/..\\..\\etc\\passwd", "/page.js/../felt.glb", "http://127.0.0.1/page.js", "*",
             "/index.html", "/felt.glb?full=1", "/favicon.ico", "/live/", "/.git/config"}) {
    const int status = status_of(answer_to(served.port, get_request(target, served.host)));
    EXPECT_TRUE(status == 404 || status == 400) << target << " " << status;
  }
  expect_served(served);
}

TEST(ViewAttack, OtherMethodsAreRefused) {
  ServedModel served;
  for (const std::string& method :
       Texts{"POST", "PUT", "DELETE", "OPTIONS", "TRACE", "BREW", "head"}) {
    const std::string answer =
        answer_to(served.port, method + " / HTTP/1.1\r\nHost: " + served.host + "\r\n\r\n");
    EXPECT_EQ(status_of(answer), 405) << method << answer;
    EXPECT_NE(answer.find("\r\nAllow: GET, HEAD\r\n"), std::string::npos) << answer;
    EXPECT_EQ(answer.find("Access-Control"), std::string::npos);
  }
  const std::string body = answer_to(
      served.port, "POST / HTTP/1.1\r\nHost: " + served.host + "\r\nContent-Length: 9\r\n\r\n");
  EXPECT_EQ(status_of(body), 405) << body;
  EXPECT_NE(body.find("\r\nAllow: GET, HEAD\r\n"), std::string::npos) << body;
  expect_served(served);
}

TEST(ViewAttack, LongHeaderIsRefused) {
  ServedModel served;
  const std::string answer = answer_to(
      served.port, get_request("/", served.host, "X: " + std::string(9000, 'x') + "\r\n"));
  EXPECT_TRUE(answer.empty() || status_of(answer) == 431) << answer;
  expect_served(served);
}

TEST(ViewAttack, HugeFrameIsClosed) {
  ServedModel served;
  Page page(served);
  page.send_text(std::string(1 << 20, 'x'));
  const auto code = page.read_to_close();
  EXPECT_TRUE(code == 1009 || code == 0) << code;
  WebSocketClient before_token(served.port);
  before_token.send_text(std::string(1 << 20, 'x'));
  EXPECT_NE(before_token.read_to_close(), 1000);
  // A header that announces 2^63 bytes, without them.
  Page liar(served);
  std::string header = "\x82\xff";
  header += std::string("\x7f") + std::string(7, '\xff') + std::string(4, '\0');
  liar.raw.send(header);
  EXPECT_NE(liar.read_to_close(), 1000);
  expect_served(served);
}

TEST(ViewAttack, EndlessFragmentsAreClosed) {
  for (const std::size_t size : {std::size_t{1000}, std::size_t{1}, std::size_t{0}}) {
    ServedModel served;
    Page page(served);
    const std::string part(size, ' ');
    page.raw.send(WebSocketClient::frame(1, part, false));
    std::string many;
    for (int i = 0; i < 1000; ++i) many += WebSocketClient::frame(0, part, false);
    std::thread reading([&] { EXPECT_NE(page.read_to_close(), 1000); });
    while (page.raw.send(many)) {
    }
    reading.join();
    expect_served(served);
  }
}

TEST(ViewAttack, EndlessPingsAreClosed) {
  ServedModel served;
  Page page(served);
  std::string many;
  for (int i = 0; i < 1000; ++i) many += WebSocketClient::frame(9, "ping");
  std::thread reading([&] { EXPECT_NE(page.read_to_close(), 1000); });
  while (page.raw.send(many)) {
  }
  reading.join();
  expect_served(served);
}

TEST(ViewAttack, BrokenFramesAreClosed) {
  ServedModel served;
  for (const std::string& frame :
       Texts{std::string("\x81\x02hi", 4),  // without a mask
             WebSocketClient::frame(3, "reserved"), WebSocketClient::frame(0, "no beginning"),
             WebSocketClient::frame(1, "\xff\xfe"),  // not UTF-8
             std::string("\xf1\x80\0\0\0\0", 6)}) {  // reserved bits
    Page page(served);
    page.raw.send(frame);
    EXPECT_NE(page.read_to_close(), 1000);
  }
  expect_served(served);
}

TEST(ViewAttack, HalfAHandshakeIsClosedAndBlocksNobody) {
  ServedModel served;
  RawClient half(served.port);
  half.send("GET /live HTTP/1.1\r\nHost: 127.0.0.1\r\nUpg");
  RawClient silent(served.port);
  expect_served(served);
  EXPECT_EQ(half.read_to_end(), "");  // after five seconds
  EXPECT_EQ(silent.read_to_end(), "");
}

// The first bytes of a handshake of TLS.
TEST(ViewAttack, TlsIsAnsweredAtOnce) {
  ServedModel served;
  RawClient client(served.port);
  client.send(std::string("\x16\x03\x01\x02\x00\x01", 6));
  const std::string answer = client.read_to_end();
  EXPECT_EQ(status_of(answer), 400) << answer;
  EXPECT_NE(answer.find("does not speak TLS"), std::string::npos) << answer;
  expect_served(served);
}

// What a client has sent behind its request does not cost it the answer.
TEST(ViewServer, AnswersARequestWithABodyAndOneBehindAnother) {
  ServedModel served;
  for (int i = 0; i < 20; ++i) {
    RawClient client(served.port);
    client.send("POST /live HTTP/1.1\r\nHost: " + served.host + "\r\n\r\n" +
                std::string(20000, 'x'));
    EXPECT_EQ(status_of(client.read_to_end()), 405);
    EXPECT_FALSE(client.was_reset());
    RawClient two(served.port);
    two.send(get_request("/", served.host) + get_request("/page.js", served.host));
    EXPECT_NE(two.read_to_end().find("the page"), std::string::npos);
    EXPECT_FALSE(two.was_reset());
  }
}

// Half-open connections: they send nothing, a part of a header, or no token.
class Crowd {
 public:
  Crowd(const ServedModel& served, std::size_t count) : served_(served), clients_(count) { fill(); }
  // Opens those again that the server has closed. Returns their number.
  std::size_t fill() {
    std::size_t opened = 0;
    for (std::size_t i = 0; i < clients_.size(); ++i) {
      if (clients_[i] != nullptr && !clients_[i]->is_closed_now()) continue;
      clients_[i] = std::make_unique<RawClient>(served_.port);
      clients_[i]->send(beginning(i % 3));
      ++opened;
    }
    return opened;
  }

 private:
  std::string beginning(std::size_t kind) const {
    const std::string whole = WebSocketClient::handshake(served_.host, "http://" + served_.host);
    return kind == 0 ? "" : kind == 1 ? whole.substr(0, whole.size() - 2) : whole;
  }

  const ServedModel& served_;
  std::vector<std::unique_ptr<RawClient>> clients_;
};

// A server that has places for 16 strangers of each kind, as in a process that may open few files.
ServedModel& with_few_places(std::optional<ServedModel>& served) {
  rlimit before{};
  ::getrlimit(RLIMIT_NOFILE, &before);
  rlimit few = before;
  few.rlim_cur = 160;
  ::setrlimit(RLIMIT_NOFILE, &few);
  served.emplace();
  ::setrlimit(RLIMIT_NOFILE, &before);
  return *served;
}

TEST(ViewAttack, HalfOpenConnectionsGiveWayToAPage) {
  std::optional<ServedModel> few, many;
  many.emplace();
  for (ServedModel* const served : {&with_few_places(few), &*many}) {
    Page first(*served);
    Crowd crowd(*served, 200);
    const std::string bearer = "Authorization: Bearer " + served->token + "\r\n";
    std::size_t opened = 0;
    for (int round = 0; round < 20; ++round) {
      opened += crowd.fill();
      EXPECT_NE(answer_to(served->port, get_request("/page.js", served->host)).find("the script"),
                std::string::npos);
      EXPECT_NE(
          answer_to(served->port, get_request("/felt.glb", served->host, bearer)).find("the scene"),
          std::string::npos);
      expect_served(*served);
    }
    if (served == &*few) {
      EXPECT_GT(opened, 200u) << "no stranger was dropped";
    }
    EXPECT_TRUE(first.is_in_control());
    EXPECT_GT(tick_of(first.read_binary(1)), 0u);
    EXPECT_NE(first.answer(R"({"type":"rearm","id":1})", 1).find("\"ok\":true"), std::string::npos);
  }
}

TEST(ViewAttack, WrongTokensDropNoPage) {
  std::optional<ServedModel> few;
  ServedModel& served = with_few_places(few);
  std::vector<std::unique_ptr<Page>> pages;
  for (std::size_t i = 0; i < ServerLimits::kClients; ++i) {
    pages.push_back(std::make_unique<Page>(served));
  }
  for (int i = 0; i < 40; ++i) {
    WebSocketClient client(served.port);
    client.send_text(R"({"type":"token","token":"0123456789abcdef0123456789abcdef"})");
    EXPECT_EQ(client.read_to_close(), 4401);
  }
  for (const auto& page : pages) EXPECT_GT(tick_of(page->read_binary(1)), 0u);
}

// Connections that are reset at once, as a scanner makes them.
TEST(ViewAttack, ResetsAreSurvived) {
  ServedModel served;
  for (int i = 0; i < 500; ++i) {
    RawClient client(served.port);
    if (i % 2 == 0) client.send(get_request("/page.js", served.host));
    client.reset();
  }
  expect_served(served);
}

// A client that sends no more, and does not read, keeps no place.
TEST(ViewAttack, HalfClosedClientIsForgotten) {
  ServedModel served;
  Page gone(served);
  gone.raw.end_sending();
  EXPECT_EQ(gone.read_to_close(), 0);
  Page next(served);
  EXPECT_TRUE(next.is_in_control());
  RawClient asking(served.port);
  asking.send(get_request("/", served.host));
  asking.end_sending();
  EXPECT_NE(asking.read_to_end().find("the page"), std::string::npos);
}

TEST(ViewAttack, NinthPageIsToldWhy) {
  ServedModel served;
  std::vector<std::unique_ptr<Page>> pages;
  for (std::size_t i = 0; i < ServerLimits::kClients; ++i) {
    pages.push_back(std::make_unique<Page>(served));
  }
  WebSocketClient ninth(served.port);
  ninth.send_text(served.token_message());
  EXPECT_EQ(ninth.read_to_close(), 1013);
}

std::size_t resident_bytes() {
  std::ifstream file("/proc/self/statm");
  std::size_t total = 0, resident = 0;
  file >> total >> resident;
  return resident * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

// The newest state follows the bytes that a slow client has not read; none is queued.
TEST(ViewAttack, SlowReaderDelaysNobodyAndQueuesNothing) {
  ServedModel served;
  served.model.set_bodies(1000);  // 64 kB a state: 600 of them are 38 MB
  Page slow(served);
  Page fast(served);
  const auto read_states = [&](int count) {
    for (int i = 0; i < count; ++i) fast.read_binary(1);
  };
  read_states(60);
  const std::size_t before = resident_bytes();
  std::uint64_t last = 0;
  for (int i = 0; i < 600; ++i) last = tick_of(fast.read_binary(1));
  constexpr std::size_t kAllowed = 16u << 20;  // the buffers of this test and of the allocator
  EXPECT_GT(before, 0u);
  // A sanitizer keeps memory that was freed.
  if (!test::kHasSanitizer) EXPECT_LT(resident_bytes(), before + kAllowed);
  // What the slow client finds is old at first and then jumps to the newest.
  std::uint64_t seen = 0;
  int states = 0;
  for (; seen < last; ++states) seen = tick_of(slow.read_binary(1));
  EXPECT_LT(states, 300) << "as many as the buffers of the two sockets hold";
}

TEST(ViewAttack, UnreadAnswersCloseTheClient) {
  ServedModel served;
  Page page(served);
  // Never reads the answers.
  const std::string request = WebSocketClient::frame(1, R"({"type":"rearm","id":1})");
  std::string many;
  for (int i = 0; i < 500; ++i) many += request;
  while (page.raw.send(many)) {
  }
  expect_served(served);
}

// A client that was closed keeps no place and no control, although it goes on sending.
TEST(ViewAttack, ClosedClientThatDoesNotReadIsDropped) {
  ServedModel served;
  Page bad(served);
  EXPECT_TRUE(bad.is_in_control());
  Page next(served);
  bad.send_binary("no message");
  const std::string ping = WebSocketClient::frame(1, R"({"type":"rearm","id":1})");
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (bad.raw.send(ping) && std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_LT(std::chrono::steady_clock::now(), end);
  EXPECT_NE(next.read_text_with("\"clients\":1").find("\"status\""), std::string::npos);
  EXPECT_TRUE(served.model.requests().empty());
}

TEST(ViewAttack, DeepJsonIsRefused) {
  ServedModel served;
  for (const std::size_t depth : {std::size_t{9}, std::size_t{30000}}) {
    Page page(served);
    page.send_text(std::string(depth, '['));
    EXPECT_EQ(page.read_to_close(), 1008);
    Page closed(served);
    closed.send_text("{\"type\":\"set\",\"id\":1,\"name\":\"axes\",\"value\":" +
                     std::string(depth, '[') + std::string(depth, ']') + "}");
    EXPECT_EQ(closed.read_to_close(), 1008);
  }
  EXPECT_TRUE(served.model.requests().empty());
  expect_served(served);
}

TEST(ViewAttack, NumbersThatAreNoneAreRefused) {
  ServedModel served;
  for (const double wrong : {std::nan(""), std::numeric_limits<double>::infinity(),
                             -std::numeric_limits<double>::infinity()}) {
    Page page(served);
    page.send_binary(pointer_bytes(1, wrong));
    EXPECT_EQ(page.read_to_close(), 1008);
  }
  for (const char* number : {"NaN", "Infinity", "-Infinity", "1e999", "-1e999", "0x10", "+1"}) {
    Page page(served);
    page.send_text(std::string(R"({"type":"set","id":1,"name":"stiffness","value":)") + number +
                   "}");
    EXPECT_EQ(page.read_to_close(), 1008) << number;
  }
  EXPECT_TRUE(served.model.requests().empty());
  EXPECT_TRUE(served.model.pointers().empty());
  expect_served(served);
}

TEST(ViewAttack, BrokenPointersAreRefused) {
  ServedModel served;
  const std::string good = pointer_bytes(1, 0.0);
  std::string other_kind = good;
  other_kind[0] = 17;
  std::string other_version = good;
  other_version[2] = 1;
  for (const std::string& bytes : Texts{good.substr(1), good + "x", std::string(), other_kind,
                                        other_version, pointer_bytes(0, 0.0)}) {
    Page page(served);
    page.send_binary(bytes);
    EXPECT_EQ(page.read_to_close(), 1008);
  }
  EXPECT_TRUE(served.model.pointers().empty());
  expect_served(served);
}

TEST(ViewAttack, UnknownNamesAreRefused) {
  ServedModel served;
  Page page(served);
  for (const char* request :
       {R"({"type":"format","id":7})", R"({"type":"rearm","id":7,"force":1})",
        R"({"type":"set","id":7,"name":"a4"})", R"({"type":"set","id":7,"value":true})",
        R"({"type":"set","id":7,"name":7,"value":true})",
        R"({"type":"set","id":7,"name":"a4","value":null})",
        R"({"type":"set","id":7,"name":"a4","value":{}})",
        R"({"type":"set","id":7,"name":"axes","value":[[1,0,0],[0,1,0],[0,0,1],[1,1,1]]})",
        R"({"type":"set","id":7,"name":"axes","value":[[1,0]]})",
        R"({"type":"pause","id":7,"value":1})"}) {
    EXPECT_NE(page.answer(request, 7).find("\"ok\":false"), std::string::npos) << request;
  }
  for (const char* text :
       {"", "{}", "null", "[]", "7", "\"token\"", R"({"type":7})", R"({"type":"rearm","id":-1})",
        R"({"type":"rearm","id":1.5})", "{\"type\""}) {
    Page other(served);
    other.send_text(text);
    EXPECT_EQ(other.read_to_close(), 1008) << text;
  }
  EXPECT_TRUE(served.model.requests().empty());
  expect_served(served);
}

// No answer lets another page frame, read or embed this one, and none holds a secret.
TEST(ViewAttack, EveryAnswerKeepsOtherPagesOut) {
  ServedModel served;
  const std::string policy =
      "Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; img-src "
      "'self'; connect-src 'self' ws://" +
      served.host + "; base-uri 'none'; form-action 'none'; frame-ancestors 'none'\r\n";
  const std::string bearer = "Authorization: Bearer " + served.token + "\r\n";
  std::vector<std::string> answers;
  for (const char* target : {"/", "/page.js", "/page.css", "/felt.glb", "/nothing", "/live"}) {
    answers.push_back(answer_to(served.port, get_request(target, served.host)));
  }
  answers.push_back(answer_to(served.port, get_request("/felt.glb", served.host, bearer)));
  answers.push_back(WebSocketClient(served.port).head);
  for (const std::string& answer : answers) {
    EXPECT_NE(answer.find(policy), std::string::npos) << answer;
  }
  answers.push_back(answer_to(served.port, get_request("/", "evil.example")));
  for (const std::string& answer : answers) {
    for (const char* header :
         {"frame-ancestors 'none'", "X-Content-Type-Options: nosniff\r\n",
          "Referrer-Policy: no-referrer\r\n", "Cross-Origin-Resource-Policy: same-origin\r\n",
          "Cross-Origin-Opener-Policy: same-origin\r\n", "Cache-Control: no-store\r\n"}) {
      EXPECT_NE(answer.find(header), std::string::npos) << header << answer;
    }
    for (const char* never : {"Set-Cookie", "Access-Control", "evil.example"}) {
      EXPECT_EQ(answer.find(never), std::string::npos) << never << answer;
    }
    EXPECT_EQ(answer.find(served.token), std::string::npos) << answer;
  }
}

TEST(ViewAttack, TokensDiffer) {
  const ServedModel one, other;
  EXPECT_NE(one.token, other.token);
}

}  // namespace
}  // namespace palpate::test
