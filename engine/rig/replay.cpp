#include "engine/rig/replay.h"

#include <memory>
#include <utility>

#include "engine/devices/path_device.h"
#include "engine/rig/rig.h"

namespace palpate {
namespace {

constexpr std::size_t kTicksBetweenProgress = 1024;

// The same as the public replay(), but throws if an allocation fails. lengths_s: null if every tick
// has the length setup.dt_s.
Result<RunRecords> replay(const Scene& scene, const RunSetup& setup,
                          const std::vector<Vec3>& path_m, const std::vector<double>* lengths_s,
                          int passes, const std::function<void(double)>& progress,
                          MemoryLedger& ledger) {
  if (auto error = check_setup(scene, setup)) return *error;
  if (auto error = take_tick_memory(path_m.size(), ledger)) return *error;
  auto keeper = std::make_unique<RecordKeeper>(path_m.size());
  for (int pass = 0; pass < passes; ++pass) {
    PathDevice device(path_m);
    auto rig =
        Rig::create(scene, setup, device,
                    {.keeper = std::move(keeper), .has_measured_times = lengths_s != nullptr});
    if (!rig) return rig.error();
    HapticSession& session = (*rig)->session();
    session.start();
    for (std::size_t n = 0; n < path_m.size(); ++n) {
      if (progress && n % kTicksBetweenProgress == 0) {
        const double of_pass = static_cast<double>(n) / static_cast<double>(path_m.size());
        progress((pass + of_pass) / passes);
      }
      session.tick(lengths_s ? (*lengths_s)[n] : setup.dt_s);
    }
    keeper = (*rig)->take_keeper();
  }
  return keeper->finish();
}

}  // namespace

Result<RunRecords> replay(const Scene& scene, const RunSetup& setup,
                          const std::vector<Vec3>& path_m, int passes,
                          const std::function<void(double)>& progress) {
  MemoryLedger ledger;
  return or_out_of_memory(
      ledger, [&] { return replay(scene, setup, path_m, nullptr, passes, progress, ledger); });
}

Result<RunRecords> replay(const Scene& scene, const RunSetup& setup,
                          const std::vector<Vec3>& path_m, const std::vector<double>& lengths_s,
                          int passes, const std::function<void(double)>& progress) {
  MemoryLedger ledger;
  return or_out_of_memory(
      ledger, [&] { return replay(scene, setup, path_m, &lengths_s, passes, progress, ledger); });
}

}  // namespace palpate
