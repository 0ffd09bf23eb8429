#pragma once
// What the parts of `pantin modes` share.
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
// Not those of the bodies of a scene.
using detail::modes::Contact;
using detail::modes::Friction;
using detail::modes::Motion;

/// What the command line asks for.
struct ModesChoices {
  std::string scene, lamina, out, path, move, against, axes;
  std::vector<double> mu, range{0, 1};
  int size = 256, samples = 101;
  double duration = 0;  // s; 0: the scene's
  double at = 0;        // s
  std::string running;  // how the lamina moves then: a letter for each finger, or by dynamics
  bool uncertain = false, advise = false, json = false;
};

/// The fingers of a lamina that touch it at the start, as contacts.
struct Grasp {
  const LaminaPlan* plan = nullptr;
  std::vector<std::size_t> fingers;  // of each contact, in the plan
  std::vector<Contact> contacts;
  std::vector<Real> roll, slide;
  std::vector<Spread> spreads;
  Prepared prepared;

  Friction friction() const { return {roll, slide}; }
  const std::string& name(std::size_t contact) const {
    return plan->fingers[fingers[contact]].name;
  }
};
/// Nothing after a complaint: no finger touches.
std::optional<Grasp> grasp_of(const LaminaPlan& plan, const std::string& file);

/// "left sticks, right slides", leaving out who separates if `others` is empty.
std::string in_words(const Grasp& grasp, const Signs& signs);

int print_modes(const Grasp& grasp, const ModesChoices& c);
int draw_map(Grasp& grasp, const ModesChoices& c);
int print_outlook(const Grasp& grasp, const ModesChoices& c);
int print_advice(const Grasp& grasp, const ModesChoices& c);
int follow_path(LaminaPlan plan, const ModesChoices& c);
int move_on(const Scene& scene, const LaminaPlan& plan, const ModesChoices& c);
int compare_with_dynamics(const Scene& scene, const LaminaPlan& plan, const ModesChoices& c);

/// The fingers as a stepper takes them, at a time (s); `until` is when the first of them turns.
std::vector<Finger> fingers_at(const LaminaPlan& plan, double time, double& until);
/// A part without an outline cannot be moved: false after a complaint.
bool can_move(const LaminaPlan& plan, const ModesChoices& c);

/// A lamina on its way along the paths of its fingers.
struct Course {
  const LaminaPlan& plan;
  Part part{plan.outline, plan.centre, plan.force, plan.torque};
  Stepper stepper{};
  double time = 0;
  int switches = 0;
  bool zeno = false;
  std::size_t choices = 0;

  /// On to a time, turn by turn of the fingers.
  StepEnd to(double target);
  Vec2 centre() const;  // of mass
};
/// The lamina and its fingers where the scene's World has brought them at ModesChoices::at.
/// Fills in `running`. Nothing after a complaint, or an interruption.
std::optional<LaminaPlan> plan_at(const Scene& scene, LaminaPlan plan, ModesChoices& c);

/// Why a course came to an end.
std::string why(const StepEnd& end);

/// A lamina where it was at equal intervals (s) from 0 on.
struct Places {
  std::span<const Placement> list;
  double interval = 0;
};
/// The text of a scene in which the lamina follows its quasi-static motion as a kinematic body
/// among its fingers: for other commands to draw.
std::string scene_along(const Scene& scene, const LaminaPlan& plan, const Places& places);
/// The same where it moves by dynamics, its fingers slower by a factor. Outlines must be convex.
std::string scene_of_dynamics(const Scene& scene, const LaminaPlan& plan, double duration,
                              double slower);
/// Of the balls that stand for point fingers there, m.
double radius_of_finger(const LaminaPlan& plan);

}  // namespace pantin::program
