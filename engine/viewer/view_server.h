#pragma once

// The server of `view`: HTTP and WebSocket, on one thread.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/viewer/http_rules.h"
#include "engine/viewer/page_files.h"
#include "engine/viewer/token.h"
#include "engine/viewer/view_model.h"
#include "geometry/base/result.h"

namespace palpate {

struct ServerSettings {
  std::string address = "127.0.0.1";  // an IP address of this machine
  std::uint16_t port = 0;             // 0: the system chooses a free one
  AllowedNames allowed = {};
  std::size_t roles = 1;  // of pages; each has a token
};

// What a client may use. Constants, so that nobody can raise them by accident.
struct ServerLimits {
  static constexpr std::size_t kHeaderBytes = 8 * 1024;
  static constexpr std::size_t kMessageBytes = 64 * 1024;  // from a client, all its fragments
  static constexpr std::size_t kTokenBytes = 1024;         // the first message
  // A client that has sent this much since its last whole message, pings and empty fragments
  // included, is closed.
  static constexpr std::size_t kUnfinishedBytes = 2 * kMessageBytes;
  // Of each kind of connection without a token (ConnectionKind). Fewer if the process may not open
  // that many files.
  static constexpr std::size_t kStrangers = 1024;
  static constexpr std::size_t kTrustedAnswers = 32;
  static constexpr std::size_t kClients = 8;       // pages with the token
  static constexpr std::size_t kQueuedTexts = 64;  // answers and events that a client has not read
  static constexpr int kHandshake_s = 5;
  static constexpr int kToken_s = 2;
  static constexpr int kAnswer_s = 60;  // for an HTTP answer to be read
  static constexpr int kLinger_s = 1;   // for the client to end after an answer
  static constexpr int kIdle_s = 15;    // without a byte, answers to pings included
};

// Serves the page, the scene and the live connection (http_rules.h, messages.h, page_request.h). A
// slow client delays neither another client nor the model: each has one message in flight, and the
// newest state follows it. The first client with the token of kMainPage controls the model, until
// another one takes over, or it leaves; then the one that has been there longest controls it.
//
// Connections without the token never keep one with the token out (ConnectionPlaces): for a new
// one, the oldest of them is dropped.
//
// The owner's thread calls the functions here. The model's functions are called on the network
// thread.
class ViewServer {
 public:
  // model and page must outlive the server. Errors: the address is not one of this machine; the
  // port is taken, or not permitted.
  static Result<std::unique_ptr<ViewServer>> listen(const ServerSettings& settings,
                                                    const PageFiles& page, ViewModel& model);
  // One line if this process may open fewer files than a server needs.
  static std::optional<std::string> files_problem();
  ~ViewServer();  // calls stop()
  ViewServer(const ViewServer&) = delete;
  ViewServer& operator=(const ViewServer&) = delete;

  std::uint16_t port() const;
  const Token& token(PageRole role = kMainPage) const;
  // Starts the network thread. Call it once.
  void start();
  // Tells the clients that the server ends, closes all connections and ends the thread. Waits less
  // than a second for clients that do not answer.
  void stop();

 private:
  class Network;
  explicit ViewServer(std::unique_ptr<Network> network);

  std::unique_ptr<Network> network_;
};

}  // namespace palpate
