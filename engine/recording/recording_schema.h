#pragma once

// What makes a file a recording (FORMAT.md).

#include <array>
#include <cstdint>

namespace palpate {

// "Plpt", in the header of the database.
inline constexpr std::uint32_t kRecordingApplication = 0x506c7074;
// What is written. A reader takes this version and those before it, from 1 on.
inline constexpr int kRecordingVersion = 2;

struct RecordingTable {
  const char* name;
  const char* sql;
};
// Exactly these tables make a recording, with these texts.
inline constexpr std::array kRecordingTables = {
    RecordingTable{"meta",
                   "CREATE TABLE meta (key TEXT PRIMARY KEY, value ANY) STRICT, "
                   "WITHOUT ROWID"},
    RecordingTable{"block",
                   "CREATE TABLE block (first_tick INTEGER PRIMARY KEY, ticks INTEGER NOT NULL, "
                   "columns BLOB NOT NULL, inputs BLOB NOT NULL) STRICT"},
    RecordingTable{"event",
                   "CREATE TABLE event (tick INTEGER NOT NULL, time REAL NOT NULL, "
                   "kind TEXT NOT NULL, detail TEXT NOT NULL) STRICT"},
    RecordingTable{"ending",
                   "CREATE TABLE ending (ticks INTEGER NOT NULL, dropped INTEGER NOT NULL, "
                   "why TEXT NOT NULL) STRICT"},
};

}  // namespace palpate
