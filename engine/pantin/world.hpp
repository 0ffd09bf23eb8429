#pragma once
/// World: everything that exists, as components of entities. A value: copying it is a snapshot.
///
/// What is added to it: bodies (shapes.hpp), joints (joints.hpp), whole chains and ragdolls
/// (figures.hpp), components of your own (World::store, World::view).
#include "engine/base/result.hpp"
#include "engine/base/rotation.hpp"
#include "engine/world/world.hpp"
