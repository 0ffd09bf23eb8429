#pragma once
/// The core of pantin: worlds, bodies, joints, figures, stepping, and reading results back.
///
/// Scene files and pictures are libraries of their own: <pantin/scene.hpp>, <pantin/render.hpp>.
#include <pantin/change.hpp>
#include <pantin/contacts.hpp>
#include <pantin/draw.hpp>
#include <pantin/events.hpp>
#include <pantin/figures.hpp>
#include <pantin/joints.hpp>
#include <pantin/laminas.hpp>
#include <pantin/measure.hpp>
#include <pantin/must.hpp>
#include <pantin/queries.hpp>
#include <pantin/save.hpp>
#include <pantin/shapes.hpp>
#include <pantin/simulation.hpp>
#include <pantin/world.hpp>
