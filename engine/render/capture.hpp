#pragma once
/// Frames to disk: PNG files, video and GIF, written by a thread of its own behind a bounded queue.
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/render/renderer.hpp"

namespace pantin {

struct CaptureOptions {
  std::string frames_directory;  // empty: no PNG files
  std::string video_path;        // empty: no video; .mp4 or .mkv
  std::string gif_path;          // empty: none; .gif
  double fps = 60;
  int width = 1280, height = 720;
  int gif_width = 640;  // pixels, at most: it is scaled down; 0: as wide as the pictures
  double gif_fps = 25;  // at most: pictures are left out; 0: as many as there are
  int queue = 3;        // images in use at once; next() waits while the writer has them all
  std::size_t frames_expected = 0;  // if known, a disk that is surely too small is refused at once
};

/// Takes frames in order. Each PNG (frame_000000.png, ...) is written beside its place and renamed;
/// a video and a GIF go through ffmpeg children started without a shell. Left-over `.part` files of
/// frames are swept from the directory at the start.
class Capture {
 public:
  /// Fails before any frame is made: directory not writable, ffmpeg missing, unknown container, a
  /// GIF of more than 1 GB of pixels.
  static Result<std::unique_ptr<Capture>> open(const CaptureOptions& options);
  virtual ~Capture() = default;  // abandons what was not finished

  /// An image to draw into; its memory is used again and again. Waits for the writer if need be.
  virtual Image& next() = 0;
  /// Hands the image of next() to the writer. Fails once the writer has failed.
  virtual Result<Done> push() = 0;
  /// Waits for the writer and for ffmpeg. Frames written, or the first failure.
  virtual Result<std::size_t> finish() = 0;
};

/// Encodes a PNG (libdeflate, filter 0, sRGB chunk).
std::vector<std::uint8_t> encode_png(const Image& image);
/// Writes beside `path`, then renames.
Result<Done> write_png(const std::string& path, const Image& image);

}  // namespace pantin
