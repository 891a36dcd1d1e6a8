#pragma once

// A file system layer of SQLite whose disk fills up, fails, stands still or disappears.

#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <sqlite3.h>
#include <string>
#include <thread>

namespace palpate::test {

// One layer for the process: a recorder uses it by its name.
class FaultLayer {
 public:
  static constexpr const char* kName = "palpate-test-faults";

  enum class Fault : std::uint8_t { kNone, kFull, kIoError, kGone };

  // The n-th write, truncation or synchronisation from now on (1: the next), and all after it,
  // fail.
  static void fail_at(std::uint64_t n, Fault fault) {
    register_once();
    state().fault = fault;
    state().fails_at = state().operations + n;
  }
  static void heal() {
    register_once();
    state().fault = Fault::kNone;
    state().still_ms = 0;
  }
  // Each write stands still until this time has passed since now.
  static void stand_still(std::chrono::milliseconds time) {
    register_once();
    state().still_until = (std::chrono::steady_clock::now() + time).time_since_epoch().count();
    state().still_ms = time.count();
  }
  static std::uint64_t operations() { return state().operations; }

 private:
  struct File {
    sqlite3_file base;
    sqlite3_file* real;
  };
  struct State {
    sqlite3_vfs layer{};
    sqlite3_vfs* real = nullptr;
    sqlite3_io_methods methods{};
    std::atomic<std::uint64_t> operations{0};
    std::atomic<std::uint64_t> fails_at{0};
    std::atomic<Fault> fault{Fault::kNone};
    std::atomic<std::int64_t> still_ms{0};
    std::atomic<std::int64_t> still_until{0};
  };
  static State& state() {
    static State state;
    return state;
  }
  static sqlite3_file* real(sqlite3_file* file) { return reinterpret_cast<File*>(file)->real; }

  // SQLITE_OK, or the code of the fault.
  static int begin_operation() {
    State& s = state();
    while (s.still_ms > 0 &&
           std::chrono::steady_clock::now().time_since_epoch().count() < s.still_until) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    const std::uint64_t n = ++s.operations;
    if (s.fault == Fault::kNone || n < s.fails_at) return SQLITE_OK;
    return s.fault == Fault::kFull ? SQLITE_FULL : SQLITE_IOERR_WRITE;
  }
  static bool is_gone() {
    State& s = state();
    return s.fault == Fault::kGone && s.operations >= s.fails_at;
  }

  static int close(sqlite3_file* file) {
    const int code = real(file)->pMethods ? real(file)->pMethods->xClose(real(file)) : SQLITE_OK;
    sqlite3_free(real(file));
    return code;
  }
  static int read(sqlite3_file* file, void* to, int amount, sqlite3_int64 from) {
    if (is_gone()) return SQLITE_IOERR_READ;
    return real(file)->pMethods->xRead(real(file), to, amount, from);
  }
  static int write(sqlite3_file* file, const void* from, int amount, sqlite3_int64 to) {
    if (const int code = begin_operation()) return code;
    return real(file)->pMethods->xWrite(real(file), from, amount, to);
  }
  static int truncate(sqlite3_file* file, sqlite3_int64 size) {
    if (const int code = begin_operation()) return code;
    return real(file)->pMethods->xTruncate(real(file), size);
  }
  static int sync(sqlite3_file* file, int flags) {
    if (const int code = begin_operation()) return code;
    return real(file)->pMethods->xSync(real(file), flags);
  }
  static int size(sqlite3_file* file, sqlite3_int64* bytes) {
    if (is_gone()) return SQLITE_IOERR_FSTAT;
    return real(file)->pMethods->xFileSize(real(file), bytes);
  }
  static int lock(sqlite3_file* file, int level) {
    return real(file)->pMethods->xLock(real(file), level);
  }
  static int unlock(sqlite3_file* file, int level) {
    return real(file)->pMethods->xUnlock(real(file), level);
  }
  static int check_lock(sqlite3_file* file, int* is_locked) {
    return real(file)->pMethods->xCheckReservedLock(real(file), is_locked);
  }
  static int control(sqlite3_file* file, int operation, void* argument) {
    return real(file)->pMethods->xFileControl(real(file), operation, argument);
  }
  static int sector(sqlite3_file* file) { return real(file)->pMethods->xSectorSize(real(file)); }
  static int characteristics(sqlite3_file* file) {
    return real(file)->pMethods->xDeviceCharacteristics(real(file));
  }

  static int open(sqlite3_vfs*, const char* name, sqlite3_file* file, int flags, int* flags_out) {
    State& s = state();
    auto* opened = static_cast<sqlite3_file*>(sqlite3_malloc(s.real->szOsFile));
    if (!opened) return SQLITE_NOMEM;
    std::memset(opened, 0, static_cast<std::size_t>(s.real->szOsFile));
    reinterpret_cast<File*>(file)->real = opened;
    const int code =
        is_gone() ? SQLITE_CANTOPEN : s.real->xOpen(s.real, name, opened, flags, flags_out);
    if (code != SQLITE_OK) {
      sqlite3_free(opened);
      file->pMethods = nullptr;
      return code;
    }
    file->pMethods = &s.methods;
    return SQLITE_OK;
  }
  static int remove(sqlite3_vfs*, const char* name, int is_synced) {
    if (const int code = begin_operation()) return code;
    return state().real->xDelete(state().real, name, is_synced);
  }

  static void register_once() {
    static const bool is_registered = [] {
      State& s = state();
      s.real = sqlite3_vfs_find(nullptr);
      s.layer = *s.real;
      s.layer.iVersion = 1;
      s.layer.szOsFile = sizeof(File);
      s.layer.pNext = nullptr;
      s.layer.zName = kName;
      s.layer.xOpen = open;
      s.layer.xDelete = remove;
      s.methods = {1,       close,      read,    write,  truncate,        sync,    size,    lock,
                   unlock,  check_lock, control, sector, characteristics, nullptr, nullptr, nullptr,
                   nullptr, nullptr,    nullptr};
      return sqlite3_vfs_register(&s.layer, 0) == SQLITE_OK;
    }();
    (void)is_registered;
  }
};

}  // namespace palpate::test
