#include "engine/render/capture.hpp"

#include <sys/statvfs.h>

#include <cerrno>
#include <condition_variable>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <deque>
#include <filesystem>
#include <mutex>
#include <optional>
#include <thread>

#include "engine/base/atomic_file.hpp"
#include "engine/render/ffmpeg.hpp"
#include "engine/render/png.hpp"

namespace pantin {

using namespace detail;

namespace {

namespace fs = std::filesystem;

// Lower bounds of the file size, bytes per pixel, over all known scenes; smaller disks are refused.
constexpr double kLeastPngBytes = 0.05, kLeastVideoBytes = 0.0005;

std::string frame_name(std::size_t index) {
  char name[40];
  std::snprintf(name, sizeof name, "frame_%06zu.png", index);
  return name;
}

/// Deletes incomplete files of an earlier run.
void sweep(const fs::path& directory) {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(directory, ignored)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("frame_") && name.ends_with(".png.part"))
      fs::remove(entry.path(), ignored);
  }
}

/// Creates the directory if necessary, and checks that a file can be created in it.
Result<Done> prepare_directory(const std::string& directory) {
  std::error_code why;
  fs::create_directories(directory, why);
  if (why && !fs::is_directory(directory)) return Error{directory + ": " + why.message()};
  sweep(directory);
  const std::string probe = directory + "/frame_.png.part";
  std::FILE* file = std::fopen(probe.c_str(), "wb");
  if (!file) return Error{directory + ": " + std::strerror(errno)};
  std::fclose(file);
  fs::remove(probe, why);
  return Done{};
}

Result<Done> check_room(const std::string& where, double bytes) {
  struct statvfs disk {};
  if (::statvfs(where.empty() ? "." : where.c_str(), &disk) != 0)
    return Error{where + ": " + std::strerror(errno)};
  const double room = static_cast<double>(disk.f_bavail) * static_cast<double>(disk.f_frsize);
  if (room >= bytes) return Done{};
  char line[160];
  std::snprintf(line, sizeof line, ": found %.1f MB free, the frames need at least %.1f MB",
                room / 1e6, bytes / 1e6);
  return Error{where + line};
}

class ThreadedCapture final : public Capture {
 public:
  explicit ThreadedCapture(const CaptureOptions& options)
      : options_(options), images_(static_cast<std::size_t>(std::max(1, options.queue))) {
    for (Image& image : images_) free_.push_back(&image);
  }

  ~ThreadedCapture() override {
    stop(Queued::dropped);  // films_ then stop their child processes
  }

  Result<Done> start() {
    if (!options_.frames_directory.empty()) {
      if (auto done = prepare_directory(options_.frames_directory); !done) return done;
      if (auto done = check_room(options_.frames_directory, expected_bytes(kLeastPngBytes)); !done)
        return done;
    }
    const bool is_gif = options_.gif_path.ends_with(".gif");
    if (options_.video_path.ends_with(".gif"))
      return Error{options_.video_path + ": the name of a video ends in .mp4 or .mkv; for a GIF " +
                   "use its own option"};
    if (!options_.gif_path.empty() && !is_gif)
      return Error{options_.gif_path + ": the name of a GIF ends in .gif"};
    for (const std::string& path : {options_.video_path, options_.gif_path})
      if (auto done = start_film(path); !done) return done;
    writer_ = std::thread([this] { write_all(); });
    return Done{};
  }

  Image& next() override {
    std::unique_lock lock(mutex_);
    if (drawing_) return *drawing_;
    freed_.wait(lock, [&] { return !free_.empty(); });
    drawing_ = free_.back();
    free_.pop_back();
    return *drawing_;
  }

  Result<Done> push() override {
    std::unique_lock lock(mutex_);
    if (!drawing_) return Error{"capture: push() without next()"};
    Image* image = std::exchange(drawing_, nullptr);
    if (failure_) {
      free_.push_back(image);
      return *failure_;
    }
    if (image->width != options_.width || image->height != options_.height) {
      free_.push_back(image);
      return Error{"capture: found a picture of " + std::to_string(image->width) + "x" +
                   std::to_string(image->height) + ", expected " + std::to_string(options_.width) +
                   "x" + std::to_string(options_.height)};
    }
    queue_.push_back(image);
    lock.unlock();
    pushed_.notify_one();
    return Done{};
  }

