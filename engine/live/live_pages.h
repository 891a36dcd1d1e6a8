#pragma once

// Between the server's thread and the thread that leads a participant through the course.

#include <array>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "engine/live/live_request.h"
#include "engine/live/person_trial.h"
#include "engine/viewer/view_model.h"

namespace palpate {

// The owner's thread calls the functions of the first part, the server's thread those of ViewModel.
// The haptic thread calls none.
class LivePages final : public ViewModel {
 public:
  static constexpr std::size_t kMostRequests = 256;  // that wait for the owner
  static constexpr std::size_t kMostTexts = 1024;    // that wait for the server

  // is_blind: the experimenter's pages get neither states nor ticks, which tell the condition.
  LivePages(double rate_Hz, bool is_blind) : rate_Hz_(rate_Hz), is_blind_(is_blind) {}

  // The next message of a page, or no value if none comes in this time.
  std::optional<LiveRequest> wait(std::chrono::microseconds time);
  // Waits until the server has taken all texts, and not longer than this time.
  void drain(std::chrono::milliseconds time);
  // To the pages of a role that are open now.
  void send(PageRole role, const nlohmann::ordered_json& json);
  void answer(const LiveRequest& request, const std::optional<std::string>& problem);
  // What a page of a role is told first, and four times a second.
  void set_hello(PageRole role, const nlohmann::ordered_json& json);
  void set_status(PageRole role, const nlohmann::ordered_json& json);
  // The scene that the pages draw, as GLB, and the trial whose states they get; null: none.
  void set_scene(std::shared_ptr<const std::string> glb);
  void set_trial(std::shared_ptr<PersonTrial> trial);
  // The ticks that the server has seen of the trial that runs, or ran last.
  struct SeenTicks {
    double newest_late_us = 0.0, worst_late_us = 0.0;  // how late they began
    std::uint64_t missed_deadlines = 0;                // see HapticThread
    std::uint32_t rules = 0;  // bits of GovernorRule: what acted since the last call
  };
  SeenTicks seen_ticks();

  bool newest(ViewState& state, std::vector<BodyPose>& bodies) override;
  std::uint64_t take_ticks(std::vector<TickSummary>& rows) override;
  double rate_Hz() const override { return rate_Hz_; }
  std::string hello(PageRole role) override;
  std::string status(PageRole role, std::size_t clients) override;
  bool shows_states(PageRole role) const override { return role == kParticipantPage || !is_blind_; }
  bool shows_ticks(PageRole role) const override { return role == kExperimenterPage && !is_blind_; }
  std::optional<std::string> take_message(PageRole role, bool is_in_control,
                                          std::string_view text) override;
  std::optional<PageText> take_text() override;
  std::optional<Event> take_event() override { return std::nullopt; }
  void point(const PointerMessage& message) override;
  // The participant's page has gone: a trial that runs ends.
  void let_go() override;
  std::optional<std::string> carry_out(const PageRequest&) override {
    return "is not for this page";
  }
  std::shared_ptr<const std::string> scene_bytes(bool full) override;

 private:
  std::shared_ptr<PersonTrial> trial();

  double rate_Hz_;
  bool is_blind_;
  std::mutex mutex_;
  std::condition_variable arrived_;  // a request
  std::condition_variable taken_;    // all texts
  std::deque<LiveRequest> requests_;
  std::deque<PageText> texts_;
  std::array<std::string, 2> hellos_{"{}", "{}"};    // by PageRole
  std::array<std::string, 2> statuses_{"{}", "{}"};  // by PageRole
  std::shared_ptr<const std::string> glb_ = std::make_shared<const std::string>();
  std::shared_ptr<PersonTrial> trial_;
  SeenTicks seen_;
};

}  // namespace palpate
