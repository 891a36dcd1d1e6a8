// The delay that a device states, and a touch that lasts through a pause: what a session and a
// recording make of them.

#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "engine/devices/vector_device.h"
#include "engine/recording/recording_replay.h"
#include "tests/engine/recording/scenario.h"
#include "tests/helpers/made.h"

namespace palpate {
namespace {

// A device at rest with a stated delay.
class DelayedDevice final : public VectorDevice {
 public:
  explicit DelayedDevice(double delay_s) : VectorDevice(with(delay_s)) {}
  Vec3 read_position_m(double) noexcept override { return position_m; }
  void command_force_N(const Vec3&) noexcept override {}

  Vec3 position_m = Vec3(0.0, 0.0, 0.02);

 private:
  static DeviceDescription with(double delay_s) {
    DeviceDescription device;
    device.name = "delayed";
    device.moves_motors = false;
    device.delay = {delay_s, delay_s};
    return device;
  }
};

struct PlateRig {
  explicit PlateRig(double delay_s = 0.0) : device(delay_s), session(loop, device) {}

  test::OwnedWorld world{test::box_soup({0.05, 0.05, 0.01})};
  HapticLoop loop =
      test::made(HapticLoop::create(world.world(), *ActuationModel::from_counts(3, 3), {}));
  DelayedDevice device;
  HapticSession session;
};

TEST(DeviceDelay, OutsideOfItsRangeIsRefusedAtTheStart) {
  for (const double delay_s : {0.0, 1e-3, kLongestDelay_s}) {
    PlateRig rig(delay_s);
    EXPECT_FALSE(rig.session.start()) << delay_s;
    rig.session.stop();
  }
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const double delay_s : {-1e-9, 1.0000001, kInfinity, std::nan("")}) {
    PlateRig rig(delay_s);
    const auto problem = rig.session.start();
    ASSERT_TRUE(problem) << delay_s;
    EXPECT_NE(problem->find("\"delayed\" states a delay of"), std::string::npos) << *problem;
    EXPECT_NE(problem->find("within 0 to 1 s"), std::string::npos) << *problem;
  }
}

TEST(DeviceDelay, IsInARecordingOnlyIfItIsStated) {
  const DelayedDevice unknown(0.0), known(4e-3);
  EXPECT_FALSE(meta_of(SessionFacts{unknown.description(), {}}).contains("device.delay_s"));
  EXPECT_EQ(std::get<double>(meta_of(SessionFacts{known.description(), {}}).at("device.delay_s")),
            4e-3);
}

TEST(DeviceDelay, OfARecordingIsReadAndChecked) {
  const auto reader = RecordingReader::open(PALPATE_OLD_RECORDINGS "/nodes.palpate");
  ASSERT_TRUE(reader);
  auto meta = reader->meta();
  ASSERT_TRUE(meta);
  const test::Scenario scenario(1);
  EXPECT_FALSE(session_of(*meta)->device.delay.is_known());
  for (const double delay_s : {4e-3, 1.5}) {
    (*meta)["device.delay_s"] = delay_s;
    const auto session = session_of(*meta);
    ASSERT_TRUE(session);
    EXPECT_EQ(session->device.delay, (DelayInterval{delay_s, delay_s}));
    const auto outcome = replay_recording(*reader, *session, scenario.scene());
    ASSERT_EQ(static_cast<bool>(outcome), delay_s <= kLongestDelay_s);
    if (!outcome) {
      EXPECT_EQ(outcome.error().element, "device.delay_s");
    }
  }
}

TEST(RecordingVersion, ThatItsColumnsContradictIsRefused) {
  const auto reader = RecordingReader::open(PALPATE_OLD_RECORDINGS "/nodes.palpate");
  ASSERT_TRUE(reader);
  auto meta = reader->meta();
  ASSERT_TRUE(meta);
  (*meta)["columns"] = recorded_columns_json();
  const auto session = session_of(*meta);
  ASSERT_TRUE(session);
  EXPECT_EQ(session->version, kRecordingVersion);
  const auto outcome = replay_recording(*reader, *session, test::Scenario(1).scene());
  ASSERT_FALSE(outcome);
  EXPECT_EQ(outcome.error().element, "columns");
}

TEST(TouchInASession, LastsThroughAPause) {
  PlateRig rig;
  ASSERT_FALSE(rig.session.start());
  TickRecord record;
  const auto touch_at = [&](double z_m) {
    rig.device.position_m.z() = z_m;
    rig.session.tick(1e-3);
    EXPECT_TRUE(rig.session.latest(record));
    return record.touch;
  };
  EXPECT_EQ(touch_at(0.012), 0);
  EXPECT_EQ(touch_at(0.009), kTouchBegan);
  rig.session.set_paused(true);
  const std::uint64_t tick = record.tick;
  for (int n = 0; n < 5; ++n) touch_at(0.009);
  EXPECT_EQ(record.tick, tick) << "a pause runs no tick";
  rig.session.set_paused(false);
  EXPECT_EQ(touch_at(0.009), 0);
  EXPECT_EQ(record.body, 0);
  EXPECT_EQ(touch_at(0.012), kTouchEnded);
}

}  // namespace
}  // namespace palpate
