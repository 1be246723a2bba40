// SPDX-License-Identifier: Apache-2.0
// Primitives of RI at random, of about unit size around the origin, most of them with something wrong.
#pragma once

#include <set>
#include <string>

#include "tests/stress/random_dice.h"

namespace patina::stress {

/// Where the shapes note what is wrong with them.
struct ShapeNotes {
  std::set<std::string> ingredients;
  bool strangeColors = false;      ///< Cs outside of 0 to 1
  bool allowStrangeColors = true;  ///< what shapes may do
};

/// One primitive, ended by a new line. `times` above 1 gives as many poses of it, of the same topology, for a
/// motion block.
std::string randomShape(Dice& dice, ShapeNotes& notes, int times = 1);

}  // namespace patina::stress
