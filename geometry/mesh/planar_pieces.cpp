#include "geometry/mesh/planar_pieces.h"

#include <cmath>
#include <limits>
#include <unordered_map>

namespace palpate {
namespace {

// See planar_pieces().
constexpr double kMergedPerExtent = 0x1p-20;
constexpr double kRoundoff = 64 * 0x1p-53;  // rounding of a few products and sums

// Grid cells per merging distance: the rounding to the grid is far below merged_m, and coordinates
// stay below 2^27.
constexpr std::int64_t kCellsPerMerged = 64;

// A vertex lies on a piece if its distance from the piece is at most half of merged_m. The vertex
// is farther than merged_m from the ends, so the cut piece has an angle of at least 120 degrees
// there, and both parts are shorter than the whole. Pieces that cross are both cut at any angle. A
// cut may bend a piece on to another vertex or across another piece, so new pieces are tested again
// until no cut is left. Two to four rounds are usual; the limit stops endless cuts of a few short
// pieces around one place.
constexpr int kMostSplitRounds = 64;
constexpr double kOnPiece = 0.5 * static_cast<double>(kCellsPerMerged);
// The vertex of a crossing may be as far from the crossing as merged_m plus the rounding of the
// crossing.
constexpr double kCrossed = static_cast<double>(kCellsPerMerged) + 2.0;

// The largest numbers of examined pairs of pieces, which limits the time, and of vertices, which
// limits the memory. Usual numbers are below ten per segment.
constexpr std::uint64_t kMostPairs = 10'000'000;
constexpr std::uint64_t kMostVertices = 1'000'000;
constexpr std::uint64_t kMostPerSegment = 32;

constexpr std::uint32_t kNoVertex = 0xffffffffu;

double squared(double x) {
  return x * x;
}

class PieceCutter {
 public:
  PieceCutter(const std::vector<PlanarSegment>& segments, double largest_m) : segments_(segments) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    Eigen::Array2d low = Eigen::Array2d::Constant(kInfinity);
    Eigen::Array2d high = -low;
    for (const PlanarSegment& s : segments) {
      low = low.min(s.from.array()).min(s.to.array());
      high = high.max(s.from.array()).max(s.to.array());
    }
    if (segments.empty()) low = high = Eigen::Array2d::Zero();
    middle_ = (0.5 * low + 0.5 * high).matrix();
    result_.merged_m = std::max(kMergedPerExtent * (high - low).maxCoeff(), kRoundoff * largest_m);
    cell_m_ = result_.merged_m / static_cast<double>(kCellsPerMerged);
  }

  PlanarPieces run() {
    if (cell_m_ > 0.0) {
      take_segments();
      int round = 0;
      while (round < kMostSplitRounds && cut()) ++round;
      result_.gave_up = result_.gave_up || round == kMostSplitRounds;
    }
    return std::move(result_);
  }

 private:
  struct Cut {
    std::uint32_t piece, vertex;
    std::int64_t along;
  };

  const GridPoint& at(std::uint32_t vertex) const { return result_.vertices[vertex].at; }

  void take_segments() {
    for (std::uint32_t s = 0; s < segments_.size(); ++s) {
      const std::uint32_t from = vertex_at(on_grid(segments_[s].from), s, 0.0);
      const std::uint32_t to = vertex_at(on_grid(segments_[s].to), s, 1.0);
      if (from != to) result_.pieces.push_back({from, to, s});
    }
    is_new_.assign(result_.pieces.size(), true);
  }

  GridPoint on_grid(const Eigen::Vector2d& p) const {
    return {std::llround((p.x() - middle_.x()) / cell_m_),
            std::llround((p.y() - middle_.y()) / cell_m_)};
  }

  static std::uint64_t bucket_of(std::int64_t column, std::int64_t row) {
    return static_cast<std::uint64_t>(column) << 32 ^ static_cast<std::uint32_t>(row);
  }
  static std::int64_t cell_of(std::int64_t x) {
    return x >= 0 ? x / kCellsPerMerged : -((kCellsPerMerged - 1 - x) / kCellsPerMerged);
  }

