#pragma once

// A haptic session that a page watches and changes.

#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "engine/devices/guardable_device.h"
#include "engine/rig/rig.h"
#include "engine/session/run_setup.h"
#include "engine/session/session_thread.h"
#include "engine/session/start_inside.h"
#include "engine/session/tick_sink.h"
#include "engine/simulation/simulated_device.h"
#include "engine/viewer/held_device.h"
#include "engine/viewer/live_settings.h"
#include "engine/viewer/page_settings.h"
#include "engine/viewer/paper_display.h"
#include "engine/viewer/pointer_plan.h"
#include "engine/viewer/state_publisher.h"
#include "engine/viewer/tick_statistics.h"
#include "engine/viewer/view_model.h"
#include "engine/viewer/wall_judge.h"

namespace palpate {

// A recording of a session.
struct ViewRecording {
  TickSink* sink = nullptr;  // null: nothing is recorded; it must outlive the session
  // Why the recording has ended before the session; no value while it goes on. The network thread
  // calls it.
  std::function<std::optional<std::string>()> failure;
  // Called on the network thread with each change of a hand that begins inside; may be empty.
  std::function<void(const StartInside::Status&)> on_start_inside = {};
};

struct ViewSettings {
  std::string scene_name;  // what the page shows as its name
  std::optional<int> cpu;  // see HapticThreadSettings
  bool has_guard = true;   // see GuardedRunSettings
  bool without_realtime = false;
  bool takes_motors = true;    // see SessionParts
  bool stays_inside = false;   // see DeviceRunSettings
  WallJudge* judge = nullptr;  // null: no wall is judged; it must outlive the session
  // The page shows nothing but this display, which needs 2 sensors; no value: the full page.
  std::optional<PaperDisplay> paper = {};
  ViewRecording recording;
};

// The place where the simulated hand rests at first: in front of the scene, where no surface is.
// With 2 sensors it is below the scene along A1, otherwise above it along A3. Device frame.
Vec3 resting_place_m(const Scene& scene, const RunSetup& setup);

// Owns the loop, the device or its driver's session, the haptic thread, and what lies between them
// and the server. The owner's thread calls create(), start(), stop() and the destructor; the
// network thread may call the functions of ViewModel from create() to the destructor.
class ViewSession final : public ViewModel {
 public:
  // The caller must have checked setup (check_setup). device: null for the simulated hand. The
  // scene and the device must outlive this object. Errors: a node of setup.moves does not exist;
  // the simulated hand would be unstable (check_plant); the scene has no GLB.
  static Result<std::unique_ptr<ViewSession>> create(const Scene& scene, const RunSetup& setup,
                                                     const ViewSettings& settings,
                                                     GuardableDevice* device = nullptr);
  ~ViewSession() override;  // calls stop()

  // Starts the haptic thread. An Error names what the device or its guard lacks.
  std::optional<Error> start();
  // Ends the thread after zero force.
  void stop();

  // One line each, after start(): privileges that the system refused.
  const std::vector<std::string>& warnings() const { return thread_.warnings(); }
  const HapticThread& thread() const { return thread_.thread(); }

  bool newest(ViewState& state, std::vector<BodyPose>& bodies) override;
  std::uint64_t take_ticks(std::vector<TickSummary>& rows) override;
  double rate_Hz() const override { return 1.0 / setup_.dt_s; }
  std::string hello(PageRole role) override;
  std::string status(PageRole role, std::size_t clients) override;
  std::optional<Event> take_event() override;
  void point(const PointerMessage& message) override;
  void let_go() override;
  std::optional<std::string> carry_out(const PageRequest& request) override;
  std::shared_ptr<const std::string> scene_bytes(bool full) override;

 private:
  // What the page gives to the rig: its settings and, unless a person holds a device, the hand.
  struct Hand {
    Hand(const Scene& scene, const RunSetup& setup, const PlantSettings& plant);

    Vec3 start_m;
    LiveSettings live;
    PointerPlan plan;
    SimulatedDevice simulated;
    HeldDevice held;
  };

  ViewSession(const Scene& scene, const RunSetup& setup, const ViewSettings& settings,
              GuardableDevice* device, std::unique_ptr<Hand> hand, std::unique_ptr<Rig> rig);

  HapticSession& session() { return rig_->session(); }
  bool is_simulated() const { return person_ == nullptr; }
  std::optional<std::string> set(const PageRequest& request);
  std::optional<Error> encode_scene();
  void pause(bool paused);
  std::optional<double> measured_rate_Hz();

  const Scene& scene_;
  RunSetup setup_;
  ViewSettings settings_;
  GuardableDevice* person_;  // null: the hand is simulated

  std::unique_ptr<Hand> hand_;
  std::unique_ptr<Rig> rig_;
  StartInsideNews start_inside_news_;
  PageSettings page_settings_;
  StatePublisher publisher_;
  SessionThread thread_;

  // Of the network thread.
  bool is_paused_ = false;
  TickStatistics statistics_;
  std::uint64_t told_trips_ = 0;
  bool has_told_recording_ = false;  // that it ended
  std::string untold_walls_;         // what the judge of the walls says
  std::uint64_t counted_ticks_ = 0;
  std::chrono::steady_clock::time_point counted_at_;
  std::optional<double> last_rate_Hz_;

  std::shared_ptr<const std::string> shown_;  // /felt.glb
  std::size_t triangles_ = 0;
  std::size_t shown_triangles_ = 0;
  std::mutex full_mutex_;
  std::shared_ptr<const std::string> full_;  // made when it is asked for
};

}  // namespace palpate
