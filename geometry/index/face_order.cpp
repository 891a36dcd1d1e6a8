#include "geometry/index/face_order.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>

#include "geometry/base/box.h"
#include "geometry/base/fixed_array.h"
#include "geometry/base/parallel.h"
#include "geometry/index/triangle_pack.h"

namespace palpate {
namespace {

constexpr std::size_t kPackFaces = TrianglePack::kLanes;
constexpr std::size_t kCluster = kPackFaces * kPackFaces;

constexpr std::size_t kCentresWorthAThread = 20000;  // a millisecond of work
// The number of bins along an axis.
constexpr int kBins = 128;
// A part is measured again if its extent, relative to its distance from the origin of its places,
// is below this limit: at the limit, 14 of a float's 24 bits resolve the centres.
constexpr float kLeastExtent = 0x1p-10f;
// The same limit as an absolute extent, for parts near the origin of their places.
constexpr float kLeastExtentAtAll = 0x1p-60f;
// The bin of the median is divided into bins again if it has more than 1 / kFullBin of the faces.
// This repeats at most kMostRefinements times; the remaining bin, 2^-56 of the part or less, is
// sorted directly.
constexpr std::size_t kFullBin = 16;
constexpr int kMostRefinements = 8;

// A face and the place of its centre, relative to a part that contains the face and in units of the
// part's size.
struct alignas(16) Centre {
  float place[3];
  std::uint32_t face;
};

static_assert(kOrderBytesPerFace == 2 * sizeof(Centre));

struct Part {
  Centre* centres;
  Centre* spare;         // scratch space of the same size
  std::uint32_t* order;  // the result; used for bin numbers before
  std::size_t size;
  bool is_point = false;     // all centres coincide
  bool is_measured = false;  // places are measured in this part
  bool is_mixed = false;     // some places are relative to a smaller part

  Part from(std::size_t begin, std::size_t end) const {
    return {centres + begin, spare + begin, order + begin, end - begin, is_point, false, false};
  }
};

struct Extent {
  std::array<float, 3> low;
  std::array<float, 3> high;

  explicit Extent(const Part& part) {
    std::copy_n(part.centres->place, 3, low.begin());
    high = low;
    for (const Centre* c = part.centres; c != part.centres + part.size; ++c) {
      for (std::size_t k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], c->place[k]);
        high[k] = std::max(high[k], c->place[k]);
      }
    }
  }

  float along(std::size_t axis) const { return high[axis] - low[axis]; }
  std::size_t widest_axis() const {
    std::size_t widest = 0;
    for (std::size_t k = 1; k < 3; ++k) {
      if (along(k) > along(widest)) widest = k;
    }
    return widest;
  }
  bool is_too_small() const {
    float reach = 0.0f;  // from the origin of places
    for (std::size_t k = 0; k < 3; ++k) reach = std::max({reach, -low[k], high[k]});
    return along(widest_axis()) < std::max(kLeastExtent * reach, kLeastExtentAtAll);
  }
};

// Selects the faces of a part that are below its median along its widest axis.
class MedianSplit {
 public:
  MedianSplit(const Extent& extent, std::size_t middle)
      : axis_(extent.widest_axis()),
        middle_(middle),
        low_(extent.low[axis_]),
        bins_per_length_(static_cast<float>(kBins) / extent.along(axis_)) {}

  // Moves these faces to the first `middle` positions.
  void select(const Part& part) const { select(part.centres, part.centres + part.size, middle_); }

  // Like select(), except that the faces in the median's bin are not yet ordered. Returns their
  // range. The result is in part.spare.
  struct Range {
    std::size_t begin;
    std::size_t end;
    std::size_t size() const { return end - begin; }
  };
  Range select_bins(const Part& part) const {
    std::array<std::uint32_t, kBins> counts{};
    for (std::size_t i = 0; i < part.size; ++i) {
      part.order[i] = bin(part.centres[i]);
      ++counts[part.order[i]];
    }
    std::size_t before = 0;
    std::uint32_t median = 0;
    while (before + counts[median] <= middle_) before += counts[median++];
    const Range range{before, before + counts[median]};
    // The next output position for bins below the median's bin, for this bin, and for bins above.
    std::array<Centre*, 3> next{part.spare, part.spare + range.begin, part.spare + range.end};
    for (std::size_t i = 0; i < part.size; ++i) {
      const std::uint32_t b = part.order[i];
      *next[std::size_t{b >= median} + std::size_t{b > median}]++ = part.centres[i];
    }
    return range;
  }

  void select_in(const Part& part, const Range& range) const {
    select(part.centres + range.begin, part.centres + range.end, middle_ - range.begin);
  }

 private:
  // Increases with the place.
  std::uint32_t bin(const Centre& c) const {
    const float bin = (c.place[axis_] - low_) * bins_per_length_;
    return static_cast<std::uint32_t>(std::min(static_cast<float>(kBins - 1), bin));
  }

