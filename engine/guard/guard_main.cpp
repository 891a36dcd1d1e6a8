// palpate-guard sets the motors of a device to zero when the engine that drives them dies or hangs.
//
// The engine starts this program (engine/devices/motor_guard.h) with a socket as descriptor 3.
// While the engine is armed, the guard watches the heartbeat in the shared memory and a pidfd of
// the engine:
//
//   duty    leaves it when                                      does
//   idle    the engine arms: watch                              nothing
//   watch   the heartbeat is stale: zero, with a new epoch      nothing
//           the driver's thread has ended: the same
//           the machine was suspended: the same
//   zero    the driver has seen the epoch: one more zero, quiet zeros at 200 Hz
//   quiet   the driver acknowledges the epoch: watch            nothing: the driver sets up
//           the heartbeat is stale: zero                        the device
//   last    after 200 ms: ends                                  zeros at 200 Hz
//
// The end of the thread is seen earlier than that of the engine. On a busy machine, a killed engine
// takes tens of milliseconds to end, because its ordinary threads wait for a processor.
//
// Whatever the duty, the end of the engine leads to `last` (armed), or to one zero (not armed). The
// driver looks at the epoch before each write. After it has seen an epoch, it writes no force; so
// the zero that begins after that is the last one needed.

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <poll.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include "engine/devices/guard_memory.h"
#include "engine/devices/monotonic_clock.h"

namespace palpate {
namespace {

constexpr std::int64_t kZeroPeriodNs = 5'000'000;  // 200 Hz
constexpr std::int64_t kLastZerosNs = 200'000'000;
// A heartbeat that is late, though not yet stale, is looked at so often.
constexpr std::int64_t kSuspectNs = 1'000'000;
// A zero begins while bytes are still queued only after this many periods.
constexpr int kPeriodsForQueue = 5;

// What the engine hands over.
struct Orders {
  GuardOrder order;
  int device = -1;
  int memory = -1;
  int engine = -1;  // a pidfd
};

// Writes the zero bytes to the device, which never blocks, and discards its answers. A device that
// fails, for example because it was unplugged, counts as one that got its zero.
class ZeroWriter {
 public:
  explicit ZeroWriter(const Orders& orders)
      : device_(orders.device),
        bytes_(orders.order.zero_bytes.data()),
        count_(orders.order.zero_count) {}

  // Discards what is queued for the device, and begins from the first byte.
  void restart() {
    tcflush(device_, TCOFLUSH);
    offset_ = 0;
    waited_ = 0;
  }

  // Begins a zero, or goes on with the one that was cut. The queue must be empty before a zero
  // begins: a device that reads slowly would otherwise be zeros behind.
  void write_some() {
    if (offset_ == 0 && is_queue_filled() && ++waited_ < kPeriodsForQueue) return;
    waited_ = 0;
    const ssize_t written = ::write(device_, bytes_ + offset_, count_ - offset_);
    if (written < 0 && (errno == EAGAIN || errno == EINTR)) return;
    offset_ = written <= 0 ? count_ : offset_ + static_cast<std::size_t>(written);
    if (offset_ < count_) return;
    offset_ = 0;
    ++completed_;
  }

  // A device whose answers nobody reads stops to read commands.
  void drain_answers() const {
    std::array<char, 512> answers;
    for (int i = 0; i < 32; ++i) {
      if (::read(device_, answers.data(), answers.size()) <= 0) return;
    }
  }

  std::uint64_t completed() const { return completed_; }  // zeros
  bool is_cut() const { return offset_ > 0; }

 private:
  bool is_queue_filled() const {
    int queued = 0;
    return ioctl(device_, TIOCOUTQ, &queued) == 0 && queued > 0;
  }

  int device_;
  const std::uint8_t* bytes_;
  std::size_t count_;
  std::size_t offset_ = 0;
  int waited_ = 0;  // periods
  std::uint64_t completed_ = 0;
};

void ignore_signals(bool ignores) {
  for (const int signal : {SIGINT, SIGHUP, SIGTERM}) {
    std::signal(signal, ignores ? SIG_IGN : SIG_DFL);
  }
}

class Guard {
 public:
  Guard(const Orders& orders, GuardMemory& memory)
      : orders_(orders), memory_(memory), writer_(orders) {}

