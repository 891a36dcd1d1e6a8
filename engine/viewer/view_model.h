#pragma once

// What the server of `view` shows and changes.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/viewer/messages.h"
#include "engine/viewer/page_request.h"
#include "engine/viewer/tick_summary.h"

namespace palpate {

// What a page may do, by the place of its token among those of the server. kMainPage may take
// control; other roles watch, and what they may ask for is the model's matter.
using PageRole = std::size_t;
inline constexpr PageRole kMainPage = 0;

// Unless a comment says otherwise, the network thread calls these functions. They must not wait for
// the haptic thread.
class ViewModel {
 public:
  virtual ~ViewModel() = default;

  // Copies the newest state. Returns false if there is none yet.
  virtual bool newest(ViewState& state, std::vector<BodyPose>& bodies) = 0;
  // Appends the ticks since the last call to `rows`. Returns the number of ticks that were lost.
  virtual std::uint64_t take_ticks(std::vector<TickSummary>& rows) = 0;
  // The nominal rate of ticks.
  virtual double rate_Hz() const = 0;

  // JSON objects in one line, with a "type". The server appends "control" to both. clients: the
  // number of pages, of all roles.
  virtual std::string hello(PageRole role) = 0;
  virtual std::string status(PageRole role, std::size_t clients) = 0;
  // Whether pages of this role get the states and the ticks (messages.h).
  virtual bool shows_states(PageRole) const { return true; }
  virtual bool shows_ticks(PageRole) const { return true; }
  // What happened since the last call, such as a trip.
  struct Event {
    std::string kind;
    std::string text;
  };
  virtual std::optional<Event> take_event() = 0;

  // The page in control moves the hand, or lets go.
  virtual void point(const PointerMessage& message) = 0;
  virtual void let_go() = 0;
  // A model with messages of its own takes every text of a page but tokens and kTakeControl: its
  // answer, a JSON object in one line or no text; no value: the server reads the text as a
  // PageRequest.
  virtual std::optional<std::string> take_message(PageRole, bool /*is_in_control*/,
                                                  std::string_view /*text*/) {
    return std::nullopt;
  }
  // A JSON object in one line for the pages of a role. The server asks 60 times a second, and again
  // until there is no value.
  struct PageText {
    PageRole role;
    std::string text;
  };
  virtual std::optional<PageText> take_text() { return std::nullopt; }
  // Carry out kSet, kRearm, kPause, kStart or kStay. Returns one line if that is refused.
  virtual std::optional<std::string> carry_out(const PageRequest& request) = 0;

  // The bytes of /felt.glb, never null. Called on a thread that may wait; thread-safe.
  virtual std::shared_ptr<const std::string> scene_bytes(bool full) = 0;
};

}  // namespace palpate
