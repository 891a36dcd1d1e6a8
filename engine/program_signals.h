#pragma once

// What Ctrl-C (SIGINT) and SIGTERM do. They belong to the program: the library leaves signals
// alone.

#include <cstdint>

#include "engine/stop_flag.h"

namespace palpate {

enum class SignalPhase : std::uint8_t {
  kAtOnce,   // either signal ends the program, with exit code 128 + signal
  kInOrder,  // the first one sets signal_flag(), the second ends the program
  kDeferred  // signals set signal_flag(), for moments that must not be cut in two
};

// Once, at the start of the program: kAtOnce from here on. Either signal is taken even if the
// program was started with it ignored, as shells do with what runs in the background. A write
// beyond the limit of file sizes fails and no longer ends the program.
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
