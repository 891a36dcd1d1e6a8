// Command lines that the program proposes, parsed by a shell.

#include "engine/cli/command_line.h"

#include <cstdio>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace palpate {
namespace {

using Words = std::vector<std::string>;

// The line's arguments as a shell parses them.
Words words_of(const std::string& line) {
  const std::string program = "palpate";
  EXPECT_EQ(line.substr(0, program.size()), program);
  const std::string command = "printf '%s\\0'" + line.substr(program.size());
  std::FILE* shell = popen(command.c_str(), "r");
  Words words;
  std::string word;
  for (int c = std::fgetc(shell); c != EOF; c = std::fgetc(shell)) {
    if (c != '\0') {
      word += static_cast<char>(c);
      continue;
    }
    words.push_back(word);
    word.clear();
  }
  EXPECT_EQ(pclose(shell), 0);
  return words;
}

TEST(ShellLine, IsParsedByAShellIntoTheSameArguments) {
  const Words words = {
      "run",           "a b.glb",  "it's",       "$HOME",     "`id`", "a\"b", "*",
      "0 0 0 1 0 0 0", "#7",       "back\\lash", "new\nline", "~",    "",     "x=1",
      "{a,b}",         "\xc3\xa9", "-1e-3",      ";true",     "&",    "!",    "a\tb"};
  EXPECT_EQ(words_of(shell_line(words)), words);
  EXPECT_EQ(shell_line({"run", "star.glb", "--fit", "0.2"}), "palpate run star.glb --fit 0.2");
}

TEST(WithOptions, ReplacesEarlierSettings) {
  EXPECT_EQ(with_options({"run", "a.glb", "--fit", "1", "--virtual"}, {{"--fit", "0.2"}}),
            (Words{"run", "a.glb", "--virtual", "--fit", "0.2"}));
  EXPECT_EQ(with_options({"run", "--fit=1", "a.glb"}, {{"--fit", "0.2"}}),
            (Words{"run", "a.glb", "--fit", "0.2"}));
  EXPECT_EQ(with_options({"run", "--scale", "3", "a.glb"}, {{"--fit", "0.2"}}),
            (Words{"run", "a.glb", "--fit", "0.2"}));
  EXPECT_EQ(with_options({"run", "a=b.glb"}, {{"--node", "#2"}, {"--fit", "0.2"}}),
            (Words{"run", "a=b.glb", "--node", "#2", "--fit", "0.2"}));
}

TEST(WithOptions, RemovesOptionsWithoutAValue) {
  EXPECT_EQ(with_options({"run", "--place", "0 0 1 1 0 0 0", "a.glb"}, {{"--place", {}}}),
            (Words{"run", "a.glb"}));
  EXPECT_EQ(with_options({"run", "a.glb", "--plane-height=1"},
                         {{"--plane-height", {}}, {"--place", {}}, {"--sensors", "2"}}),
            (Words{"run", "a.glb", "--sensors", "2"}));
}

TEST(WithOptions, InsertsOptionsBeforeTheEndOfOptions) {
  EXPECT_EQ(with_options({"run", "--", "-a.glb"}, {{"--fit", "0.2"}}),
            (Words{"run", "--fit", "0.2", "--", "-a.glb"}));
  EXPECT_EQ(with_options({"run", "--", "--fit"}, {{"--fit", {}}}), (Words{"run", "--", "--fit"}))
      << "a file with this name";
}

}  // namespace
}  // namespace palpate