  // Returns when the guard has nothing to guard any more.
  void run() {
    while (duty_ != Duty::kEnded) {
      const std::int64_t now_ns = monotonic_ns();
      memory_.guard_ns.store(now_ns, std::memory_order_release);
      wait_until(step(now_ns));
    }
    memory_.is_guard_alive.store(0, std::memory_order_release);
  }

 private:
  enum class Duty { kIdle, kWatch, kZero, kQuiet, kLast, kEnded };

  bool is_armed() const { return memory_.is_armed.load(std::memory_order_acquire) != 0; }
  std::uint64_t epoch() const { return memory_.trip_epoch.load(std::memory_order_relaxed); }
  bool is_acknowledged() const {
    return memory_.acknowledged_epoch.load(std::memory_order_acquire) == epoch();
  }

  // Does what is due now. Returns when to wake next.
  std::int64_t step(std::int64_t now_ns) {
    if (duty_ == Duty::kLast) return write_last_zeros(now_ns);
    if (!is_armed()) duty_ = Duty::kIdle;
    switch (duty_) {
      case Duty::kWatch:
        return watch(now_ns);
      case Duty::kZero:
        return write_zeros(now_ns);
      case Duty::kQuiet:
        return stay_quiet(now_ns);
      default:
        return now_ns + kGuardWakeNs;
    }
  }

  void begin_watch(std::int64_t now_ns) {
    duty_ = Duty::kWatch;
    since_ns_ = now_ns;
  }

  std::int64_t watch(std::int64_t now_ns) {
    const std::int64_t beat_ns = std::min(memory_.beat_ns.load(std::memory_order_acquire),
                                          memory_.tick_ns.load(std::memory_order_acquire));
    const std::int64_t stale_ns = std::max(since_ns_, beat_ns) + orders_.order.stale_ns;
    const std::int64_t suspect_ns = stale_ns - orders_.order.stale_ns / 5 * 4;
    const bool was_suspended = has_been_suspended();
    if (!was_suspended && now_ns < suspect_ns) return std::min(suspect_ns, now_ns + kGuardWakeNs);
    if (!was_suspended && now_ns < stale_ns && !has_driver_ended()) {
      return std::min(stale_ns, now_ns + kSuspectNs);
    }
    memory_.was_suspended.store(was_suspended ? 1 : 0, std::memory_order_release);
    memory_.trip_epoch.fetch_add(1, std::memory_order_acq_rel);
    return begin_zeros(now_ns);
  }

  // Once for each time that the machine was suspended. Its clock stood still meanwhile, so no
  // heartbeat is old; but the device has kept its force, or has lost its power and its set-up.
  bool has_been_suspended() {
    const std::int64_t ahead_ns = least_boot_ahead_ns();
    if (ahead_ns <= memory_.boot_ahead_ns.load(std::memory_order_acquire)) return false;
    memory_.boot_ahead_ns.store(most_boot_ahead_ns(), std::memory_order_release);
    return true;
  }

  bool has_driver_ended() const {
    const pid_t thread = memory_.driver_thread.load(std::memory_order_relaxed);
    return thread != 0 && tgkill(orders_.order.engine_pid, thread, 0) != 0 && errno == ESRCH;
  }

  std::int64_t begin_zeros(std::int64_t now_ns) {
    memory_.seen_epoch.store(0, std::memory_order_release);
    duty_ = Duty::kZero;
    final_zero_ = 0;
    writer_.drain_answers();
    writer_.restart();
    return write_zeros(now_ns);
  }

