#include "engine/viewer/http_connection.h"

#include <boost/beast/http/read.hpp>
#include <boost/beast/http/write.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <utility>

#include "engine/viewer/view_server.h"

namespace palpate {
namespace {

namespace http = beast::http;

// Room for a usual request. A longer one takes more, up to ServerLimits::kHeaderBytes.
constexpr std::size_t kFirstBytes = 1024;
constexpr int kSendBufferBytes = 64 * 1024;

std::string_view view_of(beast::string_view text) {
  return {text.data(), text.size()};
}

using Values = std::vector<std::string_view>;

// field: a number or a name of a header.
template <typename Name>
Values all_of(const http::request<http::empty_body>& request, Name field) {
  Values values;
  const auto [begin, end] = request.equal_range(field);
  for (auto at = begin; at != end; ++at) values.push_back(view_of(at->value()));
  return values;
}

HttpHead head_of(const http::request<http::empty_body>& request) {
  HttpHead head;
  head.method = view_of(request.method_string());
  head.target = view_of(request.target());
  head.hosts = all_of(request, http::field::host);
  head.origins = all_of(request, http::field::origin);
  head.authorizations = all_of(request, http::field::authorization);
  head.tokens = all_of(request, beast::string_view(kTokenHeader.data(), kTokenHeader.size()));
  head.is_same_origin = all_of(request, "Sec-Fetch-Site") == Values{"same-origin"};
  head.upgrades = request.find(http::field::upgrade) != request.end();
  return head;
}

}  // namespace

HttpConnection::HttpConnection(Stream stream, HttpHost& host)
    : stream_(std::move(stream)), host_(host), buffer_(2 * ServerLimits::kHeaderBytes) {
  parser_.header_limit(ServerLimits::kHeaderBytes);
  parser_.body_limit(0);
}

void HttpConnection::take_place(ConnectionKind kind) {
  place_ = host_.take_place(kind, [this] {
    beast::error_code ignored;
    stream_.socket().close(ignored);  // the operation that runs ends with an error
  });
}

// The first bytes tell whether this is HTTP at all: a client that speaks TLS waits for an answer
// instead of sending the end of a header.
void HttpConnection::read() {
  take_place(ConnectionKind::kSilent);
  stream_.expires_after(std::chrono::seconds(ServerLimits::kHandshake_s));
  stream_.async_read_some(
      buffer_.prepare(kFirstBytes),
      [self = shared_from_this()](beast::error_code error, std::size_t count) {
        if (error) return;
        self->buffer_.commit(count);
        if (may_begin_request(*static_cast<const char*>(self->buffer_.data().data()))) {
          return self->read_header();
        }
        self->refuse(400, "this is not HTTP; the server does not speak TLS (https)");
      });
}

void HttpConnection::read_header() {
  http::async_read_header(
      stream_, buffer_, parser_,
      [self = shared_from_this()](beast::error_code error, std::size_t) { self->on_read(error); });
}

void HttpConnection::on_read(beast::error_code error) {
  if (error == http::error::header_limit || error == http::error::buffer_overflow) {
    return refuse(431, "the header is longer than 8 KiB");
  }
  if (error == http::error::body_limit) {  // its header is whole
    const HttpVerdict verdict = host_.judge(head_of(parser_.get()));
    if (verdict.status != 200) return refuse(verdict.status, verdict.reason);
    return refuse(413, "no request has a body");
  }
  if (error && error.category() == make_error_code(http::error::bad_method).category() &&
      error != http::error::end_of_stream && error != http::error::partial_message) {
    return refuse(400, "this is not HTTP");
  }
  if (!error) answer();
}

void HttpConnection::answer() {
  const http::request<http::empty_body>& request = parser_.get();
  const HttpVerdict verdict = host_.judge(head_of(request));
  if (verdict.status != 403) host_header_ = view_of(request[http::field::host]);
  if (verdict.status != 200) return refuse(verdict.status, verdict.reason);
  if (verdict.resource == Resource::kLive) return upgrade();
  take_place(is_secret(verdict.resource) ? ConnectionKind::kTrusted : ConnectionKind::kAsking);
  const bool takes_gzip = accepts_gzip(view_of(request[http::field::accept_encoding]));
  host_.find(verdict.resource, takes_gzip, [self = shared_from_this()](HttpContent content) {
    self->send(200, std::move(content));
  });
}

void HttpConnection::upgrade() {
  const http::request<http::empty_body>& request = parser_.get();
  if (!beast::websocket::is_upgrade(request)) {
    return refuse(400, "this is not a handshake of a WebSocket");
  }
  place_ = {};
  const auto client = std::make_shared<LiveClient>(std::move(stream_), host_.live_host());
  client->hold(
      host_.take_place(ConnectionKind::kAsking, [client = client.get()] { client->drop(); }));
  client->accept(request, safety_headers(host_header_, host_.origins()));
}

void HttpConnection::refuse(int status, std::string_view reason) {
  take_place(ConnectionKind::kAsking);
  const auto text = std::make_shared<const std::string>(std::string(reason) + "\n");
  send(status, {*text, "text/plain; charset=utf-8", false, text});
}

// Sends the answer and closes the connection.
void HttpConnection::send(int status, HttpContent content) {
  content_ = std::move(content);
  response_.version(11);
  response_.result(static_cast<unsigned>(status));
  response_.keep_alive(false);
  for (const auto& [name, value] : safety_headers(host_header_, host_.origins())) {
    response_.set(name, value);
  }
  response_.set(http::field::content_type, content_.type);
  if (content_.is_gzip) response_.set(http::field::content_encoding, "gzip");
  response_.set(http::field::vary, "Accept-Encoding");
  if (status == 405) response_.set(http::field::allow, "GET, HEAD");
  response_.body() = {content_.bytes.data(), content_.bytes.size()};
  response_.prepare_payload();
  serializer_.emplace(response_);
  stream_.expires_after(std::chrono::seconds(ServerLimits::kAnswer_s));
  // The kernel must not hold whole answers for clients that do not read them.
  beast::error_code ignored;
  stream_.socket().set_option(net::socket_base::send_buffer_size(kSendBufferBytes), ignored);
  write_answer();
}

// The answer to HEAD is that to GET, its length included, without the body.
void HttpConnection::write_answer() {
  auto on_written = [self = shared_from_this()](beast::error_code error, std::size_t) {
    if (error) return;
    beast::error_code ignored;
    self->stream_.socket().shutdown(net::ip::tcp::socket::shutdown_send, ignored);
    self->stream_.expires_after(std::chrono::seconds(ServerLimits::kLinger_s));
    self->linger();
  };
  if (parser_.get().method() == http::verb::head) {
    return http::async_write_header(stream_, *serializer_, std::move(on_written));
  }
  http::async_write(stream_, *serializer_, std::move(on_written));
}

// Reads what the client has sent behind its request, such as a body. A socket that is closed before
// would reset the connection, and the client would lose the answer.
void HttpConnection::linger() {
  buffer_.clear();
  stream_.async_read_some(buffer_.prepare(ServerLimits::kHeaderBytes),
                          [self = shared_from_this()](beast::error_code error, std::size_t count) {
                            self->ignored_bytes_ += count;
                            if (!error && self->ignored_bytes_ <= ServerLimits::kMessageBytes) {
                              self->linger();
                            }
                          });
}

}  // namespace palpate
