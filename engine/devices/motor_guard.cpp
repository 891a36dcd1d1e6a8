#include "engine/devices/motor_guard.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <new>
#include <poll.h>
#include <pthread.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include "engine/devices/realtime_limit.h"

extern "C" char** environ;

namespace palpate {
namespace {

constexpr std::int64_t kShortestStaleNs = 20'000'000;
constexpr double kStalePeriods = 10.0;
constexpr int kAnswerMs = 5000;  // for an answer of the guard, on a busy machine
constexpr int kEndMs = 2000;     // for the guard's end; it writes zeros for 200 ms
constexpr int kLookMs = 20;      // so often a wait looks whether the guard can run at all
// An armed guard wakes every 50 ms at least. Without real-time scheduling a busy machine delays a
// wake-up by 100 ms; ten missed wake-ups mean that the guard is frozen.
constexpr std::int64_t kFrozenNs = 10 * kGuardWakeNs;
constexpr const char* kProgram = "palpate-guard";
constexpr const char* kResume =
    "let it run again, by `kill -CONT` or by the debugger that holds it, or start again";

Error guard_error(std::string problem, std::string hint = "") {
  return {ErrorCode::kInvalidArgument, "", kProgram, std::move(problem), std::move(hint)};
}

Error system_error(const std::string& action, int error) {
  return guard_error(action + " failed: " + std::strerror(error));
}

// <sys/pidfd.h> of glibc 2.36 declares its functions without extern "C".
int open_pidfd(pid_t process) {
  return static_cast<int>(syscall(SYS_pidfd_open, process, 0));
}

// A descriptor that is closed at the end of the scope.
class ClosedDescriptor {
 public:
  explicit ClosedDescriptor(int value) : value_(value) {}
  ~ClosedDescriptor() {
    if (value_ >= 0) ::close(value_);
  }
  ClosedDescriptor(const ClosedDescriptor&) = delete;
  ClosedDescriptor& operator=(const ClosedDescriptor&) = delete;
  int value() const { return value_; }

 private:
  int value_;
};

Result<std::string> find_program() {
  namespace fs = std::filesystem;
  std::error_code failed;
  const fs::path folder = fs::read_symlink("/proc/self/exe", failed).parent_path();
  const fs::path beside = folder / kProgram;
  if (!failed && ::access(beside.c_str(), X_OK) == 0) return beside.string();
  const char* named = std::getenv("PALPATE_GUARD");
  if (named == nullptr) {
    return guard_error("is not in " + folder.string() + ", and PALPATE_GUARD is not set",
                       "put the program there, or name it in this environment variable");
  }
  if (::access(named, X_OK) != 0) {
    return guard_error(std::string("PALPATE_GUARD is ") + named + "; expected a program",
                       std::strerror(errno));
  }
  return std::string(named);
}

std::optional<Error> check_guard_spec(const GuardSpec& spec) {
  const std::size_t most = GuardOrder{}.zero_bytes.size();
  const int flags = fcntl(spec.descriptor, F_GETFL);
  if (flags < 0) {
    return invalid_argument("descriptor", "is not open; expected the descriptor of the device");
  }
  if ((flags & O_NONBLOCK) == 0) {
    return invalid_argument("descriptor", "is blocking; expected O_NONBLOCK",
                            "a write that blocks would stop the guard");
  }
  if (!(spec.period_s > 0.0) || !(spec.period_s <= 1.0)) {
    return invalid_argument(
        "period_s", "is " + std::to_string(spec.period_s) + "; expected more than 0, at most 1");
  }
  if (spec.zero_bytes.empty() || spec.zero_bytes.size() > most) {
    return invalid_argument("zero_bytes", "is " + std::to_string(spec.zero_bytes.size()) +
                                              " bytes long; expected 1 to " + std::to_string(most));
  }
  return std::nullopt;
}

Error no_word() {
  return guard_error("ended, or said nothing for 5 s, before it was ready",
                     "its message, if any, is above");
}

std::optional<Error> send_order(int socket, const GuardSpec& spec, int memory, int engine) {
  const auto order = std::make_unique<GuardOrder>();
  order->engine_pid = getpid();
  order->stale_ns = stale_heartbeat_ns(spec.period_s);
  order->zero_count = static_cast<std::uint32_t>(spec.zero_bytes.size());
  std::copy(spec.zero_bytes.begin(), spec.zero_bytes.end(), order->zero_bytes.begin());
  const std::array<int, 3> descriptors = {spec.descriptor, memory, engine};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof descriptors)> control = {};
  iovec part{order.get(), sizeof *order};
  msghdr message = {};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  cmsghdr* header = CMSG_FIRSTHDR(&message);
  header->cmsg_level = SOL_SOCKET;
  header->cmsg_type = SCM_RIGHTS;
  header->cmsg_len = CMSG_LEN(sizeof descriptors);
  std::memcpy(CMSG_DATA(header), descriptors.data(), sizeof descriptors);
  if (sendmsg(socket, &message, MSG_NOSIGNAL) >= 0) return std::nullopt;
  return errno == EPIPE ? no_word() : system_error("sending the device to the guard", errno);
}

// Waits until a descriptor is readable, or has hung up, for at most `most_ms` or until `ends`
// returns true. Returns whether it is.
template <typename Ends>
bool wait_for_input(int descriptor, int most_ms, Ends&& ends) {
  const std::int64_t end_ns = monotonic_ns() + std::int64_t{1'000'000} * most_ms;
  pollfd waiting{descriptor, POLLIN, 0};
  for (;;) {
    const int ready = poll(&waiting, 1, kLookMs);
    if (ready > 0) return true;
    if (ready < 0 && errno != EINTR) return false;
    if (ends() || monotonic_ns() >= end_ns) return false;
  }
}

std::string explain_fifo(int error) {
  return std::string("SCHED_FIFO was refused to palpate-guard (") + std::strerror(error) +
         "): a zero may be late on a busy machine; " + fifo_remedy();
}

}  // namespace