  std::int64_t write_zeros(std::int64_t now_ns) {
    if (final_zero_ == 0 && memory_.seen_epoch.load(std::memory_order_acquire) == epoch()) {
      final_zero_ = writer_.completed() + (writer_.is_cut() ? 2 : 1);
    }
    writer_.write_some();
    writer_.drain_answers();
    if (is_acknowledged()) {
      begin_watch(now_ns);
    } else if (final_zero_ != 0 && writer_.completed() >= final_zero_) {
      memory_.quiet_epoch.store(epoch(), std::memory_order_release);
      duty_ = Duty::kQuiet;
      since_ns_ = now_ns;
    }
    return now_ns + kZeroPeriodNs;
  }

  std::int64_t stay_quiet(std::int64_t now_ns) {
    if (is_acknowledged()) {
      begin_watch(now_ns);
      return now_ns;
    }
    const std::int64_t beat_ns = memory_.beat_ns.load(std::memory_order_acquire);
    if (now_ns < std::max(since_ns_, beat_ns) + orders_.order.stale_ns) {
      return now_ns + kZeroPeriodNs;
    }
    memory_.quiet_epoch.store(0, std::memory_order_release);
    return begin_zeros(now_ns);
  }

  // The engine is gone.
  void begin_last_zeros() {
    if (duty_ == Duty::kLast) return;
    is_one_zero_enough_ = !is_armed();
    duty_ = Duty::kLast;
    since_ns_ = monotonic_ns();
    memory_.trip_epoch.fetch_add(1, std::memory_order_acq_rel);
    final_zero_ = writer_.completed() + 1;
    writer_.restart();
  }

  std::int64_t write_last_zeros(std::int64_t now_ns) {
    writer_.write_some();
    writer_.drain_answers();
    if ((is_one_zero_enough_ && writer_.completed() >= final_zero_) ||
        now_ns >= since_ns_ + kLastZerosNs) {
      duty_ = Duty::kEnded;
      return now_ns;
    }
    return now_ns + kZeroPeriodNs;
  }

  void wait_until(std::int64_t wake_ns) {
    const bool is_last = duty_ == Duty::kLast;
    std::array<pollfd, 2> watched = {{{orders_.engine, POLLIN, 0}, {kGuardSocket, POLLIN, 0}}};
    const std::int64_t wait_ns = std::max<std::int64_t>(0, wake_ns - monotonic_ns());
    const timespec wait{wait_ns / kSecond_ns, wait_ns % kSecond_ns};
    if (duty_ == Duty::kEnded) return;
    if (ppoll(watched.data(), is_last ? 0 : watched.size(), &wait, nullptr) <= 0) return;
    if (watched[0].revents != 0) {
      begin_last_zeros();
    } else if (watched[1].revents != 0) {
      answer_bell();
    }
  }

  // The engine has armed, disarmed or closed its side of the socket.
  void answer_bell() {
    char bell = 0;
    const ssize_t size = recv(kGuardSocket, &bell, 1, MSG_DONTWAIT);
    if (size < 0 && (errno == EAGAIN || errno == EINTR)) return;
    if (size != 1) {
      leave_engine();
      return;
    }
    ignore_signals(is_armed());
    if (!is_armed()) {
      duty_ = Duty::kIdle;
    } else if (duty_ == Duty::kIdle) {
      begin_watch(monotonic_ns());
    }
    memory_.guard_ns.store(monotonic_ns(), std::memory_order_release);
    send(kGuardSocket, &bell, 1, MSG_DONTWAIT | MSG_NOSIGNAL);
  }

  // The socket closes when the engine does not need the guard any more, and also shortly before the
  // engine's end is reported. An engine that is not armed and goes on keeps its device.
  void leave_engine() {
    pollfd engine{orders_.engine, POLLIN, 0};
    if (is_armed() || poll(&engine, 1, 100) > 0) {
      begin_last_zeros();
    } else {
      duty_ = Duty::kEnded;
    }
  }

