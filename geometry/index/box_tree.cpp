#include "geometry/index/box_tree.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <limits>
#include <span>

#include "geometry/index/embree_boxes.h"
#include "geometry/index/pack_queries.h"

namespace palpate {
namespace {

// The largest number of boxes that a query collects and sorts; more boxes are searched in order.
constexpr std::size_t kFoundAtOnce = 256;

// The boxes that Embree finds, up to the capacity.
struct FoundBoxes {
  std::array<std::uint32_t, kFoundAtOnce> numbers;
  std::size_t count = 0;
  bool are_too_many = false;

  // Returns false if the capacity is exceeded.
  bool add(std::uint32_t number) {
    are_too_many = are_too_many || count == numbers.size();
    if (!are_too_many) numbers[count++] = number;
    return !are_too_many;
  }
};

struct AlongQuery {
  SegmentQuery segment;
  FoundBoxes* found;
};

void visit_box(const RTCIntersectFunctionNArguments* args) {
  if (!args->valid[0]) return;
  const auto* query = reinterpret_cast<const AlongQuery*>(args->context);
  if (!query->found->add(args->primID)) SegmentQuery::end(args);
}

// Visits the boxes that pass the test, from number `first` on: the found boxes, or boxes of the
// whole tree if too many were found.
template <typename Test>
QueryWork visit_in_order(FoundBoxes& found, std::span<const BoxPack> groups,
                         const OrderedBoxes& ordered, std::uint32_t first, const Test& test,
                         BoxTree::Visitor visitor, void* state) {
  QueryWork work;
  if (!found.are_too_many) {
    work.sorted = found.count;
    const auto numbers = std::span(found.numbers).first(found.count);
    std::sort(numbers.begin(), numbers.end());
    for (const std::uint32_t number : numbers) {
      const bool passes = test(groups[number / kBoxLanes]) >> (number % kBoxLanes) & 1u;
      if (number >= first && passes && !visitor(state, number)) return work;
    }
    return work;
  }
  work.listed = found.count;
  const CountedTest<Test> counted{test, work.boxes};
  for (auto group = ordered.next(first / kBoxLanes, counted); group;
       group = ordered.next(*group + 1, counted)) {
    for (std::uint32_t lanes = counted(groups[*group]); lanes != 0;) {
      const std::uint32_t number =
          *group * kBoxLanes + static_cast<std::uint32_t>(take_lane(lanes));
      if (number >= first && !visitor(state, number)) return work;
    }
  }
  return work;
}

Box around(const std::vector<Box>& boxes) {
  const double infinity = std::numeric_limits<double>::infinity();
  Box box{Vec3::Constant(infinity), Vec3::Constant(-infinity)};
  for (const Box& b : boxes) box = box.united(b);
  return box;
}

// The boxes in float, rounded outwards, sixteen per group.
std::vector<BoxPack> groups_of(const std::vector<Box>& boxes, double margin) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  std::vector<BoxPack> groups((boxes.size() + kBoxLanes - 1) / kBoxLanes);
  for (std::size_t i = 0; i < groups.size() * kBoxLanes; ++i) {
    BoxPack& group = groups[i / kBoxLanes];
    for (int k = 0; k < 3; ++k) {
      const bool is_there = i < boxes.size();
      group.low[k][i % kBoxLanes] = is_there ? round_down(boxes[i].low[k] - margin) : kInfinity;
      group.high[k][i % kBoxLanes] = is_there ? round_up(boxes[i].high[k] + margin) : -kInfinity;
    }
  }
  return groups;
}

}  // namespace

BoxTree::BoxTree(const std::vector<Box>& boxes, double sweep_radius_m)
    : bounds_(around(boxes)), sweep_radius_m_(sweep_radius_m) {
  const double reach =
      std::max(bounds_.low.cwiseAbs().maxCoeff(), bounds_.high.cwiseAbs().maxCoeff());
  const double float_margin =
      kFloatMarginUlps * std::numeric_limits<float>::epsilon() * (reach + sweep_radius_m);
  // Twice the margin for Embree, so that its tree finds each box that passes the test on its own.
  std::vector<Box> grown;
  grown.reserve(boxes.size());
  for (const Box& box : boxes) grown.push_back(box.grown(2 * float_margin + sweep_radius_m));
  bounds_ = bounds_.grown(float_margin + sweep_radius_m);
  boxes_ = std::make_unique<EmbreeBoxes>(grown, visit_box);
  groups_ = groups_of(boxes, float_margin);
  ordered_groups_ = OrderedBoxes(groups_);
}

BoxTree::~BoxTree() = default;

MemoryNeed BoxTree::memory_need(std::uint64_t boxes) {
  const std::uint64_t groups = (boxes + kBoxLanes - 1) / kBoxLanes;
  const MemoryNeed tree = EmbreeBoxes::memory_need(boxes);
  const std::uint64_t kept =
      sizeof(BoxTree) + tree.kept + groups * sizeof(BoxPack) + OrderedBoxes::memory_need(groups);
  return {kept, kept + tree.peak - tree.kept + boxes * sizeof(Box)};
}

std::size_t BoxTree::memory_bytes() const {
  return sizeof(*this) + groups_.capacity() * sizeof(BoxPack) + ordered_groups_.memory_bytes() +
         boxes_->memory_bytes();
}

QueryWork BoxTree::visit_near(const Vec3& p, double radius_m, NearSearch search, Visitor visitor,
                              void* state) const noexcept {
  if (bounds_.squared_distance(p) > radius_m * radius_m) return {};
  const BoxesNear near(p, radius_m);
  FoundBoxes found;
  found.are_too_many = search == NearSearch::kInOrder;
  if (search == NearSearch::kWithEmbree) {
    // Embree visits boxes at distance zero and the rest of a leaf even with a radius of zero.
    boxes_->query_point(near.p, near.radius,
                        [&](std::uint32_t box) { return found.add(box) ? near.radius : 0.0f; });
  }
  return visit_in_order(found, groups_, ordered_groups_, 0, near, visitor, state);
}

QueryWork BoxTree::visit_along(const Vec3& p, const Vec3& d, double radius_m, std::uint32_t first,
                               Visitor visitor, void* state) const noexcept {
  assert(radius_m <= sweep_radius_m_);
  FoundBoxes found;
  AlongQuery query{{}, &found};
  if (!query.segment.begin(bounds_, p, d)) return {};
  boxes_->query_segment(query.segment);
  const BoxesAlong along{query.segment, round_up(radius_m)};
  return visit_in_order(found, groups_, ordered_groups_, first, along, visitor, state);
}

}  // namespace palpate
