// The files of one command appear together or not at all; other files are not touched.

#include "engine/report/output_files.h"

#include <array>
#include <csignal>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>

#include "engine/report/output_lock.h"
#include "engine/report/whole_file.h"
#include "tests/helpers/deadly_rename.h"
#include "tests/helpers/gltf_builder.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;
using test::TemporaryFolder;

const std::vector<std::string> kNames{"a.csv", "b.csv", "c.svg"};

void write(const fs::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

// All entries below a folder: links with their target, files with their content, folders as "/".
std::map<std::string, std::string> tree_of(const fs::path& folder) {
  std::map<std::string, std::string> tree;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    std::string& text = tree[entry.path().lexically_relative(folder).string()];
    if (entry.is_symlink()) {
      text = "-> " + fs::read_symlink(entry.path()).string();
    } else if (entry.is_directory()) {
      text = "/";
    } else {
      std::ifstream file(entry.path(), std::ios::binary);
      text.assign(std::istreambuf_iterator<char>(file), {});
    }
  }
  return tree;
}

using Tree = std::map<std::string, std::string>;

class OutputFilesTest : public testing::Test {
 protected:
  OutputFiles created(const std::string& name) const {
    auto files = OutputFiles::create(folder.path(name), kNames);
    if (!files) throw std::runtime_error(files.error().to_string());
    return std::move(*files);
  }
  Tree tree() const { return tree_of(folder.path()); }

  TemporaryFolder folder;
};

TEST_F(OutputFilesTest, AppearTogetherWhenTheyAreMoved) {
  OutputFiles files = created("deep/er/out/");
  write(files.path("a.csv"), "1");
  write(files.path("c.svg"), "2");
  EXPECT_FALSE(fs::exists(folder.path("deep/er/out/a.csv")));
  const auto error = files.move_into_place();
  ASSERT_FALSE(error) << error->to_string();
  EXPECT_EQ(tree(), (Tree{{"deep", "/"},
                          {"deep/er", "/"},
                          {"deep/er/out", "/"},
                          {"deep/er/out/a.csv", "1"},
                          {"deep/er/out/c.svg", "2"}}));
}

TEST_F(OutputFilesTest, LeavePreviousFilesUnlessTheyAreMoved) {
  fs::create_directory(folder.path("out"));
  write(folder.path("out/a.csv"), "before");
  const Tree before = tree();
  {
    OutputFiles files = created("out");
    write(files.path("a.csv"), "half");
    OutputFiles moved = std::move(files);
    write(moved.path("b.csv"), "half");
  }
  EXPECT_EQ(tree(), before);
}

TEST_F(OutputFilesTest, RemoveFoldersThatTheyMade) {
  {
    OutputFiles files = created("deep/er/out");
    write(files.path("a.csv"), "half");
  }
  EXPECT_EQ(tree(), Tree{});
  write(folder.path("file"), "");
  fs::create_directory(folder.path("there"));
  EXPECT_FALSE(OutputFiles::create(folder.path("there/new/../../file/out"), kNames));
  EXPECT_EQ(tree(), (Tree{{"file", ""}, {"there", "/"}}));
  {
    OutputFiles files = created("deep/er/out");
    write(folder.path("deep/notes"), "somebody else's");
  }
  EXPECT_EQ(tree(),
            (Tree{{"deep", "/"}, {"deep/notes", "somebody else's"}, {"file", ""}, {"there", "/"}}));
}

TEST_F(OutputFilesTest, RemoveOlderFilesOfTheirNamesOnly) {
  const fs::path out = folder.path("out");
  fs::create_directories(out / "b.csv.d");
  for (const char* name : {"a.csv", "b.csv", "c.svg", "a.csv.bak", "A.csv", ".palpate-notes",
                           "b.csv.d/c.svg", ".palpate-unfinished-notes"}) {
    write(out / name, "old");
  }
  fs::create_directory(out / ".palpate-unfinished-is-it");  // one character too long
  OutputFiles files = created("out");
  write(files.path("a.csv"), "new");
  ASSERT_FALSE(files.move_into_place());
  EXPECT_EQ(tree_of(out), (Tree{{"a.csv", "new"},
                                {"a.csv.bak", "old"},
                                {"A.csv", "old"},
                                {".palpate-notes", "old"},
                                {".palpate-unfinished-notes", "old"},
                                {".palpate-unfinished-is-it", "/"},
                                {"b.csv.d", "/"},
                                {"b.csv.d/c.svg", "old"}}));
}