std::int64_t stale_heartbeat_ns(double period_s) noexcept {
  return std::max<std::int64_t>(kShortestStaleNs, std::llround(kStalePeriods * 1e9 * period_s));
}

Result<std::unique_ptr<MotorGuard>> MotorGuard::spawn(const GuardSpec& spec) {
  if (auto problem = check_guard_spec(spec)) return *problem;
  std::unique_ptr<MotorGuard> guard(new MotorGuard);
  if (auto problem = guard->set_up(spec)) return *problem;
  return guard;
}

std::optional<Error> MotorGuard::set_up(const GuardSpec& spec) {
  const Result<std::string> program = find_program();
  if (!program) return program.error();
  memory_ = memfd_create(kProgram, MFD_CLOEXEC | MFD_ALLOW_SEALING);
  if (memory_ < 0 || ftruncate(memory_, sizeof(GuardMemory)) != 0 ||
      fcntl(memory_, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) != 0) {
    return system_error("creating the shared memory", errno);
  }
  void* memory = mmap(nullptr, sizeof(GuardMemory), PROT_READ | PROT_WRITE, MAP_SHARED, memory_, 0);
  if (memory == MAP_FAILED) return system_error("mapping the shared memory", errno);
  shared_ = new (memory) GuardMemory;

  std::array<int, 2> sockets = {-1, -1};
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, sockets.data()) != 0) {
    return system_error("creating a socket", errno);
  }
  socket_ = sockets[0];
  {
    // Closed before the guard's word is awaited, so that the end of the guard ends the waiting.
    const ClosedDescriptor theirs(sockets[1]);
    if (auto problem = start_process(*program, theirs.value())) return problem;
  }
  const ClosedDescriptor engine(open_pidfd(getpid()));
  if (engine.value() < 0) return system_error("pidfd_open", errno);
  if (auto problem = send_order(socket_, spec, memory_, engine.value())) return problem;
  return receive_word();
}

