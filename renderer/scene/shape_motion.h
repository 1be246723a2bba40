// SPDX-License-Identifier: Apache-2.0
// Primitives that change their shape: keys out of the requests of a motion block, and the state at a time.
#pragma once

#include <string>

#include "renderer/scene/scene.h"

namespace patina {

/// What of `primitive` may change, as a key.
ShapeKey shapeKey(const Primitive& primitive, double time);

/// Adds `later`, the same primitive at `time`, to the keys of `first`, of which there is one at least. All
/// keys have the same variables then. Returns what keeps the two from being states of one primitive, or
/// nothing.
std::string addKey(const Primitive& first, const Primitive& later, double time, std::vector<ShapeKey>& keys);

/// Whether a primitive changes its shape between two times.
bool deformsWithin(const PrimitiveMotion& motion, double open, double close);

/// Gives a primitive the shape it has at a time: linear between two keys, held before the first and behind
/// the last.
void setShape(Primitive& primitive, const PrimitiveMotion& motion, double time);

/// Gives everything in `scene` that moves its state at the opening of the shutter.
void settleMotion(Scene& scene);

}  // namespace patina
