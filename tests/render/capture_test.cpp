#include "engine/render/capture.hpp"

#include <sys/mount.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <set>
#include <thread>

#include "tests/base/random.hpp"
#include "tests/render/pictures.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::picture;
namespace fs = std::filesystem;

namespace {

/// A directory that goes away again.
class Place {
 public:
  Place() {
    std::string name = (fs::temp_directory_path() / "pantin-capture-XXXXXX").string();
    REQUIRE(::mkdtemp(name.data()) != nullptr);
    path_ = name;
  }
  ~Place() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }
  std::string text() const { return path_.string(); }

 private:
  fs::path path_;
};

/// PATH with other contents for one scope.
class SearchPath {
 public:
  explicit SearchPath(const std::string& path) : before_(std::getenv("PATH")) {
    setenv("PATH", path.c_str(), 1);
  }
  ~SearchPath() { setenv("PATH", before_.c_str(), 1); }

 private:
  std::string before_;
};

void paint(Image& image, int width, int height, int index, bool noise = false) {
  image.width = width, image.height = height;
  image.rgba.resize(std::size_t(4) * width * height);
  test::Random dice(static_cast<std::uint64_t>(index) + 1);
  for (std::size_t i = 0; i < image.rgba.size(); ++i) {
    const std::size_t value = noise ? dice.byte() : static_cast<std::size_t>(index) * 5 + i / 997;
    image.rgba[i] = i % 4 == 3 ? std::uint8_t(255) : static_cast<std::uint8_t>(value);
  }
}

/// Pushes up to `count` frames; stops at the first failure, whose message it returns.
std::string push_frames(Capture& capture, int width, int height, int count, bool noise = false) {
  for (int i = 0; i < count; ++i) {
    paint(capture.next(), width, height, i, noise);
    if (auto pushed = capture.push(); !pushed) return pushed.errors().front().message;
  }
  return {};
}

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

std::string output_of(const std::string& command) {
  std::string text(256, 0);
  std::FILE* pipe = ::popen(command.c_str(), "r");
  const std::size_t size = pipe ? std::fread(text.data(), 1, text.size(), pipe) : 0;
  if (pipe) ::pclose(pipe);
  text.resize(size);
  return text;
}

bool has_ffmpeg() {
  const bool found =
      std::system("ffmpeg -version >/dev/null 2>&1 && ffprobe -version >/dev/null 2>&1") == 0;
  if (!found) WARN("skipped, ffmpeg is not on this machine");
  return found;
}

/// Frames that a player can decode.
int frames_in(const std::string& video) {
  const std::string answer = output_of(
      "ffprobe -v quiet -count_frames -select_streams v -show_entries stream=nb_read_frames -of "
      "csv=p=0 '" +
      video + "' 2>/dev/null");
  return std::atoi(answer.c_str());
}

/// A directory whose only program is an `ffmpeg` that runs this shell text.
void fake_ffmpeg(const Place& place, const std::string& text) {
  const std::string path = place / "ffmpeg";
  std::ofstream(path) << "#!/bin/sh\n" << text << "\n";
  ::chmod(path.c_str(), 0755);
}

CaptureOptions video_to(const std::string& path, int width = 64, int height = 48) {
  CaptureOptions options;
  options.video_path = path;
  options.width = width, options.height = height;
  return options;
}

CaptureOptions frames_to(const std::string& path, int width = 64, int height = 48) {
  CaptureOptions options;
  options.frames_directory = path;
  options.width = width, options.height = height;
  return options;
}

}  // namespace

TEST_CASE("frames appear whole, numbered from zero, with nothing beside them") {
  const Place place;
  auto capture = Capture::open(frames_to(place / "deep/frames"));
  REQUIRE(capture);
  REQUIRE(push_frames(**capture, 64, 48, 12).empty());
  const auto written = (*capture)->finish();
  REQUIRE(written);
  CHECK(*written == 12);
  int files = 0;
  for (const auto& entry : fs::directory_iterator(place / "deep/frames")) {
    CHECK(entry.path().extension() == ".png");
    ++files;
  }
  CHECK(files == 12);
  Image expected;
  paint(expected, 64, 48, 11);
  CHECK(decode_png(read_file(place / "deep/frames/frame_000011.png")).rgba == expected.rgba);
}

