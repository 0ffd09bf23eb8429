#ifdef PANTIN_HAS_VIEW
#include "tools/pantin/view_session.hpp"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <utility>

#include "engine/scene/json/text_file.hpp"
#include "tools/pantin/assemble.hpp"
#include "tools/pantin/program.hpp"
#include "tools/pantin/states.hpp"
#include "tools/pantin/view_tune.hpp"

namespace pantin::program {

using namespace detail;

namespace {

using Clock = std::chrono::steady_clock;

constexpr double kFilmRate = 60;      // pictures per second
constexpr std::uint8_t kSeam = 40;    // grey of the line between two panes
constexpr double kMostFilmLag = 0.5;  // s: longest gap that a film fills with repeated pictures
constexpr double kSlack = 1e-9;       // s
constexpr double kForever = 1e300;    // s

/// Copies a picture into a part of another.
void place_image(const Image& from, Image& to, int left) {
  const int width = std::min(from.width, to.width - left);
  const int height = std::min(from.height, to.height);
  if (width <= 0) return;
  for (int y = 0; y < height; ++y)
    std::memcpy(
        to.rgba.data() + 4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(to.width) +
                              static_cast<std::size_t>(left)),
        from.rgba.data() + 4 * static_cast<std::size_t>(y) * static_cast<std::size_t>(from.width),
        4 * static_cast<std::size_t>(width));
}

void draw_seam(Image& picture, int x) {
  for (int y = 0; y < picture.height; ++y) {
    const std::size_t at =
        4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) +
             static_cast<std::size_t>(x));
    for (std::size_t k = 0; k < 3; ++k) picture.rgba[at + k] = picture.rgba[at - 4 + k] = kSeam;
  }
}

}  // namespace

void Session::draw_pane(std::size_t index, Image& to) {
  const Pane& pane = *desk_.panes[index];
  Overlay overlay;
  overlay.lines = desk_.labels(index);
  // Pictures of a script must be reproducible.
  if (!choices_.is_scripted && index == 0 && !desk_.panel)
    overlay.lines.push_back("picture " + std::to_string(std::lround(1e3 * draw_seconds_)) + " ms");
  overlay.alarm = pane.alarm;
  if (index == 0 && desk_.is_trouble && desk_.message_left > 0) overlay.alarm = desk_.message;
  overlay.joints = desk_.overlay;
  overlay.doubts = places_of(pane.scene(), pane.sim.findings());
  if (desk_.overlay)
    overlay.legend = overlay_legend(pane.world()), overlay.trails = pane.trails.trails();
  if (desk_.forces) {
    overlay.contacts = true;
    overlay.forces = forces_of(pane.scene());
    const auto more = forces_legend(pane.world());
    if (desk_.overlay && !more.empty())
      overlay.legend.push_back(more.front());
    else
      overlay.legend.insert(overlay.legend.end(), more.begin(), more.end());
  }
  std::vector<Vec3> colours;
  if (desk_.states) {
    colours = state_colours(pane.world());
    const auto states = states_legend(pane.world());
    overlay.legend.insert(overlay.legend.end(), states.begin(), states.end());
  }
  const std::vector<Vec3> measured = desk_.gauge.places(pane.scene());
  overlay.doubts.insert(overlay.doubts.end(), measured.begin(), measured.end());
  if (desk_.panes.size() > 1) overlay.legend.clear();  // it would cover half of a pane
  renderer_->draw({.world = pane.world(),
                   .poses = pane.poses,
                   .view = desk_.view(),
                   .overlay = &overlay,
                   .wireframe = desk_.wireframe,
                   .colours = colours},
                  to);
}

/// Combines the panes side by side, and the panel.
void Session::compose() {
  if (auto fits = renderer_->resize(desk_.pane_width(), desk_.height()); !fits) {
    fail(fits.errors(), kFailed, "failed");
    desk_.quits = true;
    return;
  }
  if (desk_.panes.size() == 1 && desk_.width() == width_) return draw_pane(0, window_image_);
  window_image_.width = width_, window_image_.height = height_;
  window_image_.rgba.assign(
      4 * static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), 255);
  for (std::size_t i = 0; i < desk_.panes.size(); ++i) {
    draw_pane(i, pane_image_);
    const int left = static_cast<int>(i) * desk_.pane_width();
    place_image(pane_image_, window_image_, left);
    if (i > 0) draw_seam(window_image_, left);
  }
}

void Session::draw() {
  const Clock::time_point start = Clock::now();
  desk_.stale = false;
  compose();
  if (window_image_.rgba.empty()) return;
  if (panel_ && desk_.width() < width_)
    panel_->draw(desk_, window_image_, desk_.width(),
                 {1 / 60.0, choices_.is_scripted ? 0 : draw_seconds_});
  ++report_.frames;
  if (auto shown = window_->show(window_image_); !shown) {
    fail(shown.errors(), kFailed, "failed");
    desk_.quits = true;
  }
  draw_seconds_ = std::chrono::duration<double>(Clock::now() - start).count();
}

/// Saves the picture under the first free number.
void Session::save() {
  desk_.wants_picture = false;
  const std::string path = free_name(choices_.frames, "frame", ".png", report_.saved.size());
  if (auto written = write_png(path, window_image_); !written) {
    fail(written.errors(), kUnwritable, "unwritable");
    return desk_.tell("could not save " + path);
  }
  report_.saved.push_back(path);
  desk_.tell("saved " + path);
}

