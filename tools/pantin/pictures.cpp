#include "tools/pantin/pictures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

namespace pantin::program {

#ifdef PANTIN_HAS_RENDER

Result<std::unique_ptr<Renderer>> open_renderer(const RenderOptions& options) {
  auto renderer = Renderer::create(options);
  if (renderer) return renderer;
  std::vector<Error> lines{
      {"no pictures: no way to OpenGL works here (`pantin doctor` says more; "
       "runs without pictures need none)"}};
  for (const Error& error : renderer.errors()) lines.push_back({"  " + error.message});
  return lines;
}

View framed(const Scene& scene, const RenderOptions& options) {
  View view = scene.view;
  const Real aspect = static_cast<Real>(options.width) / options.height;
  if (view.camera.automatic) view.camera = framing_camera(scene.world, view, aspect);
  return view;
}

std::vector<LegendEntry> legend_of(const World& world) { return overlay_legend(world); }

namespace {

Result<std::unique_ptr<Capture>> open_capture(const CaptureOptions& options) {
  return Capture::open(options);
}

}  // namespace

#else

Result<std::unique_ptr<Renderer>> open_renderer(const RenderOptions&) {
  return Error{"no pictures: this program was built without drawing (PANTIN_RENDER)"};
}

View framed(const Scene& scene, const RenderOptions&) { return scene.view; }

std::vector<LegendEntry> legend_of(const World&) { return {}; }

namespace {

Result<std::unique_ptr<Capture>> open_capture(const CaptureOptions&) {
  return Error{"no pictures: this program was built without drawing (PANTIN_RENDER)"};
}

}  // namespace

#endif

std::vector<std::string> caption_lines(const Caption& caption, double time, std::uint64_t tick,
                                       const Measures& measures,
                                       const std::vector<Unreached>& unreached) {
  std::string how = fmt::format("{}, step {:.4g} ms", caption.solver, 1e3 * caption.step);
  if (caption.substeps > 1) how += fmt::format(" in {} parts", caption.substeps);
  std::vector<std::string> lines{caption.title, fmt::format("t = {:.3f} s   step {}", time, tick),
                                 how, fmt::format("widest joint gap {:.1e} m", measures.worst_gap)};
  if (!unreached.empty())
    lines.push_back(fmt::format("{} \"{}\" not reached: {:.3g} m", unreached.front().kind,
                                unreached.front().name, unreached.front().residual_m));
  return lines;
}

Result<std::unique_ptr<Pictures>> Pictures::open(const PictureOptions& options, const Scene& scene,
                                                 std::size_t frames, Exit& why) {
  const RenderOptions drawn = render_options(options, scene);
  why = Exit::failed;
  auto renderer = open_renderer(drawn);
  if (!renderer) return renderer.errors();

  CaptureOptions filed;
  filed.frames_directory = options.frames, filed.video_path = options.video;
  filed.fps = frame_rate(options, scene);
  filed.width = drawn.width, filed.height = drawn.height;
  filed.frames_expected = frames;
  why = Exit::not_written;
  auto capture = open_capture(filed);
  if (!capture) return capture.errors();
  return std::unique_ptr<Pictures>(
      new Pictures(std::move(*renderer), std::move(*capture), framed(scene, drawn)));
}

Result<Done> Pictures::add(const World& world, std::span<const Pose> poses,
                           const Overlay& overlay) {
  renderer_->draw(world, poses, view_, overlay, capture_->next());
  return capture_->push();
}

Result<std::size_t> Pictures::finish() { return capture_->finish(); }

std::vector<std::string> stale_frames(const std::string& directory, std::size_t written) {
  std::size_t beyond = 0;
  const std::string next = fmt::format("frame_{:06}.png", written);
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(directory, ignored)) {
    const std::string name = entry.path().filename().string();
    const bool is_frame = name.starts_with("frame_") && name.ends_with(".png");
    if (is_frame && name.size() >= next.size() && (name.size() > next.size() || name >= next))
      ++beyond;
  }
  if (beyond == 0) return {};
  return {fmt::format("{}: {} from {} on {} left by an earlier run", directory,
                      beyond == 1 ? "1 frame" : fmt::format("{} frames", beyond), next,
                      beyond == 1 ? "is" : "are")};
}

}  // namespace pantin::program
