#include "engine/session/session_thread.h"

#include <utility>

namespace palpate {

SessionThread::SessionThread(HapticSession& session, GuardableDevice* device,
                             const GuardedRunSettings& settings)
    : session_(session) {
  if (device == nullptr) {
    alone_ = std::make_unique<HapticThread>(session, settings.thread);
  } else {
    guarded_ = std::make_unique<GuardedRun>(*device, session, settings);
  }
}

SessionThread::~SessionThread() {
  stop();
}

std::optional<Error> SessionThread::start() {
  if (guarded_) {
    if (auto error = guarded_->start()) return error;
    warnings_ = guarded_->warnings();
    return std::nullopt;
  }
  RealtimeStatus status = alone_->start();
  if (!status.explanation.empty()) warnings_.push_back(std::move(status.explanation));
  return std::nullopt;
}

void SessionThread::stop() {
  if (alone_) alone_->stop();
  if (guarded_) guarded_->stop();
  session_.stop();
}

const HapticThread& SessionThread::thread() const {
  return alone_ ? *alone_ : guarded_->thread();
}

}  // namespace palpate
