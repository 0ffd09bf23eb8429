#pragma once
// Quantities of joints, cables, pins and contacts, as columns of a record.
#include <functional>
#include <pantin/contacts.hpp>
#include <string>
#include <vector>

namespace pantin::program {

/// One column: its name, and its value after a step; NaN where there is none.
struct Reading {
  std::string name;
  std::function<Real(const World&)> value;
};

/// The readings of a World whose structure is built, by name: for each joint those of its
/// coordinates (angle, second_angle, travel in rad and m, angular_speed, speed per second) and its
/// reaction (reaction_fx to reaction_tz, N and N m, about the anchor, on body b); for each cable
/// its tension (N); for each pin its force (pin_fx to pin_fz, N); for each body that collides the
/// force of all its contacts (contact_fx to contact_fz, N, mean over the step), and the number of
/// bodies that it touches or, as a sensor, overlaps (contacts). `events` must outlive them and be
/// updated after each step; `step` is its length, s.
std::vector<Reading> readings_of(const World& world, const ContactEvents& events, Real step);

}  // namespace pantin::program
