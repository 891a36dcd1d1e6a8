// A simulated hAPI board for tests in other languages: the board, a pantograph and a hand behind a
// pseudo-terminal, in real time.
//
// Prints {"port": PATH}, then answers each line of stdin, a JSON object, with one line:
//   {"hand_m": [x, y]}   the place to which the hand pulls the tip; x and y as below
//   {"silence_ms": n}    the board does not answer for this time
//   {"hang_up": true}    the cable is pulled out
//   {"read": true}       nothing but the answer
// The answer is {"now_ns": t, "commands": n, "tip_m": [x, y], "last_force_ns": t, "zero_ns": t}:
// what the board has taken until now, with the tip at the newest command (null: none came), when
// the last command with a force came (null: none did), and when the first one without a force came
// after it (null: the board still holds the force). Places are in the frame of the linkage, times
// are CLOCK_MONOTONIC. It ends with stdin.

#include <algorithm>
#include <cmath>
#include <iostream>
#include <iterator>
#include <string>

#include <nlohmann/json.hpp>

#include "engine/simulation/board_terminal.h"

namespace palpate::test {
namespace {

using Json = nlohmann::json;

bool has_force(const BoardCommand& command) {
  // The host writes a torque of zero as a tiny number (HapiLink).
  return std::any_of(command.torques.begin(), command.torques.end(),
                     [](float torque) { return std::abs(torque) >= 0x1p-119f; });
}

void obey(BoardTerminal& board, const Json& order) {
  if (order.contains("hand_m")) board.set_hand(Vec2(order["hand_m"][0], order["hand_m"][1]));
  if (order.contains("hang_up")) board.hang_up();
  if (order.contains("silence_ms")) {
    BoardFault silence;
    silence.from_ns = BoardTerminal::now_ns();
    silence.until_ns = silence.from_ns + 1'000'000 * order["silence_ms"].get<std::int64_t>();
    board.add_fault(silence);
  }
}

Json report(const BoardTerminal& board) {
  const auto log = board.log();
  const auto last = std::find_if(log.rbegin(), log.rend(), has_force);
  Json json = {{"now_ns", BoardTerminal::now_ns()},
               {"commands", board.commands()},
               {"tip_m", nullptr},
               {"last_force_ns", nullptr},
               {"zero_ns", nullptr}};
  if (!log.empty()) json["tip_m"] = {log.back().tip_m.x(), log.back().tip_m.y()};
  if (last != log.rend()) json["last_force_ns"] = last->time_ns;
  if (last != log.rend() && last != log.rbegin()) json["zero_ns"] = std::prev(last)->time_ns;
  return json;
}

int serve() {
  BoardSettings settings;
  settings.kept_commands = 2000;  // of the last two seconds
  auto board = BoardTerminal::open(settings);
  if (!board) {
    std::cerr << board.error().to_string() << "\n";
    return 2;
  }
  std::cout << Json{{"port", (*board)->path()}} << std::endl;
  for (std::string line; std::getline(std::cin, line);) {
    obey(**board, Json::parse(line));
    std::cout << report(**board) << std::endl;
  }
  return 0;
}

}  // namespace
}  // namespace palpate::test

int main() {
  return palpate::test::serve();
}
