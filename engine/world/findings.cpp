#include "engine/world/findings.hpp"

namespace pantin {
namespace {

constexpr FindingInfo kInfos[] = {
    {"energy_gained", "J",
     "The energy of jointed or touching bodies exceeds their initial energy plus all work done on "
     "them by more than a twentieth of their greatest kinetic energy plus work.",
     "Use a shorter step; then the solver \"lagrangian\" with the integrator \"radau\"."},
    {"energy_lost", "J",
     "Bodies have lost more energy than drag, contacts and cable impacts dissipate, by more than a "
     "twentieth of their greatest kinetic energy plus work, and a tenth of the loss in contacts. "
     "Not checked where limits, friction or motors of joints, elastic or guided cables, or pins "
     "act.",
     "Use a shorter step; under \"lagrangian\" an integrator of higher order: \"rk4\", \"radau\"."},
    {"angular_momentum_changed", "kg m^2/s",
     "The angular momentum of bodies without contacts or fixed points changed by more than a "
     "twentieth of the angular momentum of the single bodies.",
     "Use a shorter step, or the solver \"auto\"."},
    {"joint_open", "m", "The gap of a joint exceeds a thousandth of its mechanism's size.",
     "Use the solver \"auto\" or \"lagrangian\"; check that no two joints are inconsistent."},
    {"limit_exceeded", "rad",
     "The rotation of a joint exceeds what its kind and limits allow by more than 0.05 rad.",
     "Use a shorter step; check that the limits allow the initial pose of the joint."},
    {"cable_overlong", "m",
     "An inextensible cable exceeds its length by more than a thousandth of its mechanism's size.",
     "Use a shorter step; check that the bodies at its ends can come within its length."},
    {"pin_missed", "m",
     "A body stays farther from a reachable pin of kind \"exact\" than the solver's tolerance, for "
     "longer than a quarter of a second.",
     "Move its target more slowly, or use a shorter step."},
    {"gear_slipped", "rad or m",
     "The coordinates that a gear couples violate its ratio by more than 0.01 rad, or by more than "
     "a thousandth of their mechanism's size.",
     "Use a shorter step."},
    {"belt_slipped", "m",
     "A belt without slip has drifted along a pulley by more than a thousandth of its length.",
     "Use a shorter step."},
    {"surfaces_apart", "m",
     "Surfaces that a joint holds together are separated, or penetrate, by more than a thousandth "
     "of their mechanism's size.",
     "Use a shorter step; under \"lagrangian\" the stabilisation \"projection\"."},
    {"sunk", "m",
     "A body at rest penetrates another by more than a hundredth of the smaller one's size, or a "
     "twentieth of its thickness, for longer than half a second; or a moving body penetrates by "
     "the whole thickness of the thinner one for longer than 0.15 s, or by a fraction above half "
     "of it for proportionally longer; or two NURBS shapes by three tenths of it, which may then "
     "part "
     "on the far side.",
     "Use a shorter step or more substeps; make the heavy body lighter or its support heavier."},
    {"passed_through", "m",
     "A body passed through another one: its middle half came out on the other side.",
     "Use a shorter step or more substeps; make the thin body thicker."},
    {"flung", "J",
     "Bodies squeezed by kinematic bodies have more than twice the energy that those could give "
     "them at four times their speed, within a quarter of a second.",
     "Leave room for the squeezed body, or press it with a dynamic body and a motor with a cap."},
    {"turned_too_far", "rad",
     "For a whole revolution a body rotated farther in each step than its solver resolves, and it "
     "has more than a twentieth of its mechanism's kinetic energy. Rotation about an axis of "
     "symmetry is not limited, unless the body rolls or spins on a contact.",
     "Use a shorter step, or \"lagrangian\" with \"rk4\" or \"radau\", which subdivide it."},
    {"spring_unresolved", "rad",
     "A lightly damped spring of a joint or a pin oscillates faster than the step resolves, so "
     "that its oscillation decays or grows numerically: its frequency times the step.",
     "Use a shorter step, make the spring softer, or give it its true damping."},
    {"energy_limited", "J",
     "For more than a twentieth of the last second the solver removed energy that its own steps "
     "had added, more than a quarter of the kinetic energy and a thousandth of the greatest so "
     "far.",
     "Use a shorter step; check for bodies that overlap initially."},
    {"step_rescued", "s",
     "Steps failed and fell back to Euler's method for more than a twentieth of the last second: "
     "springs or motors are too stiff for the integrator, or joints are inconsistent.",
     "Use the integrator \"radau\" or \"implicit\", or a shorter step."},
    {"contacts_unsolved", "s",
     "Contact impulses did not converge for more than a twentieth of the last second.",
     "Use a shorter step; check for bodies that are wedged without room to move."},
    {"place_uncertain", "s",
     "Surfaces of a joint nearly conform where they touch, so that rounding decides where the "
     "contact is.",
     "Make the radii of the surfaces differ by more, or use a joint that conforms: a ball joint, a "
     "hinge, a planar joint."},
};
static_assert(std::size(kInfos) == static_cast<std::size_t>(last_of(FindingKind{})) + 1);

}  // namespace

const FindingInfo& info_of(FindingKind kind) { return kInfos[static_cast<int>(kind)]; }

}  // namespace pantin
