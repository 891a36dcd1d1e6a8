// Serves the page of `palpate view` with states that a test sets, without a haptic thread, and says
// which rays of a camera hit the scene.
//
//   page_of_records SCENE SENSORS [DISPLAY]
//
// DISPLAY: what the page shows, as the JSON that a hello has; the full page without it.
//
// Prints the address of the page. Then reads commands from stdin, one JSON object a line, and
// answers each with the line "done":
//   {"state": {FIELD: value, ..., "bodies": [{"body": 1, "q": [w, x, y, z], "o": [x, y, z]}]}}
//        shows a record with these fields (names of TickRecord) and moving bodies
//   {"rays": {"view": [16], "projection": [16], "display": {"q": ..., "o": ...}, "width": w,
//             "height": h, "file": F}}
//        writes to F, as bytes of 0 and 1, row by row, which rays through the middles of pixels hit
//        a surface. The matrices are column by column, as WebGL has them; display is
//        T_display_scene.

#include <array>
#include <cstring>
#include <fstream>
#include <iostream>
#include <mutex>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "engine/scene/felt_glb.h"
#include "engine/scene/scene.h"
#include "engine/simulation/scene_sight.h"
#include "engine/viewer/page_files.h"
#include "engine/viewer/view_server.h"
#include "palpate/record.h"

namespace palpate {
namespace {

using nlohmann::json;

Vec3 vector_of(const json& values) {
  return Vec3(values.at(0).get<double>(), values.at(1).get<double>(), values.at(2).get<double>());
}

RigidTransform pose_of(const json& pose) {
  const json& q = pose.at("q");
  const auto number = [&](std::size_t i) { return q.at(i).get<double>(); };
  return {Quat(number(0), number(1), number(2), number(3)).normalized(), vector_of(pose.at("o"))};
}

template <typename Number>
void write_numbers(const json& values, const RecordField& field, TickRecord& record) {
  char* place = reinterpret_cast<char*>(&record) + field.offset;
  for (std::size_t i = 0; i < field.count; ++i) {
    const auto number = (values.is_array() ? values.at(i) : values).get<Number>();
    std::memcpy(place + i * sizeof(Number), &number, sizeof(Number));
  }
}

void write_field(const json& values, const RecordField& field, TickRecord& record) {
  switch (field.type) {
    case FieldType::kUint64:
      return write_numbers<std::uint64_t>(values, field, record);
    case FieldType::kInt64:
      return write_numbers<std::int64_t>(values, field, record);
    case FieldType::kDouble:
      return write_numbers<double>(values, field, record);
    case FieldType::kUint32:
      return write_numbers<std::uint32_t>(values, field, record);
    case FieldType::kUint16:
      return write_numbers<std::uint16_t>(values, field, record);
    case FieldType::kInt32:
      return write_numbers<std::int32_t>(values, field, record);
  }
}

// Shows the state that the test has set last.
class FixedModel final : public ViewModel {
 public:
  FixedModel(const Scene& scene, int sensors, json display, FeltGlb felt)
      : scene_(scene),
        sensors_(sensors),
        display_(std::move(display)),
        felt_(std::move(felt)),
        bytes_(std::make_shared<const std::string>(felt_.bytes)) {}

  void show(const json& fields) {
    const std::lock_guard lock(mutex_);
    ViewState state;
    state.flags = kViewPaused;  // the page shows no other state as present if no tick follows
    state.axis_count = 1;
    state.axes[0] = {1.0, 0.0, 0.0};
    for (const RecordField& field : kRecordFields) {
      const auto found = fields.find(field.name);
      if (found != fields.end()) write_field(*found, field, state.record);
    }
    state.body_name = scene_.body_name(state.record.body);
    state.material_name = scene_.material_name(state.record.material);
    bodies_.clear();
    for (const json& body : fields.value("bodies", json::array())) {
      bodies_.push_back({body.at("body"), body.at("q"), body.at("o")});
    }
    state_ = state;
  }

  bool newest(ViewState& state, std::vector<BodyPose>& bodies) override {
    const std::lock_guard lock(mutex_);
    if (!state_) return false;
    state = *state_;
    bodies = bodies_;
    return true;
  }

  // The scene with its bodies where the state has them.
  ContactWorld world() {
    const std::lock_guard lock(mutex_);
    ContactWorld world = scene_.world();
    world.tree = nullptr;
    for (const BodyPose& pose : bodies_) {
      RigidTransform T{{pose.q_wxyz[0], pose.q_wxyz[1], pose.q_wxyz[2], pose.q_wxyz[3]},
                       Vec3(pose.o_m[0], pose.o_m[1], pose.o_m[2]) - world.anchor_scene_m};
      world.bodies.at(pose.body).place(T);
    }
    return world;
  }

