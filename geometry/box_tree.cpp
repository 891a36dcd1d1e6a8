#include "geometry/box_tree.h"

#include <algorithm>
#include <cassert>
#include <limits>

#include "geometry/embree_boxes.h"

namespace palpate {
namespace {

struct AlongQuery {
  SegmentQuery segment;
  BoxTree::AlongVisitor visitor;
  void* state;
};

void visit_box(const RTCIntersectFunctionNArguments* args) {
  if (!args->valid[0]) return;
  const auto* query = reinterpret_cast<const AlongQuery*>(args->context);
  query->segment.end_at(query->visitor(query->state, args->primID), args);
}

Box around(const std::vector<Box>& boxes) {
  const double infinity = std::numeric_limits<double>::infinity();
  Box box{Vec3::Constant(infinity), Vec3::Constant(-infinity)};
  for (const Box& b : boxes) box = box.united(b);
  return box;
}

}  // namespace

BoxTree::BoxTree(const std::vector<Box>& boxes, double sweep_radius_m)
    : bounds_(around(boxes)), sweep_radius_m_(sweep_radius_m) {
  const double reach =
      std::max(bounds_.low.cwiseAbs().maxCoeff(), bounds_.high.cwiseAbs().maxCoeff());
  const double margin = sweep_radius_m + kFloatMarginUlps * std::numeric_limits<float>::epsilon() *
                                             (reach + sweep_radius_m);
  std::vector<Box> grown;
  grown.reserve(boxes.size());
  for (const Box& box : boxes) grown.push_back(box.grown(margin));
  bounds_ = bounds_.grown(margin);
  boxes_ = std::make_unique<EmbreeBoxes>(grown, visit_box);
}

BoxTree::~BoxTree() = default;

void BoxTree::visit_near(const Vec3& p, double radius_m, NearVisitor visitor,
                         void* state) const noexcept {
  if (bounds_.squared_distance(p) > radius_m * radius_m) return;
  const float p_float[3] = {static_cast<float>(p.x()), static_cast<float>(p.y()),
                            static_cast<float>(p.z())};
  const float radius = round_up(radius_m + float_point_margin_m(p));
  // Embree goes on to boxes at no distance, and to the rest of a leaf, whatever radius is left.
  bool wants_more = true;
  boxes_->query_point(p_float, radius, [&](std::uint32_t box) {
    wants_more = wants_more && visitor(state, box);
    return wants_more ? radius : 0.0f;
  });
}

void BoxTree::visit_along(const Vec3& p, const Vec3& d, double radius_m, AlongVisitor visitor,
                          void* state) const noexcept {
  assert(radius_m <= sweep_radius_m_);
  static_cast<void>(radius_m);
  AlongQuery query{};
  if (!query.segment.begin(bounds_, p, d)) return;
  query.visitor = visitor;
  query.state = state;
  boxes_->query_segment(query.segment);
}

}  // namespace palpate
