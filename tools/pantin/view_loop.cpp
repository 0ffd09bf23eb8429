#include "tools/pantin/view_loop.hpp"

#ifdef PANTIN_HAS_VIEW
#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>

#include "engine/base/utf8.hpp"
#include "engine/render/capture.hpp"
#include "tools/pantin/program.hpp"
#include "tools/pantin/view_session.hpp"

namespace pantin::program {

using namespace detail;

namespace {

using Clock = std::chrono::steady_clock;

constexpr double kFrame = 1.0 / 60;     // s, of a script's frame; the least of a live one
constexpr double kLongestFrame = 0.25;  // s of wall time that are caught up with
constexpr double kStepBudget = 0.05;    // s of wall time that a live frame may spend on steps
constexpr double kFastest = 4;          // the highest speed
constexpr double kAfterScript = 1;      // s that a run goes on after its last event
constexpr double kSlack = 1e-9;

constexpr SDL_Keycode kKeyCodes[]{SDLK_SPACE, SDLK_PERIOD, SDLK_LEFTBRACKET, SDLK_RIGHTBRACKET,
                                  SDLK_1,     SDLK_2,      SDLK_3,           SDLK_4,
                                  SDLK_5,     SDLK_o,      SDLK_r,           SDLK_s,
                                  SDLK_h,     SDLK_q,      SDLK_ESCAPE};
static_assert(std::size(kKeyCodes) == std::size(kKeys));
constexpr std::uint8_t kButtonCodes[]{SDL_BUTTON_LEFT, SDL_BUTTON_MIDDLE, SDL_BUTTON_RIGHT};
static_assert(std::size(kButtonCodes) == std::size(kButtons));

constexpr const char* kHelp[]{
    "left: drag   right or shift: drag by a spring   middle: turn   wheel: zoom",
    "space: pause   . step   [ ] slower, faster   r restart   o overlay   s save a frame",
    "1 auto   2 sweep   3 shake2   4 procedural   5 lagrangian   h help   q quit"};

double seconds_between(Clock::time_point from, Clock::time_point to) {
  return std::chrono::duration<double>(to - from).count();
}

GlPath gl_path(const std::string& name) {
  if (name == "surfaceless") return GlPath::surfaceless;
  if (name == "device") return GlPath::device;
  return name == "osmesa" ? GlPath::osmesa : GlPath::automatic;
}

}  // namespace

SessionReport show(const Scene& scene, const SessionChoices& choices) {
  return Session(scene, choices).run();
}

void Session::fail(const std::vector<Error>& errors, int exit_code, const char* status) {
  for (const Error& e : errors) complain(e.message);
  report_.exit_code = exit_code, report_.status = status;
}

bool Session::open() {
  std::error_code trouble;
  std::filesystem::create_directories(choices_.frames, trouble);
  if (!std::filesystem::is_directory(choices_.frames, trouble)) {
    fail(
        {Error{choices_.frames + ": found no folder and could make none, expected one for frames"}},
        kUnwritable, "unwritable");
    return false;
  }
  RenderOptions options;
  options.width = choices_.width, options.height = choices_.height;
  options.path = gl_path(choices_.gl);
  auto renderer = Renderer::create(options);
  if (!renderer) {
    fail(renderer.errors(), kFailed, "failed");
    return false;
  }
  renderer_ = std::move(*renderer);
  report_.gl = renderer_->report().path;
  auto window =
      Window::open(printable(scene_.title) + " - pantin", choices_.width, choices_.height,
                   choices_.is_scripted ? Window::Display::optional : Window::Display::required);
  if (!window) {
    fail(window.errors(), kFailed, "failed");
    return false;
  }
  window_ = std::move(*window);
  report_.driver = window_->driver();
  return true;
}

SessionReport Session::run() {
  if (!open()) return report_;
  choices_.is_scripted ? run_script() : run_live();
  if (save_) draw();  // asked for and then left at once
  hand_.let_go(sim_.world);
  report_.drags = hand_.drags();
  report_.solver = solver();
  report_.is_paused = paused_, report_.speed = speed_, report_.time = sim_.world.time;
  report_.hash = state_hash(sim_.world);
  return report_;
}

bool Session::may_go_on() {
  if (interrupted() && report_.exit_code == kOk)
    report_.exit_code = kInterrupted, report_.status = "interrupted";
  if (choices_.duration > 0 && simulated_ >= choices_.duration - kSlack) quit_ = true;
  return !quit_ && !interrupted();
}

void Session::run_live() {
  Clock::time_point last = Clock::now();
  while (may_go_on()) {
    handle_all();
    const Clock::time_point now = Clock::now();
    frame(std::min(seconds_between(last, now), kLongestFrame));
    last = now;
    const double rest = kFrame - seconds_between(now, Clock::now());
    if (rest > 0) SDL_Delay(static_cast<std::uint32_t>(1e3 * rest));
  }
}

void Session::run_script() {
  sim_.most_steps = 1 + static_cast<int>(std::ceil(kFrame * kFastest / scene_.step));
  auto next = choices_.script.begin();
  const auto last = choices_.script.end();
  const double end = (next == last ? 0 : choices_.script.back().time) + kAfterScript;
  for (std::uint64_t k = 0; may_go_on(); ++k) {
    const double time = static_cast<double>(k) * kFrame;
    if (next == last && time > end - kSlack) break;
    for (; next != last && next->time <= time + kSlack && !quit_; ++next) {
      push(*next);
      handle_all();
    }
    handle_all();
    if (!quit_) frame(kFrame);
  }
}

void Session::move_script_mouse(const ScriptEvent& event) {
  if (event.spot == Spot::pixel) script_x_ = event.x, script_y_ = event.y;
  if (event.spot == Spot::shift) script_x_ += event.x, script_y_ += event.y;
  if (event.spot != Spot::body) return;
  const Pose& pose = poses_[sim_.world.bodies.slot(event.body)];
  const Pose* origin = sim_.world.origins.find(event.body);
  Vec3 local(0);
  if (!event.is_centre) local = origin ? to_world(*origin, event.at) : event.at;
  const Vec3 at = eye_.project(to_world(pose, local));
  script_x_ = std::floor(at.x), script_y_ = std::floor(at.y);
}

/// Puts an event into SDL's own queue, where a user's would arrive.
void Session::push(const ScriptEvent& event) {
  move_script_mouse(event);
  const int x = static_cast<int>(std::lround(script_x_));
  const int y = static_cast<int>(std::lround(script_y_));
  SDL_Event e{};
  const auto send = [&e] {
    if (SDL_PushEvent(&e) < 0) complain(std::string("SDL took no event: ") + SDL_GetError());
  };
  switch (event.act) {
    case Act::mouse_down:
    case Act::mouse_up:
      SDL_SetModState(event.shift ? KMOD_LSHIFT : KMOD_NONE);
      e.button.type = event.act == Act::mouse_down ? SDL_MOUSEBUTTONDOWN : SDL_MOUSEBUTTONUP;
      e.button.state = event.act == Act::mouse_down ? SDL_PRESSED : SDL_RELEASED;
      e.button.windowID = window_->id(), e.button.button = kButtonCodes[event.button];
      e.button.clicks = 1, e.button.x = x, e.button.y = y;
      break;
    case Act::mouse_move:
      e.motion.type = SDL_MOUSEMOTION, e.motion.windowID = window_->id();
      e.motion.x = x, e.motion.y = y;
      break;
    case Act::wheel:
      e.wheel.type = SDL_MOUSEWHEEL, e.wheel.windowID = window_->id();
      e.wheel.preciseY = static_cast<float>(event.y);
      e.wheel.y = static_cast<int>(std::lround(event.y));
      break;
    case Act::key:
      e.key.type = SDL_KEYDOWN, e.key.windowID = window_->id(), e.key.state = SDL_PRESSED;
      e.key.keysym.sym = kKeyCodes[event.key];
      send();
      e.key.type = SDL_KEYUP, e.key.state = SDL_RELEASED;
      break;
    case Act::quit:
      e.type = SDL_QUIT;
      break;
  }
  send();
}

void Session::frame(double wall) {
  if (!paused_) advance(wall);
  if (paused_ && !stale_ && !save_ && message_frames_ == 0) return;
  draw();
}

void Session::advance(double wall) {
  const double due = std::floor(fraction_ + wall * speed_ / scene_.step + kSlack);
  const Clock::time_point start = Clock::now();
  if (!choices_.is_scripted && step_seconds_ > 0)
    sim_.most_steps = static_cast<int>(std::clamp(kStepBudget / step_seconds_, 1.0, 1e4));
  hand_.expect(static_cast<int>(std::clamp(due, 1.0, 1.0 * sim_.most_steps)) * scene_.substeps);
  const Advance done = sim_.advance(wall * speed_);
  if (done.steps > 0) step_seconds_ = seconds_between(start, Clock::now()) / done.steps;
  fraction_ = done.fraction, behind_ = done.dropped > 0;
  notice(done.report);
  for (std::size_t i = 0; i < poses_.size(); ++i)
    poses_[i] = sim_.interpolated(sim_.world.bodies.owners()[i], fraction_);
}

std::vector<std::string> Session::label() const {
  std::vector<std::string> lines{scene_.title,
                                 fmt::format("t = {:.3f} s, step {} of {:.4g} ms", sim_.world.time,
                                             sim_.world.tick, 1e3 * scene_.step),
                                 fmt::format("solver {}, {}{}", solver(),
                                             paused_   ? "paused, "
                                             : behind_ ? "too much for this machine, "
                                                       : "",
                                             speed_ < 1 ? fmt::format("speed 1/{:.0f}", 1 / speed_)
                                                        : fmt::format("speed {:.0f}", speed_)),
                                 fmt::format("worst joint gap {:.1e} m", gap_)};
  const std::vector<Unreached> off = unreached(sim_.world);
  const auto worst = std::max_element(
      off.begin(), off.end(),
      [](const Unreached& a, const Unreached& b) { return a.residual < b.residual; });
  if (worst != off.end())
    lines.push_back(fmt::format("{} of {} is {:.2g} m from its place", worst->kind, worst->name,
                                worst->residual));
  // A script's pictures are the same every time.
  if (!choices_.is_scripted) lines.push_back(fmt::format("frame {:.0f} ms", 1e3 * draw_seconds_));
  if (hand_.holds())
    lines.push_back(fmt::format("holding {} ({}), {:.1e} m from the mouse", hand_.now().body,
                                hand_.now().grip, hand_.now().residual));
  if (message_frames_ > 0) lines.push_back(message_);
  if (help_) lines.insert(lines.end(), std::begin(kHelp), std::end(kHelp));
  return lines;
}

void Session::draw() {
  const Clock::time_point start = Clock::now();
  Overlay overlay;
  overlay.lines = label();
  overlay.alarm = alarm_;
  overlay.joints = overlay_;
  if (overlay_) overlay.legend = overlay_legend(sim_.world);
  renderer_->draw({sim_.world, poses_, view_, &overlay}, image_);
  ++report_.frames;
  stale_ = false;
  if (message_frames_ > 0 && --message_frames_ == 0) stale_ = true;
  if (auto shown = window_->show(image_); !shown) {
    fail(shown.errors(), kFailed, "failed");
    quit_ = true;
  }
  draw_seconds_ = seconds_between(start, Clock::now());
  if (save_) save();
}

/// Saves the picture under the first number that is free.
void Session::save() {
  save_ = false;
  namespace fs = std::filesystem;
  std::error_code trouble;
  fs::path path;
  std::size_t number = report_.saved.size();
  do path = fs::path(choices_.frames) / fmt::format("frame_{}.png", ++number);
  while (fs::exists(path, trouble));
  if (auto written = write_png(path.string(), image_); !written) {
    fail(written.errors(), kUnwritable, "unwritable");
    return tell("could not save " + path.string());
  }
  report_.saved.push_back(path.string());
  message_ = "saved " + path.string(), message_frames_ = 120;
}

}  // namespace pantin::program
#endif
