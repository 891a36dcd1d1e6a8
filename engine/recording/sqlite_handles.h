#pragma once

// SQLite's objects with their destructors, and its errors as text.

#include <memory>
#include <sqlite3.h>
#include <string>

namespace palpate {

struct CloseDatabase {
  void operator()(sqlite3* database) const noexcept { sqlite3_close(database); }
};
struct FinalizeStatement {
  void operator()(sqlite3_stmt* statement) const noexcept { sqlite3_finalize(statement); }
};
using Database = std::unique_ptr<sqlite3, CloseDatabase>;
using Statement = std::unique_ptr<sqlite3_stmt, FinalizeStatement>;

// Null if the text cannot be prepared; sqlite3_errmsg() has the reason.
inline Statement prepare(sqlite3* database, const char* sql) {
  sqlite3_stmt* statement = nullptr;
  sqlite3_prepare_v2(database, sql, -1, &statement, nullptr);
  return Statement(statement);
}

inline std::string sqlite_problem(sqlite3* database) {
  return database ? sqlite3_errmsg(database) : "no memory";
}

}  // namespace palpate