/// Writes the scene with the present poses of the first pane under the first free number: into the
/// folder of pictures, or beside the scene if it refers to other files from there.
void Session::keep_pose() {
  desk_.wants_pose = false;
  const bool stays = !desk_.scene().files.empty();
  const std::string beside = std::filesystem::path(desk_.path()).parent_path().string();
  const std::string path =
      free_name(stays ? (beside.empty() ? "." : beside) : choices_.frames, "pose", ".json", 0);
  const auto text = read_text(desk_.path(), SceneLimits{}.bytes, "a scene file");
  const auto written = text ? with_poses(*text, desk_.scene().world, desk_.panes[0]->world())
                            : Result<std::string>(text.errors());
  if (!written) return desk_.tell("could not keep the pose: " + written.errors().front().message);
  if (const int code = write_or_complain(path, *written); code != kOk) {
    report_.exit_code = code, report_.status = "unwritable";
    return desk_.tell("could not write " + path);
  }
  report_.saved.push_back(path);
  const auto again = load_scene(path);
  desk_.tell(again ? "saved " + path
                   : path + " is saved but does not load: " + again.errors().front().message);
}

/// Writes the changed knobs into the scene file, which is then read again.
void Session::keep_tuned() {
  desk_.wants_tuned = false;
  if (desk_.turned().empty()) return desk_.tell("no slider was moved since the file was read");
  const auto text = read_text(desk_.path(), SceneLimits{}.bytes, "a scene file");
  if (!text) return desk_.tell(text.errors().front().message);
  const TunedText tuned = with_knobs(*text, desk_.turned(), desk_.scene().world);
  if (const int code = write_or_complain(desk_.path(), tuned.text); code != kOk) {
    report_.exit_code = code, report_.status = "unwritable";
    return desk_.tell("could not write " + desk_.path());
  }
  desk_.reload();
  for (const std::string& line : tuned.shared) desk_.tell("wrote " + line);
  for (const std::string& line : tuned.left) desk_.tell("did not write " + line);
  if (tuned.left.empty()) desk_.tell("wrote the sliders into " + desk_.path());
}

/// Starts and ends the record of a run as requested, and where it can go on no longer.
void Session::watch_run() {
  const Pane& pane = *desk_.panes[0];
  const RunWish wish = std::exchange(desk_.wants_run, RunWish::none);
  const bool is_over = export_ && (pane.listener != export_.get() || export_->is_over());
  if (is_over || (export_ && wish == RunWish::from_now)) return end_run();
  if (wish != RunWish::none) start_run(wish);
}

/// Records the run of the first pane under the first free number.
void Session::start_run(RunWish wish) {
  std::string path;
  std::size_t number = 0;
  do {
    path = free_name(choices_.frames, "run", ".csv", number++);
    path.erase(path.size() - std::strlen(".csv"));
  } while (std::filesystem::exists(path + ".glb"));
  const bool is_whole = wish == RunWish::whole;
  const double until = is_whole ? desk_.scene().duration + kSlack : kForever;
  auto started = std::make_unique<RunExport>(path, until);
  if (auto opened = started->open(desk_.scene(), *desk_.panes[0]); !opened) {
    desk_.panes[0]->listener = nullptr;
    return fail_file(path, opened.errors());
  }
  export_ = std::move(started);
  desk_.tell("records " + path + (is_whole ? " up to the end of the scene" : "; y ends it"));
}

void Session::end_run() {
  if (!export_) return;
  desk_.panes[0]->listener = nullptr;
  const auto ended = std::exchange(export_, nullptr);
  if (auto done = ended->close(report_.saved); !done)
    return fail_file(ended->path(), done.errors());
  desk_.tell("saved " + ended->path() + ".csv and .glb");
}

/// A file that could not be written.
void Session::fail_file(const std::string& path, const std::vector<Error>& errors) {
  fail(errors, kUnwritable, "unwritable");
  desk_.tell("could not write " + path);
}

void Session::toggle_film() {
  desk_.wants_film = false;
  if (film_) return end_film();
  film_path_ = free_name(choices_.frames, "film", ".mp4", 0);
  CaptureOptions options;
  options.video_path = film_path_, options.fps = kFilmRate;
  options.width = width_ & ~1, options.height = height_ & ~1;  // the codec requires even sizes
  auto film = Capture::open(options);
  if (!film) {
    for (const Error& e : film.errors()) complain(e.message);
    return desk_.tell(film.errors().front().message);
  }
  film_ = std::move(*film);
  film_width_ = options.width, film_height_ = options.height, film_time_ = 1 / kFilmRate;
  desk_.tell("records " + film_path_ + "; v ends it");
}

/// Adds as many pictures as the elapsed time requires.
void Session::film(double wall) {
  if (!film_) return;
  if ((width_ & ~1) != film_width_ || (height_ & ~1) != film_height_) return end_film();
  film_time_ += std::min(wall, kMostFilmLag);
  for (; film_ && film_time_ > 0.5 / kFilmRate; film_time_ -= 1 / kFilmRate) {
    Image& next = film_->next();
    next.width = film_width_, next.height = film_height_;
    next.rgba.resize(4 * static_cast<std::size_t>(film_width_) *
                     static_cast<std::size_t>(film_height_));
    place_image(window_image_, next, 0);
    if (auto pushed = film_->push(); !pushed) {
      fail(pushed.errors(), kUnwritable, "unwritable");
      film_.reset();
      desk_.tell("could not write " + film_path_);
    }
  }
}

void Session::end_film() {
  if (!film_) return;
  auto done = film_->finish();
  film_.reset();
  if (!done) return fail_file(film_path_, done.errors());
  report_.saved.push_back(film_path_);
  desk_.tell("saved " + film_path_);
}

}  // namespace pantin::program
#endif
