#include "engine/render/ffmpeg.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>

extern char** environ;

namespace pantin::detail {
namespace {

bool ends_with(const std::string& text, const std::string& end) {
  return text.size() > end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

std::string rate_text(double fps) {
  char text[32];
  std::snprintf(text, sizeof text, "%.10g", fps);
  return text;
}

enum class Container { mp4, matroska };

/// Short groups without frames that wait for later ones, flushed as they come: what is on disk can
/// be played even if ffmpeg is killed.
std::vector<std::string> arguments(const std::string& part, Container container,
                                   const std::string& size, double fps) {
  std::vector<std::string> words = {
      "ffmpeg",
      "-hide_banner",
      "-loglevel",
      "error",
      "-nostdin",
      "-y",
      "-f",
      "rawvideo",
      "-pixel_format",
      "rgba",
      "-video_size",
      size,
      "-framerate",
      rate_text(fps),
      "-i",
      "pipe:0",
      "-an",
      "-vf",
      "scale=in_range=pc:out_range=tv:out_color_matrix=bt709,format=yuv420p",
      "-c:v",
      "libx264",
      "-preset",
      "veryfast",
      "-crf",
      "18",
      "-tune",
      "zerolatency",
      "-g",
      "30",
      "-colorspace",
      "bt709",
      "-color_primaries",
      "bt709",
      "-color_trc",
      "bt709",
      "-color_range",
      "tv",
      "-flush_packets",
      "1"};
  if (container == Container::mp4) {
    words.insert(words.end(),
                 {"-movflags", "+frag_keyframe+empty_moov+default_base_moof", "-f", "mp4"});
  } else {
    words.insert(words.end(), {"-cluster_time_limit", "500", "-f", "matroska"});
  }
  words.push_back("file:" + part);  // a name with a colon must not be taken for a protocol
  return words;
}

/// Starts ffmpeg from PATH with these descriptors as its input and its complaints; an errno or 0.
int spawn(std::vector<std::string>& words, int input, int log, pid_t& child) {
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, input, STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&files, log, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&files, log, STDERR_FILENO);

  posix_spawnattr_t how;
  posix_spawnattr_init(&how);
  sigset_t none, defaults;
  sigemptyset(&none);
  sigemptyset(&defaults);
  for (int signal : {SIGPIPE, SIGINT, SIGTERM, SIGHUP}) sigaddset(&defaults, signal);
  posix_spawnattr_setsigmask(&how, &none);
  posix_spawnattr_setsigdefault(&how, &defaults);
  // A group of its own: an interrupt typed at the terminal must not stop the film before its end.
  posix_spawnattr_setpgroup(&how, 0);
  posix_spawnattr_setflags(&how,
                           POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);

  const int reason = posix_spawnp(&child, argv[0], &files, &how, argv.data(), environ);
  posix_spawnattr_destroy(&how);
  posix_spawn_file_actions_destroy(&files);
  return reason;
}

}  // namespace

Ffmpeg::Ffmpeg(std::string path, int pipe, int log, pid_t child)
    : path_(std::move(path)), pipe_(pipe), log_(log), child_(child) {}

Result<std::unique_ptr<Ffmpeg>> Ffmpeg::start(const std::string& path, int width, int height,
                                              double fps) {
  const bool mp4 = ends_with(path, ".mp4");
  if (!mp4 && !ends_with(path, ".mkv"))
    return Error{path + ": the name of a video ends in .mp4 or .mkv"};
  const std::string size = std::to_string(width) + "x" + std::to_string(height);
  if (width % 2 != 0 || height % 2 != 0)
    return Error{path + ": found a size of " + size + ", H.264 expects even width and height"};
  if (!(fps > 0 && fps <= 1000))
    return Error{path + ": found " + rate_text(fps) + " frames a second, expected 0 to 1000"};

  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) return Error{std::string("pipe: ") + std::strerror(errno)};
  ::fcntl(ends[1], F_SETPIPE_SZ, 1 << 20);  // fewer turns between the two; the default will do too
  const int log = ::memfd_create("ffmpeg-log", MFD_CLOEXEC);
  if (log < 0) {
    const int reason = errno;
    ::close(ends[0]), ::close(ends[1]);
    return Error{std::string("memfd_create: ") + std::strerror(reason)};
  }
  auto words = arguments(path + ".part", mp4 ? Container::mp4 : Container::matroska, size, fps);
  pid_t child = 0;
  const int reason = spawn(words, ends[0], log, child);
  ::close(ends[0]);
  if (reason == 0) return std::unique_ptr<Ffmpeg>(new Ffmpeg(path, ends[1], log, child));
  ::close(ends[1]), ::close(log);
  if (reason == ENOENT)
    return Error{path + ": ffmpeg is not on PATH; install it or write frames instead of a video"};
  return Error{path + ": ffmpeg does not start: " + std::strerror(reason)};
}

Ffmpeg::~Ffmpeg() {
  if (child_ != 0) {
    ::kill(child_, SIGKILL);
    wait();
  }
  if (!keep_part_) ::unlink((path_ + ".part").c_str());
  ::close(log_);
}

Result<Done> Ffmpeg::write(const Image& image) {
  std::size_t done = 0;
  while (done < image.rgba.size()) {
    const ssize_t n = ::write(pipe_, image.rgba.data() + done, image.rgba.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return failure(std::strerror(errno));
    done += static_cast<std::size_t>(n);
  }
  return Done{};
}

Result<Done> Ffmpeg::finish() {
  const int status = wait();
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    keep_part_ = true;
    std::string how = WIFSIGNALED(status)
                          ? "was stopped by signal " + std::to_string(WTERMSIG(status))
                          : "ended with status " + std::to_string(WEXITSTATUS(status));
    return Error{path_ + ": ffmpeg " + how + last_words()};
  }
  const std::string part = path_ + ".part";
  keep_part_ = true;
  if (std::rename(part.c_str(), path_.c_str()) != 0)
    return Error{path_ + ": " + std::strerror(errno)};
  return Done{};
}

/// The pipe broke: ffmpeg has ended, and its own words say more than ours.
Error Ffmpeg::failure(const std::string& what) {
  const auto finished = finish();
  return finished ? Error{path_ + ": " + what} : finished.errors().front();
}

/// Closes the pipe, so that ffmpeg comes to its end, and takes its status.
int Ffmpeg::wait() {
  if (pipe_ >= 0) ::close(pipe_);
  pipe_ = -1;
  int status = 0;
  while (child_ != 0 && ::waitpid(child_, &status, 0) < 0) {
    if (errno != EINTR) break;
  }
  child_ = 0;
  return status;
}

/// ": " and the last line that ffmpeg wrote, and where the beginning of the film is.
std::string Ffmpeg::last_words() const {
  char text[1024];
  const off_t end = ::lseek(log_, 0, SEEK_END);
  const off_t from = end > off_t(sizeof text) ? end - off_t(sizeof text) : 0;
  const ssize_t size = ::pread(log_, text, sizeof text, from);
  std::string log(text, size > 0 ? static_cast<std::size_t>(size) : 0);
  while (!log.empty() && (log.back() == '\n' || log.back() == ' ')) log.pop_back();
  const std::size_t line = log.rfind('\n');
  if (line != std::string::npos) log.erase(0, line + 1);
  std::string words = log.empty() ? "" : ": " + log;
  struct stat about {};
  if (::stat((path_ + ".part").c_str(), &about) == 0 && about.st_size > 0)
    words += " (the beginning is in " + path_ + ".part)";
  return words;
}

}  // namespace pantin::detail
