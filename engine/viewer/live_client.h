#pragma once

// One WebSocket connection of a page.

#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/viewer/connection_places.h"
#include "engine/viewer/view_stream.h"

namespace palpate {

class LiveClient;

// What the server does for its clients. All on the network thread.
class LiveHost {
 public:
  virtual ~LiveHost() = default;
  // The handshake is complete; the client has not sent its token yet.
  virtual void on_open(const std::shared_ptr<LiveClient>& client) = 0;
  // A whole message.
  virtual void on_message(LiveClient& client, std::string_view bytes, bool is_text) = 0;
  // Called once, as soon as either side begins to close an open connection.
  virtual void on_closing(LiveClient& client) = 0;
  // Called once, also for a connection that was never open.
  virtual void on_end(LiveClient& client) = 0;
  // Encode what the client lacks: false if it lacks nothing.
  virtual bool encode_ticks(LiveClient& client, std::string& out) = 0;
  virtual bool encode_state(LiveClient& client, std::string& out) = 0;
};

// Reads messages one after the other and sends one at a time. Texts are sent in order and before
// the binary messages, of which, as of the status, only the newest waits. A binary message is
// encoded when its turn comes, so that the newest one follows a message that took long.
//
// All functions are called on the network thread. The object lives as long as an operation runs.
class LiveClient : public std::enable_shared_from_this<LiveClient> {
 public:
  using Request = beast::http::request<beast::http::empty_body>;

  using Headers = std::vector<std::pair<std::string, std::string>>;

  LiveClient(Stream stream, LiveHost& host);

  // Holds this place until the client ends or holds another one.
  void hold(ConnectionPlaces::Place place) { place_ = std::move(place); }
  // Answers the handshake, which the server has judged, with these headers.
  void accept(const Request& request, Headers headers);

  // Sends a JSON message. A client that does not read its texts is closed.
  void send(std::string text);
  // Sends a JSON message after the texts that wait. A newer one replaces one that waits.
  void send_newest(std::string text);
  // Sends the newest state and ticks as soon as the last message is sent.
  void want_state();
  void want_ticks();
  // Sends the texts that wait, then closes with this code. Further calls are ignored.
  void close(std::uint16_t code, std::string reason);
  // Closes a client that is late: it has not sent its token, sends what is no message, or does not
  // read that it was closed.
  void check(std::chrono::steady_clock::time_point now);
  // Ends the connection at once.
  void drop();
  // True from the call of close() or drop(), or the closing frame of the client, on.
  bool is_closing() const { return is_closing_ || has_ended_; }

  // The server's notes about this client.
  bool has_token = false;
  std::size_t role = 0;          // PageRole, with has_token
  std::uint64_t next_tick = 0;   // number of the first tick that it lacks
  std::uint64_t lost_ticks = 0;  // since its last message of ticks
  std::uint64_t pointer = 0;     // sequence of its newest pointer message
  std::uint64_t answered_pointer = 0;

  // Call this when the client has sent its token: messages may then be longer.
  void allow_long_messages();

 private:
  void read();
  void on_read(beast::error_code error, std::size_t bytes);
  void write();
  void on_written(beast::error_code error);
  void begin_close();
  void on_closing();

  beast::websocket::stream<Stream> socket_;
  LiveHost& host_;
  ConnectionPlaces::Place place_;
  beast::flat_buffer input_;
  std::string output_;
  std::deque<std::string> texts_;
  std::string newest_text_;  // empty: none waits
  bool is_open_ = false;
  bool is_writing_ = false;
  bool wants_state_ = false;
  bool wants_ticks_ = false;
  bool is_closing_ = false;
  bool has_ended_ = false;
  std::optional<beast::websocket::close_reason> close_reason_;
  std::chrono::steady_clock::time_point begin_;
  std::chrono::steady_clock::time_point closed_at_;  // if is_closing_
  std::uint64_t bytes_at_message_ = 0;               // read by the end of the last whole message
};

}  // namespace palpate