  // The nearest vertex within merged_m of p, or a new vertex.
  std::uint32_t vertex_at(const GridPoint& p, std::uint32_t segment, double share) {
    const std::int64_t column = cell_of(p.x);
    const std::int64_t row = cell_of(p.y);
    std::int64_t nearest = kCellsPerMerged * kCellsPerMerged;
    std::uint32_t found = kNoVertex;
    for (std::int64_t c = column - 1; c <= column + 1; ++c) {
      for (std::int64_t r = row - 1; r <= row + 1; ++r) {
        const auto bucket = first_in_bucket_.find(bucket_of(c, r));
        if (bucket == first_in_bucket_.end()) continue;
        for (std::uint32_t v = bucket->second; v != kNoVertex; v = next_in_bucket_[v]) {
          const std::int64_t distance = dot(at(v) - p, at(v) - p);
          if (distance > nearest || (distance == nearest && found != kNoVertex && v > found))
            continue;
          nearest = distance;
          found = v;
        }
      }
    }
    if (found != kNoVertex) return found;
    const auto added = static_cast<std::uint32_t>(result_.vertices.size());
    result_.vertices.push_back({p, segment, share});
    const auto [bucket, is_first] = first_in_bucket_.emplace(bucket_of(column, row), added);
    next_in_bucket_.push_back(is_first ? kNoVertex : bucket->second);
    bucket->second = added;
    return added;
  }

  GridBox box_of(const PlanarPiece& piece) const {
    const GridPoint& a = at(piece.from);
    const GridPoint& b = at(piece.to);
    return GridBox{a, a}.united({b, b});
  }

  // One round of cuts. Returns false if no piece was cut.
  bool cut() {
    std::vector<GridBox> boxes;
    boxes.reserve(result_.pieces.size());
    for (const PlanarPiece& piece : result_.pieces) boxes.push_back(box_of(piece));
    const PlanarBoxes tree(boxes);
    cuts_.clear();
    std::vector<std::uint32_t> near;
    for (std::uint32_t i = 0; i < boxes.size(); ++i) {
      if (!is_new_[i]) continue;
      near.clear();
      tree.visit(boxes[i].grown(kCellsPerMerged), [&](std::uint32_t k) { near.push_back(k); });
      std::sort(near.begin(), near.end());
      for (const std::uint32_t k : near) {
        if (k != i && (k > i || !is_new_[k])) meet(i, k);
      }
      pairs_ += near.size();
      if (are_too_many()) return false;
    }
    if (cuts_.empty()) return false;
    std::sort(cuts_.begin(), cuts_.end(), [](const Cut& a, const Cut& b) {
      if (a.piece != b.piece) return a.piece < b.piece;
      return a.along != b.along ? a.along < b.along : a.vertex < b.vertex;
    });
    carry_out_cuts();
    return true;
  }

  bool are_too_many() {
    const std::uint64_t more = kMostPerSegment * segments_.size();
    result_.gave_up = pairs_ > kMostPairs + more || result_.vertices.size() > kMostVertices + more;
    return result_.gave_up;
  }

  // Finds the cuts that two pieces cause in each other.
  void meet(std::uint32_t i, std::uint32_t k) {
    const PlanarPiece a = result_.pieces[i];
    const PlanarPiece b = result_.pieces[k];
    cut_at(i, b.from);
    cut_at(i, b.to);
    cut_at(k, a.from);
    cut_at(k, a.to);
    const GridPoint along_a = at(a.to) - at(a.from);
    const GridPoint along_b = at(b.to) - at(b.from);
    const std::int64_t a_from = cross(along_b, at(a.from) - at(b.from));
    const std::int64_t a_to = cross(along_b, at(a.to) - at(b.from));
    const std::int64_t b_from = cross(along_a, at(b.from) - at(a.from));
    const std::int64_t b_to = cross(along_a, at(b.to) - at(a.from));
    const auto are_apart = [](std::int64_t s, std::int64_t t) {
      return (s < 0 && t > 0) || (s > 0 && t < 0);
    };
    if (!are_apart(a_from, a_to) || !are_apart(b_from, b_to)) return;
    const double share = static_cast<double>(a_from) / static_cast<double>(a_from - a_to);
    const GridPoint p{at(a.from).x + std::llround(share * static_cast<double>(along_a.x)),
                      at(a.from).y + std::llround(share * static_cast<double>(along_a.y))};
    const std::uint32_t vertex = vertex_at(p, a.segment, share_of(a.segment, p));
    cut_at(i, vertex, kCrossed);
    cut_at(k, vertex, kCrossed);
  }

