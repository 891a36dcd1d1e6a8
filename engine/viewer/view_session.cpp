#include "engine/viewer/view_session.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <sstream>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/rig/placed_bounds.h"
#include "engine/rig/workspace.h"
#include "engine/scene/felt_glb.h"

namespace palpate {
namespace {

using Json = nlohmann::ordered_json;

// A name of a file may hold bytes that are not UTF-8.
std::string line_of(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json vector_json(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

Json display_json(const std::optional<PaperDisplay>& paper) {
  if (!paper) return {{"name", "full"}};
  Json spheres;
  if (paper->spheres) {
    spheres = {{"green_m", vector_json(paper->spheres->green_m)},
               {"red_m", vector_json(paper->spheres->red_m)},
               {"radius_m", paper->spheres->radius_m}};
  }
  return {{"name", "paper"},
          {"Hz", paper->rate_Hz},
          {"scale", paper->scale},
          {"spheres", std::move(spheres)}};
}

Json number_or_null(const std::optional<double>& number) {
  return number ? Json(*number) : Json();
}

// The simulated hand of a page has no noise of its own: it rests where the pointer rests.
PlantSettings plant_of(const RunSetup& setup) {
  PlantSettings plant;
  plant.device = setup.device;
  plant.intention_noise_m = 0.0;
  return plant;
}

std::size_t most_moving(const Scene& scene, const RunSetup& setup) {
  if (setup.moves.empty()) return 0;
  return std::min(scene.objects().size(), LiveWorld::kMostMoving);
}

std::string trip_text(const GovernorTrip& trip) {
  std::ostringstream text;
  text << kTripReasonNames[static_cast<std::size_t>(trip.reason)] << " at " << trip.time_s
       << " s, tick " << trip.tick;
  if (trip.limit > 0.0) text << ": " << trip.value << ", limit " << trip.limit;
  return text.str();
}

// The name of the node whose closed surface the hand has to leave before force begins; null
// otherwise.
Json inside_json(const Scene& scene, const StartInside::Status& status) {
  if (status.phase != StartInside::Phase::kInside) return nullptr;
  return scene.objects()[status.object].name;
}

void add_counts(const TickStatistics::BitCounts& counts, std::span<const std::string_view> names,
                Json& json) {
  for (std::size_t bit = 0; bit < counts.size(); ++bit) {
    if (counts[bit] == 0) continue;
    json[std::string(bit < names.size() ? names[bit] : "unknown")] = counts[bit];
  }
}

}  // namespace

Vec3 resting_place_m(const Scene& scene, const RunSetup& setup) {
  if (scene.objects().empty()) return Vec3::Zero();
  const Box bounds = bounds_in_device(scene, setup.haptics.initial_pose);
  const double room_m = hand_workspace(setup).room_m;
  const double away_m = 0.5 * room_m + setup.haptics.god_object.radius_m;
  Vec3 place = 0.5 * (bounds.low + bounds.high);
  if (setup.actuation.is_planar()) {
    place.x() = bounds.low.x() - away_m;
    place.z() = setup.haptics.plane_height_m;
  } else {
    place.z() = bounds.high.z() + away_m;
  }
  return place;
}

ViewSession::Hand::Hand(const Scene& scene, const RunSetup& setup, const PlantSettings& plant)
    : start_m(resting_place_m(scene, setup)),
      live(scene, setup),
      plan(start_m),
      simulated(device_in_hand(plant, setup, plan, start_m)),
      held(simulated, live) {}

Result<std::unique_ptr<ViewSession>> ViewSession::create(const Scene& scene, const RunSetup& setup,
                                                         const ViewSettings& settings,
                                                         GuardableDevice* device) {
  const PlantSettings plant = plant_of(setup);
  if (device == nullptr) {
    if (auto error = check_plant(plant, setup.dt_s)) return *error;
  }
  auto hand = std::make_unique<Hand>(scene, setup, plant);
  Device& held = device == nullptr ? static_cast<Device&>(hand->held) : *device;
  auto rig = Rig::create(scene, setup, held,
                         {.changes = {&hand->live},
                          .sink = settings.recording.sink,
                          .takes_motors = device != nullptr && settings.takes_motors,
                          .has_tuner = true,
                          .stays_inside = settings.stays_inside});
  if (!rig) return rig.error();
  std::unique_ptr<ViewSession> session(
      new ViewSession(scene, setup, settings, device, std::move(hand), std::move(*rig)));
  if (auto error = session->encode_scene()) return *error;
  return session;
}

ViewSession::ViewSession(const Scene& scene, const RunSetup& setup, const ViewSettings& settings,
                         GuardableDevice* device, std::unique_ptr<Hand> hand,
                         std::unique_ptr<Rig> rig)
    : scene_(scene),
      setup_(setup),
      settings_(settings),
      person_(device),
      hand_(std::move(hand)),
      rig_(std::move(rig)),
      start_inside_news_(rig_->start_inside()),
      page_settings_(scene, hand_->live, rig_->tuner(), device == nullptr, device == nullptr),
      publisher_(rig_->loop(), device == nullptr ? &hand_->plan : nullptr,
                 most_moving(scene, setup)),
      thread_(
          session(), device,
          {{1.0 / setup.dt_s, 0, settings.cpu}, settings.has_guard, settings.without_realtime}) {
  session().observe(publisher_);
  if (device == nullptr) session().observe(hand_->simulated);
}

ViewSession::~ViewSession() {
  stop();
}

std::optional<Error> ViewSession::start() {
  counted_at_ = std::chrono::steady_clock::now();
  return thread_.start();
}

void ViewSession::stop() {
  thread_.stop();
}

bool ViewSession::newest(ViewState& state, std::vector<BodyPose>& bodies) {
  if (!publisher_.newest(session(), state, bodies)) return false;
  if (LoopValues loop; publisher_.loop_values(loop)) {
    state.axis_count = loop.axis_count;
    state.axes = loop.axes;
  }
  state.body_name = scene_.body_name(state.record.body);
  state.material_name = scene_.material_name(state.record.material);
  if (is_paused_) state.flags |= kViewPaused;
  return true;
}

std::uint64_t ViewSession::take_ticks(std::vector<TickSummary>& rows) {
  const std::size_t first = rows.size();
  const std::uint64_t lost = publisher_.take_ticks(rows);
  statistics_.add(std::span(rows).subspan(first));
  return lost;
}

std::string ViewSession::hello(PageRole /*role*/) {
  const SceneStatistics& facts = scene_.statistics();
  const DeviceDescription& device =
      is_simulated() ? hand_->held.description() : person_->description();
  Json json = {{"type", "hello"}, {"version", kViewVersion}, {"engine", PALPATE_VERSION}};
  json["scene"] = {{"name", settings_.scene_name},
                   {"triangles", triangles_},
                   {"shown_triangles", shown_triangles_},
                   {"simplified", shown_triangles_ < triangles_},
                   {"low_m", vector_json(facts.bounds_scene.low)},
                   {"high_m", vector_json(facts.bounds_scene.high)},
                   {"extent_m", vector_json(facts.extent_m)}};
  json["device"] = {{"name", device.name},
                    {"sensors", setup_.actuation.sensors()},
                    {"workspace_m", workspace_extent_m(setup_.device)},
                    {"low_m", device.workspace_low_m},
                    {"high_m", device.workspace_high_m},
                    {"is_simulated", is_simulated()},
                    {"moves_motors", device.moves_motors}};
  json["units"] = {{"length", "m"}, {"force", "N"}, {"angle", "rad"}, {"time", "s"}};
  json["options"] = {{"actuators", setup_.actuation.actuators()},
                     {"scale", facts.scale},
                     {"max_force_N", setup_.max_force_N ? Json(*setup_.max_force_N) : Json()}};
  json["materials"] = Json::array();
  for (const MaterialCalls& material : scene_.material_calls()) {
    json["materials"].push_back(material.material);
  }
  json["rate_Hz"] = rate_Hz();
  json["plane_height_m"] =
      setup_.actuation.is_planar() ? Json(setup_.haptics.plane_height_m) : Json();
  json["proxy_radius_m"] = setup_.haptics.god_object.radius_m;
  json["settings"] = page_settings_.list();
  json["start_device_m"] = vector_json(hand_->start_m);
  json["display"] = display_json(settings_.paper);
  return line_of(json);
}

// No value until enough ticks were counted.
std::optional<double> ViewSession::measured_rate_Hz() {
  constexpr double kShortest_s = 0.1;  // a shorter time counts too few ticks
  const auto now = std::chrono::steady_clock::now();
  const double passed_s = std::chrono::duration<double>(now - counted_at_).count();
  if (passed_s < kShortest_s) return last_rate_Hz_;
  const std::uint64_t ticks = thread().ticks();
  last_rate_Hz_ = static_cast<double>(ticks - counted_ticks_) / passed_s;
  counted_ticks_ = ticks;
  counted_at_ = now;
  return last_rate_Hz_;
}

std::string ViewSession::status(PageRole /*role*/, std::size_t clients) {
  GovernorStatus governor;
  session().latest(governor);
  Json json = {{"type", "status"}, {"rate_Hz", number_or_null(measured_rate_Hz())}};
  json["missed"] = thread().missed_deadlines();
  json["late_p999_us"] = number_or_null(statistics_.late_us(0.999));
  json["step_p50_us"] = number_or_null(statistics_.step_us(0.5));
  json["step_max_us"] = number_or_null(statistics_.step_us(1.0));
  json["trips"] = governor.trips;
  const bool is_tripped = governor.state == GovernorState::kTripped;
  json["trip"] = is_tripped ? Json(trip_text(governor.trip)) : Json();
  json["faults"] = Json::object();
  add_counts(statistics_.take_faults(), kFaultNames, json["faults"]);
  add_counts(statistics_.take_rules(), kGovernorRuleNames, json["faults"]);
  json["clients"] = clients;
  json["paused"] = is_paused_;
  json["inside"] = inside_json(scene_, rig_->start_inside().status());
  // What is set while paused, or was set in this moment, is not yet that of the loop.
  const bool is_pending = hand_->live.is_pending() || rig_->tuner().is_pending();
  LoopValues loop;
  const bool has_loop = !is_pending && publisher_.loop_values(loop);
  json["settings"] = page_settings_.values(has_loop ? std::optional(loop) : std::nullopt);
  json["pending"] = is_pending;
  return line_of(json);
}

std::optional<ViewModel::Event> ViewSession::take_event() {
  if (settings_.recording.on_start_inside) {
    if (const auto status = start_inside_news_.look()) {
      settings_.recording.on_start_inside(*status);
    }
  }
  if (settings_.recording.failure && !has_told_recording_) {
    if (const auto why = settings_.recording.failure()) {
      has_told_recording_ = true;
      return Event{"recording", "the recording has ended: " + *why};
    }
  }
  if (!untold_walls_.empty()) return Event{"stiffness", std::exchange(untold_walls_, {})};
  GovernorStatus governor;
  if (!session().latest(governor) || governor.trips == told_trips_) return std::nullopt;
  told_trips_ = governor.trips;
  return Event{"trip", "the force was cut: " + trip_text(governor.trip)};
}

// The target is kept inside the workspace.
void ViewSession::point(const PointerMessage& message) {
  PointerMessage inside = message;
  for (std::size_t k = 0; k < 3; ++k) {
    inside.target_m[k] = std::clamp(message.target_m[k], setup_.device.workspace_low_m[k],
                                    setup_.device.workspace_high_m[k]);
  }
  hand_->plan.point(inside);
}

void ViewSession::let_go() {
  hand_->plan.let_go();
}

void ViewSession::pause(bool paused) {
  is_paused_ = paused;
  hand_->held.set_paused(paused);
  session().set_paused(paused);
}

std::optional<std::string> ViewSession::set(const PageRequest& request) {
  const auto text_of = [](const Error& error) {
    return error.element + ": " + error.problem;  // hints are for command lines
  };
  const double* const number = std::get_if<double>(&request.value);
  const bool is_judged = settings_.judge != nullptr && number != nullptr;
  std::string told;
  if (is_judged) {
    auto judged = settings_.judge->judge(request.name, *number);
    if (!judged) return text_of(judged.error());
    told = std::move(*judged);
  }
  if (const auto error = page_settings_.set(request.name, request.value)) return text_of(*error);
  if (is_judged) settings_.judge->keep();
  if (!told.empty()) untold_walls_ = std::move(told);
  return std::nullopt;
}

std::optional<std::string> ViewSession::carry_out(const PageRequest& request) {
  switch (request.kind) {
    case PageRequest::Kind::kSet:
      return set(request);
    case PageRequest::Kind::kRearm:
      session().rearm();
      return std::nullopt;
    case PageRequest::Kind::kPause:
      pause(std::get<bool>(request.value));
      return std::nullopt;
    case PageRequest::Kind::kStart:
      if (!is_simulated()) return "start: a person holds the device";
      hand_->plan.start();
      return std::nullopt;
    case PageRequest::Kind::kStay:
      if (rig_->start_inside().status().phase != StartInside::Phase::kInside) {
        return "stay: the hand is not inside a closed surface";
      }
      rig_->start_inside().stay();
      return std::nullopt;
    default:
      return "this request is not for the session";
  }
}

std::optional<Error> ViewSession::encode_scene() {
  auto felt = encode_felt_scene(scene_, kMostShownTriangles);
  if (!felt) return felt.error();
  triangles_ = felt->triangles;
  shown_triangles_ = felt->shown_triangles;
  shown_ = std::make_shared<const std::string>(std::move(felt->bytes));
  return std::nullopt;
}

std::shared_ptr<const std::string> ViewSession::scene_bytes(bool full) {
  if (!full || shown_triangles_ == triangles_) return shown_;
  const std::lock_guard lock(full_mutex_);
  if (!full_) {
    auto felt = encode_felt_scene(scene_);
    if (!felt) return shown_;
    full_ = std::make_shared<const std::string>(std::move(felt->bytes));
  }
  return full_;
}

}  // namespace palpate
