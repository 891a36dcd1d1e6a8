#pragma once

// One HTTP connection: one request, one answer, or the way to a WebSocket.

#include <array>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/serializer.hpp>
#include <boost/beast/http/span_body.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "engine/viewer/connection_places.h"
#include "engine/viewer/http_rules.h"
#include "engine/viewer/live_client.h"
#include "engine/viewer/view_stream.h"

namespace palpate {

// The body of an answer, and what owns its bytes.
struct HttpContent {
  std::string_view bytes;
  std::string type;
  bool is_gzip = false;
  std::shared_ptr<const void> owner = nullptr;
};

// What a connection has shown of itself.
enum class ConnectionKind : std::uint8_t {
  kSilent,   // no whole request yet
  kAsking,   // a request that anybody may make, a handshake before its token among them
  kTrusted,  // a request with the token
};

// What the server does for its connections. All on the network thread.
class HttpHost {
 public:
  virtual ~HttpHost() = default;
  virtual HttpVerdict judge(const HttpHead& head) = 0;
  virtual const std::vector<WebOrigin>& origins() const = 0;
  // See ConnectionPlaces::take().
  virtual ConnectionPlaces::Place take_place(ConnectionKind kind, std::function<void()> drop) = 0;
  // Calls answer(content) now or later, on the network thread.
  virtual void find(Resource resource, bool accepts_gzip,
                    std::function<void(HttpContent)> answer) = 0;
  virtual LiveHost& live_host() = 0;
};

// The client has kHandshake_s for its whole request. All functions run on the network thread; the
// object lives as long as an operation runs.
class HttpConnection : public std::enable_shared_from_this<HttpConnection> {
 public:
  HttpConnection(Stream stream, HttpHost& host);

  void read();

 private:
  void read_header();
  void on_read(beast::error_code error);
  void answer();
  void upgrade();
  void refuse(int status, std::string_view reason);
  void send(int status, HttpContent content);
  void write_answer();
  void linger();
  void take_place(ConnectionKind kind);

  Stream stream_;
  HttpHost& host_;
  ConnectionPlaces::Place place_;
  beast::flat_buffer buffer_;
  beast::http::request_parser<beast::http::empty_body> parser_;
  std::string host_header_;  // once judge() has accepted it
  HttpContent content_;
  using Body = beast::http::span_body<const char>;
  beast::http::response<Body> response_;
  std::optional<beast::http::response_serializer<Body>> serializer_;
  std::size_t ignored_bytes_ = 0;  // that came behind the request
};

}  // namespace palpate
