#pragma once
/// An ffmpeg child process that encodes raw pictures into a film.
#include <sys/types.h>

#include <memory>
#include <string>

#include "engine/render/renderer.hpp"

namespace pantin::detail {

/// The input pictures of a film, and its output.
struct Film {
  std::string path;
  int width = 0, height = 0;  // pixels, of the pictures
  double fps = 0;             // of the pictures
  // For a GIF; 0: no bound, or unknown.
  int most_width = 0;        // wider pictures are scaled down
  double most_fps = 0;       // pictures beyond this rate are dropped
  std::size_t expected = 0;  // number of pictures
};

/// The container follows from the name: .mp4 (fragmented), .mkv or .gif. If ffmpeg is killed, the
/// first two can be played nearly to the last frame. The film is written to `path`.part and renamed
/// by finish().
///
/// A GIF has one palette of 256 colours, so ffmpeg buffers all its pictures: more than fit into 1
/// GB are refused.
class Ffmpeg {
 public:
  /// Fails if ffmpeg is not on PATH, the container is unknown, the size does not suit x264, or a
  /// GIF would be too large.
  static Result<std::unique_ptr<Ffmpeg>> start(const Film& film);
  /// If finish() was not called: stops ffmpeg and deletes the `.part` file.
  ~Ffmpeg();
  Ffmpeg(const Ffmpeg&) = delete;
  Ffmpeg& operator=(const Ffmpeg&) = delete;

  /// Writes one picture. SIGPIPE must be blocked or ignored on this thread. Errors contain the last
  /// line of ffmpeg's output.
  Result<Done> write(const Image& image);
  /// Closes the pipe, waits, checks the exit status and renames the file. The beginning of a failed
  /// film is kept, unless the disk was full.
  Result<Done> finish();

 private:
  Ffmpeg(std::string path, int pipe, int log, pid_t child);
  Error failure(const std::string& what);
  int wait();
  std::string last_line() const;
  std::string last_words() const;
  bool disk_is_full() const;
  bool has_beginning() const;

  std::string path_;
  int pipe_, log_;  // descriptors; -1 once closed
  pid_t child_;     // 0 after it was reaped
  bool keep_part_ = false;
};

}  // namespace pantin::detail