std::optional<Error> MotorGuard::start_process(const std::string& program, int socket) {
  posix_spawn_file_actions_t files;
  posix_spawnattr_t attributes;
  posix_spawn_file_actions_init(&files);
  posix_spawnattr_init(&attributes);
  posix_spawn_file_actions_adddup2(&files, socket, kGuardSocket);
  posix_spawn_file_actions_addclosefrom_np(&files, kGuardSocket + 1);
  posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  sigset_t none;
  sigset_t all;
  sigemptyset(&none);
  sigfillset(&all);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setsigdefault(&attributes, &all);
  // A session of its own: no terminal sends signals to the guard.
  posix_spawnattr_setflags(&attributes,
                           POSIX_SPAWN_SETSID | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  std::string name = kProgram;
  const std::array<char*, 2> arguments = {name.data(), nullptr};
  const int failed =
      posix_spawn(&process_, program.c_str(), &files, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  if (failed != 0) {
    process_ = -1;
    return system_error("starting " + program, failed);
  }
  pidfd_ = open_pidfd(process_);
  if (pidfd_ < 0) return system_error("pidfd_open of the guard", errno);
  sigset_t before;
  pthread_sigmask(SIG_SETMASK, &all, &before);
  reaper_ = std::thread([this] { wait_for_end(); });
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  return std::nullopt;
}

std::optional<Error> MotorGuard::receive_word() {
  GuardWord word;
  if (!receive(&word, sizeof word)) {
    if (is_stopped()) return guard_error("was stopped by a signal before it was ready", kResume);
    return no_word();
  }
  word.problem.back() = '\0';
  if (word.magic != kGuardMagic || word.version != kGuardVersion) {
    return guard_error("is of another build than the engine", "build both again");
  }
  if (word.problem[0] != '\0') return guard_error(word.problem.data());
  if (word.fifo_error != 0) fifo_problem_ = explain_fifo(word.fifo_error);
  return std::nullopt;
}

MotorGuard::~MotorGuard() {
  if (socket_ >= 0) ::close(socket_);  // the guard ends; if it is armed, it first writes zeros
  if (process_ > 0 && pidfd_ < 0) ::kill(process_, SIGKILL);
  if (reaper_.joinable()) {
    // An armed guard may still have zeros to write, late on a busy machine.
    const bool is_armed = shared_->is_armed.load(std::memory_order_relaxed) != 0;
    const auto is_hopeless = [&] { return is_armed ? is_stopped() : cannot_run(); };
    if (!wait_for_input(pidfd_, kEndMs, is_hopeless))
      syscall(SYS_pidfd_send_signal, pidfd_, SIGKILL, nullptr, 0);
    reaper_.join();
  }
  if (shared_ != nullptr) munmap(shared_, sizeof(GuardMemory));
  if (memory_ >= 0) ::close(memory_);
  if (pidfd_ >= 0) ::close(pidfd_);
}

void MotorGuard::wait_for_end() noexcept {
  pollfd end{pidfd_, POLLIN, 0};
  while (poll(&end, 1, -1) < 0 && errno == EINTR) {
  }
  has_ended_.store(true, std::memory_order_release);
  siginfo_t ignored = {};
  waitid(P_PIDFD, static_cast<id_t>(pidfd_), &ignored, WEXITED);
}

// Tells the guard that `is_armed` has changed, and waits until it has read it.
std::optional<Error> MotorGuard::ring() {
  char bell = kGuardBell;
  if (send(socket_, &bell, 1, MSG_NOSIGNAL) == 1 && receive(&bell, 1)) return std::nullopt;
  // A closed socket is seen before the end of the process.
  const bool is_frozen = is_stopped() || state(monotonic_ns()) == GuardState::kFrozen;
  if (is_frozen) return guard_error("is frozen: it does not run, and stops no motors", kResume);
  return guard_error("has ended or does not answer", "nobody stops the motors; start it again");
}

// Receives one message of exactly `size` bytes.
bool MotorGuard::receive(void* content, std::size_t size) const {
  return wait_for_input(socket_, kAnswerMs, [this] { return cannot_run(); }) &&
         recv(socket_, content, size, MSG_DONTWAIT) == static_cast<ssize_t>(size);
}

// Whether a signal has stopped the process.
bool MotorGuard::is_stopped() const noexcept {
  siginfo_t change = {};
  return waitid(P_PIDFD, static_cast<id_t>(pidfd_), &change, WSTOPPED | WNOHANG | WNOWAIT) == 0 &&
         change.si_pid != 0;
}

// Whether it makes no sense to wait for the guard. Before its first word, it has no heartbeat.
bool MotorGuard::cannot_run() const noexcept {
  return is_stopped() || state(monotonic_ns()) == GuardState::kFrozen;
}

std::optional<Error> MotorGuard::arm(std::int64_t boot_ahead_ns) {
  shared_->driver_thread.store(0, std::memory_order_release);
  shared_->was_suspended.store(0, std::memory_order_release);
  shared_->boot_ahead_ns.store(boot_ahead_ns, std::memory_order_release);
  shared_->is_armed.store(1, std::memory_order_release);
  if (auto problem = ring()) {
    shared_->is_armed.store(0, std::memory_order_release);
    return problem;
  }
  return std::nullopt;
}

std::optional<Error> MotorGuard::disarm() {
  shared_->is_armed.store(0, std::memory_order_release);
  return ring();
}

void MotorGuard::beat(std::int64_t tick_ns, std::int64_t now_ns) noexcept {
  thread_local const pid_t thread = gettid();
  shared_->driver_thread.store(thread, std::memory_order_relaxed);
  shared_->tick_ns.store(tick_ns, std::memory_order_release);
  shared_->beat_ns.store(now_ns, std::memory_order_release);
}

std::uint64_t MotorGuard::trip_epoch() const noexcept {
  const std::uint64_t epoch = shared_->trip_epoch.load(std::memory_order_acquire);
  if (shared_->seen_epoch.load(std::memory_order_relaxed) != epoch) {
    shared_->seen_epoch.store(epoch, std::memory_order_release);
  }
  return epoch;
}

void MotorGuard::acknowledge(std::uint64_t epoch) noexcept {
  shared_->was_suspended.store(0, std::memory_order_release);
  shared_->acknowledged_epoch.store(epoch, std::memory_order_release);
}

bool MotorGuard::is_quiet() const noexcept {
  return shared_->quiet_epoch.load(std::memory_order_acquire) ==
         shared_->trip_epoch.load(std::memory_order_acquire);
}

bool MotorGuard::was_suspended() const noexcept {
  return shared_->was_suspended.load(std::memory_order_acquire) != 0;
}

GuardState MotorGuard::state(std::int64_t now_ns) const noexcept {
  if (has_ended_.load(std::memory_order_acquire)) return GuardState::kEnded;
  if (shared_->is_guard_alive.load(std::memory_order_acquire) == 0) return GuardState::kEnded;
  const std::int64_t asleep_ns = now_ns - shared_->guard_ns.load(std::memory_order_acquire);
  return asleep_ns < kFrozenNs ? GuardState::kAlive : GuardState::kFrozen;
}

}  // namespace palpate
