#pragma once

// Reaction to Ctrl-C (SIGINT), SIGTERM and a closed terminal (SIGHUP). Only the program handles
// signals; the library does not.

#include <array>
#include <csignal>
#include <cstdint>

#include "engine/session/stop_flag.h"

namespace palpate {

inline constexpr std::array kEndingSignals = {SIGINT, SIGTERM, SIGHUP};

enum class SignalPhase : std::uint8_t {
  kAtOnce,   // each signal ends the program, with exit code 128 + signal
  kInOrder,  // the first signal sets signal_flag(), the second one ends the program
  kDeferred  // every signal sets signal_flag(), for steps that must not be interrupted
};

// Call this function once, at the start of the program; the phase is then kAtOnce. SIGINT and
// SIGTERM are handled even if they are ignored at the start, as in background jobs of shells. A
// SIGHUP that is ignored at the start stays ignored, as nohup requires. After the call, a write
// beyond the file size limit fails, but does not end the program.
void install_signal_handlers();

// Sets the phase for the lifetime of this object; the destructor restores the previous phase.
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

// Returns 128 + the number of the first signal if a signal arrived, otherwise `code`.
int exit_code_after_signals(int code);

}  // namespace palpate
