#include "tools/pantin/pictures.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "tools/pantin/program.hpp"

#ifdef PANTIN_HAS_RENDER
#include "engine/render/capture.hpp"
#include "engine/render/renderer.hpp"
#include "engine/render/strip.hpp"
#include "engine/render/trails.hpp"
#include "tools/pantin/states.hpp"
#include "tools/pantin/strip_times.hpp"
#endif

namespace pantin::program {

using namespace detail;

std::string PictureChoices::idle_option() const {
  const PictureChoices unsaid;
  const std::pair<bool, const char*> of_strips[] = {
      {strip_columns != unsaid.strip_columns, "--strip-columns"},
      {strip_rows != unsaid.strip_rows, "--strip-rows"},
      {strip_times != unsaid.strip_times, "--strip-times"}};
  const std::pair<bool, const char*> of_pictures[] = {{size != unsaid.size, "--size"},
                                                      {fps != unsaid.fps, "--fps"},
                                                      {overlay, "--overlay"},
                                                      {from != unsaid.from, "--from"},
                                                      {states, "--states"}};
  for (const auto& [said, name] : of_strips)
    if (said && strip.empty())
      return fmt::format("{}: found no strip to draw, expected --strip with it", name);
  for (const auto& [said, name] : of_pictures)
    if (said && !wanted())
      return fmt::format(
          "{}: found no pictures to draw, expected --frames, --video, --gif or --strip with it",
          name);
  return {};
}

#ifdef PANTIN_HAS_RENDER
namespace {

constexpr double kStripWidth = 1600;  // pixels, of a whole strip without --size
constexpr double kMostGifRate = 50;   // pictures per second; players show faster GIFs slowly

GlPath gl_path(const std::string& name) {
  if (name == "surfaceless") return GlPath::surfaceless;
  if (name == "device") return GlPath::device;
  return name == "osmesa" ? GlPath::osmesa : GlPath::automatic;
}

/// The renderer and the writer of frames.
struct FrameMakers {
  std::unique_ptr<Renderer> renderer;
  std::unique_ptr<Capture> capture;  // null: a strip only
};

/// The format of the frames.
struct FrameFormat {
  int width = 0, height = 0;  // pixels
  double fps = 0;
  std::uint64_t count = 0;
  std::vector<std::uint64_t> in_strip = {};  // the frame of each cell
  double period = 0;                         // that the strip shows, s; 0: the whole run
};

/// The scene's view, or the whole scene from a side.
View view_from(const std::string& side, View view) {
  const auto way = direction_of_side(side);
  if (!way) return view;
  view.camera = seen_from(*way, view.camera);
  view.camera.automatic = true;
  return view;
}

/// Spreads the cells of a strip over all frames, or over the last period of the run. With other
/// pictures the cells are the frames nearest to the equal parts of the period; else the rate is
/// such that frames are at these times.
void place_cells(const PictureChoices& choices, const Scene& scene, std::uint64_t steps,
                 FrameFormat& frames) {
  if (choices.strip.empty()) return;
  const Strip strip(choices.strip_columns, choices.strip_rows, 0, 0);
  std::optional<double> period;
  if (choices.strip_times == "auto" && choices.labels.empty()) period = period_of_run(scene, steps);
  const double end = static_cast<double>(steps) * scene.step;
  const auto cells = static_cast<double>(strip.cells());
  if (period && !choices.captured()) frames.fps = cells / *period;
  if (period) frames.count = static_cast<std::uint64_t>(end * frames.fps * (1 + 1e-12));
  frames.period = period.value_or(0);
  for (std::size_t i = 0; i < strip.cells(); ++i) {
    const double time = end - frames.period * (1 - static_cast<double>(i) / cells);
    frames.in_strip.push_back(
        period ? std::min(static_cast<std::uint64_t>(std::floor(time * frames.fps + 1e-9)),
                          frames.count - 1)
               : strip.frame_of(i, frames.count));
  }
}

/// Draws every frame of a run, and keeps those of a strip.
class DrawnPictures final : public Pictures {
 public:
  DrawnPictures(const PictureChoices& choices, const Scene& scene, const FrameFormat& frames,
                FrameMakers makers)
      : choices_(choices),
        view_(view_from(choices.from, scene.view)),
        title_(scene.title),
        step_(scene.step),
        fps_(frames.fps),
        frames_(frames.count),
        in_strip_(frames.in_strip),
        period_(frames.period),
        renderer_(std::move(makers.renderer)),
        capture_(std::move(makers.capture)) {
    const int width = frames.width, height = frames.height;
    view_ = framed_view(scene.world, view_, static_cast<Real>(width) / height);
    image_.width = width, image_.height = height;
    if (!choices.strip.empty())
      strip_.emplace(choices.strip_columns, choices.strip_rows, width, height);
  }

