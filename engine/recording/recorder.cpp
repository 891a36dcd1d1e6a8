#include "engine/recording/recorder.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <new>
#include <pthread.h>
#include <sstream>
#include <system_error>
#include <utility>
#include <vector>

#include "engine/recording/block_codec.h"
#include "engine/recording/event_log.h"
#include "engine/recording/pending_blocks.h"
#include "engine/recording/recorder_rings.h"
#include "engine/recording/recording_file.h"
#include "engine/recording/recording_settings.h"

namespace palpate {
namespace {

constexpr auto kTransactionEvery = std::chrono::milliseconds(250);
// In virtual time, how often the recorder looks whether a block is full, and the session whether a
// ring has space.
constexpr auto kLookEvery = std::chrono::microseconds(500);
// A log of 16 MiB is copied into the file, which takes a part of a second every few minutes. In
// simulated time this happens only at the end, because the log would be full after each
// transaction.
constexpr int kLogPages = 4096;
constexpr double kMostRows = 1 << 20;
// A longer transaction is committed before its time is over.
constexpr std::size_t kMostPendingBytes = std::size_t{2} << 20;

// Its text takes no memory.
Error out_of_memory() {
  return {ErrorCode::kOutOfMemory, "", "", "out of memory", ""};
}

}  // namespace

struct Recorder::State {
  State(RecordingFile created, const RecorderSettings& recorder_settings)
      : settings(recorder_settings),
        file(std::move(created)),
        ring(static_cast<std::size_t>(
                 std::clamp(std::ceil(settings.seconds * settings.rate_Hz), 1.0, kMostRows)),
             settings.input_bytes) {}

  RecorderSettings settings;
  std::string path;
  RecordingFile file;
  RecorderRing ring;
  EventRing events;

  // Of the recorder's thread.
  BlockEncoder encoder;
  std::vector<RecordedTick> rows;  // of the block that is not full
  std::vector<std::byte> inputs;   // of these rows
  EventLog log;
  PendingBlocks pending;  // of the open transaction
  std::vector<EventRow> event_rows;
  std::optional<RecordingMeta> facts;
  std::uint64_t next_tick = 0;  // after the last tick taken
  double newest_time_s = 0.0;   // of the last tick taken
  std::optional<Error> error;
  bool has_ended = false;  // the file has its ending

  // Of several threads: the facts of the session's start, events, and the request to end.
  struct OwnersEvent {
    EventRow row;
    EventTime time;
  };
  std::vector<OwnersEvent> owners_events;
  std::mutex mutex;
  std::condition_variable wakes;
  std::optional<RecordingMeta> start;
  bool must_end = false;
  std::atomic<bool> lacks_start{false};  // there was no memory for it