  Result<std::size_t> finish() override {
    stop(Queued::written);
    for (const auto& film : films_)
      if (!failure_)
        if (auto done = film->finish(); !done) failure_ = done.errors().front();
    if (failure_) return *failure_;
    return written_;
  }

 private:
  double expected_bytes(double per_pixel) const {
    return per_pixel * options_.width * options_.height *
           static_cast<double>(std::max<std::size_t>(options_.frames_expected, 1));
  }

  Result<Done> start_film(const std::string& path) {
    if (path.empty()) return Done{};
    const std::string parent = fs::path(path).parent_path().string();
    std::error_code why;
    if (!parent.empty()) fs::create_directories(parent, why);
    if (auto done = check_room(parent, expected_bytes(kLeastVideoBytes)); !done) return done;
    auto started = Ffmpeg::start({path, options_.width, options_.height, options_.fps,
                                  options_.gif_width, options_.gif_fps, options_.frames_expected});
    if (!started) return started.errors();
    films_.push_back(std::move(*started));
    return Done{};
  }

  /// What happens to queued images when the writer stops.
  enum class Queued { written, dropped };

  /// Joins the writer thread.
  void stop(Queued queued) {
    {
      std::lock_guard lock(mutex_);
      closing_ = true;
      if (queued == Queued::dropped) queue_.clear();
    }
    pushed_.notify_one();
    if (writer_.joinable()) writer_.join();
  }

  void write_all() {
    // write() must report a broken pipe as an error, without changing the program's own signal
    // handlers.
    sigset_t broken_pipe;
    sigemptyset(&broken_pipe);
    sigaddset(&broken_pipe, SIGPIPE);
    pthread_sigmask(SIG_BLOCK, &broken_pipe, nullptr);

    std::unique_lock lock(mutex_);
    while (true) {
      pushed_.wait(lock, [&] { return closing_ || !queue_.empty(); });
      if (queue_.empty()) return;
      Image* image = queue_.front();
      queue_.pop_front();
      if (!failure_) {
        lock.unlock();
        auto done = write_one(*image);
        lock.lock();
        if (done)
          ++written_;
        else
          failure_ = with_last_frame(done.errors().front());
      }
      free_.push_back(image);
      freed_.notify_one();
    }
  }

  Result<Done> write_one(const Image& image) {
    if (!options_.frames_directory.empty()) {
      const std::string path = options_.frames_directory + "/" + frame_name(written_);
      if (auto done = write_file(path, as_text(encoder_.encode(image))); !done) return done;
    }
    for (const auto& film : films_)
      if (auto done = film->write(image); !done) return done;
    return Done{};
  }

  Error with_last_frame(Error error) const {
    error.message += written_ == 0 ? "; no frame was written"
                                   : "; frames 0 to " + std::to_string(written_ - 1) + " are whole";
    return error;
  }

  const CaptureOptions options_;
  std::vector<Image> images_;
  std::vector<std::unique_ptr<Ffmpeg>> films_;
  PngEncoder encoder_;

  std::mutex mutex_;  // guards everything below
  std::condition_variable pushed_, freed_;
  std::vector<Image*> free_;
  std::deque<Image*> queue_;
  Image* drawing_ = nullptr;
  std::optional<Error> failure_;
  std::size_t written_ = 0;
  bool closing_ = false;

  std::thread writer_;
};

}  // namespace

Result<std::unique_ptr<Capture>> Capture::open(const CaptureOptions& options) {
  auto capture = std::make_unique<ThreadedCapture>(options);
  if (auto done = capture->start(); !done) return done.errors();
  return std::unique_ptr<Capture>(std::move(capture));
}

}  // namespace pantin
