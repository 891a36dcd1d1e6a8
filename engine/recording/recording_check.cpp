#include "engine/recording/recording_check.h"

#include <functional>
#include <limits>
#include <utility>

#include "engine/recording/block_walk.h"
#include "engine/recording/recording_file.h"
#include "engine/session/trace_csv.h"

namespace palpate {
namespace {

constexpr std::size_t kMostEvents = 1'000'000;
// Of a copy: a transaction is kept in memory until it is committed, and a log until it is copied.
constexpr std::uint64_t kBlocksPerTransaction = 64;
constexpr int kCopyLogPages = 4096;

void add_gap(std::int64_t first, std::int64_t count, RecordingCheck& check) {
  if (count <= 0) return;
  check.missing += static_cast<std::uint64_t>(count);
  if (check.gaps.size() < RecordingCheck::kMostListed) check.gaps.push_back({first, count});
}

void add_problem(const Error& error, RecordingCheck& check) {
  ++check.problem_count;
  if (check.problems.size() == RecordingCheck::kMostListed) return;
  check.problems.push_back(error.element + ": " + error.problem);
}

// Visits all blocks. visit: called with each good block; its error ends the walk.
using Visit = std::function<std::optional<Error>(const WalkStep&)>;

Result<RecordingCheck> walk_blocks(const RecordingReader& reader, const RecordingProgress& progress,
                                   const Visit& visit) {
  RecordingCheck check;
  BlockWalk walk(reader);
  for (WalkStep step = walk.next(); step.kind != WalkStep::Kind::kEnd; step = walk.next()) {
    if (step.kind != WalkStep::Kind::kBlock) {
      add_problem(*step.error, check);
      continue;
    }
    add_gap(step.first_tick - step.missing, step.missing, check);
    ++check.blocks;
    check.ticks += step.content.rows.size();
    check.inputs += step.content.inputs.size();
    if (auto error = visit(step)) return *error;
    if (progress) progress(walk.share());
  }
  auto ending = reader.ending();
  if (!ending) {
    add_problem(ending.error(), check);
    return check;
  }
  check.ending = std::move(*ending);
  if (!check.ending) {
    if (reader.lacks_log()) {
      add_problem({ErrorCode::kInvalidContent, "", "log",
                   "is missing: its process died, and the newest ticks are in " + reader.path() +
                       "-wal; copy that file beside this one",
                   ""},
                  check);
    }
    return check;
  }
  // Ticks are missing at the end if the ending counts more than there are.
  const std::int64_t written = check.ending->ticks, dropped = check.ending->dropped;
  constexpr auto kMost = std::numeric_limits<std::int64_t>::max();
  if (written < 0 || dropped < 0 || written > kMost - dropped) {
    add_problem({ErrorCode::kInvalidContent, "", "ending", "has impossible numbers of ticks", ""},
                check);
  } else {
    add_gap(walk.next_tick(), written + dropped - walk.next_tick(), check);
    if (walk.next_tick() > written + dropped) {
      add_problem({ErrorCode::kInvalidContent, "", "ending",
                   "counts " + std::to_string(written + dropped) + " ticks; there are " +
                       std::to_string(walk.next_tick()),
                   ""},
                  check);
    }
  }
  return check;
}

}  // namespace

Result<RecordingCheck> check_recording(const RecordingReader& reader,
                                       const RecordingProgress& progress) {
  return walk_blocks(reader, progress, [](const WalkStep&) { return std::nullopt; });
}

Result<RecordingCheck> repair_recording(const RecordingReader& reader, const std::string& to,
                                        const RecordingProgress& progress) {
  auto file =
      RecordingFile::create(to, reader.readable_meta(), nullptr, kCopyLogPages, reader.version());
  if (!file) return file.error();
  if (auto error = file->begin()) return *error;
  std::uint64_t blocks = 0;
  auto check = walk_blocks(reader, progress, [&](const WalkStep& step) -> std::optional<Error> {
    if (++blocks % kBlocksPerTransaction == 0) {
      if (auto error = file->commit()) return error;
      if (auto error = file->begin()) return error;
    }
    return file->add_block(step.first_tick, step.frames.ticks, step.frames.columns,
                           step.frames.inputs);
  });
  if (!check) return check;
  if (const auto events = reader.events(kMostEvents)) {
    for (const EventRow& e : *events) {
      if (auto error =
              file->add_event(static_cast<std::int64_t>(e.tick), e.time_s, e.kind, e.detail)) {
        return *error;
      }
    }
  }
  if (auto error = file->commit()) return *error;
  const std::string why =
      "repaired" + (check->ending ? "; ended: " + check->ending->why : std::string());
  const auto dropped =
      static_cast<std::int64_t>(check->missing);  // what is missing was dropped on the way here
  if (auto error = file->add_ending(static_cast<std::int64_t>(check->ticks), dropped, why)) {
    return *error;
  }
  if (!file->close()) {
    return Error{ErrorCode::kFileUnwritable, to, "",
                 "needs its log, " + to + "-wal, because the disk is full", ""};
  }
  return check;
}

Result<RecordingCheck> export_recording(const RecordingReader& reader, const std::string& to,
                                        const RecordingProgress& progress) {
  auto trace = TraceWriter::create(to);
  if (!trace) return trace.error();
  auto check = walk_blocks(reader, progress, [&](const WalkStep& step) -> std::optional<Error> {
    for (const RecordedTick& row : step.content.rows) trace->add(row.record);
    return std::nullopt;
  });
  if (!check) return check;
  const auto written = trace->finish();
  if (!written) return written.error();
  return check;
}

}  // namespace palpate
