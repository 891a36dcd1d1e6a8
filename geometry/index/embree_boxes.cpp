#include "geometry/index/embree_boxes.h"

#include <memory>
#include <new>
#include <stdexcept>
#include <type_traits>

#if __has_include(<tbb/task_arena.h>)
#include <tbb/task_arena.h>
#define PALPATE_HAS_TBB
#endif

namespace palpate {
namespace {

// Net bytes that Embree has allocated on this thread, the thread that builds a tree.
thread_local std::int64_t embree_bytes = 0;

bool count_bytes(void*, ssize_t bytes, bool) {
  embree_bytes += bytes;
  return true;
}

// Embree reports a memory shortage as several errors, depending on where it occurs.
[[noreturn]] void throw_embree_error(RTCError error) {
  if (error == RTC_ERROR_UNSUPPORTED_CPU) {
    throw std::runtime_error("Embree does not support this processor");
  }
  throw std::bad_alloc();
}

// Whether commit_on_this_thread() can prevent a device from using other threads. If not, the device
// must be created with one thread. With TBB, this setting would limit the whole process to one
// thread.
bool is_kept_to_one_thread([[maybe_unused]] RTCDevice device) {
#ifdef PALPATE_HAS_TBB
  constexpr ssize_t kTbb = 1;
  return rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_TASKING_SYSTEM) == kTbb;
#else
  return false;
#endif
}

// No subdivision surfaces are used, and Embree's cache for them would reserve 128 MB of address
// space.
RTCDevice new_device() {
  RTCDevice device = rtcNewDevice("tessellation_cache_size=0");
  if (device != nullptr && !is_kept_to_one_thread(device)) {
    rtcReleaseDevice(device);
    device = rtcNewDevice("tessellation_cache_size=0,threads=1");
  }
  if (device == nullptr) throw_embree_error(rtcGetDeviceError(nullptr));
  rtcSetDeviceMemoryMonitorFunction(device, count_bytes, nullptr);
  return device;
}

// One Embree device for the process: creating one costs a millisecond.
RTCDevice shared_device() {
  static const RTCDevice device = new_device();
  return device;
}

// Throws for an Embree error on the calling thread since the last check.
void check_device() {
  const RTCError error = rtcGetDeviceError(shared_device());
  if (error != RTC_ERROR_NONE) throw_embree_error(error);
}

// Builds on the calling thread only. A TBB thread that runs out of memory at its start ends the
// process, which cannot be prevented. One thread suffices because trees are small: a box represents
// 256 triangles or a body.
void commit_on_this_thread(RTCScene scene) {
#ifdef PALPATE_HAS_TBB
  tbb::task_arena(1, 1).execute([scene] { rtcCommitScene(scene); });
#else
  rtcCommitScene(scene);
#endif
  check_device();
}

struct ReleaseScene {
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
struct ReleaseGeometry {
  void operator()(RTCGeometry geometry) const { rtcReleaseGeometry(geometry); }
};
using OwnedScene = std::unique_ptr<std::remove_pointer_t<RTCScene>, ReleaseScene>;
using OwnedGeometry = std::unique_ptr<std::remove_pointer_t<RTCGeometry>, ReleaseGeometry>;

// Embree's objects, and the excess of allocated over requested block sizes: measured.
constexpr std::uint64_t kEmbreeBytesAtAll = 1500;

void write_bounds(const RTCBoundsFunctionArguments* args) {
  const auto& boxes = *static_cast<const std::vector<Box>*>(args->geometryUserPtr);
  const Box& box = boxes[args->primID];
  RTCBounds& out = *args->bounds_o;
  out.lower_x = round_down(box.low.x());
  out.lower_y = round_down(box.low.y());
  out.lower_z = round_down(box.low.z());
  out.upper_x = round_up(box.high.x());
  out.upper_y = round_up(box.high.y());
  out.upper_z = round_up(box.high.z());
}

}  // namespace

bool SegmentQuery::begin(const Box& bounds, const Vec3& p, const Vec3& d) {
  enter = 0.0;
  double leave = 1.0;
  length_m = d.cwiseAbs().maxCoeff();
  if (length_m == 0.0 || !bounds.clip(p, d, enter, leave)) return false;
  const Vec3 start = p + enter * d;
  const Vec3 inside = (leave - enter) * d;
  const Vec3 direction = d / length_m;
  embree::init(context);
  ray = {};
  ray.ray.org_x = origin[0] = static_cast<float>(start.x());
  ray.ray.org_y = origin[1] = static_cast<float>(start.y());
  ray.ray.org_z = origin[2] = static_cast<float>(start.z());
  for (int k = 0; k < 3; ++k) displacement[k] = static_cast<float>(inside[k]);
  ray.ray.dir_x = static_cast<float>(direction.x());
  ray.ray.dir_y = static_cast<float>(direction.y());
  ray.ray.dir_z = static_cast<float>(direction.z());
  ray.ray.tnear = 0.0f;
  ray.ray.tfar = round_up((leave - enter) * length_m);
  ray.ray.mask = embree::kAllRays;
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  return true;
}

EmbreeBoxes::EmbreeBoxes(const std::vector<Box>& boxes, RTCIntersectFunctionN visit) {
  const std::int64_t bytes_before = embree_bytes;
  OwnedScene scene(rtcNewScene(shared_device()));
  OwnedGeometry geometry(rtcNewGeometry(shared_device(), RTC_GEOMETRY_TYPE_USER));
  check_device();  // scene and geometry both exist
  rtcSetSceneFlags(scene.get(), RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(scene.get(), RTC_BUILD_QUALITY_MEDIUM);
  rtcSetGeometryUserPrimitiveCount(geometry.get(), static_cast<unsigned>(boxes.size()));
  rtcSetGeometryUserData(geometry.get(), const_cast<std::vector<Box>*>(&boxes));
  rtcSetGeometryMask(geometry.get(), embree::kAllRays);
  rtcSetGeometryBoundsFunction(
      geometry.get(), [](const RTCBoundsFunctionArguments* args) { write_bounds(args); }, nullptr);
  rtcSetGeometryIntersectFunction(geometry.get(), visit);
  rtcCommitGeometry(geometry.get());
  rtcAttachGeometry(scene.get(), geometry.get());
  check_device();
  commit_on_this_thread(scene.get());
  rtcSetGeometryUserData(geometry.get(), nullptr);
  memory_bytes_ =
      static_cast<std::size_t>(embree_bytes - bytes_before) + std::size_t{kEmbreeBytesAtAll};
  scene_ = scene.release();
}

MemoryNeed EmbreeBoxes::memory_need(std::uint64_t boxes) {
  // Memory of the BVH builder for user geometry, measured for 1 to 1,000,000 boxes. Block sizes
  // vary by factors of two, so a box uses between 76 and 138 bytes if there are 100 boxes or more.
  constexpr std::uint64_t kAtAll = 2304;
  constexpr std::uint64_t kPerBox = 132;
  constexpr std::uint64_t kPerBoxBuilding = 34;  // the boxes and their order
  const std::uint64_t kept = kEmbreeBytesAtAll + kAtAll + kPerBox * boxes;
  return {kept, kept + kPerBoxBuilding * boxes};
}

EmbreeBoxes::~EmbreeBoxes() {
  rtcReleaseScene(scene_);
}

}  // namespace palpate
