// What recording costs a session: the time that the haptic thread takes for it, late ticks, and the
// processor time of the recorder. Prints JSON.
//
// usage: recorder_times SCENE SECONDS RATE_HZ FOLDER

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <time.h>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "engine/devices/vector_device.h"
#include "engine/recording/recorder.h"
#include "engine/recording/recording_settings.h"
#include "engine/rig/rig.h"
#include "engine/session/haptic_thread.h"

namespace palpate {
namespace {

using nlohmann::ordered_json;

// Circles around the scene, a little below the surface of a sphere.
class Circler final : public VectorDevice {
 public:
  explicit Circler(double radius_m) : radius_m_(radius_m) {}
  Vec3 read_position_m(double dt_s) noexcept override {
    time_s_ += dt_s;
    const double a = 0.7 * time_s_, b = 0.3 * std::sin(0.4 * time_s_);
    return radius_m_ * Vec3(std::cos(a) * std::cos(b), std::sin(a) * std::cos(b), std::sin(b));
  }
  void command_force_N(const Vec3&) noexcept override {}

 private:
  double radius_m_;
  double time_s_ = 0.0;
};

double cpu_s(clockid_t clock) {
  timespec cpu{};
  ::clock_gettime(clock, &cpu);
  return static_cast<double>(cpu.tv_sec) + 1e-9 * static_cast<double>(cpu.tv_nsec);
}

struct Bench {
  const Scene& scene;
  RecordedSetup setup;
  double radius_m;
  std::string file;

  std::unique_ptr<Recorder> recorder(double rate_Hz) const {
    std::filesystem::remove(file);
    auto made = Recorder::create(file, *meta_of(scene, setup), {.rate_Hz = rate_Hz});
    if (made) return std::move(*made);
    std::cerr << made.error().to_string() << "\n";
    std::exit(1);
  }

  std::unique_ptr<Rig> rig_of(Device& device, TickSink* sink) const {
    const RunSetup run{setup.actuation, setup.haptics, setup.dt_s, {}};
    return std::move(*Rig::create(scene, run, device, {.sink = sink}));
  }

  // Mean processor time of a tick of a session, ns, over ticks that the rings can hold.
  double tick_ns(bool records) const {
    constexpr int kTicks = 6'000;
    auto sink = records ? recorder(1000.0) : nullptr;
    Circler device(radius_m);
    const auto rig = rig_of(device, sink.get());
    HapticSession& session = rig->session();
    session.start();
    for (int n = 0; n < 1'000; ++n) session.tick(setup.dt_s);
    const double begin_s = cpu_s(CLOCK_THREAD_CPUTIME_ID);
    for (int n = 0; n < kTicks; ++n) session.tick(setup.dt_s);
    const double time_s = cpu_s(CLOCK_THREAD_CPUTIME_ID) - begin_s;
    session.stop();
    if (sink) sink->finish("end");
    return 1e9 * time_s / kTicks;
  }

  // A session on the haptic thread.
  ordered_json run(bool records, double rate_Hz, double seconds) const {
    auto sink = records ? recorder(rate_Hz) : nullptr;
    Circler device(radius_m);
    const auto rig = rig_of(device, sink.get());
    HapticSession& session = rig->session();
    const auto ticks = static_cast<std::uint64_t>(rate_Hz * seconds);
    const double before_s = cpu_s(CLOCK_PROCESS_CPUTIME_ID);
    HapticThread thread(session, {rate_Hz, ticks});
    thread.start();
    thread.join();
    const double all_s = cpu_s(CLOCK_PROCESS_CPUTIME_ID) - before_s;
    const TickTimes& times = thread.times();
    ordered_json late;
    for (std::size_t k = 0; k < kLateCauseNames.size(); ++k) {
      late[std::string(kLateCauseNames[k])] = times.late_ticks[k];
    }
    ordered_json json{{"records", records},
                      {"rate_Hz", rate_Hz},
                      {"ticks", thread.ticks()},
                      {"late_ticks", late},
                      {"cpu_p50_ns", times.cpu.percentile_ns(0.5)},
                      {"cpu_p99_ns", times.cpu.percentile_ns(0.99)},
                      {"process_cpu_share", all_s / seconds}};
    if (sink) {
      const RecordingResult result = sink->finish("end");
      json["dropped"] = result.dropped;
      json["bytes_per_tick"] = static_cast<double>(result.bytes) /
                               static_cast<double>(std::max<std::uint64_t>(1, result.ticks));
    }
    return json;
  }
};

int measure(const std::string& path, double seconds, double rate_Hz, const std::string& folder) {
  const auto scene = Scene::load(path);
  if (!scene) {
    std::cerr << scene.error().to_string() << "\n";
    return 2;
  }
  RecordedSetup setup;
  setup.scene_path = path;
  setup.actuation = *ActuationModel::from_counts(3, 2);
  setup.haptics.a4.enabled = true;
  setup.dt_s = 1.0 / rate_Hz;
  const double radius_m = 0.5 * scene->statistics().extent_m.maxCoeff();
  const Bench bench{*scene, setup, radius_m - 1e-3, folder + "/recorder_times.palpate"};
  std::vector<double> with, without;
  for (int n = 0; n < 15; ++n) {
    without.push_back(bench.tick_ns(false));
    with.push_back(bench.tick_ns(true));
  }
  std::sort(with.begin(), with.end());
  std::sort(without.begin(), without.end());
  ordered_json json{{"tick_ns_without", without[7]},
                    {"tick_ns_with", with[7]},
                    {"recording_ns_per_tick", with[7] - without[7]}};
  json["sessions"] = {bench.run(false, rate_Hz, seconds), bench.run(true, rate_Hz, seconds)};
  const auto& s = json["sessions"];
  json["recorder_cpu_share"] =
      s[1]["process_cpu_share"].get<double>() - s[0]["process_cpu_share"].get<double>();
  std::cout << json.dump(2) << "\n";
  std::filesystem::remove(bench.file);
  return 0;
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  if (argc != 5) {
    std::cerr << "usage: recorder_times SCENE SECONDS RATE_HZ FOLDER\n";
    return 2;
  }
  return palpate::measure(argv[1], std::atof(argv[2]), std::atof(argv[3]), argv[4]);
}
