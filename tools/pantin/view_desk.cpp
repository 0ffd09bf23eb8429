#include "tools/pantin/view_desk.hpp"

#ifdef PANTIN_HAS_VIEW
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "engine/render/renderer.hpp"
#include "tools/pantin/findings.hpp"
#include "tools/pantin/program.hpp"

namespace pantin::program {

using namespace detail;

namespace {

constexpr double kSlowest = 1.0 / 16, kFastest = 4;
constexpr double kMessageTime = 3, kTroubleTime = 20;  // s
constexpr double kTitleTime = 3;                       // s
constexpr std::size_t kMostNotes = 20;
constexpr double kBallReach = 40;  // camera distances; balls beyond are removed

const char* const kHelp[] = {
    "left: drag exactly   right or shift: by a spring   on nothing, or alt: rotate, move the "
    "camera",
    "space: pause   . step   [ ] slower, faster   r restart   j at the end: go on, stop, loop",
    "x cut   p pin   b shoot a ball   g measure   n or click: plot   l follow   c two solvers",
    "e front   d right   t top (shift: opposite)   i corner   home: all in view",
    "o joints   f forces   w wireframe   a states   m pose mode: no dynamics   k keep the pose",
    "1 auto   2 sweep   3 shake2   4 procedural   5 lagrangian   page up, down: other scenes",
    "s picture   v video   y record the run (shift: from its start)   u save the sliders",
    "tab: panel   f5 reload the file   h help   q quit"};

}  // namespace

Desk::Desk(Scene scene, DeskChoices choices)
    : choices_(std::move(choices)), width_(choices_.width), height_(choices_.height) {
  panes.push_back(std::make_unique<Pane>());
  if (choices_.beside) {
    panes.push_back(std::make_unique<Pane>());
    panes[1]->chosen = choices_.beside;
  }
  begin(std::move(scene));
  const Camera home = home_camera();
  orbit_.start(home);
  gun = usual_gun(scene_.world, glm::distance(home.eye, home.target));
  look();
}

/// The initial camera of the scene.
Camera Desk::home_camera() const {
  const View& view = scene_.view;
  if (!view.camera.automatic) return view.camera;
  return framing_camera(panes[0]->world(), view, static_cast<Real>(pane_width()) / height_);
}

/// Takes over a scene; the camera is unchanged.
void Desk::begin(Scene scene) {
  scene_ = std::move(scene);
  scene_.view.ground_height = ground_height_of(scene_.world, scene_.view);
  title_left_ = kTitleTime, gauge.clear();
  how_ = settings_of(scene_, choices_.threads);
  how_.watch = true;
  turned_.clear();
  scenes_ = scenes_beside(choices_.path);
  leaf_ = place_of(choices_.path, scenes_);
  watch_files();
  under = followed = Entity{}, is_under = false;
  start_panes();
}

/// The scene's own file, and those that it names.
void Desk::watch_files() {
  std::vector<std::string> files{choices_.path};
  files.insert(files.end(), scene_.files.begin(), scene_.files.end());
  watch_.start(files);
}

/// Starts panes with the scene as read, and the solvers and knobs chosen since.
void Desk::start_panes() {
  grip_ = Grip::none;
  for (const auto& pane : panes) {
    const std::optional<Solver> chosen = std::exchange(pane->chosen, std::nullopt);
    pane->start(scene_.world, how_);
    if (!chosen) continue;
    if (const auto why = pane->choose(*chosen)) tell(*why);
  }
  for (const auto& [name, value] : turned_)
    for (const auto& pane : panes) turn_knob({pane->world(), how_, scene_.world}, name, value);
  stale = true;
}

void Desk::restart() {
  start_panes();
  ++restarts;
}

void Desk::faster(double times) { speed = std::clamp(speed * times, kSlowest, kFastest); }

void Desk::advance(double wall, int most) {
  if (message_left > 0 && (message_left -= wall) <= 0) stale = true;
  if (title_left_ > 0 && (title_left_ -= wall) <= 0) stale = true;
  if (is_posing()) {
    for (const auto& pane : panes) pane->pose();
    follow();
    stale = true;
    return;
  }
  if (paused) return;
  const double before = panes[0]->world().time;
  for (const auto& pane : panes) notice(*pane, pane->advance(wall * speed, most).report);
  const Real reach = kBallReach * glm::distance(orbit_.camera().eye, orbit_.camera().target);
  for (const auto& pane : panes) {
    const std::size_t count = pane->world().bodies.size();
    sweep_balls(pane->world(), orbit_.camera().target, reach);
    if (pane->world().bodies.size() != count) pane->place();
  }
  follow();
  stale = true;
  end_of_scene(before);
}

/// At the end of the scene's duration, which a run may pass.
void Desk::end_of_scene(double before) {
  const double end = scene_.duration - 0.5 * how_.h;
  if (choices_.at_end == AtEnd::go_on || before >= end || panes[0]->world().time < end) return;
  if (choices_.at_end == AtEnd::loop) return restart();
  paused = true;
  tell("the end of the scene; space goes on, r restarts, j loops");
}

void Desk::toggle_posing() {
  let_go();
  if (is_posing()) {
    for (const auto& pane : panes) pane->stop_posing();
    return tell("dynamics go on from this pose, at rest");
  }
  for (const auto& pane : panes)
    if (const auto why = pane->start_posing()) return tell(*why);
  tell("pose mode: drag without dynamics; p holds a point, k keeps the pose in a file, m ends it");
}

void Desk::single_step() {
  if (is_posing()) toggle_posing();
  paused = true;
  for (const auto& pane : panes) notice(*pane, pane->single_step());
  follow();
  stale = true;
}

/// A step after which the run cannot continue: pauses, and shows the reason in red.
void Desk::notice(Pane& pane, const StepReport& step) {
  const auto trouble = pane.trouble(step);
  if (!trouble) return;
  if (status == "ok")
    status = step.status == Status::energy_grew    ? "energy_grew"
             : step.status == Status::contact_lost ? "contact_lost"
             : step.status == Status::inconsistent ? "inconsistent"
                                                   : "diverged";
  paused = true;
  pane.alarm = *trouble;
  tell(*trouble);
}

void Desk::resize(int width, int height) {
  width_ = std::max(1, width), height_ = std::max(1, height);
  look();
}

View Desk::view() const {
  View view = scene_.view;
  view.camera = orbit_.camera();
  return view;
}

void Desk::look() {
  eye_ = make_eye(orbit_.camera(), pane_width(), height_);
  for (const auto& pane : panes)
    pane->hand.look_again(
        {eye_, mouse_x_ - 1.0 * pane_width() * static_cast<double>(pane_), mouse_y_});
  stale = true;
}

void Desk::follow() {
  if (!followed) return;
  const Pane& pane = *panes[0];
  const std::uint32_t slot = pane.world().bodies.slot(followed);
  if (slot >= pane.poses.size()) {
    followed = Entity{};
    return;
  }
  orbit_.look_at(pane.poses[slot].position);
  look();
}

void Desk::toggle_follow() {
  if (followed) {
    tell("the camera stays");
    followed = Entity{};
    return;
  }
  if (!is_under) return tell("no body under the mouse to follow");
  followed = under;
  tell("follows " + panes[0]->world().name_of(followed));
  follow();
}

void Desk::reset_camera() {
  followed = Entity{};
  orbit_.reset();
  if (scene_.view.camera.automatic) orbit_.start(home_camera());
  look();
}

void Desk::look_from(Vec3 way) {
  followed = Entity{};
  View view = scene_.view;
  view.camera = seen_from(way, orbit_.camera());
  const Camera home = home_camera();
  orbit_.start(framing_camera(panes[0]->world(), view, static_cast<Real>(pane_width()) / height_));
  orbit_.set_home(home);
  look();
}

void Desk::watch() {
  if (!watch_.changed()) return;
  reload();
  if (!is_trouble) print_error(message);
}

void Desk::open(std::string path) {  // by value: the list that contains it is rebuilt
  auto loaded = choices_.load(path);
  if (!loaded) {
    for (const Error& e : loaded.errors()) print_error(e.message);
    const std::size_t more = loaded.errors().size() - 1;
    tell(loaded.errors().front().message +
         (more > 0 ? fmt::format(" (and {} more)", more) : std::string()));
    is_trouble = true, message_left = kTroubleTime;
    if (path == choices_.path) watch_files();
    return;
  }
  const bool is_same = path == choices_.path;
  choices_.path = path;
  begin(std::move(*loaded));
  const Camera home = home_camera();
  orbit_.set_home(home);
  if (!is_same) {
    orbit_.start(home);
    gun = usual_gun(scene_.world, glm::distance(home.eye, home.target));
  }
  look();
  tell(fmt::format("{} {}", is_same ? "reloaded:" : "opened", path));
}

void Desk::leaf(int by) {
  if (scenes_.empty()) return;
  const auto count = static_cast<int>(scenes_.size());
  leaf_ = static_cast<std::size_t>((static_cast<int>(leaf_) + by + count) % count);
  const std::size_t to = leaf_;
  open(scenes_[to]);
  leaf_ = to;  // moves on past files that cannot be read
}

void Desk::choose(Solver solver, std::size_t pane) {
  if (pane >= panes.size()) return tell("there is no second pane: c opens one");
  if (const auto why = panes[pane]->choose(solver)) tell(*why);
  stale = true;
}

/// The solver of a second pane: the first that differs from the present one and can move the scene.
Solver Desk::another() const {
  for (const Solver solver : {Solver::sweep, Solver::lagrangian})
    if (panes[0]->solver() != pantin::name_of(solver) && !panes[0]->why_not(solver)) return solver;
  return Solver::articulated;
}

void Desk::compare(std::optional<Solver> solver) {
  let_go();
  if (is_posing()) toggle_posing();
  if (!solver) {
    panes.resize(1);
    pane_ = 0;
    return look();
  }
  if (panes.size() < 2) panes.push_back(std::make_unique<Pane>());
  const World now = panes[0]->world();
  panes[0]->start(now, how_);  // synchronises both clocks
  panes[1]->chosen = std::nullopt;
  panes[1]->start(now, how_);
  if (const auto why = panes[1]->choose(*solver)) tell(*why);
  look();
}

std::vector<Knob> Desk::knobs() const { return knobs_of(panes[0]->world(), how_, scene_.world); }

bool Desk::turn(const std::string& name, double value) {
  bool known = false;
  for (const auto& pane : panes) {
    known |= turn_knob({pane->world(), how_, scene_.world}, name, value);
    pane->sim.settings = how_;
    pane->hand.renew(pane->world());
    if (name == "step" && !pane->focus.name().empty()) pane->focus.start(pane->world(), how_.h);
  }
  if (!known) return false;
  std::erase_if(turned_, [&](const auto& t) { return t.first == name; });
  turned_.emplace_back(name, value);
  stale = true;
  return true;
}

/// A message for the picture and the report.
void Desk::tell(std::string line) {
  if (notes.size() < kMostNotes)
    notes.push_back(fmt::format("{:.3f} s: {}", panes[0]->world().time, line));
  message = std::move(line), message_left = kMessageTime, is_trouble = false;
  stale = true;
}

/// Omits what the panel shows, to cover less of the picture.
std::vector<std::string> Desk::labels(std::size_t index) const {
  const Pane& pane = *panes[index];
  const World& world = pane.world();
  const char* state = is_posing()      ? "pose mode, "
                      : paused         ? "paused, "
                      : pane.is_behind ? "too slow for real time, "
                                       : "";
  const std::string pace =
      speed < 1 ? fmt::format("speed 1/{:.0f}", 1 / speed) : fmt::format("speed {:.0f}", speed);
  std::vector<std::string> lines;
  if (index == 0 && title_left_ > 0) lines.push_back(scene_.title);
  if (index == 0 && !panel)
    lines.push_back(
        fmt::format("t = {:.3f} s, step {} of {:.4g} ms", world.time, world.tick, 1e3 * how_.h));
  lines.push_back(index == 0 ? fmt::format("solver {}, {}{}", pane.solver(), state, pace)
                             : "solver " + pane.solver());
  lines.push_back(fmt::format("worst joint gap {:.1e} m", pane.gap));
  const std::vector<Unreached> off = unreached(world);
  const auto worst = std::max_element(
      off.begin(), off.end(),
      [](const Unreached& a, const Unreached& b) { return a.residual < b.residual; });
  if (worst != off.end())
    lines.push_back(fmt::format("{} of {} is {:.2g} m from its target", worst->kind, worst->name,
                                worst->residual));
  if (const auto found = pane.sim.findings(); !found.empty())
    lines.push_back(
        fmt::format("found {}{}", words_of(world, found.back()),
                    found.size() > 1 ? fmt::format("; {} more", found.size() - 1) : ""));
  if (pane.hand.holds())
    lines.push_back(fmt::format("holding {} ({}), {:.1e} m from the mouse", pane.hand.now().body,
                                pane.hand.now().grip, pane.hand.now().residual));
  else if (is_under && index == pane_ && !panel)
    lines.push_back(describe_shortly(world, under));
  if (index > 0) return lines;
  if (const std::string measured = gauge.words(pane.scene()); !measured.empty())
    lines.push_back(measured);
  const bool is_alarm =
      std::any_of(panes.begin(), panes.end(), [&](const auto& p) { return p->alarm == message; });
  if (message_left > 0 && !is_trouble && !is_alarm) lines.push_back(message);
  if (help && panes.size() == 1) lines.insert(lines.end(), std::begin(kHelp), std::end(kHelp));
  return lines;
}

}  // namespace pantin::program
#endif
