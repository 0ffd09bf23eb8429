#pragma once
/// PNG files by libdeflate: for flat pictures its fastest level without filters is faster and
/// smaller than usual encoders.
#include <memory>
#include <span>
#include <string_view>

#include "engine/render/renderer.hpp"

struct libdeflate_compressor;

namespace pantin::detail {

/// Encodes pictures one after another, reusing its memory.
class PngEncoder {
 public:
  PngEncoder();
  /// The bytes of the file; valid until the next call. Opaque pictures are written as RGB.
  std::span<const std::uint8_t> encode(const Image& image);

 private:
  struct Free {
    void operator()(libdeflate_compressor* c) const;
  };
  std::unique_ptr<libdeflate_compressor, Free> compressor_;
  std::vector<std::uint8_t> rows_, file_;
};

/// The bytes as a string view, for writing files.
std::string_view as_text(std::span<const std::uint8_t> bytes);

}  // namespace pantin::detail