  void select(Centre* begin, Centre* end, std::size_t middle) const {
    std::nth_element(begin, begin + middle, end, [axis = axis_](const Centre& x, const Centre& y) {
      return x.place[axis] != y.place[axis] ? x.place[axis] < y.place[axis] : x.face < y.face;
    });
  }

  std::size_t axis_;
  std::size_t middle_;
  float low_;
  float bins_per_length_;
};

class Orderer {
 public:
  explicit Orderer(const MappedFaces& faces) : faces_(faces) {}

  // Computes the places of the centres of a part, relative to its middle and in units of its size.
  void measure(Part& part) const {
    const Box box = box_of_centres(part);
    part.is_point = box.low == box.high;
    part.is_measured = true;
    const Vec3 middle = 0.5 * box.low + 0.5 * box.high;
    // A power of two, so that only the conversion to float rounds. Limited to the range of a
    // double.
    int exponent = 0;
    std::frexp((box.high - box.low).maxCoeff(), &exponent);
    const double scale = std::ldexp(1.0, std::min(-exponent, 1000));
    run_ranges(part.size, kCentresWorthAThread, [&](std::size_t begin, std::size_t end) {
      for (Centre* c = part.centres + begin; c != part.centres + end; ++c) {
        const Vec3 place = (centre(c->face) - middle) * scale;
        for (int k = 0; k < 3; ++k) c->place[k] = static_cast<float>(place[k]);
      }
    });
  }

  void split(Part part) const {
    if (part.size <= kPackFaces) {
      for (std::size_t i = 0; i < part.size; ++i) part.order[i] = part.centres[i].face;
      return;
    }
    const std::size_t whole = part.size > kCluster ? kCluster : kPackFaces;
    const std::size_t middle = (part.size + whole - 1) / whole / 2 * whole;
    partition(part, middle, kMostRefinements);
    Part low = part.from(0, middle);
    Part high = part.from(middle, part.size);
    if (part.is_mixed) {
      measure(low);
      measure(high);
    }
    const auto split_low = [&] { split(low); };
    const auto split_high = [&] { split(high); };
    if (part.size >= kCentresWorthAThread) return run_both(split_low, split_high);
    split_low();
    split_high();
  }

 private:
  // An eighth of the sum of the corners, so that neither the centre nor the extent of many centres
  // overflows.
  Vec3 centre(std::uint32_t face) const {
    return 0.125 * faces_.corner(face, 0) + 0.125 * faces_.corner(face, 1) +
           0.125 * faces_.corner(face, 2);
  }

  Box box_of_centres(const Part& part) const {
    const Vec3 first = centre(part.centres->face);
    Box all{first, first};
    std::mutex mutex;
    run_ranges(part.size, kCentresWorthAThread, [&](std::size_t begin, std::size_t end) {
      Box box{first, first};
      for (const Centre* c = part.centres + begin; c != part.centres + end; ++c) {
        const Vec3 p = centre(c->face);
        box = box.united({p, p});
      }
      const std::lock_guard lock(mutex);
      all = all.united(box);
    });
    return all;
  }

  // Moves the first `middle` faces in the order to the front.
  void partition(Part& part, std::size_t middle, int refinements) const {
    Extent extent(part);
    if (!part.is_point && extent.is_too_small()) {
      measure(part);
      extent = Extent(part);
    }
    const MedianSplit median(extent, middle);
    if (part.is_point) return median.select(part);
    const MedianSplit::Range range = median.select_bins(part);
    std::swap(part.centres, part.spare);
    if (range.size() <= std::max(kPackFaces, part.size / kFullBin) || refinements == 0) {
      return median.select_in(part, range);
    }
    if (range.begin < middle) partition_bin(part, range, middle, refinements - 1);
  }

  // Partitions the median's bin again, for faces so close together that one bin has many of them.
  void partition_bin(Part& part, const MedianSplit::Range& range, std::size_t middle,
                     int refinements) const {
    Part bin = part.from(range.begin, range.end);
    partition(bin, middle - range.begin, refinements);
    if (bin.centres != part.centres + range.begin) {
      std::copy_n(bin.centres, bin.size, part.centres + range.begin);
    }
    part.is_mixed = bin.is_measured || bin.is_mixed;
  }

  const MappedFaces& faces_;
};

}  // namespace

void order_faces(const MappedFaces& faces, std::span<std::uint32_t> order) {
  const std::size_t count = faces.faces.size();
  if (count == 0) return;
  FixedArray<Centre> centres(count);
  FixedArray<Centre> spare(count);
  Part all{&centres[0], &spare[0], order.data(), count};
  for (std::uint32_t f = 0; f < count; ++f) centres[f].face = f;
  const Orderer orderer(faces);
  orderer.measure(all);
  orderer.split(all);
}

}  // namespace palpate
