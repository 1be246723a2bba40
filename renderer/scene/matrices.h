// SPDX-License-Identifier: Apache-2.0
// RI's transformations as matrices for row vectors, and what may be asked of a matrix before it is trusted.
#pragma once

#include <array>
#include <optional>

#include "renderer/base/math.h"
#include "rib/handler.h"

namespace patina {

M44d toMatrix(const RibMatrix& values);
M44d translation(double x, double y, double z);
M44d scaling(double x, double y, double z);

/// Rotation by `degrees` about an axis of any length but zero. Positive turns x to y about z, whatever the
/// handedness.
M44d rotation(double degrees, const V3d& axis);

/// RI's Skew: points shift along `to` so that `from` leans by `degrees` towards it. nullopt when an axis is
/// zero, both are parallel, or the angle reaches the axes' own (RI 3.2, Skew).
std::optional<M44d> skew(double degrees, const V3d& from, const V3d& to);

/// RI's Perspective: focal point at the origin; z = 1 goes to 0, infinity to 1.
M44d perspectiveMatrix(double degrees);

/// The last column is (0, 0, 0, 1).
bool isAffine(const M44d& matrix);

/// Determinant of the upper 3x3.
double determinant3(const M44d& matrix);

/// A bound on how much the matrix lengthens vectors; exact when its rows are at right angles.
double largestStretch(const M44d& matrix);

/// The inverse, or nullopt for a matrix that is singular to working precision or not finite. Being small is
/// no fault.
std::optional<M44d> inverted(const M44d& matrix);

}  // namespace patina
