#include "engine/viewer/live_client.h"

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <boost/beast/http/fields.hpp>
#include <utility>

#include "engine/viewer/view_server.h"

namespace palpate {
namespace {

namespace websocket = beast::websocket;

constexpr std::size_t kSendBufferBytes = 64 * 1024;
constexpr std::uint16_t kLateToken = 4408;  // a page that is slow may try again
constexpr auto kPatienceAtClose = std::chrono::seconds(2);

}  // namespace

LiveClient::LiveClient(Stream stream, LiveHost& host) : socket_(std::move(stream)), host_(host) {}

void LiveClient::accept(const Request& request, Headers headers) {
  Stream& stream = socket_.next_layer();
  stream.expires_never();  // the WebSocket has timers of its own
  beast::error_code ignored;
  // The kernel must not hold seconds of old states for a slow client.
  stream.socket().set_option(net::socket_base::send_buffer_size(kSendBufferBytes), ignored);
  stream.socket().set_option(net::ip::tcp::no_delay(true), ignored);
  socket_.set_option(websocket::stream_base::timeout{
      std::chrono::seconds(ServerLimits::kHandshake_s), std::chrono::seconds(ServerLimits::kIdle_s),
      /* keep_alive_pings = */ true});
  socket_.set_option(
      websocket::stream_base::decorator([headers = std::move(headers)](auto& response) {
        for (const auto& [name, value] : headers) response.set(name, value);
      }));
  socket_.read_message_max(ServerLimits::kTokenBytes);
  socket_.auto_fragment(false);
  // The client ends its half: until it ends the connection, too, async_read() tells nothing.
  socket_.control_callback([this](websocket::frame_type kind, beast::string_view) {
    if (kind != websocket::frame_type::close || is_closing()) return;
    texts_.clear();
    on_closing();
  });
  begin_ = std::chrono::steady_clock::now();
  socket_.async_accept(request, [self = shared_from_this()](beast::error_code error) {
    if (error) return self->drop();
    if (self->has_ended_) return;  // dropped while the handshake ended
    self->is_open_ = true;
    self->bytes_at_message_ = self->socket_.next_layer().rate_policy().read_bytes();
    self->host_.on_open(self);
    self->read();
  });
}

void LiveClient::allow_long_messages() {
  socket_.read_message_max(ServerLimits::kMessageBytes);
}

void LiveClient::read() {
  socket_.async_read(input_, [self = shared_from_this()](beast::error_code error, std::size_t n) {
    self->on_read(error, n);
  });
}

void LiveClient::on_read(beast::error_code error, std::size_t /*bytes*/) {
  if (error) return drop();
  bytes_at_message_ = socket_.next_layer().rate_policy().read_bytes();
  const std::string_view message(static_cast<const char*>(input_.data().data()), input_.size());
  if (!is_closing_) host_.on_message(*this, message, socket_.got_text());
  input_.consume(input_.size());
  read();
}

void LiveClient::send(std::string text) {
  if (!is_open_ || is_closing_) return;
  if (texts_.size() >= ServerLimits::kQueuedTexts) return drop();
  texts_.push_back(std::move(text));
  write();
}

void LiveClient::send_newest(std::string text) {
  if (!is_open_ || is_closing_) return;
  newest_text_ = std::move(text);
  write();
}

void LiveClient::want_state() {
  wants_state_ = true;
  write();
}

void LiveClient::want_ticks() {
  wants_ticks_ = true;
  write();
}

// Sends the next message unless one is in flight.
void LiveClient::write() {
  if (is_writing_ || !is_open_ || has_ended_) return;
  bool is_text = false;
  if (!texts_.empty()) {
    output_ = std::move(texts_.front());
    texts_.pop_front();
    is_text = true;
  } else if (!newest_text_.empty()) {
    output_ = std::exchange(newest_text_, {});
    is_text = true;
  } else if (is_closing_) {
    return begin_close();
  } else if (std::exchange(wants_state_, false) && host_.encode_state(*this, output_)) {
  } else if (std::exchange(wants_ticks_, false) && host_.encode_ticks(*this, output_)) {
  } else {
    return;
  }
  is_writing_ = true;
  socket_.text(is_text);
  socket_.async_write(net::buffer(output_),
                      [self = shared_from_this()](beast::error_code error, std::size_t) {
                        self->on_written(error);
                      });
}

void LiveClient::on_written(beast::error_code error) {
  is_writing_ = false;
  if (error) return drop();
  write();
}

void LiveClient::close(std::uint16_t code, std::string reason) {
  if (is_closing_ || has_ended_) return;
  constexpr std::size_t kLongestReason = 120;  // a control frame has 125 bytes at most
  reason.resize(std::min(reason.size(), kLongestReason));
  // A reason may repeat what the client sent. A part of a character would break the frame.
  std::replace_if(
      reason.begin(), reason.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  close_reason_ = websocket::close_reason(websocket::close_code(code), reason);
  if (!is_open_) return drop();
  on_closing();
  write();
}

void LiveClient::on_closing() {
  is_closing_ = true;
  wants_state_ = wants_ticks_ = false;
  newest_text_.clear();
  closed_at_ = std::chrono::steady_clock::now();
  host_.on_closing(*this);
}

void LiveClient::begin_close() {
  if (!close_reason_) return;
  const websocket::close_reason reason = *std::exchange(close_reason_, std::nullopt);
  socket_.async_close(reason, [self = shared_from_this()](beast::error_code) { self->drop(); });
}

void LiveClient::check(std::chrono::steady_clock::time_point now) {
  if (!has_token && now - begin_ > std::chrono::seconds(ServerLimits::kToken_s)) {
    close(kLateToken, "the token did not come in time");
  }
  // A client that does not read never sees that it is closed.
  if (is_closing_ && now - closed_at_ > kPatienceAtClose) return drop();
  const std::uint64_t read_bytes = socket_.next_layer().rate_policy().read_bytes();
  if (read_bytes - bytes_at_message_ > ServerLimits::kUnfinishedBytes) drop();
}

// Closes the socket, too: a message in flight to a client that has gone would keep it open.
void LiveClient::drop() {
  if (std::exchange(has_ended_, true)) return;
  const auto self = shared_from_this();  // the host forgets this object
  beast::error_code ignored;
  socket_.next_layer().socket().close(ignored);
  place_ = {};
  host_.on_end(*this);
}

}  // namespace palpate
