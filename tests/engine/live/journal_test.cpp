// The journal of a participant: what is written stays, what is cut is cut, what is changed is
// refused.

#include "engine/live/journal.h"

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>

#include "tests/helpers/gltf_builder.h"

namespace palpate::test {
namespace {

const JournalEntry kHead = {{"kind", "journal"}, {"participant", 3}};

std::string bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void write_bytes(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

class JournalFile : public ::testing::Test {
 protected:
  void write_three() {
    auto journal = Journal::open(path_, kHead);
    ASSERT_TRUE(journal.ok()) << journal.error().to_string();
    for (int i = 0; i < 3; ++i) {
      ASSERT_FALSE(journal->add({{"kind", "note"}, {"text", "number\n" + std::to_string(i)}}));
    }
  }
  TemporaryFolder folder_;
  std::string path_ = folder_.path("journal.txt");
};

TEST_F(JournalFile, KeepsTheEntriesInTheirOrder) {
  write_three();
  const auto journal = Journal::open(path_, kHead);
  ASSERT_TRUE(journal.ok()) << journal.error().to_string();
  ASSERT_EQ(journal->entries().size(), 3u);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(journal->entries()[static_cast<std::size_t>(i)]["text"],
              "number\n" + std::to_string(i));
  }
  EXPECT_FALSE(journal->was_cut());
}

TEST_F(JournalFile, LosesOnlyTheLineThatWasCut) {
  write_three();
  const std::string whole = bytes_of(path_);
  const std::size_t last = whole.rfind('\n', whole.size() - 2) + 1;  // where the last line begins
  for (std::size_t length = last + 1; length < whole.size(); ++length) {
    write_bytes(path_, whole.substr(0, length));
    {
      auto journal = Journal::open(path_, kHead);
      ASSERT_TRUE(journal.ok()) << length << ": " << journal.error().to_string();
      EXPECT_EQ(journal->entries().size(), 2u) << length;
      EXPECT_TRUE(journal->was_cut()) << length;
      ASSERT_FALSE(journal->add({{"kind", "note"}, {"text", "number\n2"}}));
    }
    EXPECT_EQ(bytes_of(path_), whole) << length;
  }
}

TEST_F(JournalFile, BeginsAgainIfTheHeadWasCut) {
  write_three();
  const std::string whole = bytes_of(path_);
  for (std::size_t length = 0; length < whole.find('\n'); ++length) {
    write_bytes(path_, whole.substr(0, length));
    const auto journal = Journal::open(path_, kHead);
    ASSERT_TRUE(journal.ok()) << length << ": " << journal.error().to_string();
    EXPECT_TRUE(journal->entries().empty());
  }
}

TEST_F(JournalFile, IsRefusedIfAnyByteHasChanged) {
  write_three();
  const std::string whole = bytes_of(path_);
  for (std::size_t i = 0; i < whole.size(); ++i) {
    std::string changed = whole;
    changed[i] = static_cast<char>(changed[i] ^ 1);
    write_bytes(path_, changed);
    const auto journal = Journal::open(path_, kHead);
    ASSERT_FALSE(journal.ok()) << i << " " << whole[i];
    EXPECT_EQ(journal.error().path, path_);
    EXPECT_EQ(journal.error().element.substr(0, 5), "line ") << journal.error().to_string();
    EXPECT_EQ(bytes_of(path_), changed) << "it is not repaired";
  }
}

TEST_F(JournalFile, IsRefusedIfALineIsMissingOrMoved) {
  write_three();
  const std::string whole = bytes_of(path_);
  std::vector<std::string> lines;
  for (std::size_t begin = 0; begin < whole.size();) {
    const std::size_t end = whole.find('\n', begin) + 1;
    lines.push_back(whole.substr(begin, end - begin));
    begin = end;
  }
  write_bytes(path_, lines[0] + lines[1] + lines[3]);
  EXPECT_FALSE(Journal::open(path_, kHead).ok());
  write_bytes(path_, lines[0] + lines[2] + lines[1] + lines[3]);
  EXPECT_FALSE(Journal::open(path_, kHead).ok());
}

TEST_F(JournalFile, IsRefusedWithAnotherHead) {
  write_three();
  const auto journal = Journal::open(path_, {{"kind", "journal"}, {"participant", 4}});
  ASSERT_FALSE(journal.ok());
  EXPECT_EQ(journal.error().element, "line 1");
}

TEST_F(JournalFile, IsRefusedWhileAnotherHasIt) {
  auto first = Journal::open(path_, kHead);
  ASSERT_TRUE(first.ok());
  const auto second = Journal::open(path_, kHead);
  ASSERT_FALSE(second.ok());
  EXPECT_NE(second.error().to_string().find("is in use"), std::string::npos);
}

TEST_F(JournalFile, HasWhatWasAddedBeforeAKill) {
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    auto journal = Journal::open(path_, kHead);
    for (int i = 0; journal.ok() && i < 5; ++i) journal->add({{"kind", "note"}, {"number", i}});
    ::raise(SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  const auto journal = Journal::open(path_, kHead);
  ASSERT_TRUE(journal.ok()) << journal.error().to_string();
  EXPECT_EQ(journal->entries().size(), 5u);
}

}  // namespace
}  // namespace palpate::test