  std::uint64_t take_ticks(std::vector<TickSummary>&) override { return 0; }
  double rate_Hz() const override { return 1000.0; }
  std::string hello(PageRole role) override;
  std::string status(PageRole, std::size_t clients) override {
    return json{{"type", "status"},
                {"rate_Hz", 1000},
                {"missed", 0},
                {"late_p999_us", 0},
                {"step_p50_us", 0},
                {"step_max_us", 0},
                {"trips", 0},
                {"trip", nullptr},
                {"faults", json::object()},
                {"clients", clients},
                {"paused", true},
                {"inside", nullptr},
                {"pending", false},
                {"settings", {{"axes", axes()}}}}
        .dump();
  }
  std::optional<Event> take_event() override { return std::nullopt; }
  void point(const PointerMessage&) override {}
  void let_go() override {}
  std::optional<std::string> carry_out(const PageRequest&) override { return std::nullopt; }
  std::shared_ptr<const std::string> scene_bytes(bool) override { return bytes_; }

 private:
  static json axes() { return json::array({json::array({1, 0, 0})}); }

  const Scene& scene_;
  const int sensors_;
  const json display_;
  const FeltGlb felt_;
  const std::shared_ptr<const std::string> bytes_;
  std::mutex mutex_;
  std::optional<ViewState> state_;
  std::vector<BodyPose> bodies_;
};

std::string FixedModel::hello(PageRole /*role*/) {
  const Box& box = scene_.statistics().bounds_scene;
  const auto numbers = [](const Vec3& v) { return json::array({v.x(), v.y(), v.z()}); };
  json hello = {{"type", "hello"}, {"version", kViewVersion}, {"engine", "test"}};
  hello["scene"] = {{"name", "fixed records"},
                    {"triangles", felt_.triangles},
                    {"shown_triangles", felt_.shown_triangles},
                    {"simplified", false},
                    {"low_m", numbers(box.low)},
                    {"high_m", numbers(box.high)}};
  hello["device"] = {{"name", "no device"},       {"sensors", sensors_},
                     {"workspace_m", 0.4},        {"low_m", {-0.2, -0.2, -0.2}},
                     {"high_m", {0.2, 0.2, 0.2}}, {"is_simulated", true},
                     {"moves_motors", false}};
  hello["rate_Hz"] = rate_Hz();
  hello["plane_height_m"] = sensors_ == 2 ? json(0.0) : json();
  hello["proxy_radius_m"] = 0.004;
  hello["start_device_m"] = {0, 0, 0};
  hello["display"] = display_;
  hello["settings"] = {
      {{"name", "axes"}, {"label", "Motors"}, {"kind", "axes"}, {"value", axes()}}};
  return hello.dump();
}

Eigen::Matrix4d matrix_of(const json& columns) {
  Eigen::Matrix4d matrix;
  for (int i = 0; i < 16; ++i) matrix(i % 4, i / 4) = columns.at(static_cast<std::size_t>(i));
  return matrix;
}

// Writes which pixels show a surface.
void write_hits(const ContactWorld& world, const json& rays) {
  const SceneSight sight(world);
  const Eigen::Matrix4d from_clip =
      (matrix_of(rays.at("projection")) * matrix_of(rays.at("view"))).inverse();
  const RigidTransform T_display_scene = pose_of(rays.at("display"));
  const int width = rays.at("width"), height = rays.at("height");
  const auto at = [&](double x, double y, double depth) {
    const Eigen::Vector4d p = from_clip * Eigen::Vector4d(x, y, depth, 1.0);
    return T_display_scene.inverse_point(p.head<3>() / p.w());
  };
  std::string hits;
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      const double x = 2.0 * (column + 0.5) / width - 1.0;
      const double y = 1.0 - 2.0 * (row + 0.5) / height;
      hits += sight.first_hit(at(x, y, -1.0), at(x, y, 1.0)) <= 1.0 ? '\1' : '\0';
    }
  }
  std::ofstream(rays.at("file").get<std::string>(), std::ios::binary) << hits;
}

int serve(const std::string& path, int sensors, json display) {
  const auto page = embedded_page();
  if (!page) {
    std::cerr << "page_of_records: built without the page; ./run.sh view fetches what it needs\n";
    return 77;
  }
  const auto scene = Scene::load(path);
  if (!scene) {
    std::cerr << scene.error().to_string() << '\n';
    return 2;
  }
  auto felt = encode_felt_scene(*scene);
  if (!felt) {
    std::cerr << felt.error().to_string() << '\n';
    return 2;
  }
  FixedModel model(*scene, sensors, std::move(display), std::move(*felt));
  auto server = ViewServer::listen({}, *page, model);
  if (!server) {
    std::cerr << server.error().to_string() << '\n';
    return 2;
  }
  (*server)->start();
  std::cout << "http://127.0.0.1:" << (*server)->port() << "/#" << (*server)->token().text()
            << std::endl;
  for (std::string line; std::getline(std::cin, line);) {
    const json command = json::parse(line);
    if (command.contains("state")) model.show(command["state"]);
    if (command.contains("rays")) write_hits(model.world(), command["rays"]);
    std::cout << "done" << std::endl;
  }
  (*server)->stop();
  return 0;
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  if (argc != 3 && argc != 4) {
    std::cerr << "usage: page_of_records SCENE SENSORS [DISPLAY]\n";
    return 2;
  }
  return palpate::serve(argv[1], std::stoi(argv[2]),
                        palpate::json::parse(argc == 4 ? argv[3] : R"({"name":"full"})"));
}
