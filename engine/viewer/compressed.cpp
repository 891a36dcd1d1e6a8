#include "engine/viewer/compressed.h"

#include <new>
#include <zlib.h>

namespace palpate {

std::string gzip_compressed(std::string_view bytes) {
  constexpr int kGzip = 16 + MAX_WBITS;  // zlib's code for this format
  constexpr int kUsualMemory = 8;
  z_stream stream = {};
  if (deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, kGzip, kUsualMemory,
                   Z_DEFAULT_STRATEGY) != Z_OK) {
    throw std::bad_alloc();
  }
  std::string out(deflateBound(&stream, bytes.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  deflate(&stream, Z_FINISH);  // succeeds: the output has room for all bytes
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

}  // namespace palpate