  /// The initial picture, before the first step.
  void draw_start(const World& world) { draw_frame(world, {}, 0); }

  void before_step(const World& world) override {
    before_.clear();
    for (const Body& b : world.bodies.values()) before_.push_back(b.pose);
  }

  bool after_step(const World& world, double worst_gap) override {
    if (choices_.overlay) trails_.record(world);
    const double end = static_cast<double>(world.tick) * step_, slack = 1e-9 * step_;
    while (ok_ && drawn_ < frames_ && static_cast<double>(drawn_) / fps_ <= end + slack) {
      const double part = 1 - (end - static_cast<double>(drawn_) / fps_) / step_;
      poses_.clear();
      for (std::size_t i = 0; i < world.bodies.size(); ++i) {
        const Pose& to = world.bodies.values()[i].pose;
        const Pose& from = before_.size() == world.bodies.size() ? before_[i] : to;
        if (part > 1 - 1e-9)
          poses_.push_back(to);
        else
          poses_.push_back({glm::mix(from.position, to.position, part),
                            glm::slerp(from.rotation, to.rotation, part)});
      }
      draw_frame(world, poses_, worst_gap);
    }
    return ok_;
  }

  double strip_period() const override { return period_; }

  std::variant<std::size_t, PictureFailure> finish() override {
    if (capture_) {
      Result<std::size_t> written = capture_->finish();
      if (!written) return PictureFailure{written.errors(), kUnwritable};
    }
    if (!choices_.strip.empty())
      if (const auto written = write_png(choices_.strip, strip_->image()); !written)
        return PictureFailure{written.errors(), kUnwritable};
    return static_cast<std::size_t>(capture_ ? drawn_ : 0);
  }

 private:
  std::string label_at(double time) const {
    if (choices_.labels.empty()) return fmt::format("t = {:.3f} s", time);
    const auto step = static_cast<std::size_t>(time / step_ + 1e-9);
    return choices_.labels[std::min(step, choices_.labels.size() - 1)];
  }

  void draw_frame(const World& world, std::span<const Pose> poses, double worst_gap) {
    const std::uint64_t k = drawn_++;
    const auto cell_due = [&] {
      return strip_ && strip_->filled() < strip_->cells() && in_strip_[strip_->filled()] <= k;
    };
    if (!capture_ && !cell_due()) return;
    Overlay overlay;
    overlay.joints = choices_.overlay;
    const std::string time = label_at(static_cast<double>(k) / fps_);
    // Small pictures have room for the time only.
    overlay.lines = {time};
    if (!choices_.labels.empty() && choices_.captured())
      overlay.lines = {title_, time};
    else if (!choices_.frames.empty() || !choices_.video.empty())
      overlay.lines = {title_, time,
                       fmt::format("{}, step {:.4g} ms", describe_solvers(world), 1e3 * step_),
                       fmt::format("worst joint gap {:.1e} m", worst_gap)};
    if (choices_.overlay) {
      overlay.legend = overlay_legend(world);
      overlay.trails = trails_.trails();
    }
    std::vector<Vec3> colours;
    if (choices_.states) {
      colours = state_colours(world);
      const auto states = states_legend(world);
      overlay.legend.insert(overlay.legend.end(), states.begin(), states.end());
    }
    Image& image = capture_ ? capture_->next() : image_;
    renderer_->draw(
        {.world = world, .poses = poses, .view = view_, .overlay = &overlay, .colours = colours},
        image);
    while (cell_due()) strip_->add(image);
    if (!capture_) return;
    if (const auto pushed = capture_->push(); !pushed) ok_ = false;
  }