TEST_CASE("half-written frames of an earlier run are swept, other files are not touched") {
  const Place place;
  std::ofstream(place / "frame_000007.png.part") << "half";
  std::ofstream(place / "notes.part") << "mine";
  std::ofstream(place / "frame_000099.png") << "old";
  auto capture = Capture::open(frames_to(place.text()));
  REQUIRE(capture);
  CHECK_FALSE(fs::exists(place / "frame_000007.png.part"));
  CHECK(fs::exists(place / "notes.part"));
  CHECK(fs::exists(place / "frame_000099.png"));
}

TEST_CASE("a place where no frames can be written is refused before the first") {
  const auto refused = Capture::open(frames_to("/dev/null/frames"));
  REQUIRE_FALSE(refused);
  CHECK(has(refused.errors().front().message, "/dev/null/frames: "));
}

TEST_CASE("a disk that is surely too small is refused before the first frame") {
  const Place place;
  CaptureOptions options = frames_to(place.text(), 1280, 720);
  options.frames_expected = std::size_t(1) << 50;
  const auto refused = Capture::open(options);
  REQUIRE_FALSE(refused);
  CHECK(has(refused.errors().front().message, "MB free, the frames need at least"));
}

TEST_CASE("a disk that fills up ends with whole frames only, and the last one is named") {
  const Place place;
  if (::mount("tmpfs", place.text().c_str(), "tmpfs", 0, "size=400k") != 0) {
    WARN("skipped, mounting a small disk is not permitted: " << std::strerror(errno));
    return;
  }
  std::string message;
  std::size_t whole = 0;
  {
    auto capture = Capture::open(frames_to(place.text(), 160, 120));
    REQUIRE(capture);
    message = push_frames(**capture, 160, 120, 40, true);
    const auto finished = (*capture)->finish();
    REQUIRE_FALSE(finished);
    if (!message.empty()) CHECK(finished.errors().front().message == message);
    message = finished.errors().front().message;
    for (const auto& entry : fs::directory_iterator(place.text())) {
      CHECK(entry.path().extension() == ".png");
      CHECK(decode_png(read_file(entry.path().string())).width == 160);
      ++whole;
    }
  }
  ::umount(place.text().c_str());
  CHECK(whole > 2);
  CHECK(whole < 20);
  CHECK(has(message, "No space left on device"));
  CHECK(has(message, "frames 0 to " + std::to_string(whole - 1) + " are whole"));
}

TEST_CASE("a picture of another size than the film is refused") {
  const Place place;
  auto capture = Capture::open(frames_to(place.text(), 64, 48));
  REQUIRE(capture);
  CHECK(has(push_frames(**capture, 64, 50, 1), "found a picture of 64x50, expected 64x48"));
  CHECK(push_frames(**capture, 64, 48, 1).empty());
  CHECK((*capture)->finish());
}

TEST_CASE("videos hold every frame, in both containers, and appear only when finished") {
  if (!has_ffmpeg()) return;
  const Place place;
  for (const char* name : {"film.mp4", "film.mkv"}) {
    const std::string path = place / name;
    auto capture = Capture::open(video_to(path));
    REQUIRE(capture);
    REQUIRE(push_frames(**capture, 64, 48, 40).empty());
    CHECK_FALSE(fs::exists(path));
    const auto written = (*capture)->finish();
    if (!written) FAIL(written.errors().front().message);
    CHECK(*written == 40);
    CHECK(frames_in(path) == 40);
    CHECK_FALSE(fs::exists(path + ".part"));
  }
}

TEST_CASE("frames and a video can be made at once") {
  if (!has_ffmpeg()) return;
  const Place place;
  CaptureOptions options = video_to(place / "film.mkv");
  options.frames_directory = place / "frames";
  auto capture = Capture::open(options);
  REQUIRE(capture);
  REQUIRE(push_frames(**capture, 64, 48, 5).empty());
  REQUIRE((*capture)->finish());
  CHECK(frames_in(place / "film.mkv") == 5);
  CHECK(fs::exists(place / "frames/frame_000004.png"));
}

