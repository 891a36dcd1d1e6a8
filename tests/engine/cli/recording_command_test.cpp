// --record, `replay` of recordings and the command `recording`, started as a script starts them.

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <sqlite3.h>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/devices/vector_device.h"
#include "engine/recording/recorder.h"
#include "engine/recording/recording_settings.h"
#include "engine/session/haptic_session.h"
#include "engine/session/material_tuner.h"
#include "tests/engine/cli/run_program.h"
#include "tests/helpers/made.h"
#include "tests/helpers/needs.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::content_of;
using test::kStar;
using test::Outcome;
using test::outcome_of;
using test::run_program;
using test::start_program;
using test::TemporaryFolder;

namespace fs = std::filesystem;

std::vector<std::string> recorded_run(const std::string& file, const std::string& a4 = "on") {
  return {"run", kStar, "--virtual", "--seconds", "5", "--a4", a4, "--record", file};
}

// A run that is not comparable after 5 s, which is none of the tests' business.
Outcome record(const TemporaryFolder& folder, const std::vector<std::string>& arguments) {
  const Outcome done = run_program(folder, arguments);
  EXPECT_TRUE(done.exit_code == 0 || done.exit_code == 3) << done.err;
  return done;
}

void expect_one_line(const Outcome& refused, const std::string& name) {
  EXPECT_EQ(refused.exit_code, 2) << refused.err;
  EXPECT_EQ(refused.out, "");
  EXPECT_EQ(std::count(refused.err.begin(), refused.err.end(), '\n'), 1) << refused.err;
  EXPECT_NE(refused.err.find(name), std::string::npos) << refused.err;
  EXPECT_TRUE(std::all_of(refused.err.begin(), refused.err.end(), [](unsigned char c) {
    return c >= 32 || c == '\n';
  })) << refused.err;
}

TEST(RecordingCommand, ARunIsRecordedAndReplaysToTheBit) {
  const TemporaryFolder folder;
  const Outcome run = record(folder, recorded_run("a.palpate"));
  EXPECT_NE(run.out.find("recording in a.palpate: 5000 ticks"), std::string::npos) << run.out;
  const Outcome replayed = run_program(folder, {"replay", "a.palpate"});
  EXPECT_EQ(replayed.exit_code, 0) << replayed.err;
  EXPECT_EQ(replayed.out, "5000 ticks computed again, each with the same bits\n");
  const Outcome result = run_program(folder, {"replay", "a.palpate", "--json"});
  EXPECT_EQ(nlohmann::json::parse(result.out)["proved_ticks"], 5000);
  const Outcome checked = run_program(folder, {"recording", "check", "a.palpate"});
  EXPECT_EQ(checked.exit_code, 0) << checked.out;
  // The content decides, not the name.
  fs::rename(folder.path("a.palpate"), folder.path("b.glb"));
  EXPECT_EQ(run_program(folder, {"replay", "b.glb"}).exit_code, 0);
}

TEST(RecordingCommand, TheTraceIsTheOneThatRunHasWritten) {
  const TemporaryFolder folder;
  record(folder, recorded_run("a.palpate"));
  const Outcome exported =
      run_program(folder, {"recording", "export", "a.palpate", "--csv", "trace.csv"});
  EXPECT_EQ(exported.exit_code, 0) << exported.err;
  EXPECT_EQ(content_of(folder.path("trace.csv")), content_of(folder.path("out/trace-on.csv")));
}

TEST(RecordingCommand, AComparisonWritesTwoFiles) {
  const TemporaryFolder folder;
  const Outcome run = record(folder, recorded_run("a.palpate", "compare"));
  EXPECT_FALSE(fs::exists(folder.path("a.palpate")));
  for (const char* file : {"a-off.palpate", "a-on.palpate"}) {
    EXPECT_EQ(run_program(folder, {"replay", file}).exit_code, 0) << file;
  }
  expect_one_line(run_program(folder, recorded_run("a.palpate", "compare")),
                  "a-off.palpate: exists");
}

