#pragma once

// A simulated hAPI board behind a pseudo-terminal, in real time.

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "engine/simulation/hapi_board.h"
#include "geometry/base/result.h"

namespace palpate {

// Runs the board on a thread of its own. Any thread may call any function.
class BoardTerminal {
 public:
  static Result<std::unique_ptr<BoardTerminal>> open(const BoardSettings& settings);
  ~BoardTerminal();
  BoardTerminal(const BoardTerminal&) = delete;
  BoardTerminal& operator=(const BoardTerminal&) = delete;

  // The port, for example /dev/pts/3.
  const std::string& path() const { return path_; }
  // The board's clock, which is std::chrono::steady_clock.
  static std::int64_t now_ns();
  void add_fault(const BoardFault& fault);
  // The place to which the simulated hand pulls the tip, in the frame of FiveBar.
  void set_hand(const Vec2& hand_m);
  // Closes the terminal, as if the cable was pulled out.
  void hang_up();

  std::vector<BoardCommand> log() const;
  std::uint64_t commands() const;
  std::uint64_t set_ups() const;
  // The plant's account and what its probes have found (PantographSettings::hand_probes).
  PortAccount account() const;
  ProbeResult probes() const;

 private:
  BoardTerminal(int descriptor, std::string path, const BoardSettings& settings);
  void run();
  bool serve();

  int descriptor_;
  std::string path_;
  mutable std::mutex mutex_;  // of board_
  HapiBoard board_;
  std::vector<std::uint8_t> unwritten_;
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

}  // namespace palpate