  // Takes ticks from the ring until it is empty or the time has come, and writes full blocks.
  void take_ticks(std::chrono::steady_clock::time_point until);
  // Writes the rows of a block that is not full.
  void write_rest(bool keeps_rows);
  void close_block();
  void write_block();
  void write_events(bool is_last);
  void write_event(EventRow row);
  void write_owners_events();
  std::optional<Error> add_event(const EventRow& row);
  void write_start();
  void take_gap();
  void commit();
  void end_on_full_disk();
  // Whether the recording must end.
  bool wait(std::chrono::steady_clock::time_point until) {
    std::unique_lock lock(mutex);
    wakes.wait_until(lock, until, [this] { return must_end; });
    return must_end;
  }
  void fail(std::optional<Error> problem) {
    if (problem && !error) error = std::move(problem);
  }
};

void Recorder::State::write_block() {
  if (rows.empty() || error) return;
  const std::span<const std::byte> columns = encoder.columns(rows);
  const std::span<const std::byte> packed_inputs = encoder.inputs(inputs);
  if (columns.empty() || packed_inputs.empty()) {
    return fail(Error{ErrorCode::kOutOfMemory, path, "", "needs memory to compress", ""});
  }
  pending.add({rows.front().record.tick, rows.size(), std::vector(columns.begin(), columns.end()),
               std::vector(packed_inputs.begin(), packed_inputs.end())});
  fail(pending.write_last(file));
}

void Recorder::State::commit() {
  write_start();
  if (!error) fail(file.commit());
  if (error) return;
  pending.set_committed();
  event_rows.clear();
  facts.reset();
}

// Keeps what fits, and writes the ending. What came after the last tick that is kept is not said.
void Recorder::State::end_on_full_disk() {
  file.rollback();
  // Without them, no tick can be replayed.
  if (facts && (file.begin() || file.set_meta(*facts) || file.commit())) file.rollback();
  pending.write_what_fits(file);
  if (!file.begin()) {
    bool fits = true;
    for (const EventRow& row : event_rows) {
      if (row.tick < pending.end_tick()) fits = fits && !add_event(row);
    }
    if (!fits || file.commit()) file.rollback();
  }
  has_ended = !file.add_ending(
      static_cast<std::int64_t>(pending.committed_ticks()),
      static_cast<std::int64_t>(pending.end_tick() - pending.committed_ticks()), kDiskFull);
}

// Ticks are missing before the oldest one of the ring: a block has no gap.
void Recorder::State::take_gap() {
  const RecordedTick& front = ring.front();
  const std::uint64_t missing = front.record.tick - next_tick;
  log.add_drop(next_tick, front.record.time_s, missing);
}

void Recorder::State::close_block() {
  write_block();
  rows.clear();
  inputs.clear();
  if (error || pending.bytes() < kMostPendingBytes) return;
  commit();
  if (!error) fail(file.begin());
}

void Recorder::State::take_ticks(std::chrono::steady_clock::time_point until) {
  // What is there now is taken in any case: it may have waited during a slow transaction.
  std::size_t waiting = ring.ticks();
  while (!error && ring.ticks() > 0) {
    const RecordedTick& front = ring.front();
    if (front.record.tick != next_tick) {
      take_gap();
      close_block();
    }
    if (inputs.size() + ring.front_input_bytes() > kMostBlockInputBytes) close_block();
    rows.push_back(front);
    next_tick = front.record.tick + 1;
    newest_time_s = front.record.time_s;
    ring.take(static_cast<std::uint32_t>(rows.size() - 1), inputs);
    if (waiting > 0) --waiting;
    if (rows.size() < kMostBlockTicks) continue;
    close_block();
    if (waiting == 0 && std::chrono::steady_clock::now() >= until) return;
  }
}

void Recorder::State::write_rest(bool keeps_rows) {
  if (keeps_rows) return write_block();
  close_block();
}

void Recorder::State::write_events(bool is_last) {
  RecordedEvent event;
  while (events.take(event)) log.add(event);
  log.add_lost(events.take_lost());
  if (is_last) log.finish();
  for (EventRow& row : log.take_rows()) write_event(std::move(row));
  write_owners_events();
}

void Recorder::State::write_event(EventRow row) {
  if (!error) fail(add_event(row));
  event_rows.push_back(std::move(row));
}

void Recorder::State::write_owners_events() {
  std::vector<OwnersEvent> taken;
  {
    const std::lock_guard lock(mutex);
    taken.swap(owners_events);
  }
  for (OwnersEvent& event : taken) {
    if (event.time == EventTime::kNow) {
      event.row.tick = next_tick - std::min<std::uint64_t>(next_tick, 1);
      event.row.time_s = newest_time_s;
    }
    write_event(std::move(event.row));
  }
}

std::optional<Error> Recorder::State::add_event(const EventRow& row) {
  return file.add_event(static_cast<std::int64_t>(row.tick), row.time_s, row.kind, row.detail);
}

void Recorder::State::write_start() {
  {
    const std::lock_guard lock(mutex);
    if (!start) return;
    facts.swap(start);
  }
  if (!error) fail(file.set_meta(*facts));
}

Result<std::unique_ptr<Recorder>> Recorder::create(const std::string& path,
                                                   const RecordingMeta& meta,
                                                   const RecorderSettings& settings) {
  auto file = RecordingFile::create(path, meta, settings.file_system,
                                    settings.virtual_time ? 0 : kLogPages);
  if (!file) return file.error();
  try {
    auto state = std::make_unique<State>(std::move(*file), settings);
    state->path = path;
    state->rows.reserve(kMostBlockTicks);
    std::unique_ptr<Recorder> recorder(new Recorder(std::move(state)));
    // The program's signals are handled by other threads.
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    recorder->thread_ = std::thread([r = recorder.get()] { r->run(); });
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
    return recorder;
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kOutOfMemory, path, "", "needs memory for the rings of the recorder",
                 ""};
  } catch (const std::system_error& failed) {
    return Error{ErrorCode::kOutOfMemory, path, "",
                 std::string("needs a thread, which the system refuses: ") + failed.what(), ""};
  }
}

Recorder::Recorder(std::unique_ptr<State> state)
    : state_(std::move(state)), waits_(state_->settings.virtual_time) {}

Recorder::~Recorder() {
  if (thread_.joinable()) finish("abandoned");
}

void Recorder::on_start(const SessionFacts& facts) noexcept {
  try {
    RecordingMeta meta = meta_of(facts);
    const std::lock_guard lock(state_->mutex);
    state_->start = std::move(meta);
  } catch (const std::bad_alloc&) {
    state_->lacks_start.store(true, std::memory_order_release);
  }
}