TEST_F(OutputFilesTest, ReplaceLinksAndKeepTheirTargets) {
  fs::create_directory(folder.path("real"));
  fs::create_directory_symlink("real", folder.path("out"));
  write(folder.path("elsewhere"), "mine");
  for (const char* name : {"real/a.csv", "real/b.csv"}) {
    fs::create_symlink("../elsewhere", folder.path(name));
  }
  fs::create_symlink("nowhere", folder.path("real/c.svg"));
  OutputFiles files = created("out");
  write(files.path("a.csv"), "new");
  ASSERT_FALSE(files.move_into_place());
  EXPECT_EQ(
      tree(),
      (Tree{{"out", "-> real"}, {"real", "/"}, {"real/a.csv", "new"}, {"elsewhere", "mine"}}));
}

TEST_F(OutputFilesTest, RejectANameThatIsNotAFileBeforeWriting) {
  fs::create_directories(folder.path("out/b.csv"));
  const auto files = OutputFiles::create(folder.path("out"), kNames);
  ASSERT_FALSE(files);
  EXPECT_EQ(files.error().path, folder.path("out/b.csv"));
  EXPECT_FALSE(files.error().hint.empty());
  EXPECT_EQ(tree(), (Tree{{"out", "/"}, {"out/b.csv", "/"}}));
}

TEST_F(OutputFilesTest, RejectAPathThatIsNotAFolder) {
  write(folder.path("file"), "mine");
  fs::create_symlink("nowhere", folder.path("dangling"));
  for (const std::string& path :
       {folder.path("file"), folder.path("file/out"), folder.path("dangling"),
        std::string("/proc/palpate-out"), std::string("/proc")}) {
    const auto files = OutputFiles::create(path, kNames);
    ASSERT_FALSE(files) << path;
    EXPECT_EQ(files.error().path, path);
    EXPECT_EQ(files.error().element, "`OutputFiles::folder`");
    EXPECT_FALSE(files.error().hint.empty());
  }
  EXPECT_EQ(tree(), (Tree{{"file", "mine"}, {"dangling", "-> nowhere"}}));
}

// Another entry takes a name while the command runs, so that one file cannot be moved.
TEST_F(OutputFilesTest, RestorePreviousFilesIfAMoveFails) {
  const fs::path out = folder.path("out");
  fs::create_directory(out);
  for (const char* name : {"a.csv", "b.csv"}) write(out / name, "old");
  OutputFiles files = created("out");
  for (const char* name : {"a.csv", "b.csv", "c.svg"}) write(files.path(name), "new");
  // "old/c.svg" in the hidden folder is a folder, so the file in place cannot be moved there.
  const fs::path hidden = fs::path(files.path("a.csv")).parent_path();
  fs::create_directories(hidden / "old" / "c.svg" / "full");
  write(out / "c.svg", "somebody's");
  const auto error = files.move_into_place();
  ASSERT_TRUE(error);
  EXPECT_EQ(error->path, out.string());
  const Tree now = tree_of(out);
  EXPECT_EQ(now.at("a.csv"), "old");
  EXPECT_EQ(now.at("b.csv"), "old");
  EXPECT_EQ(now.at("c.svg"), "somebody's");
}

TEST_F(OutputFilesTest, ReportErrorsUnderTheFinalPath) {
  const OutputFiles files = created("out");
  const Error error = files.in_place({ErrorCode::kFileUnwritable, files.path("b.csv"), "", "", ""});
  EXPECT_EQ(error.path, folder.path("out/b.csv"));
  EXPECT_EQ(files.in_place({ErrorCode::kFileUnwritable, "scene.glb", "", "", ""}).path,
            "scene.glb");
}