TEST(RecordingCommand, AFileThatExistsIsRefusedBeforeTheRun) {
  const TemporaryFolder folder;
  folder.write("a.palpate", "precious");
  expect_one_line(run_program(folder, recorded_run("a.palpate")), "a.palpate: exists");
  EXPECT_EQ(content_of(folder.path("a.palpate")), "precious");
  EXPECT_FALSE(fs::exists(folder.path("out")));
}

TEST(RecordingCommand, ARunInRealTimeReplaysToTheBit) {
  const TemporaryFolder folder;
  record(folder, {"run", kStar, "--seconds", "2", "--a4", "on", "--record", "a.palpate"});
  const Outcome replayed = run_program(folder, {"replay", "a.palpate"});
  EXPECT_EQ(replayed.exit_code, 0) << replayed.out << replayed.err;
}

// --move, an effect and the force of all axes.
TEST(RecordingCommand, ARunWithMovingNodesReplaysToTheBit) {
  const TemporaryFolder folder;
  const Outcome info = run_program(folder, {"info", kStar, "--list", "--json"});
  const std::string node = nlohmann::json::parse(info.out)[0]["name"];
  auto arguments = recorded_run("a.palpate");
  arguments.insert(arguments.end(), {"--sensors", "3", "--actuators", "2", "--force", "full",
                                     "--move", node + "=0.001 0 0 0 0 0.05"});
  record(folder, arguments);
  const Outcome replayed = run_program(folder, {"replay", "a.palpate", "--json"});
  EXPECT_EQ(replayed.exit_code, 0) << replayed.out << replayed.err;
  const Outcome checked = run_program(folder, {"recording", "check", "a.palpate", "--json"});
  EXPECT_GT(nlohmann::json::parse(checked.out)[0]["inputs"], 4000);
}

TEST(RecordingCommand, AChangedSceneIsRefusedByNameAndAMovedOneIsFound) {
  const TemporaryFolder folder;
  fs::copy_file(kStar, folder.path("star.glb"));
  auto arguments = recorded_run("a.palpate");
  arguments[1] = "star.glb";
  record(folder, arguments);
  fs::rename(folder.path("star.glb"), folder.path("moved.glb"));
  expect_one_line(run_program(folder, {"replay", "a.palpate"}), "star.glb");
  EXPECT_EQ(run_program(folder, {"replay", "a.palpate", "--scene", "moved.glb"}).exit_code, 0);
  fs::copy_file(PALPATE_MODELS_DIR "/cube.glb", folder.path("star.glb"));
  expect_one_line(run_program(folder, {"replay", "a.palpate"}), "star.glb: differs");
}

TEST(RecordingCommand, AnswersWhatIf) {
  const TemporaryFolder folder;
  record(folder, recorded_run("a.palpate"));
  const Outcome same = run_program(folder, {"replay", "a.palpate", "--a4", "on", "--json"});
  ASSERT_EQ(same.exit_code, 0) << same.err;
  auto result = nlohmann::json::parse(same.out);
  EXPECT_EQ(result["recorded"]["mean_penetration_m"], result["what_if"]["mean_penetration_m"]);
  const Outcome other =
      run_program(folder, {"replay", "a.palpate", "--a4", "off", "--stiffness", "2000", "--json"});
  ASSERT_EQ(other.exit_code, 0) << other.err;
  result = nlohmann::json::parse(other.out);
  EXPECT_EQ(result["open_loop"], true);
  EXPECT_GT(result["recorded"]["effects"]["a4"]["ticks"], 0);
  EXPECT_EQ(result["what_if"]["effects"]["a4"]["ticks"], 0);
  const Outcome text = run_program(folder, {"replay", "a.palpate", "--damping", "1"});
  EXPECT_NE(text.out.find("open loop"), std::string::npos) << text.out;
  expect_one_line(run_program(folder, {"replay", "a.palpate", "--sensors", "3"}), "--sensors");
  expect_one_line(run_program(folder, {"replay", kStar}), "--trajectory");
}

