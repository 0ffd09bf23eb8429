#include "engine/world/findings.hpp"

namespace pantin {
namespace {

constexpr FindingInfo kInfos[] = {
    {"energy_gained", "J",
     "Bodies that are joined or touch have more energy than they began with and all work done on "
     "them, by more than a twentieth of what moves them.",
     "Take a shorter step; then the solver \"lagrangian\" with the integrator \"radau\"."},
    {"energy_lost", "J",
     "Bodies have lost more than drag, contacts and blows of cables take, by more than a twentieth "
     "of what moves them and a tenth of what contacts took. It is not asked where limits, friction "
     "or "
     "motors of joints, elastic or guided cables, or pins act.",
     "Take a shorter step; of \"lagrangian\" an integrator of higher order: \"rk4\", \"radau\"."},
    {"angular_momentum_changed", "kg m^2/s",
     "What flies free of contacts and holds has changed its angular momentum by more than a "
     "twentieth of the spin of its parts.",
     "Take a shorter step, or the solver \"auto\"."},
    {"joint_open", "m", "A joint is open by more than a thousandth of its mechanism's size.",
     "Use the solver \"auto\" or \"lagrangian\"; check that no two joints contradict each other."},
    {"limit_exceeded", "rad",
     "A joint is turned further than its kind and its limits allow, by more than 0.05 rad.",
     "Take a shorter step; check that the limits allow the pose in which the joint starts."},
    {"cable_overlong", "m",
     "A cable that cannot stretch is longer than its length by more than a thousandth of its "
     "mechanism's size.",
     "Take a shorter step; check that the bodies at its ends can come so near."},
    {"pin_missed", "m",
     "A pin of kind \"exact\" that can be reached is further from its place than the solver's "
     "tolerance, for longer than a quarter of a second.",
     "Move its target more slowly, or take a shorter step."},
    {"gear_slipped", "rad or m",
     "The coordinates that a gear couples differ from its ratio by more than 0.01 rad, or by more "
     "than a thousandth of their mechanism's size.",
     "Take a shorter step."},
    {"belt_slipped", "m",
     "A belt that cannot slip has run along a pulley by more than a thousandth of its length.",
     "Take a shorter step."},
    {"surfaces_apart", "m",
     "Surfaces that a joint holds together are apart, or within one another, by more than a "
     "thousandth of their mechanism's size.",
     "Take a shorter step; of \"lagrangian\" the stabilisation \"projection\"."},
    {"sunk", "m",
     "A body at rest lies deeper in another one than a hundredth of the smaller one's size, or a "
     "twentieth of its thickness, for longer than half a second; or one that moves is in by the "
     "whole thickness of the thinner one for longer than 0.15 s, or by a part above half of it for "
     "longer in proportion.",
     "Take a shorter step or more substeps; make the heavy body lighter or what bears it heavier."},
    {"passed_through", "m",
     "The middle half of a body came to the other side of one that it collides with.",
     "Take a shorter step or more substeps; make the thin body thicker."},
    {"flung", "J",
     "Bodies have more than twice the energy that led bodies which press them could give them, at "
     "four times their speed within a quarter of a second.",
     "Leave room for what is pressed, or press it with a dynamic body, by a motor with a cap."},
    {"turned_too_far", "rad",
     "For a whole turn on end a body turned further in each step than its solver can follow, and "
     "it has more than a twentieth of its mechanism's kinetic energy; about an axis of symmetry it "
     "may turn as fast as it likes, unless it rolls or spins on what it touches.",
     "Take a shorter step, or \"lagrangian\" with \"rk4\" or \"radau\", which divide it."},
    {"spring_unresolved", "rad",
     "A spring of a joint or a pin, with little damping, swings by more in a step than its solver "
     "can follow, so that its swing dies or grows by itself: its frequency times the step.",
     "Take a shorter step, make the spring softer, or give it the damping that it is to have."},
    {"energy_limited", "J",
     "For more than a twentieth of the last second the solver took energy away that its own steps "
     "had made, by more than a quarter of what moves the bodies and a thousandth of what ever did.",
     "Take a shorter step; check whether bodies begin within one another."},
    {"step_rescued", "s",
     "For more than a twentieth of the last second Euler's method took steps that the integrator "
     "could not: springs or motors are too stiff for it, or joints contradict each other.",
     "Use the integrator \"radau\" or \"implicit\", or a shorter step."},
    {"contacts_unsolved", "s",
     "For more than a twentieth of the last second impulses of contacts did not converge.",
     "Take a shorter step; check whether bodies are wedged where there is no room for them."},
};
static_assert(std::size(kInfos) == static_cast<std::size_t>(last_of(FindingKind{})) + 1);

}  // namespace

const FindingInfo& info_of(FindingKind kind) { return kInfos[static_cast<int>(kind)]; }

}  // namespace pantin