// The lock of a folder is one of a process: a child process that is forked, but runs no other
// program, has the locks of its parent.
TEST_F(OutputFilesTest, AreRefusedWhileAnotherProcessHasTheFolder) {
  fs::create_directory(folder.path("out"));
  fs::create_directory_symlink("out", folder.path("link"));
  std::array<int, 2> locked{};
  ASSERT_EQ(::pipe(locked.data()), 0);
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const OutputFiles files = created("out");
    [[maybe_unused]] const auto told = ::write(locked[1], "x", 1);
    ::pause();
  }
  char byte = 0;
  ASSERT_EQ(::read(locked[0], &byte, 1), 1);
  const Tree before = tree();
  for (const char* const name : {"out", "./out/", "link"}) {
    const auto refused = OutputFiles::create(folder.path(name), kNames);
    ASSERT_FALSE(refused) << name;
    EXPECT_EQ(refused.error().path, folder.path(name));
    EXPECT_NE(refused.error().problem.find("is in use"), std::string::npos);
  }
  for (const char* const name : {"out/x.csv", "./out/x.csv", "link/x.csv"}) {
    const auto refused = WholeFile::create(folder.path(name));
    EXPECT_FALSE(refused) << name;
    if (refused) continue;
    EXPECT_NE(refused.error().problem.find("is in use"), std::string::npos);
  }
  EXPECT_EQ(tree(), before);
  ::kill(child, SIGKILL);
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(OutputFiles::create(folder.path("link"), kNames)) << "the lock ends with the process";
}

// Whether this process gets a lock while another one has the lock `theirs` of the folder.
bool is_let_in(const std::string& path, FolderUse theirs, FolderUse ours) {
  std::array<int, 2> locked{};
  if (::pipe(locked.data()) != 0) return false;
  const pid_t child = ::fork();
  if (child == 0) {
    const auto lock = OutputLock::take(path, theirs);
    [[maybe_unused]] const auto told = ::write(locked[1], lock ? "x" : "-", 1);
    ::pause();
  }
  char byte = 0;
  EXPECT_EQ(::read(locked[0], &byte, 1), 1);
  EXPECT_EQ(byte, 'x');
  const bool is_in = OutputLock::take(path, ours).ok();
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  for (const int end : locked) ::close(end);
  return is_in;
}

TEST_F(OutputFilesTest, AFolderIsSharedByShardsOrByNamedFilesAndNotByBoth) {
  fs::create_directory(folder.path("out"));
  constexpr std::array kUses = {FolderUse::kAlone, FolderUse::kShard, FolderUse::kFile};
  for (const FolderUse theirs : kUses) {
    for (const FolderUse ours : kUses) {
      EXPECT_EQ(is_let_in(folder.path("out"), theirs, ours),
                theirs == ours && theirs != FolderUse::kAlone)
          << static_cast<int>(theirs) << " " << static_cast<int>(ours);
    }
  }
}

// As the recorder locks the file that it writes.
TEST_F(OutputFilesTest, AFileThatAnotherProcessHasLockedIsNotReplaced) {
  write(folder.path("a.palpate"), "recording");
  std::array<int, 2> locked{};
  ASSERT_EQ(::pipe(locked.data()), 0);
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const int file = ::open(folder.path("a.palpate").c_str(), O_RDWR);
    struct flock lock = {};
    lock.l_type = F_WRLCK;
    lock.l_whence = SEEK_SET;
    lock.l_start = 1 << 30;  // where SQLite locks
    lock.l_len = 510;
    const bool is_held = ::fcntl(file, F_SETLK, &lock) == 0;
    [[maybe_unused]] const auto told = ::write(locked[1], is_held ? "x" : "-", 1);
    ::pause();
  }
  char byte = 0;
  ASSERT_EQ(::read(locked[0], &byte, 1), 1);
  EXPECT_EQ(byte, 'x');
  for (const char* const name : {"a.palpate", "a.palpate-wal"}) {
    const auto refused = WholeFile::create(folder.path(name));
    EXPECT_FALSE(refused) << name;
    if (!refused) {
      EXPECT_NE(refused.error().problem.find("is in use"), std::string::npos);
    }
  }
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  EXPECT_TRUE(WholeFile::create(folder.path("a.palpate")));
}

