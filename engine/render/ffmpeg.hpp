#pragma once
/// An ffmpeg child that makes a film of raw pictures.
#include <sys/types.h>

#include <memory>
#include <string>

#include "engine/render/renderer.hpp"

namespace pantin::detail {

/// The pictures that go into a film, and where it goes.
struct Film {
  std::string path;
  int width = 0, height = 0;  // pixels, of the pictures
  double fps = 0;             // of the pictures
  // Of a GIF; 0: no bound, or nobody knows.
  int most_width = 0;        // wider pictures are scaled down
  double most_fps = 0;       // of faster ones some are left out
  std::size_t expected = 0;  // pictures that will come
};

/// The container follows from the name: .mp4 (fragmented), .mkv or .gif. The first two can be
/// played up to nearly the last frame should ffmpeg be killed. The film grows in `path`.part and is
/// renamed by finish().
///
/// A GIF shares one table of 256 colours, so ffmpeg keeps all its pictures until the last has come:
/// more than fit into 1 GB are refused.
class Ffmpeg {
 public:
  /// Fails when ffmpeg is not on PATH, the container is unknown, the size does not suit x264 or a
  /// GIF would be too large.
  static Result<std::unique_ptr<Ffmpeg>> start(const Film& film);
  /// Without finish(): stops ffmpeg and removes the `.part` file.
  ~Ffmpeg();
  Ffmpeg(const Ffmpeg&) = delete;
  Ffmpeg& operator=(const Ffmpeg&) = delete;

  /// Hands one picture over. SIGPIPE must be blocked or ignored on this thread. Errors carry
  /// ffmpeg's own last line.
  Result<Done> write(const Image& image);
  /// Closes the pipe, waits, checks the exit status and renames. Of a film that failed the
  /// beginning stays, unless the disk was full.
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
  pid_t child_;     // 0 once waited for
  bool keep_part_ = false;
};

}  // namespace pantin::detail
