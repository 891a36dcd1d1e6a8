#include "engine/simulation/board_terminal.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <sched.h>
#include <stdlib.h>
#include <system_error>
#include <termios.h>
#include <unistd.h>
#include <utility>

namespace palpate {
namespace {

constexpr int kBoardPriority = 81;                 // above the threads of the driver
constexpr std::int64_t kShortestWait_ns = 10'000;  // so that other threads can always run
constexpr std::int64_t kLongestWait_ns = 1'000'000;

Error terminal_error() {
  return {ErrorCode::kFileUnreadable, "/dev/ptmx", "",
          "cannot make a pseudo-terminal: " + std::generic_category().message(errno), ""};
}

// Without this, the terminal would echo the board's answers to the board.
bool make_raw(const char* path) {
  const int descriptor = ::open(path, O_RDWR | O_NOCTTY | O_CLOEXEC);
  if (descriptor < 0) return false;
  termios settings{};
  bool is_raw = ::tcgetattr(descriptor, &settings) == 0;
  ::cfmakeraw(&settings);
  is_raw = is_raw && ::tcsetattr(descriptor, TCSANOW, &settings) == 0;
  ::close(descriptor);
  return is_raw;
}

}  // namespace

Result<std::unique_ptr<BoardTerminal>> BoardTerminal::open(const BoardSettings& settings) {
  const int descriptor = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) return terminal_error();
  std::array<char, 128> path{};
  if (::grantpt(descriptor) != 0 || ::unlockpt(descriptor) != 0 ||
      ::ptsname_r(descriptor, path.data(), path.size()) != 0 || !make_raw(path.data())) {
    const Error error = terminal_error();
    ::close(descriptor);
    return error;
  }
  return std::unique_ptr<BoardTerminal>(new BoardTerminal(descriptor, path.data(), settings));
}

BoardTerminal::BoardTerminal(int descriptor, std::string path, const BoardSettings& settings)
    : descriptor_(descriptor), path_(std::move(path)), board_(settings) {
  thread_ = std::thread([this] { run(); });
  // A board is punctual. Where the system refuses this, the simulated one may be late.
  const sched_param priority{kBoardPriority};
  pthread_setschedparam(thread_.native_handle(), SCHED_FIFO, &priority);
}

BoardTerminal::~BoardTerminal() {
  hang_up();
}

std::int64_t BoardTerminal::now_ns() {
  return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
}

void BoardTerminal::add_fault(const BoardFault& fault) {
  const std::lock_guard lock(mutex_);
  board_.add_fault(fault);
}

void BoardTerminal::set_hand(const Vec2& hand_m) {
  const std::lock_guard lock(mutex_);
  board_.set_hand(hand_m);
}

std::vector<BoardCommand> BoardTerminal::log() const {
  const std::lock_guard lock(mutex_);
  return board_.log();
}

std::uint64_t BoardTerminal::commands() const {
  const std::lock_guard lock(mutex_);
  return board_.commands();
}

std::uint64_t BoardTerminal::set_ups() const {
  const std::lock_guard lock(mutex_);
  return board_.set_ups();
}

PortAccount BoardTerminal::account() const {
  const std::lock_guard lock(mutex_);
  return board_.plant().tip().account();
}

ProbeResult BoardTerminal::probes() const {
  const std::lock_guard lock(mutex_);
  return board_.plant().probes();
}

void BoardTerminal::hang_up() {
  ends_ = true;
  if (thread_.joinable()) thread_.join();
}

void BoardTerminal::run() {
  while (!ends_ && serve()) {
  }
  ::close(descriptor_);
}

// Waits for bytes or for an answer that is due, and moves both. False: the board has hung up.
bool BoardTerminal::serve() {
  std::int64_t wait_ns = kLongestWait_ns;
  {
    const std::lock_guard lock(mutex_);
    const auto due_ns = board_.next_due_ns();
    if (due_ns) wait_ns = std::clamp(*due_ns - now_ns(), kShortestWait_ns, kLongestWait_ns);
  }
  pollfd waiting{descriptor_, POLLIN, 0};
  const timespec wait{0, static_cast<long>(wait_ns)};
  ::ppoll(&waiting, 1, &wait, nullptr);
  if ((waiting.revents & POLLHUP) != 0) {  // no program has opened the port
    std::this_thread::sleep_for(std::chrono::nanoseconds(kLongestWait_ns));
  }
  std::array<std::uint8_t, 4096> bytes;
  const ssize_t count = ::read(descriptor_, bytes.data(), bytes.size());
  const std::int64_t time_ns = now_ns();
  const std::lock_guard lock(mutex_);
  if (board_.has_hung_up(time_ns)) return false;
  if (count > 0) {
    board_.receive(std::span(bytes).first(static_cast<std::size_t>(count)), time_ns);
  }
  const std::size_t answer = board_.take_answer(bytes, time_ns);
  unwritten_.insert(unwritten_.end(), bytes.begin(), bytes.begin() + answer);
  const ssize_t written = ::write(descriptor_, unwritten_.data(), unwritten_.size());
  if (written > 0) unwritten_.erase(unwritten_.begin(), unwritten_.begin() + written);
  return true;
}

}  // namespace palpate
