// Measures what a viewer costs: the time of a tick, the time from a pointer message to the state
// that used it, the CPU of the network thread, and the late ticks of the haptic thread with and
// without clients.
//
// usage: view_times SCENE [--only=times|ticks] [--seconds=N] [--pointers=N] [--csv=FILE]
//
// --only=times: without the late ticks, which take twice --seconds; --only=ticks: these alone.
//
// The clients do not draw. One reads everything and moves the hand; three never read, and are
// replaced every ten seconds, because the server drops such clients a little later. The bare
// round trip is that of the same numbers of bytes between two threads, over a socket of this
// machine.

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <unistd.h>
#include <utility>
#include <vector>

#include "engine/rig/rig.h"
#include "engine/simulation/simulated_device.h"
#include "engine/viewer/held_device.h"
#include "engine/viewer/live_settings.h"
#include "engine/viewer/pointer_plan.h"
#include "engine/viewer/state_publisher.h"
#include "engine/viewer/view_server.h"
#include "engine/viewer/view_session.h"
#include "tests/engine/viewer/raw_client.h"

namespace palpate {
namespace {

using Clock = std::chrono::steady_clock;
using test::RawClient;
using test::WebSocketClient;

struct Options {
  std::string scene;
  int seconds = 600;
  int pointers = 1000;
  std::string csv;
  std::string only;  // empty: all
};

struct Line {
  std::string quantity;
  double value;
  std::string unit;
};

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

double at(std::vector<double> values, double share) {  // nearest rank
  std::sort(values.begin(), values.end());
  const double rank = std::ceil(share * static_cast<double>(values.size()));
  return values[static_cast<std::size_t>(std::max(1.0, rank)) - 1];
}

// The CPU time of the thread of this name, s.
double cpu_s(const std::string& name) {
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    std::string comm;
    std::getline(std::ifstream(task.path() / "comm"), comm);
    if (comm != name) continue;
    double ns = 0.0;
    std::ifstream(task.path() / "schedstat") >> ns;
    return 1e-9 * ns;
  }
  return 0.0;
}

double resident_MB() {
  double total = 0.0, resident = 0.0;
  std::ifstream("/proc/self/statm") >> total >> resident;
  return 1e-6 * resident * static_cast<double>(::sysconf(_SC_PAGESIZE));
}

std::string pointer_bytes(std::uint64_t sequence, const Vec3& target_m) {
  std::string bytes(40, '\0');
  const std::array<std::uint16_t, 2> head = {16, kViewVersion};
  const std::uint32_t buttons = 1;
  std::memcpy(bytes.data(), head.data(), 4);
  std::memcpy(bytes.data() + 4, &buttons, 4);
  std::memcpy(bytes.data() + 8, &sequence, 8);
  std::memcpy(bytes.data() + 16, target_m.data(), 24);
  return bytes;
}

std::uint64_t pointer_of(const std::string& state) {
  std::uint64_t sequence;
  std::memcpy(&sequence, state.data() + 8, sizeof sequence);
  return sequence;
}

// A session with its server.
struct View {
  View(const Scene& scene, const RunSetup& setup)
      : session(std::move(*ViewSession::create(scene, setup, {}))),
        server(std::move(*ViewServer::listen({}, {"page", "script", "style", "icon"}, *session))) {
    server->start();
    if (const auto error = session->start()) std::fprintf(stderr, "%s\n", error->problem.c_str());
  }
  std::unique_ptr<WebSocketClient> client() const {
    auto client = std::make_unique<WebSocketClient>(server->port());
    client->send_text(R"({"type":"token","token":")" + server->token().text() + "\"}");
    return client;
  }

  std::unique_ptr<ViewSession> session;
  std::unique_ptr<ViewServer> server;
};

// A place in front of the scene and a little into it, by turns.
Vec3 place(const Vec3& start_m, int n) {
  return start_m + Vec3(0.01 * std::sin(0.1 * n), 0.01 * std::cos(0.1 * n), 0.0);
}

// The pauses make the messages meet every phase of the ticks and of the frames.
void pause(std::mt19937& random) {
  std::this_thread::sleep_for(std::chrono::microseconds(5000 + random() % 20000));
}

std::vector<double> pointer_times_ms(const Scene& scene, const RunSetup& setup, int count) {
  const View view(scene, setup);
  const auto client = view.client();
  const Vec3 start_m = resting_place_m(scene, setup);
  std::mt19937 random(1);
  std::vector<double> times_ms;
  for (int n = 1; n <= count; ++n) {
    pause(random);
    const auto sequence = static_cast<std::uint64_t>(n);
    const Clock::time_point sent = Clock::now();
    client->send_binary(pointer_bytes(sequence, place(start_m, n)));
    while (pointer_of(client->read_binary(1)) < sequence) {
    }
    times_ms.push_back(ms_since(sent));
  }
  return times_ms;
}

