// The process that makes pages, played by scripts in place of the interpreter.

#include "engine/cli/python_page.h"

#include <filesystem>
#include <gmock/gmock.h>
#include <string>
#include <sys/stat.h>

#include <gtest/gtest.h>

#include "tests/engine/cli/run_program.h"
#include "tests/helpers/environment_variable.h"
#include "tests/helpers/made.h"

namespace palpate {
namespace {

using test::EnvironmentVariable;
using test::TemporaryFolder;
using testing::ElementsAre;
using testing::HasSubstr;

// A folder with scripts that play interpreters, and the files of a command.
class PythonPage : public testing::Test {
 protected:
  // Returns the path of a script that does this in place of an interpreter.
  std::string interpreter(const std::string& name, const std::string& commands) const {
    const std::string path = folder_.write(name, "#!/bin/sh\n" + commands + "\n");
    ::chmod(path.c_str(), 0700);
    return path;
  }
  PageOutcome made_by(const std::string& interpreter) const {
    const EnvironmentVariable chosen("PALPATE_PYTHON", interpreter);
    return make_page({"experiment", "--trials=no-trials.csv"}, files_);
  }

  TemporaryFolder folder_;
  OutputFiles files_ = test::made(OutputFiles::create(folder_.path("out"), {"report.html"}));
};

TEST_F(PythonPage, HasTheTextAndTheWarningsOfTheProcess) {
  const PageOutcome outcome =
      made_by(interpreter("python",
                          "echo an answer\necho 'palpate: warning: a warning' >&2\n"
                          "echo 'UserWarning: of a library' >&2\nexit 64"));
  EXPECT_EQ(outcome.end, PageEnd::kMade);
  EXPECT_EQ(outcome.text, "an answer\n");
  EXPECT_THAT(outcome.warnings, ElementsAre("a warning"));
}

TEST_F(PythonPage, StartsWithoutTheWorkingFolderAndWithOneThreadOfBlas) {
  const EnvironmentVariable threads("OPENBLAS_NUM_THREADS", "8");
  const PageOutcome outcome = made_by(
      interpreter("python", "echo \"$1 $2 $OPENBLAS_NUM_THREADS\"\nshift 4\necho \"$@\"\nexit 64"));
  EXPECT_EQ(outcome.end, PageEnd::kMade) << outcome.problem;
  EXPECT_EQ(outcome.text,
            "-P -c 1\nexperiment --out=" + files_.hidden_folder() + " --trials=no-trials.csv\n");
}

TEST_F(PythonPage, RefusesWithTheLineOfTheProcess) {
  const PageOutcome outcome =
      made_by(interpreter("python", "echo 'palpate: trials.csv: line 3: is wrong' >&2\nexit 66"));
  EXPECT_EQ(outcome.end, PageEnd::kRefused);
  EXPECT_EQ(outcome.problem, "trials.csv: line 3: is wrong");
}

TEST_F(PythonPage, NamesThePackagesThatAreMissing) {
  const PageOutcome outcome = made_by(interpreter("python", "echo scipy jinja2\nexit 93"));
  EXPECT_EQ(outcome.end, PageEnd::kMissing);
  EXPECT_THAT(outcome.problem, HasSubstr("python has no package scipy jinja2 (install "));
}

TEST_F(PythonPage, NamesAnInterpreterThatDoesNotStart) {
  const PageOutcome outcome = made_by(folder_.path("no-python"));
  EXPECT_EQ(outcome.end, PageEnd::kMissing);
  EXPECT_THAT(outcome.problem, HasSubstr("no-python could not be started (install "));
}

TEST_F(PythonPage, NamesAnInterpreterThatIsTooOld) {
  const PageOutcome outcome =
      made_by(interpreter("python", "echo 'Unknown option: -P' >&2\nexit 2"));
  EXPECT_EQ(outcome.end, PageEnd::kMissing);
  EXPECT_THAT(
      outcome.problem,
      HasSubstr("python does not work as Python 3.11 or later (exit code 2: Unknown option: -P) "
                "(install "));
}

TEST_F(PythonPage, ShowsTheLastLineOfAProcessThatFails) {
  const PageOutcome outcome = made_by(
      interpreter("python", "echo Traceback >&2\necho 'ValueError: \033[31mred' >&2\nexit 65"));
  EXPECT_EQ(outcome.end, PageEnd::kFailed);
  EXPECT_THAT(outcome.problem, HasSubstr("python failed: ValueError:  [31mred"));
}

TEST_F(PythonPage, ReportsAProcessThatIsKilled) {
  const PageOutcome outcome = made_by(interpreter("python", "kill -9 $$"));
  EXPECT_EQ(outcome.end, PageEnd::kFailed);
  EXPECT_THAT(outcome.problem, HasSubstr("python was killed by signal 9"));
}

// The first python3 in PATH often is one without the packages.
TEST_F(PythonPage, UsesTheInterpreterOfTheSystemIfTheFirstOneHasNoPackages) {
  interpreter("bin/python3", "echo numpy\nexit 93");
  const EnvironmentVariable path("PATH", folder_.path("bin") + ":/usr/bin:/bin");
  const PageOutcome outcome = made_by("");
  if (outcome.end == PageEnd::kMissing) {
    EXPECT_THAT(outcome.problem, HasSubstr("python3 has no package numpy; /usr/bin/python3 "));
  } else {
    EXPECT_EQ(outcome.end, PageEnd::kRefused);  // there is no trials.csv
    EXPECT_THAT(outcome.problem, HasSubstr("no-trials.csv"));
  }
}

// A shim of a version manager that has no version set ends like this.
TEST_F(PythonPage, UsesTheInterpreterOfTheSystemIfTheFirstOneIsBroken) {
  for (const char* const end : {"exit 126", "exit 1", "exit 0"}) {
    interpreter("bin/python3", std::string("echo 'No version is set' >&2\n") + end);
    const EnvironmentVariable path("PATH", folder_.path("bin") + ":/usr/bin:/bin");
    const PageOutcome outcome = made_by("");
    if (outcome.end == PageEnd::kMissing) {
      EXPECT_THAT(outcome.problem, HasSubstr("No version is set); /usr/bin/python3 ")) << end;
    } else {
      EXPECT_EQ(outcome.end, PageEnd::kRefused) << end;  // there is no trials.csv
    }
  }
}

// With this variable, an interpreter does not end with the exit code of what it ran.
TEST_F(PythonPage, EndsAlsoIfTheInterpreterIsToldToStay) {
  const EnvironmentVariable inspect("PYTHONINSPECT", "1");
  EXPECT_NE(made_by("").end, PageEnd::kFailed);
}

TEST_F(PythonPage, TakesTheFirstInterpreterThatHasThePackages) {
  interpreter("bin/python3", "echo the first\nexit 64");
  const EnvironmentVariable path("PATH", folder_.path("bin") + ":/usr/bin:/bin");
  EXPECT_EQ(made_by("").text, "the first\n");
}

// A pipe holds 64 KiB; a process that fills one must not wait for ever.
TEST_F(PythonPage, ReadsLongTextsOfBothStreams) {
  const PageOutcome outcome =
      made_by(interpreter("python",
                          "head -c 1000000 /dev/zero | tr '\\0' e >&2\nhead -c 2000000 /dev/zero | "
                          "tr '\\0' o\nexit 64"));
  EXPECT_EQ(outcome.end, PageEnd::kMade);
  EXPECT_EQ(outcome.text.size(), 2'000'000u);
}

}  // namespace
}  // namespace palpate
