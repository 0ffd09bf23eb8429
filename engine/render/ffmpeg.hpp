#pragma once
/// An ffmpeg child that makes a video of raw pictures.
#include <sys/types.h>

#include <memory>
#include <string>

#include "engine/render/renderer.hpp"

namespace pantin::detail {

/// The container follows from the name: .mp4 (fragmented) or .mkv. Both can be played up to nearly
/// the last frame should ffmpeg be killed. The film grows in `path`.part and is renamed by
/// finish().
class Ffmpeg {
 public:
  /// Fails when ffmpeg is not on PATH, the container is unknown or the size does not suit x264.
  static Result<std::unique_ptr<Ffmpeg>> start(const std::string& path, int width, int height,
                                               double fps);
  /// Without finish(): stops ffmpeg and removes the `.part` file.
  ~Ffmpeg();
  Ffmpeg(const Ffmpeg&) = delete;
  Ffmpeg& operator=(const Ffmpeg&) = delete;

  /// Hands one picture over. SIGPIPE must be blocked or ignored on this thread. Errors carry
  /// ffmpeg's own last line.
  Result<Done> write(const Image& image);
  /// Closes the pipe, waits, checks the exit status and renames.
  Result<Done> finish();

 private:
  Ffmpeg(std::string path, int pipe, int log, pid_t child);
  Error failure(const std::string& what);
  int wait();
  std::string last_words() const;

  std::string path_;
  int pipe_, log_;  // descriptors; -1 once closed
  pid_t child_;     // 0 once waited for
  bool keep_part_ = false;
};

}  // namespace pantin::detail
