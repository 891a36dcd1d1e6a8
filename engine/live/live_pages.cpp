#include "engine/live/live_pages.h"

#include <algorithm>
#include <utility>

namespace palpate {
namespace {

using Json = nlohmann::ordered_json;

std::string line_of(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace

std::optional<LiveRequest> LivePages::wait(std::chrono::microseconds time) {
  std::unique_lock lock(mutex_);
  if (!arrived_.wait_for(lock, time, [this] { return !requests_.empty(); })) return std::nullopt;
  LiveRequest request = std::move(requests_.front());
  requests_.pop_front();
  return request;
}

void LivePages::drain(std::chrono::milliseconds time) {
  std::unique_lock lock(mutex_);
  taken_.wait_for(lock, time, [this] { return texts_.empty(); });
}

void LivePages::send(PageRole role, const Json& json) {
  const std::lock_guard lock(mutex_);
  if (texts_.size() < kMostTexts) texts_.push_back({role, line_of(json)});
}

void LivePages::answer(const LiveRequest& request, const std::optional<std::string>& problem) {
  if (!request.id) return;
  const std::lock_guard lock(mutex_);
  if (texts_.size() < kMostTexts) {
    texts_.push_back({request.role, answer_text(request.id, problem)});
  }
}

void LivePages::set_hello(PageRole role, const Json& json) {
  std::string line = line_of(json);
  const std::lock_guard lock(mutex_);
  hellos_[role] = std::move(line);
}

void LivePages::set_status(PageRole role, const Json& json) {
  std::string line = line_of(json);
  const std::lock_guard lock(mutex_);
  statuses_[role] = std::move(line);
}

void LivePages::set_scene(std::shared_ptr<const std::string> glb) {
  const std::lock_guard lock(mutex_);
  glb_ = std::move(glb);
}

void LivePages::set_trial(std::shared_ptr<PersonTrial> trial) {
  const std::lock_guard lock(mutex_);
  if (trial_) seen_.missed_deadlines = trial_->missed_deadlines();
  if (trial) seen_ = {};
  trial_.swap(trial);
}

LivePages::SeenTicks LivePages::seen_ticks() {
  const std::lock_guard lock(mutex_);
  if (trial_) seen_.missed_deadlines = trial_->missed_deadlines();
  const SeenTicks seen = seen_;
  seen_.rules = 0;
  return seen;
}

std::shared_ptr<PersonTrial> LivePages::trial() {
  const std::lock_guard lock(mutex_);
  return trial_;
}

bool LivePages::newest(ViewState& state, std::vector<BodyPose>& bodies) {
  const auto running = trial();
  return running && running->newest(state, bodies);
}

std::uint64_t LivePages::take_ticks(std::vector<TickSummary>& rows) {
  const auto running = trial();
  if (!running) return 0;
  const std::size_t before = rows.size();
  const std::uint64_t lost = running->take_ticks(rows);
  const std::lock_guard lock(mutex_);
  for (std::size_t i = before; i < rows.size(); ++i) {
    seen_.newest_late_us = rows[i].late_us;
    seen_.worst_late_us = std::max(seen_.worst_late_us, seen_.newest_late_us);
    seen_.rules |= rows[i].rules;
  }
  return lost;
}

std::string LivePages::hello(PageRole role) {
  const std::lock_guard lock(mutex_);
  return hellos_[role];
}

std::string LivePages::status(PageRole role, std::size_t /*clients*/) {
  const std::lock_guard lock(mutex_);
  return statuses_[role];
}

std::optional<std::string> LivePages::take_message(PageRole role, bool is_in_control,
                                                   std::string_view text) {
  std::optional<std::uint64_t> id;
  auto request = parse_live_request(role, text, id);
  if (!request) return answer_text(id, request.error().to_string());
  if (role == kParticipantPage && !is_in_control) {
    return answer_text(id, "another page is in control; take control first");
  }
  {
    const std::lock_guard lock(mutex_);
    if (requests_.size() >= kMostRequests) return answer_text(id, "too many messages wait");
    requests_.push_back(std::move(*request));
  }
  arrived_.notify_one();
  return std::string();
}

std::optional<LivePages::PageText> LivePages::take_text() {
  const std::lock_guard lock(mutex_);
  if (texts_.empty()) return std::nullopt;
  PageText text = std::move(texts_.front());
  texts_.pop_front();
  if (texts_.empty()) taken_.notify_all();
  return text;
}

void LivePages::point(const PointerMessage& message) {
  if (const auto running = trial()) running->point(message);
}

void LivePages::let_go() {
  {
    const std::lock_guard lock(mutex_);
    if (!requests_.empty() && requests_.back().type == "left") return;  // pages that come and go
    requests_.push_back(
        {kParticipantPage, "left", std::nullopt, {{"type", "left"}, {"why", "hidden"}}});
  }
  arrived_.notify_one();
}

std::shared_ptr<const std::string> LivePages::scene_bytes(bool /*full*/) {
  const std::lock_guard lock(mutex_);
  return glb_;
}

}  // namespace palpate
