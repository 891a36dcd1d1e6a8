#pragma once

// Maps the faces of a cleaned surface to the triangles of its input.

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace palpate {

// A point of a triangle: the weights of the triangle's second and third corner. The weight of the
// first corner is 1 minus their sum.
using CornerWeights = std::array<double, 2>;

// A face that is a part of its source triangle, because an edge of the triangle was divided.
struct FacePiece {
  std::uint32_t face;
  std::array<CornerWeights, 3> corners;  // of the face, in the source triangle
};

// Several faces may have the same source triangle; the sources ascend with the faces.
class SourceTriangles {
 public:
  SourceTriangles() = default;  // every face has the triangle with the same number
  // All triangles except the dropped ones. dropped: ascending.
  explicit SourceTriangles(const std::vector<std::uint32_t>& dropped);

  // Appends the source of a face. Faces must be appended in ascending order, starting with 0, and
  // only to an object without dropped triangles.
  void append(std::uint32_t face, std::uint32_t triangle);
  // Appends a face that is a piece of its source triangle. Call append() for the face, too.
  void append_piece(const FacePiece& piece) { pieces_.push_back(piece); }
  void shrink_to_fit();

  // O(log n) in the number of changes.
  std::uint32_t of_face(std::size_t face) const;
  // The piece that the face is; null if the face is its whole source triangle. O(log n).
  const FacePiece* piece(std::size_t face) const;
  std::size_t memory_bytes() const;

 private:
  // Faces from `face` to the next run have consecutive sources that begin with `triangle`.
  struct Run {
    std::uint32_t face;
    std::uint32_t triangle;
  };
  std::vector<Run> runs_;  // ascending; without a run for the first faces, their sources begin at 0
  std::vector<FacePiece> pieces_;  // ascending
};

}  // namespace palpate
