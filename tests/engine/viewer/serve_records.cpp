// A server of `view` that shows given records instead of a running session, for tests of the page.
//
// usage: serve_records SCENE SENSORS ACTUATORS
//
// Serves the page of the build, or an empty one. Prints its address in one line. Then each line on
// stdin is one JSON object, shown until the next line:
//   {"record": {"tick": 1, "device_m": [0, 0, 0], ...}, "target_m": [0, 0, 0], "flags": 1,
//    "pointer": 0, "bodies": [{"body": 0, "q_wxyz": [1, 0, 0, 0], "o_m": [0, 0, 0]}]}
// Fields that are left out keep their defaults. Each line is answered by "shown" on stdout. Ends
// with the input.

#include <cstdint>
#include <cstring>
#include <iostream>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "engine/scene/scene.h"
#include "engine/session/run_setup.h"
#include "engine/viewer/page_files.h"
#include "engine/viewer/view_server.h"
#include "engine/viewer/view_session.h"

namespace palpate::test {
namespace {

using Json = nlohmann::json;

template <typename Number>
void put_number(char* to, const Json& value) {
  const auto number = value.get<Number>();
  std::memcpy(to, &number, sizeof number);
}

void put_value(FieldType type, char* to, const Json& value) {
  switch (type) {
    case FieldType::kUint64:
      return put_number<std::uint64_t>(to, value);
    case FieldType::kInt64:
      return put_number<std::int64_t>(to, value);
    case FieldType::kDouble:
      return put_number<double>(to, value);
    case FieldType::kUint32:
      return put_number<std::uint32_t>(to, value);
    case FieldType::kUint16:
      return put_number<std::uint16_t>(to, value);
  }
}

TickRecord record_of(const Json& json) {
  TickRecord record;
  char* const bytes = reinterpret_cast<char*>(&record);
  for (const RecordField& field : kRecordFields) {
    const auto given = json.find(field.name);
    if (given == json.end()) continue;
    for (std::size_t i = 0; i < field.count; ++i) {
      put_value(field.type, bytes + field.offset + i * (field.bytes / field.count),
                field.count == 1 ? *given : given->at(i));
    }
  }
  return record;
}

// Shows one record. hello, status and scene come from a session that never starts.
class ShownRecord final : public ViewModel {
 public:
  explicit ShownRecord(ViewSession& session) : session_(session) {}

  void show(const Json& json) {
    ViewState state;
    state.record = record_of(json.value("record", Json::object()));
    state.target_m = json.value("target_m", state.target_m);
    state.flags = json.value("flags", 0u);
    state.pointer = json.value("pointer", std::uint64_t{0});
    std::vector<BodyPose> bodies;
    for (const Json& body : json.value("bodies", Json::array())) {
      bodies.push_back({body.at("body"), body.at("q_wxyz"), body.at("o_m")});
    }
    const std::lock_guard lock(mutex_);
    state_ = state;
    bodies_ = std::move(bodies);
    has_state_ = true;
    rows_.push_back(TickSummary::of(state.record));
  }

  bool newest(ViewState& state, std::vector<BodyPose>& bodies) override {
    const std::lock_guard lock(mutex_);
    state = state_;
    bodies = bodies_;
    return has_state_;
  }
  std::uint64_t take_ticks(std::vector<TickSummary>& rows) override {
    const std::lock_guard lock(mutex_);
    rows.insert(rows.end(), rows_.begin(), rows_.end());
    rows_.clear();
    return 0;
  }
  double rate_Hz() const override { return session_.rate_Hz(); }
  std::string hello() override { return session_.hello(); }
  std::string status(std::size_t clients) override { return session_.status(clients); }
  std::optional<Event> take_event() override { return std::nullopt; }
  void point(const PointerMessage&) override {}
  void let_go() override {}
  std::optional<std::string> carry_out(const PageRequest& request) override {
    return session_.carry_out(request);
  }
  std::shared_ptr<const std::string> scene_bytes(bool full) override {
    return session_.scene_bytes(full);
  }

 private:
  ViewSession& session_;
  std::mutex mutex_;
  bool has_state_ = false;
  ViewState state_;
  std::vector<BodyPose> bodies_;
  std::vector<TickSummary> rows_;
};

int failed(const std::string& what) {
  std::cerr << "serve_records: " << what << "\n";
  return 2;
}

int serve(const Scene& scene, int sensors, int actuators) {
  RunSettings settings;
  settings.sensors = sensors;
  settings.actuators = actuators;
  const auto setup = make_setup(settings);
  if (!setup) return failed(setup.error().to_string());
  ViewSettings view;
  view.scene_name = "records";
  const auto session = ViewSession::create(scene, *setup, view);
  if (!session) return failed(session.error().to_string());
  ShownRecord shown(**session);
  const PageFiles page =
      embedded_page().value_or(PageFiles{"<!doctype html><title>no page</title>", "0;", "p{}"});
  const auto server = ViewServer::listen({}, page, shown);
  if (!server) return failed(server.error().to_string());
  (*server)->start();
  std::cout << "http://127.0.0.1:" << (*server)->port() << "/#" << (*server)->token().text()
            << std::endl;
  for (std::string line; std::getline(std::cin, line);) {
    shown.show(Json::parse(line));
    std::cout << "shown" << std::endl;
  }
  return 0;
}

}  // namespace
}  // namespace palpate::test

int main(int argc, char** argv) {
  using palpate::test::failed;
  if (argc != 4) return failed("expected SCENE SENSORS ACTUATORS");
  const auto scene = palpate::Scene::load(argv[1]);
  if (!scene) return failed(scene.error().to_string());
  return palpate::test::serve(*scene, std::stoi(argv[2]), std::stoi(argv[3]));
}
