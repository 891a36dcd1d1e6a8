#pragma once

// One HTTP connection: one request, one answer, or the way to a WebSocket.

#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/serializer.hpp>
#include <boost/beast/http/span_body.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <string>

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

// What the server does for its connections. All on the network thread.
class HttpHost {
 public:
  virtual ~HttpHost() = default;
  virtual HttpVerdict judge(const HttpHead& head) = 0;
  // Calls answer(content) now or later, on the network thread.
  virtual void find(Resource resource, bool accepts_gzip,
                    std::function<void(HttpContent)> answer) = 0;
  virtual LiveHost& live_host() = 0;
};

// The client has kHandshake_s for its whole request. All functions run on the network thread; the
// object lives as long as an operation runs.
class HttpConnection : public std::enable_shared_from_this<HttpConnection> {
 public:
  // connection: counts as a connection while it exists.
  HttpConnection(Stream stream, HttpHost& host, std::shared_ptr<void> connection);

  void read();

 private:
  void on_read(beast::error_code error);
  void answer();
  void refuse(int status, std::string_view reason);
  void send(int status, HttpContent content);

  Stream stream_;
  HttpHost& host_;
  std::shared_ptr<void> connection_;
  beast::flat_buffer buffer_;
  beast::http::request_parser<beast::http::empty_body> parser_;
  std::string host_header_;  // once judge() has accepted it
  HttpContent content_;
  using Body = beast::http::span_body<const char>;
  beast::http::response<Body> response_;
  std::optional<beast::http::response_serializer<Body>> serializer_;
};

}  // namespace palpate
