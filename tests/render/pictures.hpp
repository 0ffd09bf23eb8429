#pragma once
/// Making, reading and comparing pictures in tests.
#include <libdeflate.h>

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>

#include "engine/render/renderer.hpp"

namespace pantin::picture {

using namespace detail;

/// A renderer; where no way to OpenGL works, the reasons are printed and the test is not run: ctest
/// shows the file as skipped.
inline std::unique_ptr<Renderer> renderer_or_skip(const RenderOptions& options) {
  auto made = Renderer::create(options);
  if (made) return std::move(*made);
  for (const Error& e : made.errors()) WARN("skipped, no OpenGL: " << e.message);
  if (std::getenv("DASHBOARD_TEST_FROM_CTEST")) std::exit(77);
  return nullptr;
}

struct Pixel {
  int r = 0, g = 0, b = 0;
  int sum() const { return r + g + b; }
};

inline Pixel pixel(const Image& image, int x, int y) {
  const std::uint8_t* p = image.rgba.data() + 4 * (static_cast<std::size_t>(y) * image.width + x);
  return {p[0], p[1], p[2]};
}

inline int difference(Pixel a, Pixel b) {
  return std::abs(a.r - b.r) + std::abs(a.g - b.g) + std::abs(a.b - b.b);
}

/// Reads what encode_png writes: 8-bit RGB or RGBA, one IDAT, filter 0, all checksums right. An
/// empty image if anything is amiss.
inline Image decode_png(const std::vector<std::uint8_t>& file) {
  const auto word = [&](std::size_t at) {
    return std::uint32_t(file[at]) << 24 | std::uint32_t(file[at + 1]) << 16 |
           std::uint32_t(file[at + 2]) << 8 | file[at + 3];
  };
  constexpr std::array<std::uint8_t, 8> kSignature = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  if (file.size() < 8 || !std::equal(kSignature.begin(), kSignature.end(), file.begin())) return {};
  Image image;
  std::size_t channels = 0;
  std::vector<std::uint8_t> rows;
  bool ended = false;
  for (std::size_t at = 8; at + 12 <= file.size();) {
    const std::size_t size = word(at);
    if (at + 12 + size > file.size()) return {};
    if (libdeflate_crc32(0, &file[at + 4], size + 4) != word(at + 8 + size)) return {};
    const std::string type(file.begin() + at + 4, file.begin() + at + 8);
    if (type == "IHDR") {
      image.width = static_cast<int>(word(at + 8)), image.height = static_cast<int>(word(at + 12));
      channels = file[at + 17] == 2 ? 3 : 4;
      rows.resize((image.width * channels + 1) * image.height);
    } else if (type == "IDAT") {
      std::size_t actual = 0;
      auto* decompressor = libdeflate_alloc_decompressor();
      const auto result = libdeflate_zlib_decompress(decompressor, &file[at + 8], size, rows.data(),
                                                     rows.size(), &actual);
      libdeflate_free_decompressor(decompressor);
      if (result != LIBDEFLATE_SUCCESS || actual != rows.size()) return {};
    } else if (type == "IEND") {
      ended = true;
    }
    at += 12 + size;
  }
  if (!ended) return {};
  const std::uint8_t* from = rows.data();
  for (int y = 0; y < image.height; ++y) {
    if (*from++ != 0) return {};
    for (int x = 0; x < image.width; ++x, from += channels)
      for (std::size_t c = 0; c < 4; ++c)
        image.rgba.push_back(c < channels ? from[c] : std::uint8_t(255));
  }
  return image;
}

inline std::vector<std::uint8_t> read_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// How two pictures differ: overall, how many pixels visibly, and in the worst place.
struct Likeness {
  double psnr = 0;        // dB, 99 if equal
  double off_part = 0;    // part of the pixels with a channel that differs by more than 8
  double worst_tile = 0;  // mean absolute difference in the worst 16x16 tile, of 255

  /// Equal but for the rounding of another compiler; a missing shadow or a slip of a millisecond
  /// is seen. Thresholds from a study of such pairs.
  bool same() const { return psnr >= 55 && off_part <= 0.0002 && worst_tile <= 1.0; }
};

inline Likeness compare(const Image& a, const Image& b) {
  if (a.width != b.width || a.height != b.height) return {0, 1, 255};
  double squares = 0;
  std::size_t off = 0;
  const int tiles_x = (a.width + 15) / 16, tiles_y = (a.height + 15) / 16;
  std::vector<double> sums(static_cast<std::size_t>(tiles_x) * tiles_y), counts(sums.size());
  for (int y = 0; y < a.height; ++y) {
    for (int x = 0; x < a.width; ++x) {
      const Pixel p = pixel(a, x, y), q = pixel(b, x, y);
      const int d[3] = {std::abs(p.r - q.r), std::abs(p.g - q.g), std::abs(p.b - q.b)};
      const std::size_t tile = static_cast<std::size_t>(y / 16) * tiles_x + x / 16;
      for (int one : d) squares += one * one, sums[tile] += one, counts[tile] += 1;
      if (std::max({d[0], d[1], d[2]}) > 8) ++off;
    }
  }
  Likeness like;
  const double pixels = static_cast<double>(a.width) * a.height;
  like.psnr =
      squares > 0 ? std::min(99.0, 10 * std::log10(255.0 * 255 * 3 * pixels / squares)) : 99;
  like.off_part = static_cast<double>(off) / pixels;
  for (std::size_t t = 0; t < sums.size(); ++t)
    like.worst_tile = std::max(like.worst_tile, sums[t] / counts[t]);
  return like;
}

}  // namespace pantin::picture