// Virtual time only. False if the recorder will not take anything any more.
bool Recorder::wait_for_space() const noexcept {
  if (!waits_ || has_failed()) return false;
  std::this_thread::sleep_for(kLookEvery);
  return true;
}

void Recorder::on_input(const TickInput& input) noexcept {
  if (is_tick_lost_ || has_failed()) return;
  for (;;) {
    // In a ring without a tick there is no space to wait for.
    const bool may_get_space = state_->ring.ticks() > 0;
    if (state_->ring.add_input(input)) return;
    if (may_get_space && wait_for_space()) continue;
    is_tick_lost_ = true;
    return;
  }
}

void Recorder::on_tick(const TickRecord& record, const TickReading& reading) noexcept {
  tick_ = record.tick;
  time_s_ = record.time_s;
  if (has_failed()) return;
  if (is_tick_lost_) return drop_tick();
  while (!state_->ring.add_tick(record, reading)) {
    if (!wait_for_space()) return drop_tick();
  }
}

void Recorder::drop_tick() noexcept {
  state_->ring.forget_inputs();
  is_tick_lost_ = false;
  dropped_.fetch_add(1, std::memory_order_relaxed);
}

void Recorder::on_trip(const GovernorTrip& trip) noexcept {
  RecordedEvent event;
  event.kind = EventKind::kTrip;
  event.tick = trip.tick;
  event.time_s = trip.time_s;
  event.trip = trip;
  state_->events.add(event);
}

std::optional<std::string> Recorder::failure() const {
  if (!has_failed()) return std::nullopt;
  return state_->error->problem;
}

void Recorder::on_late(LateCause cause, const TickCost& cost) noexcept {
  RecordedEvent event;
  event.kind = EventKind::kLate;
  event.cause = cause;
  event.tick = tick_;
  event.time_s = time_s_;
  event.late_ns = cost.late_ns + cost.wall_ns;
  state_->events.add(event);
}

// The recorder's thread.
void Recorder::run() noexcept {
  ::pthread_setname_np(::pthread_self(), "palpate-record");
  try {
    write();
  } catch (const std::bad_alloc&) {
    state_->fail(out_of_memory());
  }
  if (state_->error) has_failed_.store(true, std::memory_order_release);
}

// A transaction is open while this function waits, because opening it fails only where writing
// would fail, too.
void Recorder::write() {
  using Clock = std::chrono::steady_clock;
  State& state = *state_;
  const bool is_virtual = state.settings.virtual_time;
  bool must_end = false;
  auto due = Clock::now();
  while (!must_end) {
    // A transaction that took long is followed by the next one at once.
    due = std::max(due + kTransactionEvery, Clock::now());
    state.fail(state.file.begin());
    while (!state.error && !must_end && Clock::now() < due) {
      must_end = state.wait(is_virtual ? std::min(due, Clock::now() + kLookEvery) : due);
      if (!is_virtual) continue;
      state.write_start();
      state.take_ticks(due);
    }
    state.write_start();
    if (!state.error) state.take_ticks(must_end ? Clock::time_point::max() : due);
    state.write_rest(is_virtual && !must_end);
    if (!state.error) state.write_events(must_end);
    if (!state.error) state.commit();
    if (state.lacks_start.load(std::memory_order_acquire)) state.fail(out_of_memory());
    if (!state.error) continue;
    if (state.file.is_full()) state.end_on_full_disk();
    return;
  }
}

void Recorder::add_event(const std::string& kind, const std::string& detail, EventTime time) {
  const std::lock_guard lock(state_->mutex);
  state_->owners_events.push_back({{0, 0.0, kind, detail}, time});
}

RecordingResult Recorder::finish(const std::string& why) {
  State& state = *state_;
  {
    const std::lock_guard lock(state.mutex);
    state.must_end = true;
  }
  state.wakes.notify_all();
  thread_.join();
  RecordingResult result;
  result.path = state.path;
  result.ticks = state.pending.committed_ticks();
  // What came after a failure was not dropped: the recording had ended.
  result.dropped = state.error ? state.pending.end_tick() - result.ticks : dropped();
  if (!state.error) {
    state.fail(state.file.add_ending(static_cast<std::int64_t>(result.ticks),
                                     static_cast<std::int64_t>(result.dropped), why));
    state.has_ended = !state.error;
  }
  if (state.has_ended) result.has_log = !state.file.close();
  result.error = state.error;
  for (const std::string& file : {state.path, state.path + "-wal"}) {
    std::error_code failed;
    const auto bytes = std::filesystem::file_size(file, failed);
    if (!failed) result.bytes += bytes;
  }
  return result;
}

}  // namespace palpate
