#include "engine/render/png.hpp"

#include <libdeflate.h>

#include <cstring>

#include "engine/base/atomic_file.hpp"
#include "engine/base/check.hpp"
#include "engine/render/capture.hpp"

namespace pantin::detail {
namespace {

constexpr std::uint8_t kSignature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};

void put_word(std::uint8_t* at, std::uint32_t word) {
  for (int i = 0; i < 4; ++i) at[i] = static_cast<std::uint8_t>(word >> (24 - 8 * i));
}

/// Completes a chunk whose `size` bytes of data start at `begin + 8`; returns the end of the chunk.
std::uint8_t* close_chunk(std::uint8_t* begin, const char* type, std::size_t size) {
  put_word(begin, static_cast<std::uint32_t>(size));
  std::memcpy(begin + 4, type, 4);
  put_word(begin + 8 + size, libdeflate_crc32(0, begin + 4, size + 4));
  return begin + 12 + size;
}

bool is_opaque(const Image& image) {
  for (std::size_t i = 3; i < image.rgba.size(); i += 4)
    if (image.rgba[i] != 255) return false;
  return true;
}

/// Copies each row after a filter byte of 0.
void pack_rows(const Image& image, std::size_t channels, std::vector<std::uint8_t>& rows) {
  const auto width = static_cast<std::size_t>(image.width);
  const auto height = static_cast<std::size_t>(image.height);
  rows.resize((width * channels + 1) * height);
  const std::uint8_t* from = image.rgba.data();
  std::uint8_t* to = rows.data();
  for (std::size_t y = 0; y < height; ++y) {
    *to++ = 0;
    if (channels == 4) {
      std::memcpy(to, from, width * 4);
      to += width * 4, from += width * 4;
      continue;
    }
    for (std::size_t x = 0; x < width; ++x, from += 4, to += 3) {
      to[0] = from[0], to[1] = from[1], to[2] = from[2];
    }
  }
}

}  // namespace

void PngEncoder::Free::operator()(libdeflate_compressor* c) const { libdeflate_free_compressor(c); }

PngEncoder::PngEncoder() : compressor_(libdeflate_alloc_compressor(1)) {}

std::span<const std::uint8_t> PngEncoder::encode(const Image& image) {
  PANTIN_ASSERT(image.width > 0 && image.height > 0 &&
                image.rgba.size() == std::size_t(4) * image.width * image.height);
  const bool opaque = is_opaque(image);
  pack_rows(image, opaque ? 3 : 4, rows_);
  const std::size_t bound = libdeflate_zlib_compress_bound(compressor_.get(), rows_.size());
  if (file_.size() < bound + 128) file_.resize(bound + 128);

  std::uint8_t* at = file_.data();
  std::memcpy(at, kSignature, sizeof kSignature);
  at += sizeof kSignature;
  put_word(at + 8, static_cast<std::uint32_t>(image.width));
  put_word(at + 12, static_cast<std::uint32_t>(image.height));
  const std::uint8_t form[5] = {8, static_cast<std::uint8_t>(opaque ? 2 : 6), 0, 0, 0};
  std::memcpy(at + 16, form, sizeof form);
  at = close_chunk(at, "IHDR", 13);
  at[8] = 0;  // perceptual
  at = close_chunk(at, "sRGB", 1);
  const std::size_t size =
      libdeflate_zlib_compress(compressor_.get(), rows_.data(), rows_.size(), at + 8, bound);
  at = close_chunk(at, "IDAT", size);
  at = close_chunk(at, "IEND", 0);
  return {file_.data(), at};
}

std::string_view as_text(std::span<const std::uint8_t> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace pantin::detail

namespace pantin {

using namespace detail;

std::vector<std::uint8_t> encode_png(const Image& image) {
  PngEncoder encoder;
  const auto bytes = encoder.encode(image);
  return {bytes.begin(), bytes.end()};
}

Result<Done> write_png(const std::string& path, const Image& image) {
  PngEncoder encoder;
  return write_file(path, as_text(encoder.encode(image)));
}

}  // namespace pantin
