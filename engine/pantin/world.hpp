#pragma once
/// World: everything that exists, as components of entities. It is a value: a copy is a snapshot.
///
/// Add to it bodies (shapes.hpp), joints (joints.hpp), whole chains and ragdolls (figures.hpp), and
/// components of your own (World::store, World::view).
#include "engine/base/result.hpp"
#include "engine/base/rotation.hpp"
#include "engine/world/world.hpp"