  const Orders& orders_;
  GuardMemory& memory_;
  ZeroWriter writer_;
  Duty duty_ = Duty::kIdle;
  std::int64_t since_ns_ = 0;     // when the duty began
  std::uint64_t final_zero_ = 0;  // the duty ends with this zero; 0: not yet known
  bool is_one_zero_enough_ = false;
};

// Receives the orders. Returns the problem, or null.
const char* receive(Orders& orders) {
  std::array<int, 3> descriptors = {-1, -1, -1};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof descriptors)> control = {};
  iovec part{&orders.order, sizeof orders.order};
  msghdr message = {};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  const ssize_t size = recvmsg(kGuardSocket, &message, MSG_CMSG_CLOEXEC);
  if (size < 0) return "descriptor 3 is no socket of an engine: an engine starts this program";
  const GuardOrder& order = orders.order;
  if (size != sizeof order || order.magic != kGuardMagic || order.version != kGuardVersion) {
    return "the guard is of another build than the engine; build both again";
  }
  if (order.stale_ns <= 0 || order.zero_count == 0 || order.zero_count > order.zero_bytes.size()) {
    return "the limits or the bytes of zero force are out of range";
  }
  const cmsghdr* header = CMSG_FIRSTHDR(&message);
  if (header == nullptr || header->cmsg_type != SCM_RIGHTS ||
      header->cmsg_len != CMSG_LEN(sizeof descriptors)) {
    return "the engine sent no three descriptors; the limit of open files may be too low";
  }
  std::memcpy(descriptors.data(), CMSG_DATA(header), sizeof descriptors);
  orders.device = descriptors[0];
  orders.memory = descriptors[1];
  orders.engine = descriptors[2];
  return nullptr;
}

// Maps the shared memory, which must not shrink: an access beyond its end would kill the guard.
GuardMemory* map_memory(int descriptor) {
  struct stat facts = {};
  const int seals = fcntl(descriptor, F_GET_SEALS);
  if (seals < 0 || (seals & F_SEAL_SHRINK) == 0) return nullptr;
  if (fstat(descriptor, &facts) != 0 || facts.st_size < std::int64_t{sizeof(GuardMemory)}) {
    return nullptr;
  }
  void* memory =
      mmap(nullptr, sizeof(GuardMemory), PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
  if (memory == MAP_FAILED) return nullptr;
  auto* shared = static_cast<GuardMemory*>(memory);
  const bool is_ours = shared->magic == kGuardMagic && shared->version == kGuardVersion;
  return is_ours ? shared : nullptr;
}

// Leaves the scheduling of the thread that started the guard, and asks for the guard's own.
void set_scheduling(GuardWord& word) {
  const sched_param ordinary{};
  sched_setscheduler(0, SCHED_OTHER, &ordinary);
  cpu_set_t all;
  CPU_ZERO(&all);
  for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) CPU_SET(cpu, &all);
  sched_setaffinity(0, sizeof all, &all);
  const sched_param fifo{kGuardPriority};
  word.fifo_error = sched_setscheduler(0, SCHED_FIFO, &fifo) == 0 ? 0 : errno;
  word.lock_error = mlockall(MCL_CURRENT) == 0 ? 0 : errno;
}

bool send_word(const GuardWord& word) {
  return send(kGuardSocket, &word, sizeof word, MSG_NOSIGNAL) == sizeof word;
}

int run_guard() {
  std::signal(SIGPIPE, SIG_IGN);
  static Orders orders;
  GuardWord word;
  const char* problem = receive(orders);
  GuardMemory* memory = problem == nullptr ? map_memory(orders.memory) : nullptr;
  if (problem == nullptr && memory == nullptr) problem = "the shared memory is not a sealed one";
  if (problem != nullptr) {
    std::strncpy(word.problem.data(), problem, word.problem.size() - 1);
    if (!send_word(word)) std::fprintf(stderr, "palpate-guard: %s\n", problem);
    return 2;
  }
  set_scheduling(word);
  memory->guard_pid.store(getpid(), std::memory_order_relaxed);
  memory->guard_ns.store(monotonic_ns(), std::memory_order_relaxed);
  memory->is_guard_alive.store(1, std::memory_order_release);
  if (!send_word(word)) return 2;
  Guard(orders, *memory).run();
  return 0;
}

}  // namespace
}  // namespace palpate

int main() {
  return palpate::run_guard();
}
