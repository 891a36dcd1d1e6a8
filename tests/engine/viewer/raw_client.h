#pragma once

// A client of the server of `view` that sends what the test wants, right or wrong. Not built on the
// server's library, so that a mistake of that library does not hide itself. A connection that
// cannot be made, and a server that neither answers nor closes, throw std::runtime_error.

#include <arpa/inet.h>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <netinet/in.h>
#include <optional>
#include <poll.h>
#include <stdexcept>
#include <string>
#include <string_view>
#include <sys/socket.h>
#include <unistd.h>
#include <utility>

namespace palpate::test {

// A test that waits longer than this fails; no test asserts a shorter time.
inline constexpr auto kPatience = std::chrono::seconds(60);

// A blocking connection to a port of this machine.
class RawClient {
 public:
  explicit RawClient(std::uint16_t port, const char* address_text = "127.0.0.1")
      : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    ::inet_pton(AF_INET, address_text, &address.sin_addr);
    if (::connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) {
      throw std::runtime_error(std::string("no connection: ") + std::strerror(errno));
    }
  }
  ~RawClient() {
    if (socket_ >= 0) ::close(socket_);
  }
  RawClient(const RawClient&) = delete;
  RawClient& operator=(const RawClient&) = delete;
  RawClient(RawClient&& other) noexcept
      : socket_(std::exchange(other.socket_, -1)), input_(std::move(other.input_)) {}

  // Returns false if the server has closed the connection.
  bool send(std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t n = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (n <= 0) return false;
      bytes.remove_prefix(static_cast<std::size_t>(n));
    }
    return true;
  }

  // Sends as much as the connection takes without waiting. Returns false if it is closed.
  bool send_some(std::string_view bytes) {
    const ssize_t n = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    return n >= 0 || errno == EAGAIN || errno == EWOULDBLOCK;
  }

  void end_sending() { ::shutdown(socket_, SHUT_WR); }

  // Ends the connection by a reset.
  void reset() {
    const linger at_once{1, 0};
    ::setsockopt(socket_, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
    ::close(std::exchange(socket_, -1));
  }

  // Reads more bytes into input(). Returns false at the end of the connection.
  bool read_more() {
    pollfd waiting{socket_, POLLIN, 0};
    const int timeout_ms = static_cast<int>(std::chrono::milliseconds(kPatience).count());
    if (::poll(&waiting, 1, timeout_ms) <= 0) {
      throw std::runtime_error("the server neither answered nor closed the connection");
    }
    char bytes[16384];
    const ssize_t n = ::recv(socket_, bytes, sizeof bytes, 0);
    if (n < 0) was_reset_ = true;
    if (n <= 0) return false;
    input_.append(bytes, static_cast<std::size_t>(n));
    return true;
  }

  // True if the connection ended by a reset, which may cost a client what it has not read.
  bool was_reset() const { return was_reset_; }

  // True if the server has closed the connection by now.
  bool is_closed_now() {
    pollfd waiting{socket_, POLLIN, 0};
    if (::poll(&waiting, 1, 0) <= 0) return false;
    char byte;
    return ::recv(socket_, &byte, 1, MSG_PEEK) <= 0;
  }

  std::string read_to_end() {
    while (read_more()) {
    }
    return std::exchange(input_, {});
  }

  // Removes and returns `count` bytes; no value at the end of the connection.
  std::optional<std::string> read_exactly(std::size_t count) {
    while (input_.size() < count) {
      if (!read_more()) return std::nullopt;
    }
    std::string bytes = input_.substr(0, count);
    input_.erase(0, count);
    return bytes;
  }

  // Removes and returns everything up to and with `end`.
  std::optional<std::string> read_until(std::string_view end) {
    std::size_t at = 0;
    while ((at = input_.find(end)) == std::string::npos) {
      if (!read_more()) return std::nullopt;
    }
    return read_exactly(at + end.size());
  }

 private:
  int socket_;
  bool was_reset_ = false;
  std::string input_;
};

// The whole answer to one request.
inline std::string answer_to(std::uint16_t port, const std::string& request,
                             const char* address = "127.0.0.1") {
  RawClient client(port, address);
  client.send(request);
  return client.read_to_end();
}

inline int status_of(const std::string& answer) {
  return answer.size() > 12 ? std::stoi(answer.substr(9, 3)) : 0;
}