  // The position of a point along a segment, as a fraction of its length.
  double share_of(std::uint32_t segment, const GridPoint& p) const {
    const PlanarSegment& s = segments_[segment];
    const Eigen::Vector2d way = s.to - s.from;
    const Eigen::Vector2d p_m =
        middle_ + cell_m_ * Eigen::Vector2d(static_cast<double>(p.x), static_cast<double>(p.y));
    return std::clamp((p_m - s.from).dot(way) / way.squaredNorm(), 0.0, 1.0);
  }

  // Adds a cut if the vertex lies on the piece and is not one of its ends.
  void cut_at(std::uint32_t piece, std::uint32_t vertex, double within = kOnPiece) {
    const PlanarPiece& p = result_.pieces[piece];
    if (vertex == p.from || vertex == p.to) return;
    const GridPoint way = at(p.to) - at(p.from);
    const GridPoint offset = at(vertex) - at(p.from);
    const std::int64_t along = dot(way, offset);
    const std::int64_t whole = dot(way, way);
    if (within < kCrossed && (along <= 0 || along >= whole)) return;
    const auto aside = static_cast<double>(cross(way, offset));
    if (squared(aside) > squared(within) * static_cast<double>(whole)) return;
    cuts_.push_back({piece, vertex, along});
  }

  // Adds a piece. A piece that returns along the last piece of the same segment cancels that piece.
  static void add_piece(const PlanarPiece& piece, bool is_cut, std::vector<PlanarPiece>& pieces,
                        std::vector<bool>& is_new) {
    if (piece.from == piece.to) return;
    const bool goes_back = !pieces.empty() && pieces.back().segment == piece.segment &&
                           pieces.back().from == piece.to && pieces.back().to == piece.from;
    if (goes_back) {
      pieces.pop_back();
      is_new.pop_back();
    } else {
      pieces.push_back(piece);
      is_new.push_back(is_cut);
    }
  }

  void carry_out_cuts() {
    std::vector<PlanarPiece> pieces;
    std::vector<bool> is_new;
    auto cut = cuts_.begin();
    for (std::uint32_t i = 0; i < result_.pieces.size(); ++i) {
      PlanarPiece rest = result_.pieces[i];
      const bool is_cut = cut != cuts_.end() && cut->piece == i;
      for (; cut != cuts_.end() && cut->piece == i; ++cut) {
        if (cut->vertex == rest.from) continue;
        add_piece({rest.from, cut->vertex, rest.segment}, true, pieces, is_new);
        rest.from = cut->vertex;
      }
      add_piece(rest, is_cut, pieces, is_new);
    }
    result_.pieces = std::move(pieces);
    is_new_ = std::move(is_new);
  }

  const std::vector<PlanarSegment>& segments_;
  Eigen::Vector2d middle_;
  double cell_m_ = 0.0;
  PlanarPieces result_;
  std::vector<bool> is_new_;  // by piece, since the last round
  std::vector<Cut> cuts_;
  std::uint64_t pairs_ = 0;
  std::unordered_map<std::uint64_t, std::uint32_t> first_in_bucket_;
  std::vector<std::uint32_t> next_in_bucket_;  // by vertex
};

}  // namespace

PlanarPieces planar_pieces(const std::vector<PlanarSegment>& segments, double largest_m) {
  return PieceCutter(segments, largest_m).run();
}

}  // namespace palpate
