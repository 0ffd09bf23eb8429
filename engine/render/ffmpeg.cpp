#include "engine/render/ffmpeg.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <optional>

extern char** environ;

namespace pantin::detail {
namespace {

constexpr double kMostGifBytes = 1e9;  // that ffmpeg buffers until it knows all colours

bool ends_with(const std::string& text, const std::string& end) {
  return text.size() > end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

std::string rate_text(double fps) {
  char text[32];
  std::snprintf(text, sizeof text, "%.10g", fps);
  return text;
}

enum class Container { mp4, matroska, gif };

std::optional<Container> container_of(const std::string& path) {
  if (ends_with(path, ".mp4")) return Container::mp4;
  if (ends_with(path, ".mkv")) return Container::matroska;
  if (ends_with(path, ".gif")) return Container::gif;
  return std::nullopt;
}

/// The size and rate of a GIF, and the memory that ffmpeg needs for it.
struct GifForm {
  int width, height;
  double fps, bytes;
};

GifForm gif_form(const Film& film) {
  GifForm form{film.width, film.height, film.fps, 0};
  if (film.most_width > 0 && film.width > film.most_width) {
    form.width = film.most_width;
    form.height = std::max(
        1, static_cast<int>(std::lround(1.0 * film.height * film.most_width / film.width)));
  }
  if (film.most_fps > 0) form.fps = std::min(form.fps, film.most_fps);
  form.bytes = 4.0 * form.width * form.height *
               std::ceil(static_cast<double>(film.expected) * form.fps / film.fps);
  return form;
}

/// One palette for all pictures, made from the moving parts; of each picture only the changed part
/// is written. Ordered dithering keeps static parts unchanged.
std::vector<std::string> gif_words(const Film& film) {
  const GifForm form = gif_form(film);
  std::string graph;
  if (form.fps < film.fps) graph += "fps=" + rate_text(form.fps) + ",";
  if (form.width < film.width)
    graph +=
        "scale=" + std::to_string(form.width) + ":" + std::to_string(form.height) + ":flags=area,";
  graph +=
      "split[pictures][sample];[sample]palettegen=stats_mode=full[colours];"
      "[pictures][colours]paletteuse=dither=bayer:bayer_scale=4:diff_mode=rectangle";
  return {"-vf", graph, "-loop", "0", "-f", "gif"};
}

/// Short groups of pictures without B-frames, flushed at once: the file can be played even if
/// ffmpeg is killed.
std::vector<std::string> h264_words(Container container) {
  std::vector<std::string> words = {
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
  if (container == Container::mp4)
    words.insert(words.end(),
                 {"-movflags", "+frag_keyframe+empty_moov+default_base_moof", "-f", "mp4"});
  else
    words.insert(words.end(), {"-cluster_time_limit", "500", "-f", "matroska"});
  return words;
}

std::string size_text(const Film& film) {
  return std::to_string(film.width) + "x" + std::to_string(film.height);
}

std::vector<std::string> arguments(const Film& film, Container container) {
  std::vector<std::string> words = {"ffmpeg",
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
                                    size_text(film),
                                    "-framerate",
                                    rate_text(film.fps),
                                    "-i",
                                    "pipe:0",
                                    "-an"};
  const auto own = container == Container::gif ? gif_words(film) : h264_words(container);
  words.insert(words.end(), own.begin(), own.end());
  words.push_back("file:" + film.path + ".part");  // so that a name with a colon is not taken for a
                                                   // protocol
  return words;
}

/// Why a film cannot be made from such pictures, or nothing.
std::optional<Error> refusal(const Film& film, Container container) {
  if (container != Container::gif && (film.width % 2 != 0 || film.height % 2 != 0))
    return Error{film.path + ": found a size of " + size_text(film) +
                 ", H.264 expects even width and height"};
  if (!(film.fps > 0 && film.fps <= 1000))
    return Error{film.path + ": found " + rate_text(film.fps) +
                 " frames per second, expected 0 to 1000"};
  if (container != Container::gif) return std::nullopt;
  const GifForm form = gif_form(film);
  if (form.bytes <= kMostGifBytes) return std::nullopt;
  char line[160];
  std::snprintf(line, sizeof line,
                ": found a GIF of %.0f pictures of %dx%d, expected at most %.0f of that size",
                form.bytes / (4.0 * form.width * form.height), form.width, form.height,
                std::floor(kMostGifBytes / (4.0 * form.width * form.height)));
  return Error{film.path + line + "; make it shorter, smaller or slower, or a video"};
}

/// Starts ffmpeg from PATH with these descriptors as stdin and stderr; returns an errno or 0.
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
  // In its own process group: an interrupt typed at the terminal must not end the film early.
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

Result<std::unique_ptr<Ffmpeg>> Ffmpeg::start(const Film& film) {
  const std::string& path = film.path;
  const auto container = container_of(path);
  if (!container) return Error{path + ": the name of a video ends in .mp4 or .mkv"};
  if (auto refused = refusal(film, *container)) return *refused;

  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) return Error{std::string("pipe: ") + std::strerror(errno)};
  ::fcntl(ends[1], F_SETPIPE_SZ, 1 << 20);  // fewer context switches; the default size works as
                                            // well
  const int log = ::memfd_create("ffmpeg-log", MFD_CLOEXEC);
  if (log < 0) {
    const int reason = errno;
    ::close(ends[0]), ::close(ends[1]);
    return Error{std::string("memfd_create: ") + std::strerror(reason)};
  }
  auto words = arguments(film, *container);
  pid_t child = 0;
  const int reason = spawn(words, ends[0], log, child);
  ::close(ends[0]);
  if (reason == 0) return std::unique_ptr<Ffmpeg>(new Ffmpeg(path, ends[1], log, child));
  ::close(ends[1]), ::close(log);
  if (reason == ENOENT)
    return Error{path + ": ffmpeg is not on PATH; install it or write frames instead of a film"};
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
  // ffmpeg exits with status 0 even if the last bytes of a GIF do not fit on the disk.
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0 || disk_is_full()) {
    keep_part_ = has_beginning() && !disk_is_full();
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

/// The pipe broke: ffmpeg has exited, and its own message is more specific.
Error Ffmpeg::failure(const std::string& what) {
  const auto finished = finish();
  return finished ? Error{path_ + ": " + what} : finished.errors().front();
}

/// Closes the pipe, so that ffmpeg finishes, and returns its status.
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

/// The last line of ffmpeg's output.
std::string Ffmpeg::last_line() const {
  char text[1024];
  const off_t end = ::lseek(log_, 0, SEEK_END);
  const off_t from = end > off_t(sizeof text) ? end - off_t(sizeof text) : 0;
  const ssize_t size = ::pread(log_, text, sizeof text, from);
  std::string log(text, size > 0 ? static_cast<std::size_t>(size) : 0);
  while (!log.empty() && (log.back() == '\n' || log.back() == ' ')) log.pop_back();
  const std::size_t line = log.rfind('\n');
  if (line != std::string::npos) log.erase(0, line + 1);
  return log;
}

bool Ffmpeg::disk_is_full() const {
  return last_line().find(std::strerror(ENOSPC)) != std::string::npos;
}

/// ": " and ffmpeg's last line, and the path of the incomplete film.
std::string Ffmpeg::last_words() const {
  const std::string log = last_line();
  std::string words = log.empty() ? "" : ": " + log;
  if (keep_part_) words += " (the beginning is in " + path_ + ".part)";
  return words;
}

/// Whether a part of the film is on disk.
bool Ffmpeg::has_beginning() const {
  struct stat about {};
  return ::stat((path_ + ".part").c_str(), &about) == 0 && about.st_size > 0;
}

}  // namespace pantin::detail