inline std::string get_request(const std::string& target, const std::string& host,
                               const std::string& more = "") {
  return "GET " + target + " HTTP/1.1\r\nHost: " + host + "\r\n" + more + "\r\n";
}

// A message or a closing frame.
struct WebSocketMessage {
  int opcode = 0;  // 1 text, 2 binary, 8 close
  std::string bytes;
  std::uint16_t close_code() const {
    if (opcode != 8 || bytes.size() < 2) return 0;
    return static_cast<std::uint16_t>(static_cast<unsigned char>(bytes[0]) << 8 |
                                      static_cast<unsigned char>(bytes[1]));
  }
};

class WebSocketClient {
 public:
  static std::string handshake(const std::string& host, const std::string& origin,
                               const std::string& target = "/live") {
    const std::string origin_line = origin.empty() ? "" : "Origin: " + origin + "\r\n";
    return get_request(target, host,
                       origin_line +
                           "Upgrade: websocket\r\nConnection: Upgrade\r\n"
                           "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
                           "Sec-WebSocket-Version: 13\r\n");
  }

  explicit WebSocketClient(std::uint16_t port) : raw(port) {
    const std::string host = "127.0.0.1:" + std::to_string(port);
    raw.send(handshake(host, "http://" + host));
    head = raw.read_until("\r\n\r\n").value_or("");
    if (status_of(head) != 101) throw std::runtime_error("no handshake: " + head);
  }

  // A masked frame, as clients must send it. The mask is zero, which is a mask, too.
  static std::string frame(int opcode, std::string_view bytes, bool is_last = true) {
    std::string text;
    text += static_cast<char>((is_last ? 0x80 : 0) | opcode);
    if (bytes.size() < 126) {
      text += static_cast<char>(0x80 | bytes.size());
    } else if (bytes.size() < 65536) {
      text += static_cast<char>(0x80 | 126);
      text += static_cast<char>(bytes.size() >> 8);
      text += static_cast<char>(bytes.size() & 255);
    } else {
      text += static_cast<char>(0x80 | 127);
      for (int shift = 56; shift >= 0; shift -= 8) {
        text += static_cast<char>(bytes.size() >> shift & 255);
      }
    }
    return text + std::string(4, '\0') + std::string(bytes);
  }

  bool send_text(std::string_view text) { return raw.send(frame(1, text)); }
  bool send_binary(std::string_view bytes) { return raw.send(frame(2, bytes)); }
  bool send_close() { return raw.send(frame(8, "\x03\xe9")); }  // code 1001

  // The next frame; no value at the end of the connection.
  std::optional<WebSocketMessage> read() {
    const auto head_bytes = raw.read_exactly(2);
    if (!head_bytes) return std::nullopt;
    WebSocketMessage message;
    message.opcode = (*head_bytes)[0] & 15;
    std::size_t size = (*head_bytes)[1] & 127;
    const std::size_t more = size == 126 ? 2 : size == 127 ? 8 : 0;
    if (more > 0) {
      const auto length = raw.read_exactly(more);
      if (!length) return std::nullopt;
      size = 0;
      for (const char c : *length) size = size << 8 | static_cast<unsigned char>(c);
    }
    const auto bytes = raw.read_exactly(size);
    if (!bytes) return std::nullopt;
    message.bytes = *bytes;
    return message;
  }

  // The next text that contains `part`; the messages before it are dropped.
  std::string read_text_with(std::string_view part) {
    while (const auto message = read()) {
      if (message->opcode == 1 && message->bytes.find(part) != std::string::npos) {
        return message->bytes;
      }
    }
    throw std::runtime_error("no text with " + std::string(part));
  }

  // The next binary message of this kind.
  std::string read_binary(int kind) {
    while (const auto message = read()) {
      if (message->opcode == 2 && message->bytes[0] == kind) return message->bytes;
    }
    throw std::runtime_error("no binary message of kind " + std::to_string(kind));
  }

  // The code of the closing frame; 0: the connection ended without one.
  std::uint16_t read_to_close() {
    while (const auto message = read()) {
      if (message->opcode == 8) return message->close_code();
    }
    return 0;
  }

  RawClient raw;
  std::string head;
};

}  // namespace palpate::test