// A recording states the rule of alignment, so that its replay turns the same way round.
TEST(RecordingCommand, ARunThatAlignsForwardReplaysToTheBit) {
  const TemporaryFolder folder;
  auto forward = recorded_run("a.palpate");
  forward.insert(forward.end(), {"--align", "forward"});
  record(folder, forward);
  EXPECT_EQ(run_program(folder, {"replay", "a.palpate"}).exit_code, 0);
  const Outcome same = run_program(folder, {"replay", "a.palpate", "--align", "forward", "--json"});
  ASSERT_EQ(same.exit_code, 0) << same.err;
  auto result = nlohmann::json::parse(same.out);
  const auto angle = [&](const char* which) {
    return result[which]["mean_contact_angle_deg"].get<double>();
  };
  EXPECT_EQ(angle("recorded"), angle("what_if"));
  const Outcome nearest =
      run_program(folder, {"replay", "a.palpate", "--align", "nearest", "--json"});
  ASSERT_EQ(nearest.exit_code, 0) << nearest.err;
  result = nlohmann::json::parse(nearest.out);
  EXPECT_NE(angle("recorded"), angle("what_if"));
  // A recording with two motors has no such question.
  auto two = recorded_run("b.palpate");
  two.insert(two.end(), {"--sensors", "2", "--actuators", "2"});
  record(folder, two);
  expect_one_line(run_program(folder, {"replay", "b.palpate", "--align", "forward"}), "--align");
}

TEST(RecordingCommand, WhatIfWithTheFullForceHasAllMotors) {
  const TemporaryFolder folder;
  record(folder, recorded_run("a.palpate", "off"));
  const Outcome full = run_program(folder, {"replay", "a.palpate", "--force", "full", "--json"});
  ASSERT_EQ(full.exit_code, 0) << full.err;
  const auto result = nlohmann::json::parse(full.out);
  EXPECT_NE(result["recorded"]["work_lost_J"], 0.0);
  EXPECT_EQ(result["what_if"]["work_lost_J"], 0.0);
}

// A device that draws circles through the middle of the scene.
class ScenicDevice final : public VectorDevice {
 public:
  explicit ScenicDevice(const Scene& scene)
      : middle_m_(0.5 *
                  (scene.statistics().bounds_scene.low + scene.statistics().bounds_scene.high)),
        extent_m_(scene.statistics().extent_m) {}
  Vec3 read_position_m(double dt_s) noexcept override {
    time_s_ += dt_s;
    const Vec3 share(std::sin(1.3 * time_s_), std::sin(1.7 * time_s_), std::cos(2.9 * time_s_));
    return middle_m_ + 0.55 * extent_m_.cwiseProduct(share);
  }
  void command_force_N(const Vec3&) noexcept override {}

 private:
  Vec3 middle_m_, extent_m_;
  double time_s_ = 0.0;
};

