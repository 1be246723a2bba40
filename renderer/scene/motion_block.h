// SPDX-License-Identifier: Apache-2.0
// The motion block that SceneBuilder is reading.
#pragma once

#include <string>
#include <vector>

#include "renderer/scene/scene_builder.h"

namespace patina {

struct SceneBuilder::MotionBlock {
  enum class Kind : uint8_t {
    Transforms,
    Primitives,
    Others  ///< what does not move: the first request is carried out
  };

  Location where;
  std::vector<double> times;
  bool sound = true;    ///< no error so far: else the first request holds throughout
  size_t ignored = 0;   ///< motion blocks inside, which are errors, still open
  std::string request;  ///< the first one's name
  Kind kind = Kind::Others;
  size_t count = 0;  ///< requests so far

  std::vector<TransformKey> transforms;  ///< one for each request that could be carried out
  bool absolute = false;                 ///< they replace the current transformation

  size_t primitive = 0;          ///< of the list that primitives go to now: what the first request made
  std::vector<ShapeKey> shapes;  ///< as `transforms`
};

}  // namespace patina
