#pragma once

// A file system layer of SQLite that only reads.

namespace palpate {

// Registers the layer and returns its SQLite name; null if SQLite has no memory. Files are opened
// for reading, nothing is ever created, written, removed, locked or mapped, and the index of a
// write-ahead log lies in the reader's own memory. So a log that a crash has left is used even
// where the folder cannot be written. Thread-safe.
const char* read_only_files() noexcept;

}  // namespace palpate
