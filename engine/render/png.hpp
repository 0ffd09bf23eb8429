#pragma once
/// PNG files by libdeflate: the pictures are flat, so its fastest level without filters beats the
/// usual writers both in time and in size.
#include <memory>
#include <span>
#include <string_view>

#include "engine/render/renderer.hpp"

struct libdeflate_compressor;

namespace pantin::detail {

/// Encodes one picture after another with the same memory.
class PngEncoder {
 public:
  PngEncoder();
  /// The bytes of the file; good until the next call. Opaque pictures are written as RGB.
  std::span<const std::uint8_t> encode(const Image& image);

 private:
  struct Free {
    void operator()(libdeflate_compressor* c) const;
  };
  std::unique_ptr<libdeflate_compressor, Free> compressor_;
  std::vector<std::uint8_t> rows_, file_;
};

/// Bytes as what files are written from.
std::string_view as_text(std::span<const std::uint8_t> bytes);

}  // namespace pantin::detail
