#include "geometry/embree_boxes.h"

namespace palpate {
namespace {

// One Embree device for the process: creating one costs milliseconds and starts threads.
RTCDevice shared_device() {
  static const RTCDevice device = rtcNewDevice(nullptr);
  return device;
}

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

EmbreeBoxes::EmbreeBoxes(const std::vector<Box>& boxes, RTCIntersectFunctionN visit)
    : scene_(rtcNewScene(shared_device())) {
  rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_MEDIUM);
  const RTCGeometry geometry = rtcNewGeometry(shared_device(), RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(boxes.size()));
  rtcSetGeometryUserData(geometry, const_cast<std::vector<Box>*>(&boxes));
  rtcSetGeometryMask(geometry, embree::kAllRays);
  rtcSetGeometryBoundsFunction(
      geometry, [](const RTCBoundsFunctionArguments* args) { write_bounds(args); }, nullptr);
  rtcSetGeometryIntersectFunction(geometry, visit);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene_, geometry);
  rtcCommitScene(scene_);
  rtcSetGeometryUserData(geometry, nullptr);
  rtcReleaseGeometry(geometry);
}

EmbreeBoxes::~EmbreeBoxes() {
  rtcReleaseScene(scene_);
}

}  // namespace palpate