// Two sets of files of one process do not affect each other; the last one determines the content.
TEST_F(OutputFilesTest, FromTwoPartsOfAProcessAreNotMixed) {
  OutputFiles first = created("out");
  write(first.path("a.csv"), "first");
  write(first.path("b.csv"), "first");
  OutputFiles second = created("out");
  write(second.path("a.csv"), "second");
  EXPECT_TRUE(fs::exists(first.path("a.csv"))) << "the command is still running";
  ASSERT_FALSE(first.move_into_place());
  ASSERT_FALSE(second.move_into_place());
  EXPECT_EQ(tree(), (Tree{{"out", "/"}, {"out/a.csv", "second"}}));
}

TEST_F(OutputFilesTest, LeaveNothingInTheFolderWhileTheyArePaused) {
  fs::create_directory(folder.path("out"));
  OutputFiles files = created("out");
  files.pause();
  EXPECT_EQ(tree(), (Tree{{"out", "/"}}));
  ASSERT_FALSE(files.resume());
  write(files.path("a.csv"), "1");
  ASSERT_FALSE(files.move_into_place());
  EXPECT_EQ(tree(), (Tree{{"out", "/"}, {"out/a.csv", "1"}}));
}

TEST_F(OutputFilesTest, FromAKilledCommandAreRemovedByTheNext) {
  fs::create_directory(folder.path("out"));
  write(folder.path("out/a.csv"), "old");
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const OutputFiles files = created("out");
    write(files.path("b.csv"), "half");
    ::kill(::getpid(), SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_GT(tree().size(), 2u) << "a hidden folder is left";
  EXPECT_EQ(tree().at("out/a.csv"), "old");
  { const OutputFiles files = created("out"); }
  EXPECT_GT(tree().size(), 2u) << "only a command that succeeds removes it";
  OutputFiles files = created("out");
  write(files.path("a.csv"), "new");
  ASSERT_FALSE(files.move_into_place());
  EXPECT_EQ(tree(), (Tree{{"out", "/"}, {"out/a.csv", "new"}}));
}

TEST_F(OutputFilesTest, FromACommandThatIsKilledWhileItMovesThemAreNotMixed) {
  const fs::path out = folder.path("out");
  for (const char* const before : {"", "old"}) {
    const int renames = *before ? 6 : 3;  // of the previous files and the new ones
    for (int last = 1; last <= renames; ++last) {
      SCOPED_TRACE(std::string(before) + ", rename " + std::to_string(last));
      fs::remove_all(out);
      fs::create_directory(out);
      for (const std::string& name : kNames) {
        if (*before) write(out / name, before);
      }
      const pid_t child = ::fork();
      ASSERT_GE(child, 0);
      if (child == 0) {
        OutputFiles files = created("out");
        for (const std::string& name : kNames) write(files.path(name), "new");
        test::die_at_rename(last);
        ::_exit(files.move_into_place() ? 1 : 0);
      }
      int status = 0;
      ASSERT_EQ(::waitpid(child, &status, 0), child);
      EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL);
      std::set<std::string> texts;
      std::size_t count = 0;
      for (const std::string& name : kNames) {
        if (!fs::exists(out / name)) continue;
        texts.insert(tree_of(out).at(name));
        ++count;
      }
      EXPECT_LE(texts.size(), 1u) << "files of two commands";
      EXPECT_TRUE(count == kNames.size() || !fs::exists(out / kNames.back()));
      OutputFiles files = created("out");
      write(files.path("a.csv"), "newest");
      ASSERT_FALSE(files.move_into_place());
      EXPECT_EQ(tree_of(out), (Tree{{"a.csv", "newest"}}));
    }
  }
}

}  // namespace
}  // namespace palpate
