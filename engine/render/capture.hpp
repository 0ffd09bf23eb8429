#pragma once
/// Writes frames to disk: PNG files, video and GIF, in a thread of its own behind a bounded queue.
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
  std::string gif_path;          // empty: no GIF; .gif
  double fps = 60;
  int width = 1280, height = 720;
  int gif_width = 640;  // pixels, upper bound: wider pictures are scaled down; 0: no bound
  double gif_fps = 25;  // upper bound: pictures are dropped; 0: no bound
  int queue = 3;        // images in use at once; next() blocks while the writer holds them all
  std::size_t frames_expected = 0;  // if known, a disk that is certainly too small is refused at
                                    // once
};

/// Takes frames in order. Each PNG (frame_000000.png, ...) is written to a temporary file and
/// renamed; video and GIF are piped to ffmpeg child processes started without a shell. Left-over
/// `.part` files of frames are deleted from the directory at the start.
class Capture {
 public:
  /// Fails before any frame is made: directory not writable, ffmpeg missing, unknown container, or
  /// a GIF of more than 1 GB of pixels.
  static Result<std::unique_ptr<Capture>> open(const CaptureOptions& options);
  virtual ~Capture() = default;  // discards what was not finished

  /// An image to draw into; its memory is reused. Waits for the writer if necessary.
  virtual Image& next() = 0;
  /// Passes the image of next() to the writer. Fails once the writer has failed.
  virtual Result<Done> push() = 0;
  /// Waits for the writer and for ffmpeg. Returns the number of frames written, or the first
  /// failure.
  virtual Result<std::size_t> finish() = 0;
};

/// Encodes a PNG (libdeflate, filter 0, sRGB chunk).
std::vector<std::uint8_t> encode_png(const Image& image);
/// Writes to a temporary file beside `path`, then renames it.
Result<Done> write_png(const std::string& path, const Image& image);

}  // namespace pantin