// A thread answers each message of the pointer's length by one of the state's length.
std::vector<double> bare_times_ms(int count) {
  constexpr std::size_t kAsked = 46;                           // a pointer in its frame
  constexpr std::size_t kAnswered = 140 + sizeof(TickRecord);  // a state in its frame
  const int listening = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof address;
  ::bind(listening, reinterpret_cast<sockaddr*>(&address), length);
  ::listen(listening, 1);
  ::getsockname(listening, reinterpret_cast<sockaddr*>(&address), &length);
  std::thread answering([&] {
    const int peer = ::accept(listening, nullptr, nullptr);
    std::array<char, kAnswered> bytes{};
    while (::recv(peer, bytes.data(), kAsked, MSG_WAITALL) == static_cast<ssize_t>(kAsked)) {
      ::send(peer, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    }
    ::close(peer);
  });
  std::vector<double> times_ms;
  {
    RawClient client(ntohs(address.sin_port));
    std::mt19937 random(1);
    for (int n = 0; n < count; ++n) {
      pause(random);
      const Clock::time_point sent = Clock::now();
      client.send(std::string(kAsked, 'x'));
      client.read_exactly(kAnswered);
      times_ms.push_back(ms_since(sent));
    }
  }
  answering.join();
  ::close(listening);
  return times_ms;
}

// Reads everything and moves the hand until `ends`.
void watch(WebSocketClient& client, const Vec3& start_m, const std::atomic<bool>& ends) {
  constexpr int kStatesPerPointer = 3;  // 50 ms
  int states = 0;
  std::uint64_t sequence = 0;
  while (!ends) {
    client.read_binary(1);
    if (++states % kStatesPerPointer != 0) continue;
    ++sequence;
    client.send_binary(pointer_bytes(sequence, place(start_m, static_cast<int>(sequence))));
  }
}

// Keeps three clients that never read until `ends`.
void refuse_to_read(const View& view, const std::atomic<bool>& ends) {
  constexpr int kClients = 3;
  constexpr auto kLook = std::chrono::milliseconds(100);
  constexpr auto kReplace = std::chrono::seconds(10);
  std::vector<std::unique_ptr<WebSocketClient>> clients(kClients);
  Clock::time_point due = Clock::now();
  for (; !ends; std::this_thread::sleep_for(kLook)) {
    if (Clock::now() < due) continue;
    for (auto& client : clients) client = view.client();
    due += kReplace;
  }
}

// The ticks of a session, with one client that reads and three that do not, or without a client.
void measure_ticks(const Scene& scene, const RunSetup& setup, bool has_clients, int seconds,
                   std::vector<Line>& lines) {
  const std::string of = has_clients ? "with clients: " : "without clients: ";
  const View view(scene, setup);
  std::atomic<bool> ends{false};
  std::vector<std::thread> clients;
  clients.reserve(2);
  if (has_clients) {
    clients.emplace_back([&, reader = std::shared_ptr(view.client())] {
      watch(*reader, resting_place_m(scene, setup), ends);
    });
    clients.emplace_back([&] { refuse_to_read(view, ends); });
  }
  std::this_thread::sleep_for(std::chrono::seconds(1));  // the start is not measured
  const double cpu_before_s = cpu_s("palpate-network");
  const double before_MB = resident_MB();
  const Clock::time_point start = Clock::now();
  std::this_thread::sleep_for(std::chrono::seconds(seconds));
  const double cpu_share = 1e3 * (cpu_s("palpate-network") - cpu_before_s) / ms_since(start);
  lines.push_back({of + "CPU of the network thread", 100.0 * cpu_share, "%"});
  lines.push_back({of + "growth of memory", resident_MB() - before_MB, "MB"});
  ends = true;
  for (std::thread& client : clients) client.join();
  view.session->stop();
  const TickTimes& times = view.session->thread().times();
  lines.push_back({of + "ticks", static_cast<double>(times.wall.count()), "1"});
  for (std::size_t i = 0; i < kLateCauseNames.size(); ++i) {
    lines.push_back({of + "late ticks: " + std::string(kLateCauseNames[i]),
                     static_cast<double>(times.late_ticks[i]), "1"});
  }
}

// Sessions of the same hand with and without what a viewer adds to a tick. Nobody reads.
class TickPair {
 public:
  TickPair(const Scene& scene, const RunSetup& setup)
      : dt_s_(setup.dt_s),
        plain_(scene, setup, false),
        viewed_(scene, setup, true),
        start_m_(resting_place_m(scene, setup)) {}

  // The median time of a tick, ns: without a viewer, and how much more it takes with one. The
  // sessions alternate, so that both meet the same disturbances.
  std::pair<double, double> medians_ns() {
    constexpr int kBlocks = 2000;
    std::vector<double> plain_ns, more_ns;
    for (int n = 0; n < kBlocks; ++n) {
      const bool is_first = n % 2 == 0;
      const double first = block_ns(is_first ? plain_ : viewed_, n);
      const double second = block_ns(is_first ? viewed_ : plain_, n);
      plain_ns.push_back(is_first ? first : second);
      more_ns.push_back(is_first ? second - first : first - second);
    }
    return {at(plain_ns, 0.5), at(more_ns, 0.5)};
  }

 private:
  struct Side {
    Side(const Scene& scene, const RunSetup& setup, bool is_viewed)
        : plan(resting_place_m(scene, setup)),
          live(scene, setup),
          simulated(device_in_hand(plant(setup), setup, plan, resting_place_m(scene, setup))),
          held(simulated, live),
          rig(rig_of(scene, setup, is_viewed)),
          publisher(rig->loop(), &plan, 0) {
      if (is_viewed) rig->session().observe(publisher);
      rig->session().observe(simulated);
      rig->session().start();
    }
    static PlantSettings plant(const RunSetup& setup) {
      PlantSettings settings;
      settings.device = setup.device;
      settings.intention_noise_m = 0.0;
      return settings;
    }
    std::unique_ptr<Rig> rig_of(const Scene& scene, const RunSetup& setup, bool is_viewed) {
      if (!is_viewed) return std::move(*Rig::create(scene, setup, simulated));
      return std::move(*Rig::create(scene, setup, held, {.changes = {&live}, .has_tuner = true}));
    }

    PointerPlan plan;
    LiveSettings live;
    SimulatedDevice simulated;
    HeldDevice held;
    std::unique_ptr<Rig> rig;
    StatePublisher publisher;
  };

  double block_ns(Side& side, int n) const {
    constexpr int kTicks = 200;
    PointerMessage message;
    message.sequence = static_cast<std::uint64_t>(n) + 1;
    message.holds = true;
    const Vec3 target_m = place(start_m_, n);
    message.target_m = {target_m.x(), target_m.y(), target_m.z()};
    side.plan.point(message);
    const Clock::time_point start = Clock::now();
    for (int i = 0; i < kTicks; ++i) side.rig->session().tick(dt_s_);
    return 1e6 * ms_since(start) / kTicks;
  }

  double dt_s_;
  Side plain_, viewed_;
  Vec3 start_m_;
};

void measure_times(const Scene& scene, const RunSetup& setup, int pointers,
                   std::vector<Line>& lines) {
  const std::vector<double> bare_ms = bare_times_ms(pointers);
  const std::vector<double> pointer_ms = pointer_times_ms(scene, setup, pointers);
  for (const double share : {0.5, 0.99}) {
    const std::string name = share == 0.5 ? "median" : "99 %";
    lines.push_back({"bare round trip: " + name, at(bare_ms, share), "ms"});
    lines.push_back({"pointer to state: " + name, at(pointer_ms, share), "ms"});
  }
  const auto [plain_ns, more_ns] = TickPair(scene, setup).medians_ns();
  lines.push_back({"tick without a viewer: median", plain_ns, "ns"});
  lines.push_back({"tick with a viewer: more", more_ns, "ns"});
}

int measure(const Options& options) {
  const auto scene = Scene::load(options.scene, {.fit_size_m = 0.2});
  if (!scene) {
    std::fprintf(stderr, "view_times: %s\n", scene.error().to_string().c_str());
    return 2;
  }
  RunSettings settings;
  settings.sensors = 3;
  settings.actuators = 3;
  settings.haptics.a4.enabled = true;
  const RunSetup setup = *make_setup(settings);
  std::vector<Line> lines;
  if (options.only != "ticks") measure_times(*scene, setup, options.pointers, lines);
  if (options.only != "times") {
    measure_ticks(*scene, setup, false, options.seconds, lines);
    measure_ticks(*scene, setup, true, options.seconds, lines);
  }
  std::ofstream csv(options.csv);
  csv << "quantity,value,unit\n";
  for (const Line& line : lines) {
    std::printf("%-45s %12.3f %s\n", line.quantity.c_str(), line.value, line.unit.c_str());
    csv << line.quantity << "," << line.value << "," << line.unit << "\n";
  }
  csv.flush();
  if (options.csv.empty() || csv) return 0;
  std::fprintf(stderr, "view_times: %s: cannot be written\n", options.csv.c_str());
  return 1;
}

// Returns whether all arguments are known.
bool parse(int count, char** arguments, Options& options) {
  for (int i = 1; i < count; ++i) {
    const std::string word = arguments[i];
    const std::size_t equals = word.find('=');
    const std::string name = word.substr(0, equals);
    const std::string value = equals == std::string::npos ? "" : word.substr(equals + 1);
    const int number = std::atoi(value.c_str());
    if (name == "--only" && (value == "times" || value == "ticks")) {
      options.only = value;
    } else if (name == "--csv" && !value.empty()) {
      options.csv = value;
    } else if (name == "--seconds" && number > 0) {
      options.seconds = number;
    } else if (name == "--pointers" && number > 0) {
      options.pointers = number;
    } else if (!name.starts_with("-") && options.scene.empty()) {
      options.scene = word;
    } else {
      return false;
    }
  }
  return !options.scene.empty();
}

}  // namespace
}  // namespace palpate

int main(int count, char** arguments) {
  palpate::Options options;
  if (!palpate::parse(count, arguments, options)) {
    std::fprintf(stderr,
                 "usage: view_times SCENE [--only=times|ticks] [--seconds=N] [--pointers=N] "
                 "[--csv=FILE]\n");
    return 2;
  }
  try {
    return palpate::measure(options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "view_times: %s\n", error.what());
    return 1;
  }
}
