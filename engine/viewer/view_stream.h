#pragma once

// The types of Boost.Asio and Boost.Beast that the server uses.

#include <boost/asio/basic_socket_acceptor.hpp>
#include <boost/asio/basic_waitable_timer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/basic_stream.hpp>
#include <boost/beast/core/rate_policy.hpp>
#include <chrono>
#include <cstdint>
#include <limits>

namespace palpate {

namespace net = boost::asio;
namespace beast = boost::beast;

using Executor = net::io_context::executor_type;
using Acceptor = net::basic_socket_acceptor<net::ip::tcp, Executor>;
using Timer = net::basic_waitable_timer<std::chrono::steady_clock,
                                        net::wait_traits<std::chrono::steady_clock>, Executor>;

// Counts what a stream reads; limits nothing.
class CountingPolicy {
 public:
  std::uint64_t read_bytes() const noexcept { return read_bytes_; }

 private:
  friend class beast::rate_policy_access;
  static constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();
  std::size_t available_read_bytes() const noexcept { return kAll; }
  std::size_t available_write_bytes() const noexcept { return kAll; }
  void transfer_read_bytes(std::size_t bytes) noexcept { read_bytes_ += bytes; }
  void transfer_write_bytes(std::size_t) noexcept {}
  void on_timer() const noexcept {}

  std::uint64_t read_bytes_ = 0;
};

using Stream = beast::basic_stream<net::ip::tcp, Executor, CountingPolicy>;

}  // namespace palpate