TEST_CASE("a capture that is given up leaves no video and no child") {
  if (!has_ffmpeg()) return;
  const Place place;
  {
    auto capture = Capture::open(video_to(place / "film.mp4"));
    REQUIRE(capture);
    REQUIRE(push_frames(**capture, 64, 48, 5).empty());
  }
  CHECK(fs::is_empty(place.text()));
}

TEST_CASE("wrong names, odd sizes and impossible rates of videos are refused in one line") {
  const Place place;
  const auto message = [&](const CaptureOptions& options) {
    auto refused = Capture::open(options);
    return refused ? std::string() : refused.errors().front().message;
  };
  CHECK(has(message(video_to(place / "film.avi")), "the name of a video ends in .mp4 or .mkv"));
  CHECK(has(message(video_to(place / "film.mp4", 65, 48)),
            "found a size of 65x48, H.264 expects even width and height"));
  CaptureOptions still = video_to(place / "film.mp4");
  still.fps = 0;
  CHECK(has(message(still), "found 0 frames per second"));
  CHECK(fs::is_empty(place.text()));
}

TEST_CASE("a missing ffmpeg is told before the first frame") {
  const Place place;
  const SearchPath none(place.text());
  const auto refused = Capture::open(video_to(place / "film.mp4"));
  REQUIRE_FALSE(refused);
  CHECK(has(refused.errors().front().message, "film.mp4: ffmpeg is not on PATH"));
}

TEST_CASE("an ffmpeg that fails is quoted") {
  const Place place;
  fake_ffmpeg(place, "echo 'first line' >&2; echo 'Unknown encoder libx264' >&2; exit 3");
  const SearchPath fake(place.text() + ":/bin:/usr/bin");
  auto capture = Capture::open(video_to(place / "film.mp4", 640, 480));
  REQUIRE(capture);
  push_frames(**capture, 640, 480, 8);
  const auto finished = (*capture)->finish();
  REQUIRE_FALSE(finished);
  const std::string message = finished.errors().front().message;
  CHECK(has(message, "film.mp4: ffmpeg ended with status 3: Unknown encoder libx264"));
  CHECK_FALSE(has(message, "first line"));
}

TEST_CASE("an ffmpeg that is killed leaves a film that plays nearly to the last frame") {
  if (!has_ffmpeg()) return;
  const Place place;
  const std::string real = output_of("command -v ffmpeg | tr -d '\\n'");
  fake_ffmpeg(place, "echo $$ > '" + (place / "pid") + "'\nexec '" + real + "' \"$@\"");
  for (const char* name : {"film.mp4", "film.mkv"}) {
    std::string message;
    {
      const SearchPath fake(place.text() + ":/bin:/usr/bin");
      auto capture = Capture::open(video_to(place / name));
      REQUIRE(capture);
      REQUIRE(push_frames(**capture, 64, 48, 200).empty());
      std::this_thread::sleep_for(std::chrono::milliseconds(1500));
      int child = 0;
      std::ifstream(place / "pid") >> child;
      REQUIRE(child > 0);
      ::kill(child, SIGKILL);
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      push_frames(**capture, 64, 48, 200);
      const auto finished = (*capture)->finish();
      REQUIRE_FALSE(finished);
      message = finished.errors().front().message;
    }
    INFO(message);
    CHECK(has(message, "ffmpeg was stopped by signal 9"));
    CHECK(has(message, std::string("the beginning is in ")));
    const int kept = frames_in((place / name) + ".part");
    INFO(kept << " of 200 frames kept");
    CHECK(kept >= 120);
  }
}

TEST_CASE("no more images are in use than the queue holds, and next() waits for the writer") {
  const Place place;
  // Sleeps before it reads; a frame is larger than the pipe, so the first one stays in the making.
  fake_ffmpeg(place,
              "sleep 0.6\ncat >/dev/null\nfor last; do :; done\nexec touch \"${last#file:}\"");
  const SearchPath fake(place.text() + ":/bin:/usr/bin");
  CaptureOptions options = video_to(place / "film.mp4", 1280, 720);
  options.queue = 2;
  auto capture = Capture::open(options);
  REQUIRE(capture);
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  std::set<Image*> images;
  double third = 0;
  for (int i = 0; i < 6; ++i) {
    Image& image = (*capture)->next();
    if (i == 2) third = std::chrono::duration<double>(Clock::now() - start).count();
    images.insert(&image);
    paint(image, 1280, 720, i);
    REQUIRE((*capture)->push());
  }
  CHECK(images.size() == 2);
  CHECK(third > 0.4);
  const auto finished = (*capture)->finish();
  if (!finished) FAIL(finished.errors().front().message);
  CHECK(*finished == 6);
}

