#pragma once

// A board with a fake firmware behind a pseudo-terminal, and a log of its torques.

#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <fcntl.h>
#include <memory>
#include <mutex>
#include <poll.h>
#include <sched.h>
#include <string>
#include <sys/socket.h>
#include <termios.h>
#include <thread>
#include <unistd.h>
#include <vector>

#include "engine/devices/guard_memory.h"
#include "engine/devices/monotonic_clock.h"
#include "tests/engine/devices/fake_firmware.h"

namespace palpate {

// Opens the host's side of a pseudo-terminal, which passes all bytes unchanged.
inline int open_raw(const std::string& port) {
  const int descriptor = ::open(port.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC | O_NONBLOCK);
  termios settings = {};
  tcgetattr(descriptor, &settings);
  cfmakeraw(&settings);
  tcsetattr(descriptor, TCSANOW, &settings);
  return descriptor;
}

// Reads the host's bytes on a thread of its own and answers. Its port behaves like the board's.
class FakeBoardTerminal {
 public:
  // One tick message that the board has read, or several of zero torque in a row, and when.
  struct Entry {
    std::int64_t first_ns = 0;
    std::int64_t last_ns = 0;
    bool is_zero = true;
    std::uint64_t count = 1;
  };

  // A pseudo-terminal passes bytes on through a worker of the kernel, which has ordinary priority.
  // A pair of sockets passes them at once, but has no flush. Its port is an inherited descriptor.
  enum class Kind { kTerminal, kSockets };

  explicit FakeBoardTerminal(Kind kind = Kind::kTerminal,
                             ResetKind reset = ResetKind::kGivesMotorsToDevice0)
      : firmware_(reset) {
    if (kind == Kind::kTerminal) {
      open_terminal();
    } else {
      open_sockets();
    }
    thread_ = std::thread([this] { run(); });
  }
  ~FakeBoardTerminal() { hang_up(); }
  FakeBoardTerminal(const FakeBoardTerminal&) = delete;
  FakeBoardTerminal& operator=(const FakeBoardTerminal&) = delete;

  const std::string& port() const { return port_; }

  // The board stops reading, or reads on.
  void pause(bool pauses) { is_paused_.store(pauses); }
  // Whether the board answers tick messages; true at first.
  void answer(bool answers) { answers_.store(answers); }

  // The board answers until the host's queue is full, and reads no command until the host has read
  // answers, as firmware that waits for room in its own queue.
  void flood() { floods_.store(true); }
  bool is_flooding() const { return floods_.load(); }

  // Closes the board's side.
  void hang_up() {
    if (!thread_.joinable()) return;
    ends_.store(true);
    thread_.join();
    ::close(terminal_);
    ::close(host_side_);
    terminal_ = -1;
  }

  // The log: neighbouring messages that are both zero, or both not, form one entry.
  std::vector<Entry> log() const {
    const std::lock_guard lock(mutex_);
    return log_;
  }
  // The board reads with this real-time priority, if the process may use it.
  void set_priority(int priority) {
    const sched_param fifo{priority};
    pthread_setschedparam(thread_.native_handle(), SCHED_FIFO, &fifo);
  }
  // Whether the last message was zero, or there was none.
  bool is_zero() const {
    const std::lock_guard lock(mutex_);
    return log_.empty() || log_.back().is_zero;
  }
  std::uint64_t bytes_read() const { return bytes_read_.load(); }

 private:
  void open_terminal() {
    terminal_ = posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC | O_NONBLOCK);
    const bool is_made = terminal_ >= 0 && grantpt(terminal_) == 0 && unlockpt(terminal_) == 0;
    const char* const name = is_made ? ptsname(terminal_) : nullptr;
    if (name == nullptr) return;  // the test is not run (helpers/needs.h)
    port_ = name;
    // A terminal that nobody has opened looks hung up; this descriptor keeps it open.
    host_side_ = open_raw(port_);
  }
  void open_sockets() {
    std::array<int, 2> ends = {-1, -1};
    socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, ends.data());
    terminal_ = ends[0];
    fcntl(terminal_, F_SETFD, FD_CLOEXEC);
    host_side_ = ends[1];
    port_ = std::to_string(host_side_);
  }

  void run() {
    std::array<std::uint8_t, 4096> bytes;
    while (!ends_.load()) {
      pollfd readable{terminal_, POLLIN, 0};
      if (floods_.load()) {
        wait_for_room();
        floods_.store(false);
      }
      if (is_paused_.load()) {
        ::usleep(1000);
        continue;
      }
      if (poll(&readable, 1, 5) <= 0) continue;
      const ssize_t size = ::read(terminal_, bytes.data(), bytes.size());
      const std::int64_t now_ns = monotonic_ns();
      bytes_read_ += static_cast<std::uint64_t>(std::max<ssize_t>(0, size));
      for (ssize_t i = 0; i < size; ++i) take(bytes[static_cast<std::size_t>(i)], now_ns);
    }
  }

  void wait_for_room() {
    const std::array<char, 256> answers = {};
    // The kernel makes more room a little later, when it moves bytes to the reader's side.
    for (int ms = 0; ms < 10; ++ms) {
      // Bounded, because the host may read as fast as the board writes.
      for (const std::size_t size : {answers.size(), std::size_t{1}}) {
        for (int n = 0; n < 256 && ::write(terminal_, answers.data(), size) > 0; ++n) {
        }
      }
      ::usleep(1000);
    }
    while (!ends_.load() && ::write(terminal_, answers.data(), 1) <= 0) ::usleep(1000);
  }

  void take(std::uint8_t byte, std::int64_t now_ns) {
    if (!firmware_.take(byte)) return;
    enter(firmware_.is_zero(), now_ns);
    if (!answers_.load()) return;
    const auto answer = firmware_.answer();
    [[maybe_unused]] const ssize_t ignored = ::write(terminal_, answer.data(), answer.size());
  }

  void enter(bool is_zero, std::int64_t now_ns) {
    const std::lock_guard lock(mutex_);
    if (!log_.empty() && log_.back().is_zero == is_zero) {
      log_.back().last_ns = now_ns;
      ++log_.back().count;
    } else {
      log_.push_back({now_ns, now_ns, is_zero, 1});
    }
  }

  int terminal_ = -1;
  int host_side_ = -1;
  std::string port_;
  FakeFirmware firmware_;
  mutable std::mutex mutex_;
  std::vector<Entry> log_;
  std::atomic<bool> is_paused_{false};
  std::atomic<bool> answers_{true};
  std::atomic<bool> floods_{false};
  std::atomic<bool> ends_{false};
  std::atomic<std::uint64_t> bytes_read_{0};
  std::thread thread_;
};

}  // namespace palpate
