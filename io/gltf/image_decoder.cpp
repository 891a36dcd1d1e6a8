#include "io/gltf/image_decoder.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <new>
#include <optional>
#include <spng.h>
#include <string>
#include <turbojpeg.h>
#include <utility>
#include <vector>

#include "io/gltf/error.h"
#include "io/gltf/limits.h"

namespace palpate {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::size_t kColours = 3;
constexpr std::uint16_t kPer8BitStep = 257;  // 255 becomes 65535
constexpr const char* kDamagedHint = "the image may be damaged or truncated";

bool begins_with(Bytes bytes, std::span<const std::uint8_t> magic) {
  return bytes.size() >= magic.size() && std::equal(magic.begin(), magic.end(), bytes.begin());
}

std::optional<Error> check_size(std::uint64_t width, std::uint64_t height, const ImageRoom& room) {
  // As in gltf/limits.h: the decoded pixels, the kept pixels and the decoder's own memory.
  constexpr std::uint64_t kBytesPerPixel = 16;
  const std::string size =
      "has " + std::to_string(width) + " x " + std::to_string(height) + " pixels; ";
  if (width == 0 || height == 0) return gltf_invalid({}, size + "expected 1 x 1 or more");
  if (width > kMaxGltfImageSide || height > kMaxGltfImageSide) {
    const std::string side = std::to_string(kMaxGltfImageSide);
    return gltf_error(ErrorCode::kLimitExceeded, {},
                      size + "at most " + side + " x " + side + " are read");
  }
  if (width * height > room.max_pixels) {
    return gltf_error(
        ErrorCode::kLimitExceeded, {},
        size + "at most " + std::to_string(room.max_pixels) + " of a scene can still be read",
        "use a smaller image");
  }
  if (room.admit) return room.admit(kBytesPerPixel * width * height);
  return std::nullopt;
}

std::vector<std::uint16_t> widened(const std::vector<std::uint8_t>& values) {
  std::vector<std::uint16_t> wide(values.size());
  std::transform(values.begin(), values.end(), wide.begin(), [](std::uint8_t value) {
    return static_cast<std::uint16_t>(kPer8BitStep * value);
  });
  return wide;
}

// --- PNG -----------------------------------------------------------------------------------------

// The error for a status of the library; throws std::bad_alloc if the library is out of memory.
Error png_error(int status) {
  if (status == SPNG_EMEM) throw std::bad_alloc();
  return gltf_invalid({}, std::string("cannot be decoded as PNG: ") + spng_strerror(status),
                      kDamagedHint);
}

std::vector<std::uint16_t> without_alpha(const std::vector<std::uint16_t>& rgba) {
  std::vector<std::uint16_t> rgb(rgba.size() / 4 * kColours);
  for (std::size_t from = 0, to = 0; from < rgba.size(); from += 4, to += kColours) {
    for (std::size_t colour = 0; colour < kColours; ++colour)
      rgb[to + colour] = rgba[from + colour];
  }
  return rgb;
}

Result<ImageDescription> decode_png(Bytes bytes, const ImageRoom& room) {
  // Chunks without pixels, such as texts, are skipped; a colour profile is inflated before it is
  // skipped.
  constexpr std::size_t kMaxChunkBytes = std::size_t{1} << 22;
  const std::unique_ptr<spng_ctx, decltype(&spng_ctx_free)> png(spng_ctx_new(0), &spng_ctx_free);
  if (!png) return png_error(SPNG_EMEM);
  spng_set_crc_action(png.get(), SPNG_CRC_ERROR, SPNG_CRC_USE);
  spng_set_chunk_limits(png.get(), kMaxChunkBytes, kMaxChunkBytes);
  if (const int status = spng_set_png_buffer(png.get(), bytes.data(), bytes.size())) {
    return png_error(status);
  }
  spng_ihdr header{};
  if (const int status = spng_get_ihdr(png.get(), &header)) return png_error(status);
  if (auto error = check_size(header.width, header.height, room)) return *error;
  const std::size_t pixels = std::size_t{header.width} * header.height;
  ImageDescription image{header.width, header.height, {}};
  if (header.bit_depth == 16) {
    std::vector<std::uint16_t> rgba(4 * pixels);
    const int status = spng_decode_image(png.get(), rgba.data(), rgba.size() * sizeof rgba.front(),
                                         SPNG_FMT_RGBA16, 0);
    if (status) return png_error(status);
    image.rgb = without_alpha(rgba);
  } else {
    std::vector<std::uint8_t> rgb(kColours * pixels);
    if (const int status = spng_decode_image(png.get(), rgb.data(), rgb.size(), SPNG_FMT_RGB8, 0)) {
      return png_error(status);
    }
    image.rgb = widened(rgb);
  }
  return image;
}

// --- JPEG ----------------------------------------------------------------------------------------

struct CloseTurboJpeg {
  void operator()(void* decoder) const { tjDestroy(decoder); }
};

// The last error of the library; throws std::bad_alloc if the library is out of memory, which only
// its message shows.
Error jpeg_error(tjhandle decoder) {
  const std::string reason = tjGetErrorStr2(decoder);
  const bool has_no_memory = reason.find("nsufficient memory") != std::string::npos ||
                             reason.find("emory allocation failure") != std::string::npos;
  if (decoder == nullptr || has_no_memory) throw std::bad_alloc();
  return gltf_invalid({}, "cannot be decoded as JPEG: " + reason, kDamagedHint);
}

Result<ImageDescription> decode_jpeg(Bytes bytes, const ImageRoom& room) {
  const std::unique_ptr<void, CloseTurboJpeg> decoder(tjInitDecompress());
  if (!decoder) return jpeg_error(nullptr);
  int width = 0;
  int height = 0;
  int subsampling = 0;
  int colour_space = 0;
  if (tjDecompressHeader3(decoder.get(), bytes.data(), bytes.size(), &width, &height, &subsampling,
                          &colour_space) != 0) {
    return jpeg_error(decoder.get());
  }
  if (colour_space == TJCS_CMYK || colour_space == TJCS_YCCK) {
    return gltf_error(ErrorCode::kUnsupported, {}, "has CMYK colours", "save it in grey or RGB");
  }
  const auto columns = static_cast<std::uint32_t>(width);
  const auto rows = static_cast<std::uint32_t>(height);
  if (auto error = check_size(columns, rows, room)) return *error;
  std::vector<std::uint8_t> rgb(kColours * columns * rows);
  // A truncated file is only a warning of the library. The number of scans is limited because each
  // processes the whole image, however few bytes it has.
  constexpr int kFlags = TJFLAG_STOPONWARNING | TJFLAG_LIMITSCANS | TJFLAG_ACCURATEDCT;
  if (tjDecompress2(decoder.get(), bytes.data(), bytes.size(), rgb.data(), width, 0, height,
                    TJPF_RGB, kFlags) != 0) {
    return jpeg_error(decoder.get());
  }
  return ImageDescription{columns, rows, widened(rgb)};
}

}  // namespace

Result<ImageDescription> decode_image(Bytes bytes, const ImageRoom& room) {
  constexpr std::array<std::uint8_t, 8> kPng = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  constexpr std::array<std::uint8_t, 3> kJpeg = {0xff, 0xd8, 0xff};
  if (begins_with(bytes, kPng)) return decode_png(bytes, room);
  if (begins_with(bytes, kJpeg)) return decode_jpeg(bytes, room);
  return gltf_error(ErrorCode::kUnsupported, {}, "is neither PNG nor JPEG by its first bytes",
                    "save it as PNG, with 16 bits if heights need them");
}

}  // namespace palpate
