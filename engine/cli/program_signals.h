#pragma once

// What Ctrl-C (SIGINT), SIGTERM and a terminal that is closed (SIGHUP) do. They belong to the
// program: the library leaves signals alone.

#include <array>
#include <csignal>
#include <cstdint>

#include "engine/session/stop_flag.h"

namespace palpate {

inline constexpr std::array kEndingSignals = {SIGINT, SIGTERM, SIGHUP};

enum class SignalPhase : std::uint8_t {
  kAtOnce,   // each signal ends the program, with exit code 128 + signal
  kInOrder,  // the first one sets signal_flag(), the second ends the program
  kDeferred  // signals set signal_flag(), for moments that must not be cut in two
};

// Once, at the start of the program: kAtOnce from here on. SIGINT and SIGTERM are taken even if the
// program was started with them ignored, as shells do with what runs in the background; SIGHUP is
// then left ignored, as nohup wants it. A write beyond the limit of file sizes fails and no longer
// ends the program.
void take_signals();

// The phase while this lives; then that of before.
class SignalPhaseScope {
 public:
  explicit SignalPhaseScope(SignalPhase phase);
  ~SignalPhaseScope();
  SignalPhaseScope(const SignalPhaseScope&) = delete;
  SignalPhaseScope& operator=(const SignalPhaseScope&) = delete;

 private:
  SignalPhase before_;
};

const StopFlag& signal_flag();

// 128 + the first signal if one has come, else `code`.
int exit_code_after_signals(int code);

}  // namespace palpate
