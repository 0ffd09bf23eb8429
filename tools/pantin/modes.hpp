#pragma once
// Declarations shared by the parts of `pantin modes`.
#include <string>
#include <vector>

#include "engine/modes/feasible.hpp"
#include "engine/modes/lamina_plan.hpp"
#include "engine/modes/stepper.hpp"
#include "engine/modes/uncertain.hpp"
#include "engine/scene/scene.hpp"
#include "tools/pantin/program.hpp"

namespace pantin::program {

using namespace detail::modes;
// Not the contacts of bodies in a scene.
using detail::modes::Contact;
using detail::modes::Friction;
using detail::modes::Motion;

/// Options of the command line.
struct ModesChoices {
  std::string scene, lamina, out, path, move, against, axes;
  std::vector<double> mu, range{0, 1};
  int size = 256, samples = 101;
  double duration = 0;  // s; 0: the scene's
  double at = 0;        // s
  std::string running;  // the lamina's present motion: a letter for each finger, or by dynamics
  bool uncertain = false, advise = false, json = false;
};

/// The fingers that touch a lamina at the start, as contacts.
struct Grasp {
  const LaminaPlan* plan = nullptr;
  std::vector<std::size_t> fingers;  // the finger of each contact, as index in the plan
  std::vector<Contact> contacts;
  std::vector<Real> roll, slide;
  std::vector<Spread> spreads;
  Prepared prepared;

  Friction friction() const { return {roll, slide}; }
  const std::string& name(std::size_t contact) const {
    return plan->fingers[fingers[contact]].name;
  }
};
/// Returns nothing after an error: no finger touches.
std::optional<Grasp> grasp_of(const LaminaPlan& plan, const std::string& file);

/// "left sticks, right slides"; separating fingers are omitted if `others` is empty.
std::string in_words(const Grasp& grasp, const Signs& signs);

int print_modes(const Grasp& grasp, const ModesChoices& c);
int draw_map(Grasp& grasp, const ModesChoices& c);
int print_outlook(const Grasp& grasp, const ModesChoices& c);
int print_advice(const Grasp& grasp, const ModesChoices& c);
int follow_path(LaminaPlan plan, const ModesChoices& c);
int move_on(const Scene& scene, const LaminaPlan& plan, const ModesChoices& c);
int compare_with_dynamics(const Scene& scene, const LaminaPlan& plan, const ModesChoices& c);

/// The fingers as input of a stepper, at a time (s); at `until` the first of them changes its
/// velocity.
std::vector<Finger> fingers_at(const LaminaPlan& plan, double time, double& until);
/// Returns false after an error if the part has no outline, so that it cannot move.
bool can_move(const LaminaPlan& plan, const ModesChoices& c);

/// The quasi-static motion of a lamina as its fingers follow their paths.
struct Course {
  const LaminaPlan& plan;
  Part part{plan.outline, plan.centre, plan.force, plan.torque};
  Stepper stepper{};
  double time = 0;
  int switches = 0;
  bool zeno = false;
  std::size_t choices = 0;

  /// Advances to a time, in intervals of constant finger velocities.
  StepEnd to(double target);
  Vec2 centre() const;  // the mass centre
};
/// The state of lamina and fingers in the scene's World at ModesChoices::at. Sets `running`.
/// Returns nothing after an error, or an interruption.
std::optional<LaminaPlan> plan_at(const Scene& scene, LaminaPlan plan, ModesChoices& c);

/// Why a course ended.
std::string why(const StepEnd& end);

/// Placements of a lamina at equal intervals (s), from 0 on.
struct Places {
  std::span<const Placement> list;
  double interval = 0;
};
/// A scene file in which the lamina follows its quasi-static motion as a kinematic body among its
/// fingers, for other commands to draw.
std::string scene_along(const Scene& scene, const LaminaPlan& plan, const Places& places);
/// The same under dynamics, with the fingers slower by a factor. Outlines must be convex.
std::string scene_of_dynamics(const Scene& scene, const LaminaPlan& plan, double duration,
                              double slower);
/// The radius of the balls that represent point fingers there, m.
double radius_of_finger(const LaminaPlan& plan);

}  // namespace pantin::program