TEST_CASE("the program's own SIGPIPE is left alone") {
  struct sigaction before {
  }, after{};
  ::sigaction(SIGPIPE, nullptr, &before);
  const Place place;
  auto capture = Capture::open(frames_to(place.text()));
  REQUIRE(capture);
  REQUIRE(push_frames(**capture, 64, 48, 2).empty());
  REQUIRE((*capture)->finish());
  ::sigaction(SIGPIPE, nullptr, &after);
  CHECK(before.sa_handler == after.sa_handler);
}

TEST_CASE(
    "a GIF has its own size and rate, stands beside a video, and appears only when finished") {
  if (!has_ffmpeg()) return;
  const Place place;
  const std::string path = place / "film.gif";
  CaptureOptions options = video_to(place / "film.mp4", 160, 120);
  options.gif_path = path;
  options.fps = 50, options.gif_fps = 25, options.gif_width = 81;  // odd: no H.264 in it
  options.frames_expected = 40;
  auto capture = Capture::open(options);
  REQUIRE(capture);
  REQUIRE(push_frames(**capture, 160, 120, 40).empty());
  CHECK_FALSE(fs::exists(path));
  const auto written = (*capture)->finish();
  if (!written) FAIL(written.errors().front().message);
  CHECK(*written == 40);
  CHECK(frames_in(place / "film.mp4") == 40);
  CHECK(frames_in(path) == 20);
  CHECK_FALSE(fs::exists(path + ".part"));
  const std::string form = output_of(
      "ffprobe -v quiet -select_streams v -show_entries stream=width,height,avg_frame_rate -of "
      "csv=p=0 '" +
      path + "' | tr -d '\\n'");
  CHECK(form == "81,61,25/1");
}

TEST_CASE("GIFs that are misnamed or larger than ffmpeg can keep are refused in one line") {
  const Place place;
  const auto message = [&](CaptureOptions options, std::size_t frames) {
    options.frames_expected = frames;
    auto refused = Capture::open(options);
    return refused ? std::string() : refused.errors().front().message;
  };
  CaptureOptions gif = frames_to("", 640, 360);
  gif.gif_path = place / "film.png";
  CHECK(has(message(gif, 10), "film.png: the name of a GIF ends in .gif"));
  CHECK(has(message(video_to(place / "film.gif"), 10), "the name of a video ends in .mp4 or .mkv"));
  gif.gif_path = place / "film.gif", gif.fps = 100, gif.gif_fps = 50;
  CHECK(has(message(gif, 2200),
            "film.gif: found a GIF of 1100 pictures of 640x360, expected at most 1085"));
  CHECK(fs::is_empty(place.text()));
}

TEST_CASE("a GIF that ffmpeg is missing for, or fails at, is told and leaves nothing") {
  const Place place;
  CaptureOptions gif = frames_to("", 64, 48);
  gif.gif_path = place / "film.gif";
  {
    const SearchPath none(place.text());
    const auto refused = Capture::open(gif);
    REQUIRE_FALSE(refused);
    CHECK(has(refused.errors().front().message, "film.gif: ffmpeg is not on PATH"));
  }
  fake_ffmpeg(place,
              "for last; do :; done\n: >\"${last#file:}\"\ncat >/dev/null\n"
              "echo 'no such filter: palettegen' >&2; exit 3");
  const SearchPath fake(place.text() + ":/bin:/usr/bin");
  {
    auto capture = Capture::open(gif);
    REQUIRE(capture);
    REQUIRE(push_frames(**capture, 64, 48, 4).empty());
    const auto finished = (*capture)->finish();
    REQUIRE_FALSE(finished);
    CHECK(has(finished.errors().front().message,
              "film.gif: ffmpeg ended with status 3: no such filter: palettegen"));
  }
  CHECK_FALSE(fs::exists(gif.gif_path));
  CHECK_FALSE(fs::exists(gif.gif_path + ".part"));
}
