#include "tests/engine/cli/command_line_fixture.h"

#include <algorithm>
#include <cstdlib>
#include <sstream>
#include <sys/wait.h>
#include <utility>

namespace palpate::test {

Outcome CommandLine::call(std::vector<std::string> arguments,
                          const std::string& stdout_path) const {
  return run_program(folder, std::move(arguments), stdout_path);
}

Outcome CommandLine::call_with_output_closed(const std::vector<std::string>& arguments) const {
  const std::string err = folder.path("stderr");
  std::string line = "cd '" + folder.path() + "' && '" PALPATE_PROGRAM "'";
  for (const std::string& argument : arguments) line += " '" + argument + "'";
  const int status = std::system((line + " >&- 2>'" + err + "'").c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, "", content_of(err)};
}

void CommandLine::expect_refused(const std::vector<std::string>& arguments,
                                 const std::vector<std::string>& names) const {
  std::string text;
  for (const std::string& a : arguments) text += a + " ";
  SCOPED_TRACE(text);
  const Outcome o = call(arguments);
  EXPECT_EQ(o.exit_code, 2);
  EXPECT_EQ(o.out, "");
  EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
  EXPECT_TRUE(o.err.starts_with("palpate: ") && o.err.ends_with("\n")) << o.err;
  for (const std::string& name : names) {
    EXPECT_NE(o.err.find(name), std::string::npos) << "no \"" << name << "\" in: " << o.err;
  }
}

Outcome CommandLine::expect_done(const std::vector<std::string>& arguments, int exit_code) const {
  std::string text;
  for (const std::string& a : arguments) text += a + " ";
  SCOPED_TRACE(text);
  const Outcome o = call(arguments);
  EXPECT_EQ(o.exit_code, exit_code) << o.err;
  return o;
}

Outcome CommandLine::expect_run(const std::vector<std::string>& arguments) const {
  const Outcome o = call(arguments);
  EXPECT_TRUE(o.exit_code == 0 || o.exit_code == 3) << o.err;
  return o;
}

Outcome CommandLine::expect_not_comparable(const std::vector<std::string>& arguments) const {
  return expect_done(arguments, 3);
}

std::string CommandLine::write_path(const std::string& name) const {
  std::ostringstream text;
  for (int n = 0; n < 200; ++n) text << 0.12 - 0.0005 * n << " " << 0.0003 * n << " 0\n";
  for (int n = 0; n < 50; ++n) text << "0.02 " << 0.06 + 0.005 * n << " 0\n";
  return folder.write(name, text.str());
}

std::vector<std::string> CommandLine::replay(const std::vector<std::string>& more) const {
  std::vector<std::string> arguments{"replay", kStar, "--trajectory", folder.path("path.txt")};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::vector<std::vector<std::string>> rows_of(const std::string& csv) {
  std::vector<std::vector<std::string>> rows;
  for (const std::string& line : lines_of(csv)) {
    std::vector<std::string> row;
    std::istringstream stream(line);
    for (std::string field; std::getline(stream, field, ',');) row.push_back(field);
    rows.push_back(row);
  }
  if (!rows.empty()) rows.erase(rows.begin());
  return rows;
}

std::string without_times(const std::string& csv) {
  std::string text;
  std::vector<bool> is_time;
  for (const std::string& line : lines_of(csv)) {
    std::istringstream fields(line);
    const bool is_header = is_time.empty();
    std::size_t column = 0;
    for (std::string field; std::getline(fields, field, ','); ++column) {
      if (is_header) is_time.push_back(field.ends_with("_ns"));
      if (!is_time.at(column)) text += field + ",";
    }
    text += "\n";
  }
  return text;
}

std::vector<std::string> keys_of(const nlohmann::json& object) {
  std::vector<std::string> keys;
  for (const auto& item : object.items()) keys.push_back(item.key());
  std::sort(keys.begin(), keys.end());
  return keys;
}

std::vector<std::string> sorted(std::vector<std::string> texts) {
  std::sort(texts.begin(), texts.end());
  return texts;
}

const std::vector<std::string> kSummaryKeys{"ticks",
                                            "contact_ticks",
                                            "mean_penetration_m",
                                            "max_penetration_m",
                                            "mean_contact_angle_deg",
                                            "share_within_30deg",
                                            "losses_of_contact",
                                            "work_lost_J",
                                            "port_work_J",
                                            "faults",
                                            "governor",
                                            "effects",
                                            "not_understood",
                                            "step_ns",
                                            "step_ns_clock",
                                            "load_ms",
                                            "triangles"};

}  // namespace palpate::test