// Records a session in which every number of every material changes at random. Returns how many
// changes were accepted.
int record_changed_materials(const std::string& model, const std::string& file) {
  const auto scene = Scene::load(model);
  EXPECT_TRUE(scene) << scene.error().to_string();
  RecordedSetup setup;
  setup.scene_path = model;
  setup.virtual_time = true;
  auto recorder = Recorder::create(file, *meta_of(*scene, setup), {.virtual_time = true});
  EXPECT_TRUE(recorder) << recorder.error().to_string();
  MaterialTuner tuner(*scene);
  std::vector<std::pair<std::size_t, const ParameterKey*>> numbers;
  for (const MaterialCalls& material : scene->material_calls()) {
    for (const std::uint32_t call : material.calls) {
      for (const ParameterKey& key :
           compiled_effects()[scene->world().effects->calls[call].effect].keys) {
        if (const auto handle = tuner.add(material.material, std::string(key.key))) {
          numbers.emplace_back(*handle, &key);
        }
      }
    }
  }
  auto loop = test::made(HapticLoop::create(scene->world(), setup.actuation, setup.haptics));
  ScenicDevice device(*scene);
  HapticSession session(loop, device, {.changes = {&tuner}, .sink = recorder->get()});
  session.start();
  test::Random random(21);
  int changes = 0;
  for (int n = 0; n < 4000; ++n) {
    if (n % 20 == 0 && !numbers.empty()) {
      const auto& [handle, key] = numbers[random.index(numbers.size())];
      const double most = std::min(key->most, 1000.0);
      const double number = key->kind == ParameterKey::Kind::kChoice
                                ? static_cast<double>(random.index(2))
                                : random.uniform(std::max(key->least, -1000.0), most);
      if (!tuner.set(handle, number)) ++changes;
    }
    session.tick(1e-3);
  }
  session.stop();
  EXPECT_EQ((*recorder)->finish("end").ticks, 4000u);
  return changes;
}

// Every number of every material changes while a session is recorded; another process replays it.
// The parameters of some effects hold addresses, which differ from process to process.
TEST(RecordingCommand, ChangedMaterialsReplayInAnotherProcess) {
  for (const char* model :
       {"gallery", "effect_friction", "effect_friction_map", "effect_magnet", "effect_restitution",
        "effect_stiffness", "effect_texture", "effect_vibration", "effect_viscosity"}) {
    const TemporaryFolder folder;
    const std::string path = std::string(PALPATE_MODELS_DIR) + "/" + model + ".glb";
    const int changes = record_changed_materials(path, folder.path("a.palpate"));
    EXPECT_GT(changes, 0) << model;
    const Outcome replayed = run_program(folder, {"replay", "a.palpate", "--json"});
    EXPECT_EQ(replayed.exit_code, 0) << model << replayed.err << replayed.out;
  }
}

// The ending counts what there should be.
TEST(RecordingCommand, ATailThatIsGoneIsNoticed) {
  const TemporaryFolder folder;
  record(folder, recorded_run("a.palpate"));
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(folder.path("a.palpate").c_str(), &database), SQLITE_OK);
  EXPECT_EQ(sqlite3_exec(database, "DELETE FROM block WHERE first_tick > 2000", nullptr, nullptr,
                         nullptr),
            SQLITE_OK);
  sqlite3_close(database);
  const Outcome replayed = run_program(folder, {"replay", "a.palpate"});
  EXPECT_EQ(replayed.exit_code, 1) << replayed.out;
  EXPECT_NE(replayed.out.find("the ending states 5000 ticks"), std::string::npos) << replayed.out;
}

TEST(RecordingCommand, ACopyOverItselfIsRefused) {
  const TemporaryFolder folder;
  record(folder, recorded_run("a.palpate"));
  fs::create_symlink("a.palpate", folder.path("link"));
  const std::string before = content_of(folder.path("a.palpate"));
  for (const char* to : {"a.palpate", "./a.palpate", "link"}) {
    expect_one_line(run_program(folder, {"recording", "export", "a.palpate", "--csv", to}), to);
    expect_one_line(run_program(folder, {"recording", "repair", "a.palpate", "--out", to}), to);
  }
  EXPECT_EQ(content_of(folder.path("a.palpate")), before);
}