  PictureChoices choices_;
  View view_;
  std::string title_;
  double step_, fps_;
  std::uint64_t frames_, drawn_ = 0;
  std::vector<std::uint64_t> in_strip_;  // the frame of each cell
  double period_;
  std::unique_ptr<Renderer> renderer_;
  std::unique_ptr<Capture> capture_;
  std::vector<Pose> before_, poses_;
  Image image_;
  ContactTrails trails_;
  std::optional<Strip> strip_;
  bool ok_ = true;
};

}  // namespace

std::variant<std::unique_ptr<Pictures>, PictureFailure> Pictures::open(
    const PictureChoices& choices, const Scene& scene, std::uint64_t steps) {
  int width = scene.output.width, height = scene.output.height;
  if (!choices.size.empty() && !parse_size(choices.size, width, height))
    return PictureFailure{
        {Error{fmt::format("--size: found \"{}\", expected WIDTHxHEIGHT, each from 16 to 8192",
                           choices.size)}},
        kUsage};
  if (choices.size.empty() && !choices.captured() && !choices.strip.empty()) {
    const double part = kStripWidth / (static_cast<double>(choices.strip_columns) * width);
    if (part < 1) width = static_cast<int>(width * part), height = static_cast<int>(height * part);
    width = std::max(width, 16), height = std::max(height, 16);
  }
  const double fps = choices.fps > 0 ? choices.fps : scene.output.fps;
  // Frames 0, 1, ... at k / fps, without the end of the run: one second at 25 fps has 25.
  const auto frames = std::max<std::uint64_t>(
      1, static_cast<std::uint64_t>(static_cast<double>(steps) * scene.step * fps * (1 + 1e-12)));
  RenderOptions options;
  options.width = width, options.height = height, options.path = gl_path(choices.gl);
  auto renderer = Renderer::create(options);
  if (!renderer) {
    std::vector<Error> errors = renderer.errors();
    errors.insert(errors.begin(),
                  Error{"no OpenGL context could be created, so no pictures can be made; the scene "
                        "runs without --frames, --video, --gif and --strip. What was tried:"});
    return PictureFailure{errors, kFailed};
  }
  std::unique_ptr<Capture> capture;
  if (choices.captured()) {
    CaptureOptions to;
    to.frames_directory = choices.frames, to.video_path = choices.video;
    to.gif_path = choices.gif;
    to.fps = fps, to.width = width, to.height = height, to.frames_expected = frames;
    if (!choices.size.empty()) to.gif_width = 0;
    if (choices.fps > 0) to.gif_fps = kMostGifRate;
    auto opened = Capture::open(to);
    if (!opened) return PictureFailure{opened.errors(), kUnwritable};
    capture = std::move(*opened);
  }
  FrameFormat format{width, height, fps, frames};
  place_cells(choices, scene, steps, format);
  auto pictures = std::make_unique<DrawnPictures>(
      choices, scene, format, FrameMakers{std::move(*renderer), std::move(capture)});
  pictures->draw_start(scene.world);
  return pictures;
}

#else

std::variant<std::unique_ptr<Pictures>, PictureFailure> Pictures::open(const PictureChoices&,
                                                                       const Scene&,
                                                                       std::uint64_t) {
  return PictureFailure{{Error{"this build has no pictures (PANTIN_RENDER was off or its libraries "
                               "missing); the scene runs without --frames, --video, --gif and "
                               "--strip"}},
                        kFailed};
}

#endif

}  // namespace pantin::program
