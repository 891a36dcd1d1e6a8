#pragma once

// Joins the parts of all units of a dealt run (dealt_run.h), and writes its results.

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/report/output_files.h"
#include "engine/trials/deal/run_identity.h"
#include "geometry/base/result.h"

namespace palpate {

// The kind of the run whose parts are in a folder. The error names a folder without parts, or the
// element of its parts/run.json.
Result<RunKind> kind_of_run_in(const std::string& folder);

struct JoinedParts {
  RunIdentity identity;
  std::string rows;  // of all units, in their order, below the line of the names of the columns
};

// Reads the parts in these folders and checks them. columns_of: the names of the columns of a run's
// rows, for runs whose kind is `kind`.
//
// Errors, which name the file: a folder without parts; a run of another kind; folders of different
// runs, with the entry that differs (find_difference); a part with wrong hashes; a unit whose parts
// in two folders differ, with the line and the column; units without a part.
Result<JoinedParts> join_parts(const std::vector<std::string>& folders, RunKind kind,
                               const std::function<std::string(const RunIdentity&)>& columns_of);

// Writes the texts as files of these names, which are results of a run of this kind, beside the
// folder's own files. They appear in the folder when the caller moves them into place, together or
// not at all; the caller may add the page before (page_names). The results of another kind of run
// in the folder are removed then; what has such a name and is no file is left alone. An error if
// another process writes there.
Result<OutputFiles> stage_results(const std::string& folder, RunKind kind,
                                  const std::vector<std::pair<std::string, std::string>>& texts);

}  // namespace palpate
