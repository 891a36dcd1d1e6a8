#include "engine/viewer/view_server.h"

#include <algorithm>
#include <boost/asio/ip/address.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/thread_pool.hpp>
#include <chrono>
#include <deque>
#include <functional>
#include <optional>
#include <pthread.h>
#include <sys/resource.h>
#include <thread>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/viewer/compressed.h"
#include "engine/viewer/http_connection.h"
#include "engine/viewer/live_client.h"

namespace palpate {
namespace {

using Clock = std::chrono::steady_clock;
using Json = nlohmann::ordered_json;

constexpr auto kFrame = std::chrono::microseconds(16'667);
constexpr auto kCheckEvery = std::chrono::milliseconds(250);
// While a pointer message waits for its tick, the newest state is read this often, and not longer
// than this; then the next frame answers.
constexpr auto kLookEvery = std::chrono::microseconds(250);
constexpr auto kLookFor = std::chrono::milliseconds(20);
constexpr auto kPatienceAtStop = std::chrono::milliseconds(700);
constexpr std::size_t kKeptTicks = 16384;  // for clients that are late
constexpr auto kRetryAccept = std::chrono::milliseconds(100);
// While strangers crowd, so many connections at most are accepted in this time, 16,000 a second: a
// stranger has its place for at least kStrangers / 16,000 s, time for a request that follows its
// connection, and a page waits for the crowd before it for less than a third of a second. The
// crowd costs this thread a part of its time.
constexpr auto kAcceptWhenFull = std::chrono::microseconds(500);
constexpr int kAcceptedAtOnce = 8;
// Files that the rest of the process may need while it serves, among them those of the pages.
constexpr rlim_t kOtherFiles = 128;
constexpr std::size_t kFewestStrangers = 8;

constexpr std::uint16_t kGoingAway = 1001;
constexpr std::uint16_t kPolicy = 1008;
constexpr std::uint16_t kTryAgainLater = 1013;
constexpr std::uint16_t kWrongToken = 4401;

std::string line_of(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string event_text(const char* kind, const std::string& text) {
  return line_of({{"type", "event"}, {"kind", kind}, {"text", text}});
}

// A JSON object in one line, with one more member.
std::string with_control(std::string object, bool in_control) {
  object.pop_back();
  return object + ",\"control\":" + (in_control ? "true}" : "false}");
}

bool may_control(const LiveClient& client) {
  return client.has_token && client.role == kMainPage;
}

// How many connections of each of two kinds may be open.
std::size_t most_strangers() {
  rlimit files{};
  if (::getrlimit(RLIMIT_NOFILE, &files) != 0) return kFewestStrangers;
  const rlim_t left = files.rlim_cur - std::min(files.rlim_cur, kOtherFiles);
  return static_cast<std::size_t>(
      std::clamp<rlim_t>(left / 2, kFewestStrangers, ServerLimits::kStrangers));
}

Error listen_error(const ServerSettings& settings, const boost::system::error_code& error) {
  namespace errc = boost::system::errc;
  const std::string port = std::to_string(settings.port);
  if (error == errc::address_in_use) {
    return invalid_argument("port", "is " + port + ", which is taken; expected a free port",
                            "choose another one, or 0 for any");
  }
  if (error == errc::permission_denied) {
    return invalid_argument("port", "is " + port + ", which only root may use",
                            "choose one from 1024 on, or 0 for any");
  }
  return invalid_argument("listen", "is \"" + settings.address + "\": " + error.message() +
                                        "; expected an IP address of this machine");
}

}  // namespace

class ViewServer::Network final : public HttpHost, public LiveHost {
 public:
  Network(const ServerSettings& settings, const PageFiles& page, ViewModel& model);
  ~Network() override { stop(); }

  std::optional<Error> listen();
  void start();
  void stop();
  std::uint16_t port() const { return port_; }
  const Token& token(PageRole role) const { return tokens_[role]; }

  HttpVerdict judge(const HttpHead& head) override;
  const std::vector<WebOrigin>& origins() const override { return settings_.allowed.origins; }
  ConnectionPlaces::Place take_place(ConnectionKind kind, std::function<void()> drop) override;
  void find(Resource resource, bool accepts_gzip, std::function<void(HttpContent)> answer) override;
  LiveHost& live_host() override { return *this; }

  void on_open(const std::shared_ptr<LiveClient>& client) override;
  void on_message(LiveClient& client, std::string_view bytes, bool is_text) override;
  void on_closing(LiveClient& client) override;
  void on_end(LiveClient& client) override;
  bool encode_state(LiveClient& client, std::string& out) override;
  bool encode_ticks(LiveClient& client, std::string& out) override;

 private:
  struct PageFile {
    std::string_view plain;
    std::string gzip;
    std::string type;
  };

  using Socket = net::basic_stream_socket<net::ip::tcp, Executor>;

  void accept();
  void accept_waiting(Socket first);
  void accept_after(Clock::duration time);
  bool drop_stranger();
  void admit(LiveClient& client);
  void carry_out(LiveClient& client, const PageRequest& request);
  void point(LiveClient& client, std::string_view bytes);
  void give_control(LiveClient& client);
  void pass_control();
  void take_control(LiveClient& client, const std::string& why);
  void answer(LiveClient& client, std::optional<std::uint64_t> id,
              const std::optional<std::string>& problem);
  void frame();
  void check();
  void look();
  void take_ticks();
  void send_texts();
  void close_all();
  std::size_t admitted() const;
  const PageFile& page_file(Resource resource) const;

  ServerSettings settings_;
  ViewModel& model_;
  std::vector<Token> tokens_;  // by PageRole
  std::uint16_t port_ = 0;
  PageFile html_, script_, style_, icon_;

  // They outlive the connections, which the handlers in context_ own.
  ConnectionPlaces silent_{0};
  ConnectionPlaces asking_{0};
  ConnectionPlaces trusted_{ServerLimits::kTrustedAnswers};

  net::io_context context_{1};
  Acceptor acceptor_{context_};
  Timer frame_timer_{context_};
  Timer check_timer_{context_};
  Timer look_timer_{context_};
  Timer accept_timer_{context_};
  Timer stop_timer_{context_};
  net::thread_pool encoder_{1};  // for scenes that take long to encode
  std::thread thread_;
  bool is_stopping_ = false;

  std::vector<std::shared_ptr<LiveClient>> clients_;  // with and without token
  LiveClient* in_control_ = nullptr;
  Clock::time_point next_frame_;
  Clock::time_point look_until_;
  bool is_looking_ = false;

  std::deque<TickSummary> ticks_;  // the newest
  std::uint64_t first_tick_ = 0;   // number of ticks_.front()
  std::vector<TickSummary> taken_;
  ViewState state_;
  std::vector<BodyPose> bodies_;
};

ViewServer::Network::Network(const ServerSettings& settings, const PageFiles& page,
                             ViewModel& model)
    : settings_(settings),
      model_(model),
      html_{page.html, gzip_compressed(page.html), "text/html; charset=utf-8"},
      script_{page.script, gzip_compressed(page.script), "text/javascript; charset=utf-8"},
      style_{page.style, gzip_compressed(page.style), "text/css; charset=utf-8"},
      icon_{page.icon, gzip_compressed(page.icon), "image/svg+xml"} {
  for (std::size_t role = 0; role < settings.roles; ++role) tokens_.push_back(Token::make());
  silent_.set_most(most_strangers());
  asking_.set_most(most_strangers());
}

std::optional<Error> ViewServer::Network::listen() {
  boost::system::error_code error;
  const auto address = net::ip::make_address(settings_.address, error);
  if (error) {
    return invalid_argument(
        "listen", "is \"" + settings_.address + "\"; expected an IP address of this machine");
  }
  const net::ip::tcp::endpoint endpoint(address, settings_.port);
  acceptor_.open(endpoint.protocol(), error);
  // A server that has just ended leaves its port reserved for a minute otherwise.
  if (!error) acceptor_.set_option(net::socket_base::reuse_address(true), error);
  if (!error) acceptor_.bind(endpoint, error);
  if (!error) acceptor_.non_blocking(true, error);  // of accept(): see accept_waiting()
  if (!error) acceptor_.listen(net::socket_base::max_listen_connections, error);
  if (error) return listen_error(settings_, error);
  port_ = acceptor_.local_endpoint(error).port();
  return std::nullopt;
}

void ViewServer::Network::start() {
  accept();
  next_frame_ = Clock::now();
  frame();
  check();
  thread_ = std::thread([this] { context_.run(); });
  ::pthread_setname_np(thread_.native_handle(), "palpate-network");  // as top and ps show it
}

void ViewServer::Network::stop() {
  if (!thread_.joinable()) return;
  net::post(context_, [this] { close_all(); });
  thread_.join();
  encoder_.join();
  clients_.clear();
}

// The timers end when is_stopping_ is set; the thread ends when the last connection has ended, or
// after kPatienceAtStop.
void ViewServer::Network::close_all() {
  is_stopping_ = true;
  boost::system::error_code ignored;
  acceptor_.close(ignored);
  for (Timer* timer : {&frame_timer_, &check_timer_, &look_timer_, &accept_timer_}) timer->cancel();
  const auto clients = clients_;  // an end changes the list
  for (const auto& client : clients) {
    if (client->has_token) client->send(event_text("end", "the server ends"));
    client->close(kGoingAway, "the server ends");
  }
  stop_timer_.expires_after(kPatienceAtStop);
  stop_timer_.async_wait([this](boost::system::error_code) { context_.stop(); });
  if (clients_.empty()) stop_timer_.cancel();
}

void ViewServer::Network::accept() {
  acceptor_.async_accept([this](boost::system::error_code error, Socket socket) {
    if (is_stopping_) return;
    if (error) return accept_after(drop_stranger() ? kAcceptWhenFull : kRetryAccept);
    accept_waiting(std::move(socket));
  });
}

// Takes those that wait behind the first one, too, up to kAcceptedAtOnce.
void ViewServer::Network::accept_waiting(Socket first) {
  bool was_full = false;
  boost::system::error_code error;
  Socket socket = std::move(first);
  for (int accepted = 1;; ++accepted) {
    was_full = was_full || silent_.is_full();
    std::make_shared<HttpConnection>(Stream(std::move(socket)), *this)->read();
    if (accepted == kAcceptedAtOnce) break;
    socket = acceptor_.accept(error);
    // For example too many open files, which a stranger's end makes fewer.
    if (error) break;
  }
  const bool waits_for_more = !error || error == net::error::would_block;
  if (!waits_for_more && !drop_stranger()) return accept_after(kRetryAccept);
  if (was_full || !waits_for_more) return accept_after(kAcceptWhenFull);
  accept();
}

void ViewServer::Network::accept_after(Clock::duration time) {
  accept_timer_.expires_after(time);
  accept_timer_.async_wait([this](boost::system::error_code) {
    if (!is_stopping_) accept();
  });
}

bool ViewServer::Network::drop_stranger() {
  return silent_.drop_oldest() || asking_.drop_oldest();
}

ConnectionPlaces::Place ViewServer::Network::take_place(ConnectionKind kind,
                                                        std::function<void()> drop) {
  ConnectionPlaces& places = kind == ConnectionKind::kSilent   ? silent_
                             : kind == ConnectionKind::kAsking ? asking_
                                                               : trusted_;
  return places.take(std::move(drop));
}

HttpVerdict ViewServer::Network::judge(const HttpHead& head) {
  return palpate::judge(head, tokens_, settings_.allowed);
}

const ViewServer::Network::PageFile& ViewServer::Network::page_file(Resource resource) const {
  if (resource == Resource::kScript) return script_;
  if (resource == Resource::kIcon) return icon_;
  return resource == Resource::kStyle ? style_ : html_;
}

void ViewServer::Network::find(Resource resource, bool accepts_gzip,
                               std::function<void(HttpContent)> answer) {
  const bool is_full = resource == Resource::kFullScene;
  if (resource != Resource::kScene && !is_full) {
    const PageFile& file = page_file(resource);
    return answer({accepts_gzip ? std::string_view(file.gzip) : file.plain, file.type, accepts_gzip,
                   nullptr});
  }
  net::post(encoder_, [this, is_full, answer = std::move(answer)]() mutable {
    auto bytes = model_.scene_bytes(is_full);
    net::post(context_, [bytes = std::move(bytes), answer = std::move(answer)] {
      answer({*bytes, "model/gltf-binary", false, bytes});
    });
  });
}

void ViewServer::Network::on_open(const std::shared_ptr<LiveClient>& client) {
  if (is_stopping_) return client->close(kGoingAway, "the server ends");
  clients_.push_back(client);
}

void ViewServer::Network::on_closing(LiveClient& client) {
  if (in_control_ == &client) pass_control();
}

void ViewServer::Network::on_end(LiveClient& client) {
  std::erase_if(clients_, [&](const auto& c) { return c.get() == &client; });
  if (in_control_ == &client) pass_control();
  if (is_stopping_ && clients_.empty()) stop_timer_.cancel();
}

// The client in control leaves.
void ViewServer::Network::pass_control() {
  in_control_ = nullptr;
  model_.let_go();
  if (is_stopping_) return;
  const auto next = std::find_if(clients_.begin(), clients_.end(),
                                 [](const auto& c) { return may_control(*c) && !c->is_closing(); });
  if (next == clients_.end()) return;
  take_control(**next, "the page in control has left; this page is in control now");
}

void ViewServer::Network::take_control(LiveClient& client, const std::string& why) {
  in_control_ = &client;
  client.pointer = client.answered_pointer = 0;
  client.send(event_text("control", why));
}

void ViewServer::Network::on_message(LiveClient& client, std::string_view bytes, bool is_text) {
  if (!is_text) {
    if (!client.has_token) return client.close(kWrongToken, "the first message must be the token");
    return point(client, bytes);
  }
  std::optional<std::uint64_t> id;
  const auto request = parse_request(bytes, id);
  if (!client.has_token) {
    const auto role = request && request->kind == PageRequest::Kind::kToken
                          ? place_of(request->token, tokens_)
                          : std::nullopt;
    if (!role) return client.close(kWrongToken, "the token is missing or wrong");
    client.role = *role;
    return admit(client);
  }
  const bool is_for_server = request && request->kind == PageRequest::Kind::kTakeControl;
  if (!is_for_server) {
    auto text = model_.take_message(client.role, in_control_ == &client, bytes);
    if (text && !text->empty()) client.send(std::move(*text));
    if (text) return;
  }
  if (!request) {
    if (!id) return client.close(kPolicy, request.error().to_string());
    return answer(client, id, request.error().to_string());
  }
  carry_out(client, *request);
}

std::size_t ViewServer::Network::admitted() const {
  return static_cast<std::size_t>(
      std::count_if(clients_.begin(), clients_.end(), [](const auto& c) { return c->has_token; }));
}

void ViewServer::Network::admit(LiveClient& client) {
  if (admitted() >= ServerLimits::kClients) {
    return client.close(kTryAgainLater, "eight pages are open; close one");
  }
  client.has_token = true;
  client.hold({});  // it is no stranger any more
  client.allow_long_messages();
  take_ticks();
  client.next_tick = first_tick_ + ticks_.size();
  if (in_control_ == nullptr && may_control(client)) in_control_ = &client;
  client.send(with_control(model_.hello(client.role), in_control_ == &client));
  client.want_state();
}

void ViewServer::Network::answer(LiveClient& client, std::optional<std::uint64_t> id,
                                 const std::optional<std::string>& problem) {
  Json json = {{"type", "answer"}, {"id", id ? Json(*id) : Json()}, {"ok", !problem}};
  if (problem) json["problem"] = *problem;
  client.send(line_of(json));
}

void ViewServer::Network::carry_out(LiveClient& client, const PageRequest& request) {
  if (request.kind == PageRequest::Kind::kToken) return;
  if (request.kind == PageRequest::Kind::kTakeControl) {
    if (!may_control(client)) return answer(client, request.id, "this page cannot take control");
    give_control(client);
    return answer(client, request.id, std::nullopt);
  }
  if (in_control_ != &client) {
    return answer(client, request.id, "another page is in control; take control first");
  }
  answer(client, request.id, model_.carry_out(request));
}

void ViewServer::Network::give_control(LiveClient& client) {
  if (&client == in_control_) return;
  LiveClient* const before = std::exchange(in_control_, nullptr);
  model_.let_go();
  if (before != nullptr) {
    before->send(event_text("control", "another page has taken control; this one watches"));
  }
  take_control(client, "this page is in control");
}

void ViewServer::Network::point(LiveClient& client, std::string_view bytes) {
  const auto message = decode_pointer(bytes);
  if (!message) return client.close(kPolicy, message.error().to_string());
  if (in_control_ != &client) return;  // a page that has just lost control still sends some
  client.pointer = message->sequence;
  model_.point(*message);
  look_until_ = Clock::now() + kLookFor;
  if (!std::exchange(is_looking_, true)) look();
}

// Looks for the first tick that used the newest pointer message. The haptic thread makes no system
// call, so it cannot wake this thread.
void ViewServer::Network::look() {
  const bool waits = in_control_ != nullptr && in_control_->answered_pointer < in_control_->pointer;
  if (is_stopping_ || !waits || Clock::now() > look_until_) {
    is_looking_ = false;
    return;
  }
  if (model_.newest(state_, bodies_) && state_.pointer >= in_control_->pointer) {
    in_control_->answered_pointer = state_.pointer;
    is_looking_ = false;
    return in_control_->want_state();
  }
  look_timer_.expires_after(kLookEvery);
  look_timer_.async_wait([this](boost::system::error_code) { look(); });
}

bool ViewServer::Network::encode_state(LiveClient& client, std::string& out) {
  if (!model_.shows_states(client.role) || !model_.newest(state_, bodies_)) return false;
  if (in_control_ == &client) client.answered_pointer = state_.pointer;
  const double now_s = std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
  palpate::encode_state(state_, bodies_, now_s, out);
  return true;
}

void ViewServer::Network::take_ticks() {
  taken_.clear();
  const std::uint64_t lost = model_.take_ticks(taken_);
  if (lost > 0) {
    for (const auto& client : clients_) client->lost_ticks += lost;
  }
  ticks_.insert(ticks_.end(), taken_.begin(), taken_.end());
  const std::size_t excess = ticks_.size() - std::min(ticks_.size(), kKeptTicks);
  ticks_.erase(ticks_.begin(), ticks_.begin() + static_cast<std::ptrdiff_t>(excess));
  first_tick_ += excess;
}

bool ViewServer::Network::encode_ticks(LiveClient& client, std::string& out) {
  if (client.next_tick < first_tick_) {
    client.lost_ticks += first_tick_ - client.next_tick;
    client.next_tick = first_tick_;
  }
  const auto begin = ticks_.begin() + static_cast<std::ptrdiff_t>(client.next_tick - first_tick_);
  taken_.assign(begin, ticks_.end());
  if (taken_.empty() && client.lost_ticks == 0) return false;
  client.next_tick = first_tick_ + ticks_.size();
  palpate::encode_ticks(taken_, static_cast<std::uint32_t>(std::exchange(client.lost_ticks, 0)),
                        thinning_group(model_.rate_Hz()), out);
  return true;
}

void ViewServer::Network::send_texts() {
  while (const auto text = model_.take_text()) {
    for (const auto& client : std::vector(clients_)) {
      if (client->has_token && client->role == text->role) client->send(text->text);
    }
  }
}

// Sixty times a second.
void ViewServer::Network::frame() {
  if (is_stopping_) return;
  take_ticks();
  send_texts();
  for (const auto& client : std::vector(clients_)) {
    if (!client->has_token) continue;
    client->want_state();
    if (model_.shows_ticks(client->role)) client->want_ticks();
  }
  next_frame_ = std::max(next_frame_ + kFrame, Clock::now());
  frame_timer_.expires_at(next_frame_);
  frame_timer_.async_wait([this](boost::system::error_code) { frame(); });
}

// Four times a second.
void ViewServer::Network::check() {
  if (is_stopping_) return;
  const auto event = model_.take_event();
  const std::size_t count = admitted();
  std::vector<std::string> statuses(tokens_.size());  // one for each role: the model counts in it
  for (const auto& client : std::vector(clients_)) {
    if (client->has_token) {
      std::string& status = statuses[client->role];
      if (status.empty()) status = model_.status(client->role, count);
      if (event) client->send(event_text(event->kind.c_str(), event->text));
      client->send_newest(with_control(status, client.get() == in_control_));
    }
    client->check(Clock::now());
  }
  check_timer_.expires_after(kCheckEvery);
  check_timer_.async_wait([this](boost::system::error_code) { check(); });
}

Result<std::unique_ptr<ViewServer>> ViewServer::listen(const ServerSettings& settings,
                                                       const PageFiles& page, ViewModel& model) {
  auto network = std::make_unique<Network>(settings, page, model);
  if (auto error = network->listen()) return *error;
  return std::unique_ptr<ViewServer>(new ViewServer(std::move(network)));
}

ViewServer::ViewServer(std::unique_ptr<Network> network) : network_(std::move(network)) {}

ViewServer::~ViewServer() {
  stop();
}

std::optional<std::string> ViewServer::files_problem() {
  constexpr rlim_t kEnough = kOtherFiles + 2 * kFewestStrangers;
  rlimit files{};
  if (::getrlimit(RLIMIT_NOFILE, &files) != 0 || files.rlim_cur >= kEnough) return std::nullopt;
  return "this process may open " + std::to_string(files.rlim_cur) + " files; the server needs " +
         std::to_string(kEnough) +
         " so that strangers cannot keep a page out (raise the limit, such as with ulimit -n 1024)";
}

std::uint16_t ViewServer::port() const {
  return network_->port();
}

const Token& ViewServer::token(PageRole role) const {
  return network_->token(role);
}

void ViewServer::start() {
  network_->start();
}

void ViewServer::stop() {
  network_->stop();
}

}  // namespace palpate
