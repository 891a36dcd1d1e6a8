#include "engine/recording/read_only_files.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <sqlite3.h>
#include <string_view>
#include <sys/stat.h>
#include <unistd.h>

namespace palpate {
namespace {

constexpr const char* kName = "palpate-read-only";

struct OpenFile {
  sqlite3_file base;  // SQLite's part, first
  int descriptor;
  bool is_database;
};

OpenFile& of(sqlite3_file* file) {
  return *reinterpret_cast<OpenFile*>(file);
}

int close_file(sqlite3_file* file) {
  ::close(of(file).descriptor);
  return SQLITE_OK;
}

int read_file(sqlite3_file* file, void* to, int amount, sqlite3_int64 from) {
  auto* bytes = static_cast<char*>(to);
  int done = 0;
  while (done < amount) {
    const ssize_t got = ::pread(of(file).descriptor, bytes + done,
                                static_cast<std::size_t>(amount - done), from + done);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return SQLITE_IOERR_READ;
    if (got == 0) break;
    done += static_cast<int>(got);
  }
  if (done == amount) return SQLITE_OK;
  std::memset(bytes + done, 0, static_cast<std::size_t>(amount - done));
  return SQLITE_IOERR_SHORT_READ;
}

// The length that the header of a database states; 0 if there is none.
sqlite3_int64 stated_size(int descriptor) {
  constexpr std::size_t kPageSizeAt = 16, kPagesAt = 28;
  std::array<unsigned char, 100> header{};
  const ssize_t got = ::pread(descriptor, header.data(), header.size(), 0);
  if (got != static_cast<ssize_t>(header.size())) return 0;
  const std::uint32_t page = big_endian(&header[kPageSizeAt], 2);
  return sqlite3_int64{page == 1 ? 65536 : page} * big_endian(&header[kPagesAt], 4);
}

// A database that was cut has its stated length: SQLite would refuse all of it otherwise. The pages
// that are gone are read as zeros, which are no page of a table.
int file_size(sqlite3_file* file, sqlite3_int64* size) {
  struct stat status {};
  if (::fstat(of(file).descriptor, &status) != 0) return SQLITE_IOERR_FSTAT;
  *size = status.st_size;
  if (of(file).is_database) *size = std::max(*size, stated_size(of(file).descriptor));
  return SQLITE_OK;
}

int write_file(sqlite3_file*, const void*, int, sqlite3_int64) {
  return SQLITE_READONLY;
}
int truncate_file(sqlite3_file*, sqlite3_int64) {
  return SQLITE_READONLY;
}
int sync_file(sqlite3_file*, int) {
  return SQLITE_OK;
}
int lock_file(sqlite3_file*, int) {
  return SQLITE_OK;
}
int check_reserved(sqlite3_file*, int* is_reserved) {
  *is_reserved = 0;
  return SQLITE_OK;
}
int control_file(sqlite3_file*, int, void*) {
  return SQLITE_NOTFOUND;
}
int sector_size(sqlite3_file*) {
  return 4096;
}
int characteristics(sqlite3_file*) {
  return 0;
}

// Version 1 has no shared memory and no mapping.
constexpr sqlite3_io_methods kMethods = {
    1,         close_file, read_file,      write_file,   truncate_file, sync_file,       file_size,
    lock_file, lock_file,  check_reserved, control_file, sector_size,   characteristics, nullptr,
    nullptr,   nullptr,    nullptr,        nullptr,      nullptr};

int open_file(sqlite3_vfs*, const char* name, sqlite3_file* file, int flags, int* flags_out) {
  file->pMethods = nullptr;
  if (!name) return SQLITE_CANTOPEN;  // a temporary file
  int descriptor = ::open(name, O_RDONLY | O_NONBLOCK | O_CLOEXEC | O_NOCTTY);
  // Where there is no log, SQLite gets an empty one.
  if (descriptor < 0 && (flags & SQLITE_OPEN_WAL) != 0) {
    descriptor = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  }
  if (descriptor < 0) return SQLITE_CANTOPEN;
  of(file).descriptor = descriptor;
  of(file).is_database = (flags & SQLITE_OPEN_MAIN_DB) != 0;
  file->pMethods = &kMethods;
  if (flags_out) *flags_out = (flags & ~SQLITE_OPEN_READWRITE) | SQLITE_OPEN_READONLY;
  return SQLITE_OK;
}

int delete_file(sqlite3_vfs*, const char*, int) {
  return SQLITE_OK;
}

// A recording has no rollback journal: one that lies beside it belongs to nobody.
int access_file(sqlite3_vfs*, const char* name, int flags, int* result) {
  *result = 0;
  if (flags == SQLITE_ACCESS_READWRITE || std::string_view(name).ends_with("-journal")) {
    return SQLITE_OK;
  }
  struct stat status {};
  *result = ::stat(name, &status) == 0 && S_ISREG(status.st_mode) && status.st_size > 0 ? 1 : 0;
  return SQLITE_OK;
}

bool register_layer() {
  const sqlite3_vfs* usual = sqlite3_vfs_find(nullptr);
  if (!usual) return false;
  static sqlite3_vfs layer = *usual;  // its names, time and randomness
  layer.iVersion = 1;
  layer.szOsFile = sizeof(OpenFile);
  layer.pNext = nullptr;
  layer.zName = kName;
  layer.xOpen = open_file;
  layer.xDelete = delete_file;
  layer.xAccess = access_file;
  return sqlite3_vfs_register(&layer, 0) == SQLITE_OK;
}

}  // namespace

const char* read_only_files() noexcept {
  static const bool is_registered = register_layer();
  return is_registered ? kName : nullptr;
}

}  // namespace palpate
