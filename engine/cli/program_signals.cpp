#include "engine/cli/program_signals.h"

#include <atomic>
#include <csignal>
#include <string_view>
#include <unistd.h>

namespace palpate {
namespace {

// State that the handler shares with the program: lock-free atomics only.
std::atomic<SignalPhase> phase{SignalPhase::kAtOnce};
std::atomic<int> first_signal{0};
StopFlag flag;
static_assert(std::atomic<SignalPhase>::is_always_lock_free);
static_assert(std::atomic<int>::is_always_lock_free);

constexpr int kSignalBase = 128;  // shells add the signal's number to it

bool has_terminal = false;  // on stderr: a progress bar may have left the cursor in its line

void say(std::string_view text) {
  [[maybe_unused]] const auto ignored = ::write(STDERR_FILENO, text.data(), text.size());
}

// Only calls that signal-safety(7) allows.
void on_signal(int signal) {
  int none = 0;
  const bool is_first = first_signal.compare_exchange_strong(none, signal);
  const SignalPhase now = phase.load();
  if (now == SignalPhase::kDeferred || (now == SignalPhase::kInOrder && is_first)) {
    flag.request();
    return;
  }
  say(has_terminal ? "\npalpate: interrupted\n" : "palpate: interrupted\n");
  ::_exit(kSignalBase + signal);
}

bool is_ignored(int signal) {
  struct sigaction now = {};
  return ::sigaction(signal, nullptr, &now) == 0 && now.sa_handler == SIG_IGN;
}

}  // namespace

void install_signal_handlers() {
  has_terminal = ::isatty(STDERR_FILENO) != 0;
  struct sigaction action = {};
  action.sa_handler = on_signal;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  for (const int signal : kEndingSignals) sigaddset(&action.sa_mask, signal);
  for (const int signal : kEndingSignals) {
    if (signal == SIGHUP && is_ignored(signal)) continue;
    ::sigaction(signal, &action, nullptr);
  }
  std::signal(SIGXFSZ, SIG_IGN);
}

SignalPhaseScope::SignalPhaseScope(SignalPhase phase_now) : before_(phase.exchange(phase_now)) {}

SignalPhaseScope::~SignalPhaseScope() {
  phase.store(before_);
}

const StopFlag& signal_flag() {
  return flag;
}

int exit_code_after_signals(int code) {
  const int signal = first_signal.load();
  return signal == 0 ? code : kSignalBase + signal;
}

}  // namespace palpate
