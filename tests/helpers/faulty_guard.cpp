// Part of a palpate-guard that something happens to at one step of its life. The linker leads its
// calls of the C library through the functions below (--wrap).
//
// PALPATE_GUARD_STEP says what and when: "send 2 before kill". The calls of recvmsg, mlockall,
// send, recv and ppoll are counted from 1. What happens:
//   kill     SIGKILL
//   stop     SIGSTOP
//   suspend  the machine seems to have been suspended for a second: CLOCK_BOOTTIME jumps
// Just before, it writes "PID TIME" into the file PALPATE_GUARD_HIT: its process, and the time on
// CLOCK_MONOTONIC in ns.

#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

extern "C" {
ssize_t __real_recvmsg(int socket, msghdr* message, int flags);
int __real_mlockall(int flags);
ssize_t __real_send(int socket, const void* content, size_t size, int flags);
ssize_t __real_recv(int socket, void* content, size_t size, int flags);
int __real_ppoll(pollfd* watched, nfds_t count, const timespec* time, const sigset_t* mask);
int __real_clock_gettime(clockid_t clock, timespec* time);
}

namespace {

constexpr long long kNsPerSecond = 1'000'000'000;

struct GuardFault {
  std::array<char, 16> call = {};
  int count = 0;
  std::array<char, 8> side = {};
  std::array<char, 8> what = {};
};

GuardFault wanted_fault() {
  GuardFault fault;
  const char* text = std::getenv("PALPATE_GUARD_STEP");
  if (text != nullptr) {
    std::sscanf(text, "%15s %d %7s %7s", fault.call.data(), &fault.count, fault.side.data(),
                fault.what.data());
  }
  return fault;
}

bool seems_suspended = false;

void hit(const char* what) {
  timespec now;
  __real_clock_gettime(CLOCK_MONOTONIC, &now);
  const char* path = std::getenv("PALPATE_GUARD_HIT");
  const int file = path == nullptr ? -1 : ::open(path, O_CREAT | O_WRONLY | O_CLOEXEC, 0600);
  if (file >= 0) {
    ::dprintf(file, "%d %lld\n", ::getpid(), now.tv_sec * kNsPerSecond + now.tv_nsec);
    ::close(file);
  }
  if (std::strcmp(what, "kill") == 0) ::kill(::getpid(), SIGKILL);
  if (std::strcmp(what, "stop") == 0) ::kill(::getpid(), SIGSTOP);
  if (std::strcmp(what, "suspend") == 0) seems_suspended = true;
}

// One of the calls of a function.
class Step {
 public:
  Step(const char* call, int count) {
    static const GuardFault fault = wanted_fault();
    if (count != fault.count || std::strcmp(call, fault.call.data()) != 0) return;
    fault_ = &fault;
    on("before");
  }
  ~Step() { on("after"); }
  Step(const Step&) = delete;
  Step& operator=(const Step&) = delete;

 private:
  void on(const char* side) const {
    if (fault_ != nullptr && std::strcmp(fault_->side.data(), side) == 0) hit(fault_->what.data());
  }
  const GuardFault* fault_ = nullptr;
};

}  // namespace

extern "C" {

ssize_t __wrap_recvmsg(int socket, msghdr* message, int flags) {
  static int count = 0;
  const Step step("recvmsg", ++count);
  return __real_recvmsg(socket, message, flags);
}

int __wrap_mlockall(int flags) {
  static int count = 0;
  const Step step("mlockall", ++count);
  return __real_mlockall(flags);
}

ssize_t __wrap_send(int socket, const void* content, size_t size, int flags) {
  static int count = 0;
  const Step step("send", ++count);
  return __real_send(socket, content, size, flags);
}

ssize_t __wrap_recv(int socket, void* content, size_t size, int flags) {
  static int count = 0;
  const Step step("recv", ++count);
  return __real_recv(socket, content, size, flags);
}

int __wrap_ppoll(pollfd* watched, nfds_t count, const timespec* time, const sigset_t* mask) {
  static int calls = 0;
  const Step step("ppoll", ++calls);
  return __real_ppoll(watched, count, time, mask);
}

int __wrap_clock_gettime(clockid_t clock, timespec* time) {
  const int result = __real_clock_gettime(clock, time);
  if (clock == CLOCK_BOOTTIME && seems_suspended) ++time->tv_sec;
  return result;
}

}  // extern "C"