// A log beside a closed recording is none of it, and one beside a link is not that of the file.
TEST(RecordingCommand, OnlyTheLogOfTheFileItselfIsUsed) {
  const TemporaryFolder folder;
  record(folder, recorded_run("a.palpate"));
  folder.write("a.palpate-wal", std::string(100'000, 'w'));
  EXPECT_EQ(run_program(folder, {"recording", "check", "a.palpate"}).exit_code, 0);
  EXPECT_EQ(run_program(folder, {"replay", "a.palpate"}).exit_code, 0);
}

// A recording holds its strategy: it replays to the bit, and answers what other strategies give.
TEST(RecordingCommand, ARunWithAStrategyReplaysToTheBit) {
  for (const std::string strategy :
       {"full", "a4", "a4-anticipate", "a4-passive:2.5", "anisotropic:0.25", "cd"}) {
    const TemporaryFolder folder;
    record(folder, {"run", kStar, "--virtual", "--seconds", "5", "--strategy", strategy, "--record",
                    "a.palpate"});
    const Outcome replayed = run_program(folder, {"replay", "a.palpate"});
    EXPECT_EQ(replayed.exit_code, 0) << strategy << replayed.out << replayed.err;
    const Outcome same =
        run_program(folder, {"replay", "a.palpate", "--strategy", strategy, "--json"});
    ASSERT_EQ(same.exit_code, 0) << same.err;
    auto result = nlohmann::json::parse(same.out);
    EXPECT_EQ(result["open_loop"], true);
    EXPECT_EQ(result["recorded"]["port_work_J"], result["what_if"]["port_work_J"]) << strategy;
    const Outcome other =
        run_program(folder, {"replay", "a.palpate", "--strategy", "mask", "--json"});
    ASSERT_EQ(other.exit_code, 0) << other.err;
    result = nlohmann::json::parse(other.out);
    EXPECT_NE(result["recorded"]["port_work_J"], result["what_if"]["port_work_J"]) << strategy;
    expect_one_line(
        run_program(folder, {"replay", "a.palpate", "--strategy", "mask", "--force", "none"}),
        "--strategy: is given beside --force");
  }
}

// A strategy of another version is refused by name.
TEST(RecordingCommand, AnUnknownStrategyIsRefusedByName) {
  const TemporaryFolder folder;
  record(folder, {"run", kStar, "--virtual", "--seconds", "2", "--strategy", "cd", "--record",
                  "a.palpate"});
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open(folder.path("a.palpate").c_str(), &db), SQLITE_OK);
  const char* update = "UPDATE meta SET value = 'springs' WHERE key = 'strategy'";
  ASSERT_EQ(sqlite3_exec(db, update, nullptr, nullptr, nullptr), SQLITE_OK);
  sqlite3_close(db);
  expect_one_line(run_program(folder, {"replay", "a.palpate"}), "strategy: is \"springs\"");
}

// A disk of 200 KiB: the run ends as without recording, and says so. Needs the right to mount.
TEST(RecordingCommand, AFullDiskEndsTheRecordingAndNotTheRun) {
  const TemporaryFolder folder;
  fs::create_directory(folder.path("small"));
  const std::string program = PALPATE_PROGRAM;
  const std::string run = program + " run " + kStar + " --seconds 5 --a4 on --out ";
  const std::string script =
      "cd " + folder.path() + " || exit 9\n" + run + "plain > plain.txt\n" +
      "echo $? > plain.code\n" + "mount -t tmpfs -o size=200k none small || exit 9\n" + run +
      "full --record small/a.palpate --json > full.txt 2> full.err\n" + "echo $? > full.code\n" +
      program + " recording check small/a.palpate --json > check.txt\n" + "echo $? > check.code\n";
  folder.write("script", script);
  const int status =
      std::system(("unshare -m sh " + folder.path("script") + " 2> " + folder.path("err")).c_str());
  std::string reason = content_of(folder.path("err"));
  std::replace(reason.begin(), reason.end(), '\n', ' ');
  PALPATE_NEEDS(status == 0 ? "" : "needs the right to mount a file system: " + reason);
  EXPECT_EQ(content_of(folder.path("full.code")), content_of(folder.path("plain.code")));
  const std::string warning = content_of(folder.path("full.err"));
  EXPECT_NE(warning.find("the recording ended: small/a.palpate"), std::string::npos) << warning;
  const auto result = nlohmann::json::parse(content_of(folder.path("full.txt")));
  EXPECT_NE(result["recordings"][0]["problem"].get<std::string>().find("full"), std::string::npos);
  EXPECT_EQ(result["runs"][0]["ticks"], 5'000);
  EXPECT_EQ(content_of(folder.path("check.code")), "0\n");
  const auto check = nlohmann::json::parse(content_of(folder.path("check.txt")))[0];
  EXPECT_GT(check["ticks"], 200);
  EXPECT_LT(check["ticks"], 5'000);
  EXPECT_EQ(check["ending"]["why"], "disk full");
  EXPECT_EQ(check["ending"]["ticks"], check["ticks"]);
}

// The limit of the size of files acts like a full disk. In simulated time as well, each size keeps
// what fits, and the ending says why there is no more.
TEST(RecordingCommand, AFullDiskKeepsWhatFitsAndSaysSo) {
  const TemporaryFolder folder;
  const auto run = [&](const std::string& file, const std::string& out) {
    return std::vector<std::string>{"run", kStar,   "--virtual", "--seconds", "20", "--a4",
                                    "on",  "--out", out,         "--record",  file, "--json"};
  };
  for (const int kilobytes : {200, 300, 404, 700, 1'000}) {
    const std::string file = std::to_string(kilobytes) + ".palpate";
    Outcome done;
    {
      const test::FileSizeLimit limit(static_cast<rlim_t>(kilobytes) * 1000);
      // The traces meet the limit as well, after the recording.
      done = run_program(folder, run(file, "out"));
    }
    const Outcome checked = run_program(folder, {"recording", "check", file, "--json"});
    ASSERT_EQ(checked.exit_code, 0) << kilobytes << checked.out << checked.err << done.err;
    const auto check = nlohmann::json::parse(checked.out)[0];
    EXPECT_EQ(check["ending"]["why"], "disk full") << kilobytes;
    const auto ticks = check["ticks"].get<std::int64_t>();
    EXPECT_GT(ticks, 1'000) << kilobytes;
    EXPECT_LT(ticks, 20'000);
    const Outcome replayed = run_program(folder, {"replay", file});
    EXPECT_EQ(replayed.exit_code, 0) << replayed.out << replayed.err;
    EXPECT_NE(replayed.out.find("disk full"), std::string::npos);
    const Outcome info = run_program(folder, {"recording", "info", file});
    EXPECT_NE(info.out.find("ended         disk full"), std::string::npos) << info.out;
  }
}

// A disk that is full before the recording begins.
TEST(RecordingCommand, ADiskWithoutSpaceForARecordingIsNamed) {
  const TemporaryFolder folder;
  for (const rlim_t bytes : {1'000, 5'000, 12'288, 40'000}) {
    const test::FileSizeLimit limit(bytes);
    const Outcome o =
        run_program(folder, {"run", kStar, "--virtual", "--seconds", "2", "--record", "a.palpate"});
    EXPECT_EQ(o.exit_code, 2);
    EXPECT_NE(o.err.find("a-off.palpate: cannot be written: the disk is full"), std::string::npos)
        << bytes << o.err;
    EXPECT_NE(o.err.find("(free disk space, or record on another disk)"), std::string::npos)
        << bytes << o.err;
  }
}

TEST(RecordingCommand, InfoIsASummaryAndHasTheKeysOnRequest) {
  const TemporaryFolder folder;
  record(folder, recorded_run("a.palpate"));
  const Outcome info = run_program(folder, {"recording", "info", "a.palpate"});
  ASSERT_EQ(info.exit_code, 0) << info.err;
  for (const char* text :
       {"5000 ticks", "simulated time", "star.glb", "1000 Hz", "2 sensors, 1 actuator",
        "gaps          none", "trips         0", "ended         end (5000 ticks, 0 dropped)"}) {
    EXPECT_NE(info.out.find(text), std::string::npos) << text << "\n" << info.out;
  }
  EXPECT_EQ(info.out.find("proxy.work_budget"), std::string::npos);
  EXPECT_LT(std::count(info.out.begin(), info.out.end(), '\n'), 20);
  const Outcome keys = run_program(folder, {"recording", "info", "--keys", "a.palpate"});
  EXPECT_NE(keys.out.find("proxy.work_budget"), std::string::npos);
  const auto result = nlohmann::json::parse(
      run_program(folder, {"recording", "info", "a.palpate", "--json"}).out)[0];
  EXPECT_EQ(result["ticks"], 5000);
  EXPECT_EQ(result["gaps"], 0);
  EXPECT_TRUE(result["meta"].contains("proxy.work_budget"));
}

// kill -9: all but the last half second is there, and check says that there is no ending.
TEST(RecordingCommand, AKilledRunLeavesARecordingThatReplays) {
  const TemporaryFolder folder;
  const auto started = start_program(
      folder, {"run", kStar, "--seconds", "60", "--a4", "on", "--record", "a.palpate"});
  std::this_thread::sleep_for(std::chrono::milliseconds(3'000));
  ::kill(started.process, SIGKILL);
  EXPECT_EQ(outcome_of(started).exit_code, -1);
  const Outcome checked = run_program(folder, {"recording", "check", "a.palpate", "--json"});
  ASSERT_EQ(checked.exit_code, 0) << checked.out << checked.err;
  const auto check = nlohmann::json::parse(checked.out)[0];
  EXPECT_TRUE(check["ending"].is_null());
  EXPECT_GT(check["ticks"], 100);
  const Outcome replayed = run_program(folder, {"replay", "a.palpate"});
  EXPECT_EQ(replayed.exit_code, 0) << replayed.out << replayed.err;
  EXPECT_NE(replayed.out.find("no ending"), std::string::npos);
  // The log was used and not changed.
  EXPECT_TRUE(fs::exists(folder.path("a.palpate-wal")));
  EXPECT_FALSE(fs::exists(folder.path("a.palpate-shm")));
  const Outcome repaired =
      run_program(folder, {"recording", "repair", "a.palpate", "--out", "b.palpate"});
  EXPECT_EQ(repaired.exit_code, 0) << repaired.err;
  EXPECT_FALSE(fs::exists(folder.path("b.palpate-wal")));
  EXPECT_EQ(run_program(folder, {"replay", "b.palpate"}).exit_code, 0);
}

TEST(RecordingCommand, OtherFilesAreRefused) {
  const TemporaryFolder folder;
  folder.write("text", "hello");
  folder.write("empty", "");
  for (const char* command : {"info", "check"}) {
    for (const char* file : {"text", "empty", "missing", "."}) {
      expect_one_line(run_program(folder, {"recording", command, file}), file);
    }
  }
  expect_one_line(run_program(folder, {"recording", "repair", "text", "--out", "copy"}), "text");
  EXPECT_FALSE(fs::exists(folder.path("copy")));
}

TEST(RecordingCommand, AnotherVersionIsStatedFirst) {
  const TemporaryFolder folder;
  record(folder, recorded_run("a.palpate"));
  sqlite3* database = nullptr;
  sqlite3_open(folder.path("a.palpate").c_str(), &database);
  EXPECT_EQ(sqlite3_exec(database, "UPDATE meta SET value = '99.0' WHERE key = 'engine'", nullptr,
                         nullptr, nullptr),
            SQLITE_OK);
  sqlite3_close(database);
  const Outcome replayed = run_program(folder, {"replay", "a.palpate"});
  EXPECT_EQ(replayed.exit_code, 0);
  EXPECT_TRUE(replayed.out.starts_with("recorded by version 99.0; this is version"))
      << replayed.out;
}

}  // namespace
}  // namespace palpate
