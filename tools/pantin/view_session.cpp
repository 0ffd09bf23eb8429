#ifdef PANTIN_HAS_VIEW
#include "tools/pantin/view_session.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "engine/solvers/solver.hpp"
#include "tools/pantin/program.hpp"

namespace pantin::program {

using namespace detail;

namespace {

constexpr double kSlowest = 1.0 / 16, kFastest = 4;
constexpr double kTurnPerPixel = 0.006;  // rad
constexpr double kSteepest = 1.5;        // rad, above and below the horizon
constexpr double kZoomPerClick = 0.9;    // of the distance
constexpr int kMessageFrames = 180;
constexpr std::size_t kMostNotes = 20;

}  // namespace

Session::Session(const Scene& scene, const SessionChoices& choices)
    : scene_(scene), choices_(choices), view_(scene.view) {
  start_over();
  if (view_.camera.automatic)
    view_.camera =
        framing_camera(sim_.world, scene.view, static_cast<Real>(choices.width) / choices.height);
  look();
}

/// The scene as it was read, with the solver chosen since.
void Session::start_over() {
  hand_.forget();
  holding_button_ = 0;
  alarm_.clear();
  const int most_steps = sim_.most_steps;
  sim_ = Simulation(scene_.world, {scene_.step, scene_.substeps, choices_.threads, false});
  sim_.most_steps = most_steps;
  sim_.insert(Stage::before_drive, [this](World& world, Real) {
    hand_.before_part(world, scene_.step / scene_.substeps);
  });
  sim_.insert(Stage::after_step, [this](World& world, Real h) {
    hand_.after_step(world);
    const Measures m = measure(world);
    gap_ = m.worst_gap;
    report_.worst_gap = std::max(report_.worst_gap, m.worst_gap);
    report_.worst_gap_rel = std::max(report_.worst_gap_rel, m.worst_gap_rel);
    ++report_.steps, simulated_ += h;
  });
  if (chosen_) choose(*chosen_);
  fraction_ = gap_ = 0;
  poses_.clear();
  for (const Body& b : sim_.world.bodies.values()) poses_.push_back(b.pose);
  stale_ = true;
}

void Session::handle_all() {
  for (SDL_Event e; SDL_PollEvent(&e) != 0;) handle(e);
}

void Session::handle(const SDL_Event& e) {
  switch (e.type) {
    case SDL_QUIT:
      quit_ = true;
      break;
    case SDL_MOUSEBUTTONDOWN:
      button_down(e.button);
      break;
    case SDL_MOUSEBUTTONUP:
      button_up(e.button);
      break;
    case SDL_MOUSEMOTION:
      mouse_moved(e.motion);
      break;
    case SDL_MOUSEWHEEL:
      zoom(static_cast<double>(e.wheel.preciseY));
      break;
    case SDL_KEYDOWN:
      // A key that is kept down repeats; only steps are wanted again and again.
      if (!e.key.repeat || e.key.keysym.sym == SDLK_PERIOD) key_down(e.key.keysym.sym);
      break;
    case SDL_WINDOWEVENT:
      stale_ = true;
      break;
    default:
      break;
  }
}

void Session::button_down(const SDL_MouseButtonEvent& e) {
  mouse_x_ = e.x, mouse_y_ = e.y;
  if (e.button == SDL_BUTTON_MIDDLE) turning_ = true;
  if ((e.button != SDL_BUTTON_LEFT && e.button != SDL_BUTTON_RIGHT) || hand_.holds()) return;
  const SeenPixel mouse{eye_, 1.0 * e.x, 1.0 * e.y};
  const auto picked = pick({sim_.world, poses_}, mouse);
  if (!picked) return tell(fmt::format("no body at {}, {}", e.x, e.y));
  if (sim_.world.bodies[picked->body].motion == Motion::fixed)
    return tell(sim_.world.name_of(picked->body) + " is fixed and cannot be dragged");
  const bool soft = e.button == SDL_BUTTON_RIGHT || (SDL_GetModState() & KMOD_SHIFT) != 0;
  hand_.take(sim_.world, *picked, soft ? PinKind::spring : PinKind::exact, mouse);
  holding_button_ = e.button;
  stale_ = true;
}

void Session::button_up(const SDL_MouseButtonEvent& e) {
  if (e.button == SDL_BUTTON_MIDDLE) turning_ = false;
  if (e.button != holding_button_) return;
  hand_.let_go(sim_.world);
  holding_button_ = 0;
  help_ = false;  // they know how, and the lines cover the picture
  stale_ = true;
}

void Session::mouse_moved(const SDL_MouseMotionEvent& e) {
  const int right = e.x - mouse_x_, down = e.y - mouse_y_;
  mouse_x_ = e.x, mouse_y_ = e.y;
  if (turning_) return rotation(right, down);
  hand_.move({eye_, 1.0 * e.x, 1.0 * e.y});
}

void Session::key_down(SDL_Keycode key) {
  stale_ = true;
  constexpr Solver kSolvers[]{Solver::articulated, Solver::sweep, Solver::shake2,
                              Solver::procedural, Solver::lagrangian};
  if (key >= SDLK_1 && key <= SDLK_5) return choose(kSolvers[key - SDLK_1]);
  switch (key) {
    case SDLK_SPACE:
      paused_ = !paused_;
      break;
    case SDLK_PERIOD:
      single_step();
      break;
    case SDLK_LEFTBRACKET:
      speed_ = std::max(speed_ / 2, kSlowest);
      break;
    case SDLK_RIGHTBRACKET:
      speed_ = std::min(speed_ * 2, kFastest);
      break;
    case SDLK_o:
      overlay_ = !overlay_;
      break;
    case SDLK_r:
      start_over();
      ++report_.restarts;
      break;
    case SDLK_s:
      save_ = true;
      break;
    case SDLK_h:
      help_ = !help_;
      break;
    case SDLK_q:
    case SDLK_ESCAPE:
      quit_ = true;
      break;
    default:
      break;
  }
}

/// Pauses too: the picture is that of the step's end.
void Session::single_step() {
  paused_ = true;
  hand_.expect(scene_.substeps);
  notice(sim_.advance(scene_.step).report);  // what is left of a step stays left
  for (std::size_t i = 0; i < poses_.size(); ++i) poses_[i] = sim_.world.bodies.values()[i].pose;
}

void Session::notice(const StepReport& step) {
  const std::string body = sim_.world.name_of(step.body);
  if (step.status == Status::diverged)
    stop("diverged", fmt::format("diverged: body {} could not go on or left all bounds", body));
  if (step.status == Status::bad_clock)
    stop("diverged", "diverged: the time or the step is no number to compute with");
  if (step.status == Status::energy_grew)
    stop("energy_grew",
         fmt::format("energy grew severalfold by itself where body {} is: the solver "
                     "{} does not keep it",
                     body, solver()));
}

/// A step that is not to be gone on from: pauses, and stays to be seen in red.
void Session::stop(const char* status, std::string line) {
  if (report_.exit_code == kOk) report_.exit_code = kDiverged, report_.status = status;
  paused_ = true;
  alarm_ = line;
  tell(std::move(line));
}

void Session::look() {
  eye_ = make_eye(view_.camera, choices_.width, choices_.height);
  hand_.look_again({eye_, 1.0 * mouse_x_, 1.0 * mouse_y_});
  stale_ = true;
}

void Session::rotation(double right, double down) {
  const Vec3 back = view_.camera.eye - view_.camera.target;
  const Real distance = glm::length(back);
  if (!(distance > 0)) return;
  const Real around = std::atan2(back.x, back.z) - kTurnPerPixel * right;
  const Real above =
      std::clamp(std::asin(std::clamp(back.y / distance, -1.0, 1.0)) + kTurnPerPixel * down,
                 -kSteepest, kSteepest);
  view_.camera.eye =
      view_.camera.target + distance * Vec3(std::cos(above) * std::sin(around), std::sin(above),
                                            std::cos(above) * std::cos(around));
  look();
}

void Session::zoom(double clicks) {
  const Vec3 back = view_.camera.eye - view_.camera.target;
  const Real distance = glm::length(back);
  if (!(distance > 0)) return;
  const Real to = std::clamp(distance * std::pow(kZoomPerClick, clicks), 1e-3, 1e6);
  view_.camera.eye = view_.camera.target + to / distance * back;
  look();
}

void Session::choose(Solver solver) {
  const auto choose_in = [solver](World& world) {
    world.default_settings.solver = solver;
    for (SolverSettings& s : world.settings.values()) s.solver = solver;
    world.mark_dirty();
  };
  World tried = sim_.world;
  choose_in(tried);
  const std::vector<StructureFault> before = check(sim_.world);
  for (const StructureFault& f : check(tried)) {
    const bool known = std::any_of(before.begin(), before.end(),
                                   [&](const StructureFault& b) { return b.link == f.link; });
    if (!known && !f.is_minor)
      return tell(fmt::format("not with the solver {}: {} {}", pantin::name_of(solver),
                              tried.name_of(f.link), f.reason));
  }
  chosen_ = solver;
  choose_in(sim_.world);
}

/// A line for the picture and for the report.
void Session::tell(std::string line) {
  if (report_.notes.size() < kMostNotes)
    report_.notes.push_back(fmt::format("{:.3f} s: {}", sim_.world.time, line));
  message_ = std::move(line), message_frames_ = kMessageFrames;
  stale_ = true;
}

std::string Session::solver() const {
  return chosen_ ? pantin::name_of(*chosen_) : describe_solvers(sim_.world);
}

}  // namespace pantin::program
#endif
